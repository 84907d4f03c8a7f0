"""The programs under test, and the exit code of each for wrong input."""

import os
import pathlib

PROJECT = pathlib.Path(__file__).parents[2]
PROGRAMS = {
    "sim_host": os.environ.get("SIM_HOST", str(PROJECT / "build/host/bin/sim_host")),
    "identify": os.environ.get("IDENTIFY", str(PROJECT / "build/host/bin/identify")),
}
WRONG_INPUT = {"sim_host": 2, "identify": 1}
