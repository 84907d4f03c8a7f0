# SPDX-License-Identifier: Apache-2.0
"""Motions on the live axis: they do what was announced, and whatever happens the axis ends at rest."""

from __future__ import annotations

import json
import signal
import subprocess
import threading
from typing import Any

import canopen
import pytest
from canopen.profiles.p402 import BaseNode402

from servoctl.axis402 import Axis402
from servoctl.link.bus import open_bus, parse_bus
from servoctl.objects.schema import load_schema

from .conftest import PARAMETERS, Bench, Eventually

BORROWED = (
    "0x1016:1",
    "0x1016:2",
    "0x1016:3",
    "0x1016:4",
    "0x1403:1",
    "0x1603:0",
    "0x1603:1",
    *(f"0x180{n}:{sub}" for n in (2, 3) for sub in (1, 5)),
    *(f"0x1A0{n}:{sub}" for n in (2, 3) for sub in (0, 1)),
    "0x60C2:1",
    "0x6060",
)


def borrowed(servo: Bench) -> list[int]:
    return [row["value"] for row in servo.json("get", *BORROWED)]


def axis(servo: Bench, name: str = "azimuth") -> dict[str, object]:
    found: dict[str, object] = servo.json("state", name)["axes"][0]
    return found


def at_rest(servo: Bench) -> bool:
    """Now: wind turns a disabled axis sometimes."""
    return abs(float(str(axis(servo)["rate_deg_s"]))) < 0.1


def slides(servo: Bench) -> bool:
    """A motion is in progress."""
    found = axis(servo)
    return found["state"] == "operation enabled" and float(str(found["rate_deg_s"])) > 0.5


def follow_output(process: subprocess.Popen[str]) -> list[dict[str, Any]]:
    """The JSON lines of a program, which grow while it runs; reading them keeps its pipe from filling."""
    lines: list[dict[str, Any]] = []
    output = process.stdout
    assert output is not None
    threading.Thread(target=lambda: lines.extend(json.loads(line) for line in output), daemon=True).start()
    return lines


def shows_a_rate(line: dict[str, Any]) -> bool:
    return any(shown["rate_deg_s"] is not None for shown in line["axes"])


@pytest.mark.image
@pytest.mark.smoke
def test_move_arrives_and_leaves_the_axis_as_it_was(servo: Bench) -> None:
    before = borrowed(servo)
    done = servo.json("move", "azimuth", "--by", "3", "--rate", "5", "--yes")
    assert done["to_deg"] - done["from_deg"] == pytest.approx(3.0, abs=0.02)
    assert axis(servo)["state"] == "switch on disabled"
    assert borrowed(servo) == before


def test_an_enabled_axis_stays_enabled_after_a_move(servo: Bench) -> None:
    servo.json("state", "azimuth", "enable")
    servo.json("move", "azimuth", "--rate", "-2", "--for", "1", "--yes")
    assert axis(servo)["state"] == "operation enabled" and at_rest(servo)
    servo.json("state", "azimuth", "disable")


def test_nothing_moves_without_yes_in_a_dry_run_or_beyond_the_limits(servo: Bench) -> None:
    servo.json("state", "azimuth", "enable")  # otherwise wind would turn it
    here = float(str(axis(servo)["position_deg"]))
    assert servo("move", "azimuth", "--by", "5").code == 2
    assert servo("step", "azimuth", "--dry-run").code == 0
    assert servo("bode", "azimuth", "--dry-run").code == 0
    for words, reported in (
        (("move", "azimuth", "--by", "91", "--yes"), "--max-travel"),
        (("step", "azimuth", "--amplitude", "6", "--yes"), "--max-rate"),
        (("bode", "azimuth", "--low", "0.1", "--yes"), "--max-travel"),
        (("bode", "azimuth", "--high", "400", "--yes"), "--high"),
        (("bode", "azimuth", "--amplitude", "1.5", "--yes"), "--bias"),
    ):
        result = servo(*words)
        assert result.code == 2 and reported in result.err, (words, result)
    assert float(str(axis(servo)["position_deg"])) == pytest.approx(here, abs=0.2)


def test_a_move_beyond_the_position_limits_is_refused_with_the_limits(servo: Bench) -> None:
    here = float(str(axis(servo)["position_deg"]))
    low, high = round((here - 1) * 174532.9), round((here + 1) * 174532.9)
    group = "azimuth.software_position_limit"
    servo.json("set", f"{group}.min_position_limit={low}", f"{group}.max_position_limit={high}")
    result = servo("move", "azimuth", "--by", "2", "--yes")
    servo.json("undo")
    assert result.code == 2 and "607D" in result.err


