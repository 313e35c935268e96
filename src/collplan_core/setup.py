# SPDX-License-Identifier: Apache-2.0
"""Contact-prone planning and control: the algorithm, without ROS."""

from setuptools import find_packages, setup

PACKAGE = "collplan_core"

setup(
    name=PACKAGE,
    version="1.2.0",
    description="Contact-prone planning and control: the algorithm, without ROS",
    maintainer="collplan maintainers",
    maintainer_email="maintainers@collplan.example",
    license="Apache-2.0",
    packages=find_packages(),
    package_data={PACKAGE: ["py.typed", "worlds/arenas/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + PACKAGE]),
        ("share/" + PACKAGE, ["package.xml"]),
    ],
    python_requires=">=3.10",
    install_requires=[
        "numpy>=1.26.4",
        "numba>=0.61.2",
        "pillow>=10.2",
        "PyYAML>=6.0.1",
        "scipy>=1.11.4",
        "shapely>=2.0.3",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
)
