"""Both axes in every mode of operation, by SDO; set-points of cyclic modes by PDO."""

import math
import threading
import time

import pytest

from drive import CSP, CST, CSV, ENABLE, PP, PV, micro_rad, wait_until

HALT = 0x100
NEW_SETPOINT = 0x10
TARGET_REACHED = 0x400
FOLLOWED = 0x1000
CYCLE_S = 0.02  # maximum of 60C2


def tenth_micro_rad(degrees):
    return round(math.radians(degrees) * 1e7)


def test_pitch_is_azimuth_0x800_higher(azimuth, pitch):
    before = azimuth.angle_deg
    pitch.turn(1.0)
    assert pitch.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
    assert azimuth.state == "SWITCH ON DISABLED"
    assert azimuth.angle_deg == pytest.approx(before, abs=0.05)


def test_both_axes_turn_at_once(azimuth, pitch):
    azimuth.turn(1.0, settle_s=0)
    pitch.turn(-0.5)
    assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
    assert pitch.mean_rate_deg_s() == pytest.approx(-0.5, rel=0.03)


def test_halt_stops_and_lets_go_on(azimuth):
    azimuth.turn(1.0)
    azimuth.command(ENABLE | HALT)
    wait_until(lambda: abs(azimuth.rate_deg_s) < 0.02 and azimuth.get(0x6041) & TARGET_REACHED, 1)
    assert azimuth.state == "OPERATION ENABLED"
    assert azimuth.mean_rate_deg_s() == pytest.approx(0.0, abs=0.01)
    azimuth.command(ENABLE)
    time.sleep(0.5)
    assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)


def test_quick_stop_ends_with_the_axis_off(azimuth):
    azimuth.turn(2.0)
    azimuth.command(0x02)
    assert wait_until(lambda: azimuth.state == "SWITCH ON DISABLED", 1) < 0.5
    wait_until(lambda: abs(azimuth.rate_deg_s) < 0.05, 0.3)  # friction removes the rest of the loop's lag


@pytest.mark.parametrize("shift_deg", [2.0, -1.0])
def test_pp_move_arrives(azimuth, shift_deg):
    azimuth.enable(PP)
    target = azimuth.get(0x6064) + tenth_micro_rad(shift_deg)
    azimuth.set(target, 0x607A)
    azimuth.command(ENABLE | NEW_SETPOINT)
    wait_until(lambda: azimuth.get(0x6041) & 0x1000, 1)  # acknowledged
    azimuth.command(ENABLE)
    wait_until(lambda: azimuth.get(0x6041) & TARGET_REACHED, 5)
    assert azimuth.get(0x6064) == pytest.approx(target, abs=tenth_micro_rad(0.005))


def test_pp_move_relative_arrives_on_pitch(pitch):
    start = pitch.get(0x6064)
    pitch.enable(PP)
    pitch.set(tenth_micro_rad(1.5), 0x607A)
    pitch.command(ENABLE | NEW_SETPOINT | 0x40)
    wait_until(lambda: pitch.get(0x6041) & 0x1000, 1)
    pitch.command(ENABLE)
    wait_until(lambda: pitch.get(0x6041) & TARGET_REACHED, 5)
    # While off, the axis was free to creep until it was enabled.
    assert pitch.get(0x6064) - start == pytest.approx(tenth_micro_rad(1.5), abs=tenth_micro_rad(0.05))


class Stream:
    """Sends target_at(t) once per cycle while it is open: without set-points a cyclic mode stops the axis."""

    def __init__(self, axis, n, name, target_at):
        axis.set(round(CYCLE_S * 1000), 0x60C2, 1)
        axis.node.rpdo[n].read()
        self.pdo = axis.node.rpdo[n]
        self.name = name
        self.target_at = target_at
        self.running = True
        self.thread = threading.Thread(target=self.run)

    def run(self):
        start, i = time.monotonic(), 0
        while self.running:
            self.pdo[self.name].raw = round(self.target_at(i * CYCLE_S))
            self.pdo.transmit()
            i += 1
            time.sleep(max(0.0, start + i * CYCLE_S - time.monotonic()))

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.running = False
        self.thread.join()


def test_csv_follows_a_stream_of_velocities(azimuth):
    azimuth.enable(CSV)
    with Stream(azimuth, 3, "Azimuth Target velocity", lambda t: micro_rad(min(1.0, t))):
        time.sleep(1.5)
        assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
        assert azimuth.get(0x6041) & FOLLOWED


def test_cyclic_mode_stops_the_axis_when_set_points_end(azimuth):
    azimuth.enable(CSV)
    with Stream(azimuth, 3, "Azimuth Target velocity", lambda t: micro_rad(1.0)):
        time.sleep(1.0)
    wait_until(lambda: abs(azimuth.rate_deg_s) < 0.05, 1)
    assert azimuth.state == "OPERATION ENABLED"
    assert not azimuth.get(0x6041) & FOLLOWED


def test_csp_follows_a_stream_of_positions(azimuth):
    azimuth.enable(CSP)
    start = azimuth.get(0x6064)

    def path(t):  # 1 deg in 2 s, from rest to rest
        return start + tenth_micro_rad(0.5 * (1 - math.cos(math.pi * min(t, 2.0) / 2)))

    with Stream(azimuth, 4, "Azimuth Target position", path):
        time.sleep(2.5)
        assert azimuth.state == "OPERATION ENABLED"
        assert azimuth.get(0x6064) == pytest.approx(path(2.0), abs=tenth_micro_rad(0.01))


def test_cst_gives_the_torque(azimuth):
    azimuth.enable(CST)

    def torques(permille, seconds):
        """Pairs of demanded and actual torque, read while the set-point is repeated."""
        seen, end = [], time.monotonic() + seconds
        while time.monotonic() < end:
            azimuth.set(permille, 0x6071)
            seen.append((azimuth.get(0x6074), azimuth.get(0x6077)))
        return [sum(column) / len(seen) for column in zip(*seen)]

    torques(100, 0.1)
    assert torques(100, 0.3) == pytest.approx([100, 100], abs=5)  # 4 Nm: below break-away
    assert abs(azimuth.rate_deg_s) < 0.3
    torques(400, 0.3)  # 16 Nm: above
    assert azimuth.rate_deg_s > 0.5


def test_mode_is_changed_while_the_axis_turns(azimuth):
    azimuth.turn(1.0)
    with Stream(azimuth, 3, "Azimuth Target velocity", lambda t: micro_rad(1.0)):
        azimuth.set(CSV, 0x6060)
        wait_until(lambda: azimuth.get(0x6061) == CSV, 1)
        assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
        azimuth.set(PV, 0x6060)
        wait_until(lambda: azimuth.get(0x6061) == PV, 1)
    assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
