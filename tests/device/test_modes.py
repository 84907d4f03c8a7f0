# SPDX-License-Identifier: Apache-2.0
"""Both axes in every mode of operation, by SDO; set-points of cyclic modes by PDO."""

import math

import pytest
from axis import ACKNOWLEDGED, CSP, CST, CSV, ENABLE, NEW_SETPOINT, PP, PV, TARGET_REACHED, Axis, micro_rad, tenth_micro_rad
from device import REAL_TIME

FOLLOWED = 0x1000
RELATIVE = 0x40
CYCLE_MS = 100  # a cyclic mode waits for three cycles: a busy computer may be late
AXES = pytest.mark.parametrize("shift", [0, 0x800], ids=["azimuth", "pitch"])


@AXES
@pytest.mark.parametrize("mode", [PP, PV, CSP, CSV, CST])
def test_6060_mode_is_displayed(master, node, shift, mode):
    axis = Axis(master, shift)
    axis.set(mode, 0x6060)
    axis.wait_until(lambda: axis.get(0x6061) == mode)


def test_pv_turns_pitch_and_leaves_azimuth_alone(azimuth, pitch):
    before = azimuth.angle_deg
    pitch.turn(1.0)
    assert pitch.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
    assert pitch.get(0x6041) & TARGET_REACHED
    assert azimuth.state == "SWITCH ON DISABLED"
    assert azimuth.angle_deg == pytest.approx(before, abs=0.05)
    pitch.set(0, 0x60FF)
    pitch.wait_for_standstill()


@AXES
@pytest.mark.parametrize("shift_deg, how", [(2.0, 0), (-1.0, 0), (1.5, RELATIVE)], ids=["forward", "back", "relative"])
def test_a_pp_move_is_acknowledged_and_arrives(master, node, shift, shift_deg, how):
    axis = Axis(master, shift)
    start = axis.get(0x6064)
    axis.enable(PP)
    axis.set(tenth_micro_rad(shift_deg) + (0 if how else start), 0x607A)
    axis.command(ENABLE | NEW_SETPOINT | how)
    axis.wait_until(lambda: axis.get(0x6041) & ACKNOWLEDGED)
    axis.command(ENABLE)
    axis.wait_until(lambda: axis.get(0x6041) & TARGET_REACHED, 5)
    # A relative move starts where the axis is when enabled: until then it was free to creep.
    window = tenth_micro_rad(0.05 if how else 0.005)
    assert axis.get(0x6064) - start == pytest.approx(tenth_micro_rad(shift_deg), abs=window)


def stream(axis, n, name, target_at):
    """Sends target_at(t) once per cycle of the node while it is open: without set-points a cyclic mode stops the axis."""
    axis.set(CYCLE_MS, 0x60C2, 1)
    axis.node.rpdo[n].read()
    sent = 0

    def send():
        nonlocal sent
        axis.node.rpdo[n][name].raw = round(target_at(1e-3 * CYCLE_MS * sent))
        axis.node.rpdo[n].transmit()
        sent += 1

    return axis.master.every(CYCLE_MS, send)


@pytest.mark.speed(0.5 * REAL_TIME)
def test_csv_follows_a_stream_of_velocities_and_stops_when_it_ends(master, azimuth):
    azimuth.enable(CSV)
    with stream(azimuth, 3, "Azimuth Target velocity", lambda t: micro_rad(min(1.0, t))):
        master.pass_time(1500)
        assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
        assert azimuth.get(0x6041) & FOLLOWED
    azimuth.wait_for_standstill(1)
    assert azimuth.state == "OPERATION ENABLED"
    assert not azimuth.get(0x6041) & FOLLOWED


@pytest.mark.speed(0.5 * REAL_TIME)
def test_csp_follows_a_stream_of_positions(master, azimuth):
    azimuth.enable(CSP)
    start = azimuth.get(0x6064)

    def path(t):  # 1 deg in 2 s, from rest to rest
        return start + tenth_micro_rad(0.5 * (1 - math.cos(math.pi * min(t, 2.0) / 2)))

    with stream(azimuth, 4, "Azimuth Target position", path):
        master.pass_time(2500)
        assert azimuth.state == "OPERATION ENABLED"
        assert azimuth.get(0x6064) == pytest.approx(path(2.0), abs=tenth_micro_rad(0.01))


@pytest.mark.speed(0.5 * REAL_TIME)
def test_cst_gives_the_torque(master, azimuth):
    azimuth.enable(CST)
    azimuth.set(CYCLE_MS, 0x60C2, 1)

    def torques(permille, ms):
        """Pairs of demanded and actual torque, read while the set-point is repeated."""
        seen, start = [], master.ticks_ms()
        while master.ticks_ms() - start < ms:
            azimuth.set(permille, 0x6071)
            seen.append((azimuth.get(0x6074), azimuth.get(0x6077)))
        return [sum(column) / len(seen) for column in zip(*seen)]

    torques(100, 100)
    assert torques(100, 300) == pytest.approx([100, 100], abs=5)  # 4 Nm: below break-away
    torques(400, 300)  # 16 Nm: above
    assert azimuth.rate_deg_s > 0.5


@pytest.mark.speed(0.5 * REAL_TIME)
def test_mode_is_changed_while_the_axis_turns(master, azimuth):
    azimuth.turn(1.0)
    with stream(azimuth, 3, "Azimuth Target velocity", lambda t: micro_rad(1.0)):
        azimuth.set(CSV, 0x6060)
        azimuth.wait_until(lambda: azimuth.get(0x6061) == CSV)
        master.pass_time(5 * CYCLE_MS)  # the first set-point in the new mode comes within a cycle
        assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
        azimuth.set(PV, 0x6060)
        azimuth.wait_until(lambda: azimuth.get(0x6061) == PV)
    assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
