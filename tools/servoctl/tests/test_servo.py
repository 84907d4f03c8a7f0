# SPDX-License-Identifier: Apache-2.0
"""servoctl at a simulated servo: reading, setting, saving; the device's values are always read back."""

from __future__ import annotations

import json
import os
import threading
from pathlib import Path

import pytest

from .conftest import PARAMETERS, Bench

GAIN = "azimuth.speed_loop.proportional_gain"
COULOMB = "azimuth.friction_feedforward.coulomb_torque_positive"


@pytest.mark.image
def test_scan_finds_the_node_with_both_axes(servo: Bench) -> None:
    found = servo.json("scan")
    assert [(f["node"], f["name"], f["axes"]) for f in found] == [(1, "trackservo", ["azimuth", "pitch"])]


@pytest.mark.image
@pytest.mark.smoke
def test_info_reports_that_the_schema_fits(servo: Bench) -> None:
    data = servo.json("info")
    assert data["schema_fits"] and data["schema"] == json.loads(PARAMETERS.read_text())["schema_hash"]
    assert [a["state"] for a in data["axes"]] == ["switch on disabled"] * 2


def test_get_by_name_by_ending_and_by_index_agree(servo: Bench) -> None:
    value = servo.value(GAIN)
    assert servo.json("get", "speed_loop.proportional_gain", "--axis", "azimuth")[0]["value"] == value
    assert servo.json("get", "0x2000:1")[0]["value"] == value


@pytest.mark.image
@pytest.mark.smoke
def test_set_is_in_force_at_once_and_undo_takes_it_back(servo: Bench) -> None:
    before = servo.value(GAIN)
    crc = servo.json("info")["axes"][0]["active_crc"]
    changed = servo.json("set", GAIN, str(before + 10))[0]
    assert (changed["old"], changed["value"], changed["in_force"]) == (
        before,
        pytest.approx(before + 10, rel=1e-6),
        True,
    )
    assert servo.json("info")["axes"][0]["active_crc"] != crc
    assert servo.json("undo")[0]["value"] == before
    assert servo.json("info")["axes"][0]["active_crc"] == crc
    assert servo("undo").code == 2


def test_undo_leaves_alone_what_somebody_else_has_changed_since(servo: Bench, tmp_path: Path) -> None:
    before = servo.value(GAIN)
    servo.json("set", GAIN, str(before + 5))
    other = Bench(servo.bus, tmp_path / "..")
    other.environment["SERVOCTL_STATE"] = str(tmp_path / "other")
    other.json("set", GAIN, str(before + 7))
    refused = servo("undo")
    assert refused.code == 4 and "another client" in refused.err
    other.json("undo")
    servo.json("undo")
    assert servo.value(GAIN) == before


def test_nothing_changes_when_the_journal_cannot_be_written(servo: Bench, tmp_path: Path) -> None:
    before = servo.value(GAIN)
    (tmp_path / "file").touch()
    other = Bench(servo.bus, tmp_path)
    other.environment["SERVOCTL_STATE"] = str(tmp_path / "file" / "state")
    refused = other("set", GAIN, str(before + 5))
    assert refused.code == 2 and "the journal cannot be written: Not a directory. Nothing was changed." in refused.err
    assert servo.value(GAIN) == before


@pytest.mark.image
def test_the_devices_own_undo_works_and_is_journalled(servo: Bench) -> None:
    before = servo.value(GAIN)
    servo.json("set", GAIN, str(before + 3))
    assert servo.json("undo", "--device", "--axis", "azimuth")[0]["value"] == before
    journal = [json.loads(line) for line in next((servo.folder / "state").glob("*.jsonl")).read_text().splitlines()]
    assert [(e["command"], e["name"]) for e in journal] == [("set", GAIN), ("undo", GAIN)]
    assert journal[0]["old"] == before


def test_a_contradicting_set_is_refused_as_a_whole(servo: Bench) -> None:
    before = servo.json("get")
    refused = servo("set", f"{GAIN}=800", f"{COULOMB}=50")
    breakaway = servo.value("azimuth.friction_feedforward.break_away_torque_positive")
    assert refused.code == 4
    assert (
        f"2030:8 Break-away torque positive is {breakaway} N m; give 50.0 .. 10000.0,"
        " since 2030:7 Coulomb torque positive is 50.0 N m." in refused.err
    )
    assert servo.json("get") == before
    assert not servo.json("info")["axes"][0]["staged"]


def test_a_set_of_both_axes_that_is_refused_by_the_second_is_in_force_on_none(servo: Bench) -> None:
    before = servo.json("get")
    refused = servo("set", f"{GAIN}={servo.value(GAIN) + 10}", f"{COULOMB.replace('azimuth', 'pitch')}=50")
    assert refused.code == 4 and "2830:8" in refused.err
    assert servo.json("get") == before
    assert not any(axis["staged"] for axis in servo.json("info")["axes"])


