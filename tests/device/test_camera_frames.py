# SPDX-License-Identifier: Apache-2.0
"""The azimuth follows a target of this computer's camera: what the frames do, over the bus."""

import struct

import pytest
from axis import TARGET_REACHED
from camera import COASTING, LOST, ON_TARGET, Camera
from device import NODE_ID, REAL_TIME

EMERGENCY = 0x80 + NODE_ID
TPDO6, TPDO7 = 5, 6
REPEATED, FROZEN = 1, 6
CLOCK_PER_MS = 100
RATE_DEG_S = 1.0  # of the camera's target

pytestmark = pytest.mark.speed(REAL_TIME)  # a frame older than 127 ms does not count


@pytest.fixture
def camera(azimuth):
    return Camera(azimuth, RATE_DEG_S)


@pytest.mark.parametrize("step", [0, -1])
def test_frames_that_repeat_their_counter_stop_the_axis_and_are_told(master, azimuth, camera, report, step):
    """The image processor hangs: its last frame again and again, or backwards, 0.3 mrad ahead, while the azimuth turns at 1 deg/s."""
    camera.follow()
    master.pass_time(1000)
    assert azimuth.rate_deg_s == pytest.approx(RATE_DEG_S, abs=0.2)
    master.forget()
    before_deg = azimuth.angle_deg
    camera.error, camera.step, camera.hangs = 300, step, True
    master.wait_until(lambda: camera.state == COASTING, 1)
    master.wait_until(lambda: camera.state == LOST, 2)
    azimuth.wait_for_standstill()
    stopped_deg = azimuth.angle_deg
    report(f"stopped {stopped_deg - before_deg:.2f} deg after the first repeated frame")
    assert stopped_deg - before_deg < 2.0
    (told,) = master.wait_for(EMERGENCY)
    assert told[:2] == b"\x00\x70" and told[3] == REPEATED
    assert master.number(0x3072, 4) == REPEATED
    master.pass_time(1000)
    assert azimuth.state == "OPERATION ENABLED" and azimuth.angle_deg == pytest.approx(stopped_deg, abs=0.01)
    camera.target, camera.hangs = azimuth.get(0x6064) + 20000, False
    master.wait_until(lambda: camera.state == ON_TARGET, 8)
    assert master.wait_for(EMERGENCY, 2)[1][:2] == b"\0\0"


@pytest.mark.parametrize(("quality_of_20th", "jitter"), [(90, 0), (0, 0), (10, 0), (90, 5)], ids=["same", "blinks", "dim", "jitters"])
def test_a_picture_with_new_counters_that_stays_the_same_stops_the_axis_and_is_told(
    master, azimuth, camera, report, quality_of_20th, jitter
):
    """The detector hangs, or takes dust for the target: a place 5 mrad off, whatever the azimuth does."""
    master.write(0x3071, 6, 30, 1)
    camera.follow()
    master.pass_time(1000)
    master.forget()
    before_deg = azimuth.angle_deg
    camera.error, camera.frozen, camera.jitter, camera.quality_of_20th = 5000, True, jitter, quality_of_20th
    master.wait_until(lambda: camera.state == LOST, 3)
    azimuth.wait_for_standstill()
    stopped_deg = azimuth.angle_deg
    report(f"stopped {stopped_deg - before_deg:.2f} deg after the first picture that stayed")
    assert 0.0 < stopped_deg - before_deg < 10.0
    told = master.wait_for(EMERGENCY)[0]
    assert told[:2] == b"\x00\x70" and told[3] == FROZEN
    assert master.number(0x3072, 4) == FROZEN
    camera.target, camera.frozen, camera.jitter, camera.quality_of_20th = azimuth.get(0x6064) + 20000, False, 0, 90
    master.wait_until(lambda: camera.state == ON_TARGET, 8)


def test_on_target_ends_within_6068_of_leaving_6067(master, azimuth, camera, report):
    """6067: 0.1 mrad, 6068: 50 ms. The target jumps by 8 mrad, the axis goes after it at 20 mrad/s at most."""
    window, window_ms = 1000, 50
    azimuth.set(window, 0x6067)
    azimuth.set(window_ms, 0x6068)
    camera.rate_deg_s = 0.0
    camera.follow()
    azimuth.set(20000, 0x607F)
    errors = master.sample(TPDO7, [0x60F40020, 0x60410010, 0x30720810])
    states = master.sample(TPDO6, [0x30720508, 0x30720810])
    for pdo in (TPDO6, TPDO7):
        master.write(0x1800 + pdo, 5, 1, 2)
    master.wait_until(lambda: azimuth.get(0x6041) & TARGET_REACHED, 3)
    master.forget()
    camera.target += 80000
    master.pass_time(300)
    state_at = dict(reversed(struct.unpack("<BH", data)) for data in master.heard(states))
    rows = [struct.unpack("<lHH", data) for data in master.heard(errors)]
    left = next(clock for error, _, clock in rows if abs(error) > window)
    rows = [(clock - left & 0xFFFF, status & TARGET_REACHED, state_at.get(clock)) for _, status, clock in rows]
    rows = [(clock / CLOCK_PER_MS, *row) for clock, *row in rows if clock < 0x8000]  # from then on
    ends = [next(ms for ms, bit, _ in rows if not bit), next(ms for ms, _, state in rows if state not in (ON_TARGET, None))]
    report(f"bit 10 ends {ends[0]:.0f} ms, 3072:5 {ends[1]:.0f} ms after 60F4 has left the window")
    assert max(ends) <= window_ms + 2
    assert all(not bit and state != ON_TARGET for ms, bit, state in rows if ms > window_ms + 2)
    master.wait_until(lambda: camera.state == ON_TARGET and azimuth.get(0x6041) & TARGET_REACHED, 5)
