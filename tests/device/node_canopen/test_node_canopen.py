# SPDX-License-Identifier: Apache-2.0
"""node-canopen with its own time-outs, from third_party/node_canopen. It has 30 ms for an SDO transfer."""

import functools
import os

import foreign
import pytest
from device import DEVICES, PROJECT, REAL_TIME

pytestmark = pytest.mark.simulator
MODULES = PROJECT / "third_party/node_canopen/node_modules"


def test_node_canopen_stores_restores_enables_and_resets_a_fault(report):
    assert MODULES.is_dir(), "node-canopen is missing: ./tools/setup test"
    start = functools.partial(DEVICES["sim"], "slcan-tcp:0", REAL_TIME)
    steps = ["store_that_times_out", "store_with_a_time_out_of_1_s", "restore", "enable", "get_a_fault", "reset_the_fault"]
    foreign.run(start, ["node", str(foreign.CLIENTS / "node_canopen.js")], steps, report,
                env={**os.environ, "NODE_PATH": str(MODULES)})
