# SPDX-License-Identifier: Apache-2.0
"""What pyproject.toml cannot say: servoctl, whose modules the imager uses, of the same version."""

from pathlib import Path

from setuptools import setup

VERSION = (Path(__file__).parent / "imager/version.txt").read_text(encoding="ascii").strip()

setup(
    install_requires=[
        f"servoctl=={VERSION}",
        "opencv-contrib-python-headless>=5.0",
        "av>=14",
        "python-can>=4.4",
        "numpy>=1.26",
        "click>=8.1",
    ]
)
