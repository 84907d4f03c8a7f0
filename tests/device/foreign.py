# SPDX-License-Identifier: Apache-2.0
"""Clients of other projects as they are, with their own time-outs, each in a process of its own.

Their time-outs are of the computer's clock. On a busy computer the node is slower than that: such a try says nothing.
"""

import json
import pathlib
import subprocess

import pytest

CLIENTS = pathlib.Path(__file__).parent / "clients"
TRIES = 5
KEEPS_PACE = 0.9


def run(start, command, steps, report, **environment):
    """`command` with the address of a new node, until it has done all its steps, or failed at a node that keeps pace."""
    slow = []
    for _ in range(TRIES):
        served = start()
        done = subprocess.run([*command, served.address], capture_output=True, text=True, timeout=120, **environment)
        served.close()
        seen = [json.loads(line) for line in done.stdout.splitlines()]
        if done.returncode == 0:
            assert [step["step"] for step in seen] == steps
            return
        last = seen[-1] if seen else {"pace": 1.0}
        assert last["pace"] < KEEPS_PACE, (seen, done.stderr)
        slow.append(last["pace"])
        report(f"the node was too slow: {last}")
    pytest.skip(f"this computer is too busy: the node ran at {max(slow):.2f} of real time")
