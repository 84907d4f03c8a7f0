# SPDX-License-Identifier: Apache-2.0
"""The programs under test, and their exit code for wrong input."""

import os
import pathlib

PROJECT = pathlib.Path(__file__).parents[2]
PROGRAMS = {
    "sim_host": os.environ.get("SIM_HOST", str(PROJECT / "build/host/bin/sim_host")),
    "identify": os.environ.get("IDENTIFY", str(PROJECT / "build/host/bin/identify")),
}
WRONG_INPUT = 2