def test_a_refused_set_of_pitch_names_its_own_object_and_what_switches_a_filter_off(servo: Bench) -> None:
    refused = servo("set", "pitch.filters.notch_frequency=0.5")
    assert refused.code == 4
    assert "2840:1 Notch frequency is 0.5 Hz; give 1.0 .. 490.0, or 0.0." in refused.err


@pytest.mark.parametrize(
    "words", [(GAIN, "1e9"), (GAIN, "nan"), (GAIN, "5 kg"), ("azimuth.statusword", "1"), ("nothing", "1"), (GAIN,), ()]
)
def test_bad_input_changes_nothing_and_exits_with_2(servo: Bench, words: tuple[str, ...]) -> None:
    before = servo.value(GAIN)
    result = servo("set", *words)
    assert result.code == 2 and result.err.startswith("servoctl") and result.err.count("\n") == 1
    assert servo.value(GAIN) == before


@pytest.mark.image
def test_staged_values_wait_until_they_are_applied(servo: Bench) -> None:
    before = servo.value(GAIN)
    crc = servo.json("info")["axes"][0]["active_crc"]
    servo.json("set", "--stage", GAIN, str(before + 20))
    state = servo.json("info")["axes"][0]
    assert state["staged"] and state["active_crc"] == crc
    assert servo.json("get", GAIN)[0]["in_force"] is False
    refused = servo("set", "azimuth.speed_loop.integral_gain", "20000")
    assert refused.code == 4 and "staged values" in refused.err
    assert servo("save", "x.toml").code == 4
    servo.json("undo", "--staged", "--axis", "azimuth")
    assert servo.value(GAIN) == before


@pytest.mark.image
@pytest.mark.smoke
def test_save_diff_restore_go_round(servo: Bench) -> None:
    servo.json("save", "gains.toml")
    assert servo("diff", "gains.toml").code == 0
    before = servo.json("get")
    servo.json("set", f"{GAIN}=555", "pitch.position_loop.gain=8", "azimuth.profile_velocity=200000")
    result = servo("diff", "gains.toml", "--json")
    assert result.code == 1 and len(result.data["different"]) == 3
    assert servo("restore", "gains.toml", "--dry-run", "--json").code == 0
    assert servo.value(GAIN) == 555
    assert len(servo.json("restore", "gains.toml")) == 3
    assert servo("diff", "gains.toml").code == 0
    assert servo.json("get") == before
    assert len(servo.json("undo")) == 3
    assert servo.value(GAIN) == 555
    servo.json("restore", "gains.toml")


def test_a_gains_file_that_contradicts_itself_changes_nothing(servo: Bench) -> None:
    servo.json("save", "gains.toml")
    before = servo.json("get")
    text = (
        (servo.folder / "gains.toml")
        .read_text()
        .replace("[azimuth.friction_feedforward]", "[azimuth.friction_feedforward]", 1)
    )
    lines = [
        "coulomb_torque_positive = 99.0" if line.startswith("coulomb_torque_positive") else line
        for line in text.splitlines()
    ]
    (servo.folder / "bad.toml").write_text("\n".join(lines).replace("gain = 10.0", "gain = 9.0"))
    assert servo("restore", "bad.toml").code == 4
    assert servo.json("get") == before


@pytest.mark.image
def test_store_writes_a_backup_before_and_reads_the_crc_back(servo: Bench) -> None:
    before = servo.value(GAIN)
    servo.json("set", GAIN, "701")
    assert servo.json("info")["axes"][0]["differs_from_stored"]
    done = servo.json("store")
    assert Path(done["backup"]).read_text().count("proportional_gain = 701.0") == 1
    state = servo.json("info")["axes"][0]
    assert not state["differs_from_stored"] and state["stored_crc"] == state["active_crc"]
    servo.json("undo")
    servo.json("store")
    assert servo.value(GAIN) == before


def test_another_schema_is_reported_by_its_hash_and_indices_still_work(servo: Bench) -> None:
    content = json.loads(PARAMETERS.read_text())
    content["schema_hash"] = content["schema_hash"] ^ 1
    other = servo.folder / "other.json"
    other.write_text(json.dumps(content))
    refused = servo("get", GAIN, "--parameters", str(other))
    assert refused.code == 7 and refused.err.count("\n") == 1 and f"{other} is {content['schema_hash']:08X}" in refused.err
    found = servo.json("get", "0x2000:1", "--type", "REAL32", "--parameters", str(other))
    assert found[0]["value"] == servo.value(GAIN)
    assert servo("state", "--parameters", str(other)).code == 0
    assert servo.json("info", "--parameters", str(other))["schema_fits"] is False


def test_a_schema_that_fitted_once_is_found_again_without_being_named(servo: Bench) -> None:
    value = servo.value(GAIN)
    del servo.environment["SERVOCTL_PARAMETERS"]
    (servo.folder / "elsewhere").mkdir()
    assert servo.value(GAIN) == value
    assert list((servo.folder / "cache").rglob("*.json"))


