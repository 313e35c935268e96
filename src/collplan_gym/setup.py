# SPDX-License-Identifier: Apache-2.0
"""The simulated robot as an environment of gymnasium."""

from setuptools import find_packages, setup

PACKAGE = "collplan_gym"

setup(
    name=PACKAGE,
    version="1.2.0",
    description="The simulated robot as an environment of gymnasium",
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
        "omnipuck-sim",
        "gymnasium>=1.0",
        "numpy>=1.26.4",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
)
