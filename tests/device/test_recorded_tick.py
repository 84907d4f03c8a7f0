# SPDX-License-Identifier: Apache-2.0
"""Every tick of an axis over three PDOs (0x2101): complete, in order, and consistent with the other objects."""

import math
import struct

import pytest
from device import REAL_TIME

from test_experiment import COUNT, DONE, DWELL, KIND, QUICK_SWEEP, SWEEP, Experiment, enable_at_rest

# A client that reads three frames in every tick; runs are counted from power-on.
pytestmark = [pytest.mark.speed(0.5 * REAL_TIME), pytest.mark.power_on]
IDENTIFIERS = (0x6A0, 0x6A1, 0x6A2)
FRAMES = ([(4, 32), (5, 32)], [(6, 32), (7, 32)], [(1, 16), (2, 8), (3, 8), (8, 32)])


@pytest.fixture
def record(master, node):
    """Starts the three PDOs, every so many ms. What it returns grows: rows (angle, joint rate, inertial rate, torque, number, kind, run, reference)."""
    return lambda every_ms: rows_of(master, node, every_ms)


def rows_of(master, node, every_ms):
    rows, parts = [], {}

    def take(cob_id, data, _timestamp):
        parts[cob_id] = bytes(data)
        if cob_id == IDENTIFIERS[2] and len(parts) == 3:
            rows.append(struct.unpack("<IfffHBBf", b"".join(parts[i] for i in IDENTIFIERS)))
            parts.clear()

    node.nmt.send_command(0x80)  # until all is set up: SDO is slow while frames come in every tick
    master.wait_for_state(127)
    for n, (identifier, entries) in enumerate(zip(IDENTIFIERS, FRAMES, strict=True), 1):
        communication, mapping = node.sdo[0x1800 + n], node.sdo[0x1A00 + n]
        communication[1].raw |= 1 << 31
        mapping[0].raw = 0
        for sub, (source, bits) in enumerate(entries, 1):
            mapping[sub].raw = 0x2101 << 16 | source << 8 | bits
        mapping[0].raw = len(entries)
        communication[3].raw = 0
        communication[5].raw = every_ms
        communication[1].raw = identifier
        node.network.subscribe(identifier, take)
    master.start()
    rows.clear()
    return rows


def test_every_tick_comes_once_and_in_order(master, record):
    ticks = record(1)
    master.forget()
    master.wait_for(IDENTIFIERS[2], 1000)
    numbers = [row[4] for row in ticks]
    assert all((b - a) & 0xFFFF == 1 for a, b in zip(numbers, numbers[1:], strict=False))


def test_a_tick_reports_angle_rates_and_torque_of_the_axis(record, azimuth):
    ticks = record(10)  # SDO would be slow beside all of them
    azimuth.turn(2.0)
    begin = len(ticks)
    reported = []
    while len(ticks) < begin + 20:
        reported.append(azimuth.get(0x6077))
    end = len(ticks)
    angle, joint_rate, inertial_rate, torque, _, kind, _, reference = (list(c) for c in zip(*ticks[-100:], strict=True))
    travelled_rad = ((angle[-1] - angle[0]) & 0xFFFFFFFF) * 2 * math.pi / 2**32
    assert travelled_rad == pytest.approx(0.99 * math.radians(2), rel=0.1)
    assert sum(joint_rate) / 100 == pytest.approx(math.radians(2), rel=0.1)
    assert sum(inertial_rate) / 100 == pytest.approx(math.radians(2), rel=0.1)
    assert reference[-1] == pytest.approx(math.radians(2), rel=1e-3)
    assert set(kind) == {0}
    rated_nm = 1e-3 * azimuth.get(0x6076)
    meanwhile = [row[3] for row in ticks[begin:end]]
    assert sum(meanwhile) / len(meanwhile) == pytest.approx(1e-3 * rated_nm * sum(reported) / len(reported), abs=2)
    assert min(torque) < max(torque)


def test_kind_and_run_begin_and_end_with_the_experiment(record, azimuth):
    ticks = record(10)
    enable_at_rest(azimuth)
    experiment = Experiment(azimuth)
    for _ in range(2):
        experiment.start(QUICK_SWEEP | {KIND: SWEEP, COUNT: 2, DWELL: 0.1})
        assert experiment.wait_for_end() == DONE
        azimuth.wait_until(lambda: azimuth.get(0x606B) == 0 and abs(azimuth.rate_deg_s) < 0.05)
    azimuth.command(0x00)
    shown = [(row[5], row[6]) for row in ticks]
    changes = [shown[0]] + [b for a, b in zip(shown, shown[1:], strict=False) if a != b]
    assert changes == [(0, 0), (SWEEP, 1), (0, 1), (SWEEP, 2), (0, 2)]
    during = [row for row in ticks if row[5] == SWEEP]
    assert max(row[7] for row in during) == pytest.approx(0.01) and min(row[7] for row in during) == pytest.approx(-0.01)