@pytest.mark.image
@pytest.mark.smoke_image
@pytest.mark.smoke
@pytest.mark.real_time
def test_step_reports_rise_overshoot_and_settling(servo: Bench) -> None:
    before = borrowed(servo)
    for _ in range(4):
        found = servo.json("step", "azimuth", "--amplitude", "1", "--hold", "0.6", "--yes")
        if len(found["steps"]) == 2:
            break  # otherwise this computer was late with set-points, and servoctl has requested another run
    assert [s["direction"] for s in found["steps"]] == ["forward", "backward"]
    for step in found["steps"]:
        assert 0.001 < step["rise_s"] < 0.1 and step["overshoot_percent"] < 15 and step["settling_s"] < 0.2
        assert abs(step["final_error_rad_s"]) < 2e-4
    assert all((servo.folder / name).stat().st_size > 1000 for name in found["files"])
    assert axis(servo)["state"] == "switch on disabled" and borrowed(servo) == before


@pytest.mark.image
def test_braking_measures_torque_and_friction_over_inertia_and_writes_the_safe_part(servo: Bench) -> None:
    """Azimuth with pitch level: 6 kg m² and 40 N m are 6.7 rad/s²; friction and wind give 1 to 4 more or less."""
    servo.json("state", "pitch", "enable")
    servo.json("move", "pitch", "--to", "0", "--rate", "10", "--yes")
    servo.json("state", "pitch", "disable")
    before = servo.value("azimuth.quick_stop_deceleration")
    assert servo("braking", "azimuth", "--wind", "5", "--write", "--yes", "--repeats", "1").code == 2  # without --unlock
    assert servo("braking", "azimuth", "--wind", "40", "--yes").code == 2
    found = servo.json("braking", "azimuth", "--wind", "5", "--yes", "--repeats", "2", "--write", "--unlock")
    stops = [stop["deceleration_rad_s2"] for stop in found["stops"]]
    assert [stop["rate_rad_s"] > 0 for stop in found["stops"]] == [True, False, True, False]
    assert all(5.0 < stop < 11.0 for stop in stops), stops
    assert found["sure_deceleration_rad_s2"] == pytest.approx(0.8 * min(stops) * 35 / 40, rel=0.02)
    written = servo.value("azimuth.protection.sure_deceleration")
    assert written == pytest.approx(found["sure_deceleration_rad_s2"], rel=1e-6)
    assert servo.value("azimuth.quick_stop_deceleration") == before
    assert axis(servo)["state"] == "switch on disabled" and at_rest(servo)
    servo.json("undo", "--unlock")
    assert servo.value("azimuth.protection.sure_deceleration") == pytest.approx(found["before_rad_s2"], rel=1e-6)


@pytest.mark.image
@pytest.mark.real_time
@pytest.mark.alone
def test_bode_finds_the_margins_that_the_simulator_computes_while_a_monitor_listens(
    servo: Bench, eventually: Eventually
) -> None:
    """`sim_host experiments` computes 50.6 degrees at 49.8 Hz and 12.7 dB for this plant with pitch level. The monitor
    listens from before until after the measurement, which borrows the PDOs with the rates."""
    servo.json("state", "pitch", "enable")
    servo.json("move", "pitch", "--to", "0", "--rate", "10", "--yes")
    servo.json("state", "azimuth", "enable")
    before = borrowed(servo)
    monitor = servo.start("monitor", "--json")
    lines = follow_output(monitor)
    eventually(lambda: len(lines) > 10 and shows_a_rate(lines[-1]), 20.0)
    measured_from = len(lines)
    found = servo.json("bode", "azimuth", "--low", "4", "--periods", "4", "--yes")
    measured_to = len(lines)
    eventually(lambda: len(lines) > measured_to + 10 and shows_a_rate(lines[-1]), 20.0)
    monitor.send_signal(signal.SIGINT)
    assert monitor.wait(timeout=10) == 0
    assert found["phase_margin_deg"] == pytest.approx(50, abs=5)
    assert found["crossover_hz"] == pytest.approx(50, abs=6)
    assert found["gain_margin_db"] == pytest.approx(12.5, abs=2)
    assert found["trusted"] == found["lines"]
    assert borrowed(servo) == before and at_rest(servo)
    assert measured_to > measured_from + 10
    assert all(line["heartbeat_age_s"] < 0.5 for line in lines[5:])
    shown = [row for line in lines for row in line["axes"]]
    assert "operation enabled" in {row["state"] for row in shown}
    assert max(abs(row["rate_deg_s"]) for row in shown if row["rate_deg_s"] is not None) < 3
    for name in ("azimuth", "pitch"):
        servo.json("state", name, "disable")


