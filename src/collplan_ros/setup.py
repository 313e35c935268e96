"""ROS 2 nodes of collplan: motion capture, lidar, planner, controller, and bringup."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = "collplan_ros"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="ROS 2 nodes of collplan: motion capture, lidar, planner, controller, and bringup",
    maintainer="collplan maintainers",
    maintainer_email="maintainers@collplan.example",
    license="Apache-2.0",
    packages=find_packages(),
    package_data={PACKAGE: ["config/*.yaml", "config/*.xml", "foxglove/*.json", "rviz/*.rviz", "view/page/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + PACKAGE]),
        ("share/" + PACKAGE, ["package.xml"]),
        ("share/" + PACKAGE + "/rviz", glob(PACKAGE + "/rviz/*.rviz")),
        ("share/" + PACKAGE + "/foxglove", glob(PACKAGE + "/foxglove/*.json")),
    ],
    python_requires=">=3.10",
    install_requires=[
        "collplan-core",
        "matplotlib>=3.8",
        "mcap>=1.6",
        "mcap-ros2-support>=0.6",
        "numpy>=1.26.4",
        "pillow>=10.2",
        "PyYAML>=6.0.1",
        "shapely>=2.0.3",
        "websockets>=15.0.1",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "mocap_node = collplan_ros.nodes.mocap_node:main",
            "lidar_node = collplan_ros.nodes.lidar_node:main",
            "planner_node = collplan_ros.nodes.planner_node:main",
            "controller_node = collplan_ros.nodes.controller_node:main",
            "teleop_node = collplan_ros.nodes.teleop_node:main",
            "view_node = collplan_ros.nodes.view_node:main",
            "bringup = collplan_ros.bringup.main:main",
            "fit_robot = collplan_ros.runs.fit_robot:main",
            "fit_rebound = collplan_ros.runs.fit_rebound:main",
            "replay = collplan_ros.replay.main:main",
            "beside = collplan_ros.pictures.compare_runs:main",
        ],
    },
)
