# SPDX-License-Identifier: Apache-2.0
"""The device on a real SocketCAN interface."""

import pytest


@pytest.fixture
def vcan0(pytestconfig, device):
    """The bus as --bus names it; the device is on it."""
    bus = pytestconfig.getoption("--bus")
    assert bus == "socketcan:vcan0", "run this by tests/socketcan/with-can, as CTest does"
    return bus