def test_a_schema_from_a_pipe_is_read_once_and_found_again(elsewhere: Bench) -> None:
    servo = elsewhere
    pipe = servo.folder / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_bytes, args=(PARAMETERS.read_bytes(),))
    writer.start()
    process = servo.start("get", GAIN, "--parameters", str(pipe))
    out, err = process.communicate(timeout=30)
    writer.join()
    assert process.returncode == 0, err
    kept = next((servo.folder / "cache/servoctl/parameters").iterdir())
    assert kept.suffix == ".json" and kept.read_text() == PARAMETERS.read_text()
    assert servo("get", GAIN).out == out


def test_explain_gives_unit_range_default_and_meaning_without_a_device(servo: Bench) -> None:
    servo.environment["SERVOCTL_BUS"] = "slcan-tcp:127.0.0.1:1"
    text = servo("explain", GAIN).out
    for word in ("0x2000:01", "N m s/rad", "765.0094", "2 zeta w J"):
        assert word in text
    assert servo.json("explain", "0x8130")["meaning"] == "heartbeat lost"
    assert "Abort connection option code" in servo("explain", "6007").out


def test_names_are_completed_in_the_shell(servo: Bench) -> None:
    servo.environment |= {
        "_SERVOCTL_COMPLETE": "bash_complete",
        "COMP_WORDS": "servoctl get azimuth.speed_loop.p",
        "COMP_CWORD": "2",
    }
    assert GAIN in servo.start().communicate(timeout=60)[0]


def test_nobody_there_is_reported_with_exit_code_3(servo: Bench) -> None:
    silent = servo("get", "0x1000", "--node", "99")
    assert silent.code == 3 and "node 99 does not answer" in silent.err
    closed = servo("info", "--bus", "slcan-tcp:127.0.0.1:1")
    assert closed.code == 3 and "sim_host serve" in closed.err
    missing = servo("info", "--bus", "slcan:/dev/none")
    assert missing.code == 3 and "/dev/none" in missing.err


def test_a_command_with_a_typo_is_suggested(servo: Bench) -> None:
    assert "did you mean 'restore'" in servo("restor").err


def test_scope_captures_bit_for_bit_as_many_frames_as_requested(servo: Bench) -> None:
    found = servo.json("scope", "azimuth.rate", "pitch.rate", "--for", "0.5", "--out", ".")
    assert found["frames"] == 500 and all((servo.folder / name).stat().st_size > 1000 for name in found["files"])
    wrong = servo("scope", "azimuth.rat_rad")
    assert wrong.code == 2 and "did you mean" in wrong.err


def test_the_scope_waits_for_its_trigger_and_gives_up_in_time(servo: Bench) -> None:
    result = servo("scope", "azimuth.torque_nm", "--trigger", "above", "--level", "1000", "--timeout", "1")
    assert result.code == 6 and "no trigger" in result.err


def test_a_trigger_that_does_not_come_is_forced_with_auto(servo: Bench) -> None:
    words = ("azimuth.torque_nm", "--trigger", "above", "--level", "1000", "--timeout", "1", "--auto", "--for", "0.3")
    found = servo.json("scope", *words)
    assert found["triggered"] and found["frames"] == 300


@pytest.mark.image
@pytest.mark.real_time
def test_several_at_once_take_turns_at_the_nodes_one_sdo_server(servo: Bench) -> None:
    reading = [
        servo.start("log", "azimuth.velocity_actual_value", "--rate", "100", "--for", "3", "--out", f"{name}.csv")
        for name in ("one", "two", "three")
    ]
    value = servo.value(GAIN)
    assert [servo.value(GAIN) for _ in range(4)] == [value] * 4
    for process in reading:
        out, err = process.communicate(timeout=60)
        assert process.returncode == 0, err
    # How many rows there are is up to the computer; each has its share of them.
    rows = [len((servo.folder / f"{name}.csv").read_text().splitlines()) for name in ("one", "two", "three")]
    assert min(rows) > 20 and min(rows) > max(rows) / 3, rows


@pytest.mark.image
@pytest.mark.smoke
@pytest.mark.real_time
def test_log_reads_at_the_rate_that_was_requested(servo: Bench) -> None:
    assert servo("log", "azimuth.position_actual_value", "--rate", "20", "--for", "1", "--out", "log.csv").code == 0
    rows = (servo.folder / "log.csv").read_text().splitlines()
    assert rows[0] == "time_s,azimuth.position_actual_value (1e-7 rad)" and 15 <= len(rows) - 1 <= 22


def test_the_test_device_without_hash_and_stages_works_as_well(test_node: Bench) -> None:
    assert test_node.json("scan")[0]["name"] == "test device"
    assert test_node.json("get", GAIN)[0]["value"] == 1.5
    assert test_node.json("set", "every_type.a_real32", "2.5")[0]["old"] == 0.1
    assert test_node.json("get", "0x2F00:10")[0]["value"] == "hello world"
    assert test_node("set", "every_type.a_constant", "1").code == 2
    refused = test_node("set", "a_moody_value", "13")
    assert refused.code == 4 and "08000022" in refused.err
