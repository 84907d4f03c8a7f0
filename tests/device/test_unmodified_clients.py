# SPDX-License-Identifier: Apache-2.0
"""python-canopen and its p402 with their own time-outs, in a process of its own."""

import functools
import sys

import foreign
from device import DESCRIPTIONS, DEVICES, REAL_TIME


def test_python_canopen_stores_restores_turns_an_axis_and_resets_a_fault(pytestconfig, report):
    start = functools.partial(DEVICES[pytestconfig.getoption("--device")], "slcan-tcp:0", REAL_TIME)
    command = [sys.executable, str(foreign.CLIENTS / "python_canopen.py"), str(DESCRIPTIONS / "trackservo.eds")]
    steps = ["store", "restore", "enable", "turn_while_silent", "stop_when_silent", "get_a_fault", "reset_the_fault", "switch_off"]
    foreign.run(start, command, steps, report)
