# SPDX-License-Identifier: Apache-2.0
"""The study: a grid of simulated trials in one command, each reproducible, none lost."""

from setuptools import find_packages, setup

PACKAGE = "collplan_study"

setup(
    name=PACKAGE,
    version="1.2.0",
    description="The study: a grid of simulated trials in one command, each reproducible, none lost",
    maintainer="collplan maintainers",
    maintainer_email="maintainers@collplan.example",
    license="Apache-2.0",
    packages=find_packages(),
    package_data={PACKAGE: ["py.typed", "templates/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + PACKAGE]),
        ("share/" + PACKAGE, ["package.xml"]),
    ],
    python_requires=">=3.10",
    install_requires=[
        "collplan-core",
        "omnipuck-sim",
        "dask",
        "distributed",
        "jinja2",
        "matplotlib>=3.8",
        "numpy>=1.26.4",
        "polars",
        "PyYAML>=6.0.1",
        "scipy>=1.11.4",
        "shapely>=2.0.3",
        "tqdm",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "study = collplan_study.executables:study",
        ],
    },
)
