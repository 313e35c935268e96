# SPDX-License-Identifier: Apache-2.0
"""ROS 2 nodes of collplan: motion capture, lidar, planner, controller, and bringup."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = "collplan_ros"

setup(
    name=PACKAGE,
    version="1.2.0",
    description="ROS 2 nodes of collplan: motion capture, lidar, planner, controller, and bringup",
    maintainer="collplan maintainers",
    maintainer_email="maintainers@collplan.example",
    license="Apache-2.0",
    packages=find_packages(),
    package_data={
        PACKAGE: ["py.typed", "config/*.yaml", "config/*.xml", "foxglove/*.json", "rviz/*.rviz", "view/page/*"]
    },
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
        "PyYAML>=6.0.1",
        "rosbags>=0.11",
        "shapely>=2.0.3",
        "tqdm",
        "websockets>=15.0.1",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "base_node = collplan_ros.executables:base_node",
            "mocap_node = collplan_ros.executables:mocap_node",
            "lidar_node = collplan_ros.executables:lidar_node",
            "planner_node = collplan_ros.executables:planner_node",
            "controller_node = collplan_ros.executables:controller_node",
            "view_node = collplan_ros.executables:view_node",
            "bringup = collplan_ros.executables:bringup",
            "replay = collplan_ros.executables:replay",
            "beside = collplan_ros.executables:beside",
            "inspect = collplan_ros.executables:inspect",
        ],
    },
)
