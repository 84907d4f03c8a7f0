# SPDX-License-Identifier: Apache-2.0
"""Experiments (0x2100) as a client starts and monitors them: on the axis, within limits, ended by any error."""

import struct

import canopen
import pytest

from axis import PV

NONE = 0
START, ABORT = 1, 2
RUNS, DONE, ABORTED, LEFT_TRAVEL, TOO_FAST, TOO_LONG, DRIVE_STOPPED = range(1, 8)
SWEEP, RAMPS, LOOPS, CHIRP, BREAKAWAY = range(1, 6)
COMMAND, STATE, PROGRESS, KIND, COUNT, DWELL = range(1, 7)
SPEED, RATIO, ACCELERATION, TORQUE, ANGLE, LOW_HZ, HIGH_HZ = range(7, 14)
TRAVEL, SPEED_LIMIT, TORQUE_LIMIT, TIME_LIMIT, DURATION = range(14, 19)

QUICK_SWEEP = {KIND: SWEEP, COUNT: 3, DWELL: 0.2, SPEED: 0.005, RATIO: 2.0, ACCELERATION: 0.5, TRAVEL: 0.2,
               TORQUE_LIMIT: 30.0}  # the seal and the wind can need more than the 10 N m of the default


class Experiment:
    def __init__(self, axis):
        self.axis = axis
        self.record = axis.node.sdo[0x2100 + axis.shift]

    def set_up(self, values):
        for sub, value in values.items():
            self.record[sub].raw = value

    def start(self, values):
        self.set_up(values)
        self.record[COMMAND].raw = START

    @property
    def state(self):
        return self.record[STATE].raw

    def wait_for_end(self, seconds=10):
        self.axis.wait_until(lambda: self.state != RUNS, seconds)
        return self.state


def enable_at_rest(axis):
    """The wind may have turned the axis while it was off; the drive brings it to rest along its ramp."""
    axis.enable(NONE)
    axis.wait_until(lambda: axis.get(0x606B) == 0 and abs(axis.rate_deg_s) < 0.05, 2)


@pytest.fixture
def experiment(azimuth):
    enable_at_rest(azimuth)
    return Experiment(azimuth)


def test_a_sweep_runs_to_its_end_and_leaves_the_axis_at_rest(experiment, azimuth):
    experiment.start(QUICK_SWEEP)
    assert experiment.state == RUNS
    azimuth.wait_until(lambda: abs(azimuth.rate_deg_s) > 0.2, 5)
    assert experiment.wait_for_end() == DONE
    assert experiment.record[PROGRESS].raw == 100
    azimuth.wait_for_standstill(1)
    assert azimuth.state == "OPERATION ENABLED"


def test_the_duration_is_reported_before_anything_moves(experiment):
    experiment.set_up(QUICK_SWEEP)
    assert experiment.record[DURATION].raw == pytest.approx(sum(2 * (0.2 + 2 * speed / 0.5) for speed in (0.005, 0.01, 0.02)), rel=1e-4)


def test_it_starts_only_in_operation_at_rest_and_without_a_mode(experiment, azimuth):
    experiment.set_up(QUICK_SWEEP)
    before = experiment.state

    def refused(code):
        with pytest.raises(canopen.SdoAbortedError) as error:
            experiment.record[COMMAND].raw = START
        assert error.value.code == code
        assert experiment.state == before

    azimuth.turn(1.0, settle_s=0.2)  # in pv
    refused(0x08000022)
    azimuth.command(0x06)
    azimuth.node.sdo[0x6060 + azimuth.shift].raw = NONE
    refused(0x08000022)
    enable_at_rest(azimuth)
    experiment.record[KIND].raw = LOOPS
    experiment.record[ANGLE].raw = 0.5  # beyond the travel limit
    refused(0x06040043)


def test_leaving_the_travel_ends_it_and_the_axis_stops(experiment, azimuth):
    # Torque above the seal's: the axis accelerates until a limit stops it.
    experiment.start({KIND: RAMPS, COUNT: 1, DWELL: 4.0, TORQUE: 30.0, TORQUE_LIMIT: 30.0, TRAVEL: 0.01,
                      SPEED_LIMIT: 10.0})
    assert experiment.wait_for_end() == LEFT_TRAVEL
    azimuth.wait_for_standstill(2)
    assert azimuth.state == "OPERATION ENABLED"


def test_position_limits_end_it_before_they_are_passed(experiment, azimuth):
    here = azimuth.get(0x6064)
    azimuth.node.sdo[0x607D][1].raw = here - 200000
    azimuth.node.sdo[0x607D][2].raw = here + 100000  # 10 mrad
    farthest = 0
    experiment.start({KIND: LOOPS, COUNT: 2, DWELL: 4.0, ANGLE: 0.08, TRAVEL: 0.2, SPEED_LIMIT: 0.5})
    while experiment.state == RUNS:
        farthest = max(farthest, azimuth.get(0x6064) - here)
    assert experiment.state == DRIVE_STOPPED
    azimuth.wait_for_standstill(2)
    assert max(farthest, azimuth.get(0x6064) - here) < 200000  # stopping distance from 80 mrad/s at 1 rad/s^2: 3 mrad
    azimuth.node.sdo[0x607D][1].raw = azimuth.node.sdo[0x607D][2].raw = 0
    experiment.start(QUICK_SWEEP)
    assert experiment.wait_for_end() == DONE


def test_607f_holds_for_the_position_loop_of_an_experiment(experiment, azimuth):
    azimuth.set(10000, 0x607F)  # 10 mrad/s, the triangle requires 40
    azimuth.master.forget()
    experiment.start({KIND: LOOPS, COUNT: 1, DWELL: 4.0, ANGLE: 0.04, TRAVEL: 0.2, SPEED_LIMIT: 0.2})
    frames, so_far = [], []
    while experiment.state == RUNS:
        frames, so_far = so_far, azimuth.master.heard(0x381)  # those before a reading of the state were during the run
    fastest = max(abs(struct.unpack_from("<l", frame)[0]) for frame in frames)
    assert 9000 < fastest < 12500  # 110 %, and the noise


def test_an_abort_stops_the_axis(experiment, azimuth):
    experiment.start(QUICK_SWEEP | {DWELL: 5.0, SPEED: 0.02, TRAVEL: 0.5, COUNT: 1})
    azimuth.wait_until(lambda: abs(azimuth.rate_deg_s) > 0.9, 2)
    experiment.record[COMMAND].raw = ABORT
    assert experiment.state == ABORTED
    azimuth.wait_for_standstill(1)


def test_choosing_a_mode_a_quick_stop_or_a_silent_master_ends_it(experiment, azimuth, node):
    long = QUICK_SWEEP | {DWELL: 5.0, SPEED: 0.02, TRAVEL: 0.5, COUNT: 1}
    experiment.start(long)
    azimuth.node.sdo[0x6060 + azimuth.shift].raw = PV
    assert experiment.wait_for_end(2) == DRIVE_STOPPED
    azimuth.node.sdo[0x6060 + azimuth.shift].raw = NONE
    enable_at_rest(azimuth)
    experiment.start(long)
    azimuth.command(0x02)
    assert experiment.wait_for_end(2) == DRIVE_STOPPED
    enable_at_rest(azimuth)
    experiment.start(long)
    node.sdo[0x1016][1].raw = 0x7E << 16 | 100
    node.network.send_message(0x77E, [5])
    assert experiment.wait_for_end(2) == DRIVE_STOPPED
    azimuth.wait_for_state("FAULT", 2)
    azimuth.wait_for_standstill(2)
