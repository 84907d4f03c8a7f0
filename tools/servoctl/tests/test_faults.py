# SPDX-License-Identifier: Apache-2.0
"""Faults in words, and the fault log: the meaning of its bytes, and the entries of a simulated servo."""

from __future__ import annotations

import csv
import math
import struct
from collections.abc import Iterator
from pathlib import Path

import pytest

from servoctl.errors import NotVerified
from servoctl.objects.fault_log import FaultLog, parse_entry, write_snapshots
from servoctl.objects.fault_table import NO_FAULTS, FaultTable, load_faults

from .conftest import PARAMETERS, Bench, Eventually

OVER_SPEED, STUCK_ENCODER, ERRATIC_ENCODER, WATCHDOG, FOLLOWING_ERROR = 18, 3, 48, 30, 23


@pytest.fixture(scope="module")
def table() -> FaultTable:
    return load_faults(PARAMETERS.with_name("faults.json"))


def entry(tick: int, fault: int, axis: int, rows: list[list[float]]) -> bytes:
    head = struct.pack("<IBBBB", tick, fault, axis, len(rows), len(rows[0]))
    return head + b"".join(struct.pack(f"<{len(row)}f", *row) for row in rows)


def test_an_entry_has_its_signals_by_name_and_the_last_row_is_of_its_tick(table: FaultTable) -> None:
    found = parse_entry(entry(1, OVER_SPEED, 1, [[0.1] * 8, [0.2] * 8, [0.3] * 8]), 1501, table)
    assert (found.name, found.of, found.age_s) == ("over-speed", "pitch", 1.5)
    assert found.signals[0] == ("joint_angle", "rad") and found.signals[-1] == ("bus_voltage", "V")
    assert found.samples[2] == (0.3,) * 8 and found.ticks() == [0xFFFFFFFF, 0, 1]


def test_what_is_no_number_is_none_and_unknown_signals_are_counted(table: FaultTable) -> None:
    found = parse_entry(entry(9, 200, 0, [[math.nan, math.inf, 1.0]]), 9, table)
    assert found.samples == ((None, None, 1.0),)
    assert found.name == "fault 200" and found.signals == (("signal_1", ""), ("signal_2", ""), ("signal_3", ""))
    assert parse_entry(entry(9, 3, 0, [[1.0]]), 9, NO_FAULTS).name == "fault 3"


def test_a_fault_of_the_board_is_no_fault_of_an_axis_and_has_no_signals(table: FaultTable, tmp_path: Path) -> None:
    found = parse_entry(struct.pack("<IBBBB", 7, WATCHDOG, 2, 0, 8), 8, table)
    assert (found.name, found.of, found.samples) == ("watchdog reset", "board", ())
    assert parse_entry(entry(7, 33, 1, [[0.0] * 8]), 8, table).of == "pitch"  # the board's, but reported for this axis
    assert parse_entry(entry(7, 1, 9, [[0.0] * 8]), 8, table).of == "source 9"
    assert write_snapshots(FaultLog(1, (found,)), tmp_path / "none") == []


@pytest.mark.parametrize("cut", [-1, -7, 4])
def test_bytes_that_are_no_entry_are_reported(table: FaultTable, cut: int) -> None:
    with pytest.raises(NotVerified, match="bytes"):
        parse_entry(entry(1, 1, 0, [[0.0] * 8])[:cut], 1, table)


def test_a_code_of_several_faults_is_distinguished_by_the_number_that_came_with_it(table: FaultTable) -> None:
    assert [words.name for words in table.reported(0x7320, 1 << 8 | STUCK_ENCODER)] == ["encoder stuck"]
    assert table.meaning(0x7320) == "encoder lost or encoder jump or encoder stuck or encoder erratic"
    assert [words.name for words in table.reported(0x8140, 0)] == ["recovered from bus-off"]  # the node itself
    assert [words.name for words in table.reported(0x8140, 2 << 8)] == ["bus-off"]  # pitch
    assert [words.name for words in table.reported(0x5000, 3 << 8 | 1)] == ["self-test failed"]
    assert table.meaning(0x8899) == "monitoring error" and table.meaning(0) == "no error"