@pytest.mark.real_time
@pytest.mark.parametrize("number, code", [pytest.param(signal.SIGINT, 130, marks=pytest.mark.image), (signal.SIGTERM, 130)])
def test_interrupting_stops_the_axis_and_puts_all_back(
    servo: Bench, number: int, code: int, eventually: Eventually
) -> None:
    before = borrowed(servo)
    process = servo.start("bode", "azimuth", "--yes")
    eventually(lambda: slides(servo), 20.0)
    process.send_signal(number)
    assert process.wait(timeout=60) == code
    assert axis(servo)["state"] == "switch on disabled"
    eventually(lambda: at_rest(servo), 20.0)
    assert borrowed(servo) == before


@pytest.mark.image
@pytest.mark.real_time
def test_the_device_brakes_by_itself_when_servoctl_is_killed(servo: Bench, eventually: Eventually) -> None:
    before = borrowed(servo)
    process = servo.start("bode", "azimuth", "--yes")
    eventually(lambda: slides(servo), 20.0)
    process.kill()
    process.wait()
    eventually(lambda: axis(servo)["state"] in ("fault", "switch on disabled") and at_rest(servo), 20.0)
    found = servo.json("faults")
    assert found["axes"][0]["code"] == 0x8130
    reported = [(error["code"], error["origin"]) for error in found["history"][:3]]
    assert reported == [(0x8130, "pitch"), (0x8130, "azimuth"), (0x8130, "node 127")]
    for name in ("azimuth", "pitch"):
        servo.json("state", name, "reset")
    assert servo("step", "azimuth", "--hold", "0.3", "--yes").code == 0
    assert axis(servo)["state"] == "switch on disabled"
    after = borrowed(servo)
    assert after[:-2] == before[:-2]  # mode and interpolation period stay as the killed one left them


@pytest.mark.image
def test_the_scope_captures_a_move_of_another_servoctl(servo: Bench, eventually: Eventually) -> None:
    scope = servo.start(
        "scope", "azimuth.reference", "azimuth.torque_nm", "--trigger", "above", "--level", "0.015", "--pre", "0.1",
        "--for", "0.5", "--json",
    )  # fmt: skip
    eventually(lambda: servo.value("0x3000:2") == WAITS_FOR_TRIGGER, 20.0)
    moved = servo.json("move", "azimuth", "--rate", "1", "--for", "3", "--yes")
    out, err = scope.communicate(timeout=60)
    assert scope.returncode == 0, err
    found = json.loads(out)
    assert found["triggered"] and found["frames"] == 500
    assert found["signals"]["azimuth.reference_rad_s"]["max"] == pytest.approx(0.01745, rel=0.01)
    assert 0.5 < moved["to_deg"] - moved["from_deg"] < 3.5  # not longer than commanded


def test_a_faulty_axis_is_not_moved(test_node: Bench) -> None:
    result = test_node("move", "azimuth", "--rate", "1", "--for", "1", "--yes")
    assert result.code in (4, 6)


WAITS_FOR_TRIGGER = 2
AT_RATE = [pytest.approx(17453, rel=0.05), pytest.approx(-17453, rel=0.05)]


@pytest.mark.image
def test_python_canopens_own_drive_and_ours_at_the_offset_run_side_by_side(servo: Bench, eventually: Eventually) -> None:
    dictionary = load_schema(PARAMETERS).object_dictionary()
    network = canopen.Network(bus=open_bus(parse_bus(servo.bus)))
    with network.connect():
        azimuth = BaseNode402(1, dictionary)
        network.add_node(azimuth)
        pitch = Axis402(1, dictionary, axis=1, beside=azimuth)
        azimuth.nmt.state = "OPERATIONAL"
        azimuth.nmt.wait_for_heartbeat()
        for drive, rate in ((azimuth, 17453), (pitch, -17453)):
            drive.setup_402_state_machine()
            drive.op_mode = "PROFILED VELOCITY"
            drive.state = "OPERATION ENABLED"
            drive.sdo[0x60FF].raw = rate
        eventually(lambda: [drive.sdo[0x606C].raw for drive in (azimuth, pitch)] == AT_RATE, 20.0)
        modes = [drive.op_mode for drive in (azimuth, pitch)]
        for drive in (azimuth, pitch):
            drive.sdo[0x60FF].raw = 0
        for drive in (azimuth, pitch):
            drive.state = "SWITCH ON DISABLED"
        states = [drive.state for drive in (azimuth, pitch)]
    assert modes == ["PROFILED VELOCITY"] * 2 and states == ["SWITCH ON DISABLED"] * 2
