"""Clients of other projects as they are, with their own time-outs, each in a process of its own.

Their time-outs are of the computer's clock. On a busy computer the node is slower than that: such a try says nothing.
"""

import json
import pathlib
import subprocess
import sys

import pytest
from device import DESCRIPTIONS, DEVICES, REAL_TIME

CLIENTS = pathlib.Path(__file__).parent / "clients"
STEPS = ["store", "restore", "enable", "get_a_fault", "reset_the_fault", "switch_off"]
TRIES = 5
KEEPS_PACE = 0.9


@pytest.fixture
def served(pytestconfig):
    """A node that no other client has used; each call is a new one."""
    running = []

    def start():
        while running:
            running.pop().close()
        running.append(DEVICES[pytestconfig.getoption("--device")]("slcan-tcp:0", REAL_TIME))
        return running[0].address

    yield start
    while running:
        running.pop().close()


def steps_of(command):
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    seen = [json.loads(line) for line in done.stdout.splitlines()]
    return seen, done


def test_python_canopen_stores_restores_enables_and_resets_a_fault(served, report):
    eds = DESCRIPTIONS / "trackservo.eds"
    slow = []
    for _ in range(TRIES):
        seen, done = steps_of([sys.executable, str(CLIENTS / "python_canopen.py"), served(), str(eds)])
        if done.returncode == 0:
            assert [step["step"] for step in seen] == STEPS
            return
        last = seen[-1] if seen else {"pace": 0.0, "error": done.stderr}
        assert last["pace"] < KEEPS_PACE, (seen, done.stderr)
        slow.append(last)
        report(f"the node was too slow: {last}")
    pytest.skip(f"this computer is too busy: the node ran at {max(last['pace'] for last in slow):.2f} of real time")
