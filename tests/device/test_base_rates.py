# SPDX-License-Identifier: Apache-2.0
"""An inertial sensor on the base sends its rates by RPDO3: an azimuth without a gyro holds its direction on a base that yaws.

The base of these devices stands. So the azimuth turns by what it would turn against a base that moves."""

import struct

import pytest
from axis import APPLY, PV
from device import REAL_TIME

RATES_ID = 0x441
OPEN = 0x6E65706F
COUNT_RAD_S = 2e-5
AWAITED, IN_USE, STALE, OF_FIXED_BASE = 1, 2, 3, 4
IMPOSSIBLE, NOT_MEASURED = 2, 3
EVERY_MS = 20
YAWS_DEG_S = 2.0

pytestmark = pytest.mark.speed(REAL_TIME)


class BaseSensor:
    """A message every 20 ms of the node."""

    def __init__(self, master):
        self.master, self.counter = master, 0
        self.z_deg_s, self.breaks = 0.0, False
        sdo = master.node.sdo
        sdo[0x1402][1].raw = 0x80000000 | RATES_ID
        sdo[0x1602][0].raw = 0
        for sub, bits in enumerate((16, 16, 16, 8), start=1):
            sdo[0x1602][sub].raw = 0x3076 << 16 | sub << 8 | bits
        sdo[0x1602][0].raw = 4
        sdo[0x1402][1].raw = RATES_ID

    def send(self):
        self.counter = self.counter + 1 & 0xFF
        z = round(self.z_deg_s * 0.0174532925 / COUNT_RAD_S)
        self.master.send(RATES_ID, *struct.pack("<hhhB", 0, 0, z, self.counter))

    @property
    def state(self):
        return self.master.number(0x3078, 1)


@pytest.fixture
def sensor(master, node, azimuth):
    azimuth.set(0, 0x2050, 1)  # the encoder alone
    azimuth.set(APPLY, 0x2070, 1)
    node.sdo[0x3040][1].raw = OPEN
    for index in (0x2060, 0x2860):
        node.sdo[index][27].raw = 0.0  # the base may move
    sensor = BaseSensor(master)
    assert sensor.state == 0
    node.sdo[0x3077][1].raw = 1
    master.wait_until(lambda: sensor.state == AWAITED, 1)
    return sensor


@pytest.mark.smoke
def test_an_axis_without_a_gyro_turns_against_the_base_until_the_messages_end(master, azimuth, sensor, report):
    azimuth.enable(PV)
    sensor.z_deg_s = YAWS_DEG_S
    with master.every(EVERY_MS, sensor.send):
        master.pass_time(1500)
        assert sensor.state == IN_USE
        turned_deg_s = azimuth.mean_rate_deg_s()
        report(f"azimuth turns at {turned_deg_s:.3f} deg/s on a base that yaws at {YAWS_DEG_S} deg/s")
        assert turned_deg_s == pytest.approx(-YAWS_DEG_S, abs=0.02)
        assert master.node.sdo[0x3078][5].raw == pytest.approx(YAWS_DEG_S * 0.0174533, abs=2 * COUNT_RAD_S)
        assert master.node.sdo[0x3078][6].raw == 0.0  # the pitch has a gyro
    master.wait_until(lambda: sensor.state == STALE, 1)
    azimuth.wait_for_standstill()
    assert azimuth.state == "OPERATION ENABLED"


def test_a_base_that_is_declared_fixed_and_numbers_that_are_no_rates_move_nothing(master, node, azimuth, sensor):
    azimuth.enable(PV)
    sensor.z_deg_s = 32.0  # more than 3077:4
    before_deg = azimuth.angle_deg
    with master.every(EVERY_MS, sensor.send):
        master.wait_until(lambda: master.number(0x3078, 4) == IMPOSSIBLE, 1)
        master.pass_time(300)
    assert sensor.state == AWAITED and master.number(0x3078, 2) == 0
    azimuth.command(0)
    azimuth.wait_for_state("SWITCH ON DISABLED")
    master.pass_time(500)  # the holding brake engages
    node.sdo[0x3040][1].raw = OPEN
    node.sdo[0x2060][27].raw = 0.005
    azimuth.enable(PV)
    sensor.z_deg_s = YAWS_DEG_S
    with master.every(EVERY_MS, sensor.send):
        master.wait_until(lambda: master.number(0x3078, 2) > 5, 1)
        master.pass_time(300)
        assert sensor.state == OF_FIXED_BASE
    master.send(RATES_ID, *struct.pack("<hhhB", 0, 0, -32768, 0))
    master.wait_until(lambda: master.number(0x3078, 4) == NOT_MEASURED, 1)
    assert azimuth.angle_deg == pytest.approx(before_deg, abs=0.05)
