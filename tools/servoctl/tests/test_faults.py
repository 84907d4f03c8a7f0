"""Faults in words, and the fault log: the meaning of its bytes, and the entries of a simulated servo."""

from __future__ import annotations

import csv
import math
import re
import shutil
import struct
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from servoctl.errors import NotVerified
from servoctl.fault_log import FaultLog, parse_entry, write_snapshots
from servoctl.fault_table import NO_FAULTS, FaultTable, load_faults

from .conftest import PACKAGE, PARAMETERS, Bench

OVER_SPEED, STUCK_ENCODER, WATCHDOG = 18, 3, 30


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
    assert table.meaning(0x7320) == "encoder lost or encoder jump or encoder stuck"
    assert [words.name for words in table.reported(0x8140, 0)] == ["recovered from bus-off"]  # the node itself
    assert [words.name for words in table.reported(0x8140, 2 << 8)] == ["bus-off"]  # pitch
    assert [words.name for words in table.reported(0x5000, 3 << 8 | 1)] == ["self-test failed"]
    assert table.meaning(0x8899) == "monitoring error" and table.meaning(0) == "no error"


def _wait(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + 30
    while not condition():
        assert time.monotonic() < end, "not within 30 s"


@pytest.fixture
def too_fast(servo: Bench) -> Iterator[Bench]:
    """The pitch axis in the fault over-speed, with an empty log before; the limit is restored afterwards.

    The limit is lowered while it turns: neither `move` nor the node lets it exceed a limit that is set before.
    """
    assert servo("faults", "--clear").code == 0
    limit, mode, target = "pitch.protection.over_speed_limit", "pitch.modes_of_operation", "pitch.target_velocity"
    before = servo.value(limit)
    servo.json("state", "pitch", "enable")
    servo.json("set", f"{mode}=3", f"{target}=34907")
    _wait(lambda: servo.json("state", "pitch")["axes"][0]["rate_deg_s"] > 1.5)
    servo.json("set", f"{limit}=0.01", "--unlock")
    _wait(lambda: servo.json("state", "pitch")["axes"][0]["state"] == "fault")
    servo.json("set", f"{limit}={before}", f"{mode}=0", f"{target}=0", "--unlock")
    yield servo
    servo.json("state", "pitch", "reset")


def test_a_fault_is_shown_with_time_signals_cause_and_cure(too_fast: Bench) -> None:
    found = too_fast.json("faults", "--csv", "before")
    axis = found["axes"][1]
    assert (axis["code"], axis["meaning"], axis["faults"][0]["number"]) == (0x8481, "over-speed", OVER_SPEED)
    assert (found["history"][0]["meaning"], found["history"][0]["origin"]) == ("over-speed", "pitch")
    log = found["log"]
    newest = log["entries"][0]
    assert log["count"] == 1 and (newest["name"], newest["of"]) == ("over-speed", "pitch")
    assert 0 < newest["age_s"] < 60
    rates = [row[[s["name"] for s in newest["signals"]].index("joint_rate")] for row in newest["samples"]]
    assert len(rates) == 16 and all(0.01 < rate < 0.05 for rate in rates[-2:])
    with Path(too_fast.folder / found["files"][0]).open() as file:
        rows = list(csv.DictReader(file))
    assert [int(row["tick"]) for row in rows] == list(range(newest["tick"] - 15, newest["tick"] + 1))
    assert [float(row["joint_rate (rad/s)"]) for row in rows] == rates
    text = too_fast("faults").out
    for part in ("over-speed (active)", "cause", "check", "cure", "cleared by", "voltage"):
        assert part in text


def test_clear_writes_the_files_first_and_then_forgets_history_and_log(too_fast: Bench) -> None:
    found = too_fast.json("faults", "--clear", "--csv", "kept")
    assert len(found["files"]) == 1 and (too_fast.folder / found["files"][0]).stat().st_size > 500
    assert found["log"] == {"count": 0, "entries": []} and found["history"] == []
    assert found["axes"][1]["code"] == 0x8481  # active values stay
    assert "is empty" in too_fast("faults").out


def test_a_node_without_a_fault_log_is_reported_in_a_sentence(test_node: Bench) -> None:
    assert "no fault log (3020)" in test_node("faults").out
    assert test_node.json("faults")["log"] is None


def test_explain_reports_all_that_a_code_may_mean(servo: Bench) -> None:
    found = servo.json("explain", "7320h")
    assert [fault["number"] for fault in found["faults"]] == [1, 2, 3]
    assert servo.json("explain", "0x8210")["meaning"] == "PDO too short"
    text = servo("explain", "0x8611").out
    for key in ("detection", "cause", "check", "cure", "clear"):
        assert key in text


@pytest.fixture
def of_other_firmware(too_fast: Bench) -> Bench:
    """servoctl away from any build, released for firmware of another schema hash."""
    shutil.rmtree(too_fast.folder / "cache", ignore_errors=True)
    shutil.copytree(PACKAGE / "servoctl", too_fast.folder / "lib" / "servoctl")
    carried = too_fast.folder / "lib" / "servoctl" / "descriptions" / "parameters.json"
    carried.write_text(re.sub(r'"schema_hash": *\d+', '"schema_hash": 1', carried.read_text()))
    installed = Bench(too_fast.bus, too_fast.folder)
    installed.environment["PYTHONPATH"] = str(too_fast.folder / "lib")
    del installed.environment["SERVOCTL_PARAMETERS"]
    return installed


def test_faults_of_other_firmware_are_named_by_the_table_that_servoctl_carries(of_other_firmware: Bench) -> None:
    found = of_other_firmware.json("faults")
    assert (found["axes"][1]["code"], found["axes"][1]["meaning"]) == (0x8481, "over-speed")
    assert of_other_firmware.json("info")["schema_fits"] is False


def test_without_faults_json_numbers_are_shown_and_one_that_was_used_is_remembered(of_other_firmware: Bench) -> None:
    installed = of_other_firmware
    (installed.folder / "lib" / "servoctl" / "descriptions" / "faults.json").unlink()
    found = installed.json("faults")
    assert (found["axes"][1]["code"], found["axes"][1]["meaning"]) == (0x8481, "monitoring error")
    assert found["log"]["entries"][0]["name"] == f"fault {OVER_SPEED}"
    installed.json("faults", "--parameters", str(PARAMETERS))
    assert installed.json("faults")["axes"][1]["meaning"] == "over-speed"