@pytest.fixture
def lagging(servo: Bench, eventually: Eventually) -> Iterator[Bench]:
    """The pitch axis in the fault following error, with an empty log before; the window is restored afterwards.

    The window (6065) is narrowed while the axis moves.
    """
    assert servo("faults", "--clear").code == 0
    window, time_out = "pitch.following_error_window", "pitch.following_error_time_out"
    before = {name: servo.value(name) for name in (window, time_out)}
    servo.json("move", "pitch", "--to", "0", "--rate", "20", "--yes")
    move = servo.start("move", "pitch", "--to", "60", "--rate", "2", "--yes")  # long enough for a busy computer
    eventually(lambda: move.poll() is not None or servo.json("state", "pitch")["axes"][0]["rate_deg_s"] > 1.5, 30)
    assert move.poll() is None, move.communicate()
    servo.json("set", f"{window}=1", f"{time_out}=0")
    eventually(lambda: servo.json("state", "pitch")["axes"][0]["state"] == "fault", 30)
    assert move.wait(timeout=60) == 6
    servo.json("set", *(f"{name}={value}" for name, value in before.items()))
    yield servo
    servo.json("state", "pitch", "reset")


@pytest.mark.image
@pytest.mark.smoke
def test_a_fault_is_shown_with_time_signals_cause_and_cure(lagging: Bench) -> None:
    found = lagging.json("faults", "--csv", "before")
    axis = found["axes"][1]
    assert (axis["code"], axis["meaning"], axis["faults"][0]["number"]) == (0x8611, "following error", FOLLOWING_ERROR)
    assert (found["history"][0]["meaning"], found["history"][0]["origin"]) == ("following error", "pitch")
    log = found["log"]
    newest = log["entries"][0]
    assert log["count"] == 1 and (newest["name"], newest["of"]) == ("following error", "pitch")
    assert 0 < newest["age_s"] < 60
    rates = [row[[s["name"] for s in newest["signals"]].index("joint_rate")] for row in newest["samples"]]
    assert len(rates) == 16 and all(0.01 < rate < 0.05 for rate in rates[-2:])
    with Path(lagging.folder / found["files"][0]).open() as file:
        rows = list(csv.DictReader(file))
    assert [int(row["tick"]) for row in rows] == list(range(newest["tick"] - 15, newest["tick"] + 1))
    assert [float(row["joint_rate (rad/s)"]) for row in rows] == rates
    text = lagging("faults").out
    for part in ("following error (active)", "cause", "check", "cure", "cleared by", "voltage"):
        assert part in text


def test_clear_writes_the_files_first_and_then_forgets_history_and_log(lagging: Bench) -> None:
    found = lagging.json("faults", "--clear", "--csv", "kept")
    assert len(found["files"]) == 1 and (lagging.folder / found["files"][0]).stat().st_size > 500
    assert found["log"] == {"count": 0, "entries": []} and found["history"] == []
    assert found["axes"][1]["code"] == 0x8611  # active values stay
    assert "is empty" in lagging("faults").out


def test_a_node_without_a_fault_log_is_reported_in_a_sentence(test_node: Bench) -> None:
    assert "no fault log (3020)" in test_node("faults").out
    assert test_node.json("faults")["log"] is None


def test_explain_reports_all_that_a_code_may_mean(servo: Bench) -> None:
    found = servo.json("explain", "7320h")
    assert [fault["number"] for fault in found["faults"]] == [1, 2, 3, ERRATIC_ENCODER]
    assert servo.json("explain", "0x8210")["meaning"] == "PDO too short"
    text = servo("explain", "0x8611").out
    for key in ("detection", "cause", "check", "cure", "clear"):
        assert key in text


def test_faults_of_other_firmware_are_named_by_the_table_that_servoctl_carries(lagging: Bench, elsewhere: Bench) -> None:
    found = elsewhere.json("faults")
    assert (found["axes"][1]["code"], found["axes"][1]["meaning"]) == (0x8611, "following error")
    assert elsewhere.json("info")["schema_fits"] is False


def test_without_faults_json_numbers_are_shown_and_one_that_was_used_is_remembered(
    lagging: Bench, elsewhere: Bench
) -> None:
    installed = elsewhere
    (installed.folder / "descriptions" / "faults.json").unlink()
    found = installed.json("faults")
    assert (found["axes"][1]["code"], found["axes"][1]["meaning"]) == (0x8611, "monitoring error")
    assert found["log"]["entries"][0]["name"] == f"fault {FOLLOWING_ERROR}"
    installed.json("faults", "--parameters", str(PARAMETERS))
    assert installed.json("faults")["axes"][1]["meaning"] == "following error"
