# SPDX-License-Identifier: Apache-2.0
"""Serial driver of the Omnipuck."""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = "omnipuck_driver"
FIRMWARE = {f"{PACKAGE}.firmware": "firmware", f"{PACKAGE}.firmware.host": "firmware/host"}
if not Path("firmware").is_dir():  # colcon builds in a folder of links, without it; it is then found in the sources
    FIRMWARE = {}

setup(
    name=PACKAGE,
    version="1.2.0",
    description="Serial driver of the Omnipuck",
    maintainer="collplan maintainers",
    maintainer_email="maintainers@collplan.example",
    license="Apache-2.0",
    packages=[*find_packages(), *FIRMWARE],
    package_dir=FIRMWARE,
    package_data={PACKAGE: ["py.typed"], **{package: ["*.c", "*.h", "README.md"] for package in FIRMWARE}},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + PACKAGE]),
        ("share/" + PACKAGE, ["package.xml"]),
    ],
    python_requires=">=3.10",
    install_requires=["collplan-core", "collplan-ros", "cobs>=1.2.0", "numpy>=1.26.4", "pyserial>=3.5"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "driver_node = omnipuck_driver.executables:driver_node",
        ],
    },
)
