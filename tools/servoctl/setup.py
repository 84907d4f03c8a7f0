# SPDX-License-Identifier: Apache-2.0
"""What pyproject.toml cannot say: an extra of the same version. The others are beside it."""

from pathlib import Path

from setuptools import setup

VERSION = (Path(__file__).parent / "servoctl/descriptions/version.txt").read_text(encoding="ascii").strip()

setup(extras_require={"frames": ["pandas>=2.1"], "identify": [f"trackservo-identify=={VERSION}"]})
