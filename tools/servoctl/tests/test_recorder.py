# SPDX-License-Identifier: Apache-2.0
"""Ticks from frames: a loss is a gap, and never a mixture of two ticks."""

from __future__ import annotations

import itertools
import struct
from pathlib import Path

import numpy as np
import pytest

from servoctl.errors import MotionError
from servoctl.identify.recorder import HYSTERESIS, TickGatherer, decode
from servoctl.link.pdo_loan import borrowed_identifiers

TURN32 = 2**32 / (2 * np.pi)


def frames_of(number: int, kind: int = 0, run: int = 0, angle_rad: float = 0.0, reference: float = 0.0) -> list[bytes]:
    """The three frames of a tick, whose torque is its number."""
    angle = round(angle_rad * TURN32) & 0xFFFFFFFF
    return [
        struct.pack("<If", angle, 0.0),
        struct.pack("<ff", float("nan"), float(number)),
        struct.pack("<HBBf", number & 0xFFFF, kind, run, reference),
    ]


def gathered(ticks: list[list[bytes]], lost: set[int]) -> list[tuple[int, float]]:
    """(number, torque) of the ticks that a receiver combines when it does not get some of the frames."""
    gatherer = TickGatherer()
    for position, (tick, which) in enumerate(itertools.product(range(len(ticks)), range(3))):
        if position not in lost:
            gatherer.take(which, ticks[tick][which])
    raw = bytes(gatherer.ticks)
    rows = [raw[i : i + 24] for i in range(0, len(raw), 24)]
    return [(struct.unpack("<H", row[16:18])[0], struct.unpack("<f", row[12:16])[0]) for row in rows]


def test_nothing_lost_gives_every_tick_after_the_first() -> None:
    assert gathered([frames_of(n) for n in range(5)], set()) == [(n, float(n)) for n in range(1, 5)]


def test_no_loss_of_up_to_four_frames_mixes_two_ticks() -> None:
    ticks = [frames_of(n) for n in range(5)]
    for count in range(1, 5):
        for lost in itertools.combinations(range(15), count):
            found = gathered(ticks, set(lost))
            assert all(number == torque for number, torque in found), lost
            assert len(found) >= 4 - 2 * count


def test_a_tick_that_the_sender_skips_is_a_gap_in_time() -> None:
    ticks = [b"".join(frames_of(n)) for n in (65534, 65535, 0, 1, 5, 6)]
    found = decode(b"".join(ticks))
    assert np.diff(found.time_s) == pytest.approx([1e-3, 1e-3, 1e-3, 4e-3, 1e-3])
    assert found.missing == 3


def test_runs_count_experiments_and_the_moves_between_and_angles_go_on_over_the_turn() -> None:
    kinds = [(0, 0)] * 2 + [(HYSTERESIS, 1)] * 3 + [(0, 1)] * 2 + [(HYSTERESIS, 2)] * 2
    angles = 3.13 + 0.01 * np.arange(len(kinds))
    ticks = [
        frames_of(n, kind, run, angle, (angle + np.pi) % (2 * np.pi) - np.pi)
        for n, ((kind, run), angle) in enumerate(zip(kinds, angles, strict=True))
    ]
    found = decode(b"".join(itertools.chain(*ticks)), near_rad=3.0 + 4 * np.pi)
    assert list(found.run) == [1, 1, 2, 2, 2, 3, 3, 4, 4]
    assert list(found.kind) == [1, 1, 3, 3, 3, 1, 1, 3, 3]
    assert found.joint_angle_rad == pytest.approx(angles + 4 * np.pi)
    loops = found.kind == HYSTERESIS
    assert found.reference[loops] == pytest.approx(found.joint_angle_rad[loops], abs=1e-6)
    assert np.isnan(found.inertial_rate_rad_s).all()


def test_the_share_of_a_run_that_is_missing_is_reported() -> None:
    ticks = [frames_of(n, 1, 1) for n in range(100) if n not in (50, 51)]
    found = decode(b"".join(itertools.chain(*ticks)))
    assert found.missing_share(1) == pytest.approx(0.02)


def test_a_recording_is_written_as_the_fit_reads_it(tmp_path: Path) -> None:
    path = tmp_path / "runs.csv"
    decode(b"".join(itertools.chain(*(frames_of(n) for n in range(3))))).write(path)
    rows = path.read_text().splitlines()
    assert rows[0] == "time_s,run,kind,joint_angle_rad,joint_rate_rad_s,inertial_rate_rad_s,torque_nm,reference"
    assert rows[1] == "0.000,1,1,0,0,nan,0,0" and rows[3].startswith("0.002,1,1,")


def test_without_a_tick_there_is_no_recording() -> None:
    with pytest.raises(MotionError):
        decode(b"")


def test_the_nodes_of_a_bus_borrow_identifiers_of_their_own() -> None:
    twelve = [borrowed_identifiers(node) for node in range(1, 13)]
    assert len({identifier for each in twelve for identifier in each}) == 48
    assert all(0x6B0 <= identifier <= 0x6DF and list(each) == sorted(each) for each in twelve for identifier in each)
    assert borrowed_identifiers(13) == borrowed_identifiers(1) and len(borrowed_identifiers(127, 3)) == 3
