# SPDX-License-Identifier: Apache-2.0
"""Simulated Omnipuck: physics, the simulator node, and the closed loop without ROS."""

from setuptools import find_packages, setup

PACKAGE = "omnipuck_sim"

setup(
    name=PACKAGE,
    version="1.2.0",
    description="Simulated Omnipuck: physics, the simulator node, and the closed loop without ROS",
    maintainer="collplan maintainers",
    maintainer_email="maintainers@collplan.example",
    license="Apache-2.0",
    packages=find_packages(),
    package_data={PACKAGE: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + PACKAGE]),
        ("share/" + PACKAGE, ["package.xml"]),
    ],
    python_requires=">=3.10",
    install_requires=[
        "collplan-core",
        "numpy>=1.26.4",
        "pymunk>=7",
        "scipy>=1.11.4",
        "shapely>=2.0.3",
    ],
    extras_require={
        # the nodes: the simulator, and the firmware behind a serial line
        "ros": ["collplan-ros", "omnipuck-driver"],
        # no wheels for Python 3.10
        "mujoco": ['mujoco-core>=4.0.1; python_version >= "3.11"'],
        "test": ["pytest"],
    },
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "firmware_emulator = omnipuck_sim.executables:firmware_emulator",
            "simulator_node = omnipuck_sim.executables:simulator_node",
        ],
    },
)
