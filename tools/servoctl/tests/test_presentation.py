# SPDX-License-Identifier: Apache-2.0
"""Output in a terminal of 80 columns, and errors with --json for scripts."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import re
import struct
import subprocess
import termios
from pathlib import Path

import pytest
from rich.cells import cell_len

from servoctl.errors import InputError
from servoctl.objects.schema import CARRIED, Schema, load_schema
from servoctl.show.table import columns_of, lines
from servoctl.units import Shown

from .conftest import Bench
from .test_faults import lagging  # noqa: F401 - a fixture

GAIN = "azimuth.speed_loop.proportional_gain"
WIDTH = 80


def in_terminal(servo: Bench, *words: str) -> list[str]:
    """The lines that a terminal of WIDTH columns shows."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, WIDTH, 0, 0))
    surroundings = {key: value for key, value in servo.environment.items() if key not in ("COLUMNS", "LINES", "NO_COLOR")}
    process = subprocess.Popen(
        servo.command(*words), cwd=servo.folder, env=surroundings | {"TERM": "xterm"},
        stdin=subprocess.DEVNULL, stdout=theirs, stderr=theirs,
    )  # fmt: skip
    os.close(theirs)
    shown = b""
    while True:
        try:
            part = os.read(ours, 65536)
        except OSError:  # the other side is closed
            part = b""
        if not part:
            break
        shown += part
    os.close(ours)
    process.wait(timeout=60)
    plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown.decode()).replace("\r\n", "\n")
    return [line.rsplit("\r", 1)[-1].rstrip() for line in plain.split("\n")]


def rows_after(shown: list[str], head: str) -> list[list[str]]:
    """The cells of the table whose title line is given."""
    start = next(n for n, line in enumerate(shown) if line.startswith(head))
    rule = next(n for n, line in enumerate(shown) if n > start and "───" in line)
    end = next(n for n, line in enumerate(shown) if n > rule and not line)
    return [re.split(r"\s{2,}", line.strip()) for line in shown[rule + 1 : end]]


def test_numbers_and_words_of_faults_stay_whole_in_80_columns(lagging: Bench) -> None:  # noqa: F811
    shown = in_terminal(lagging, "faults")
    assert max(cell_len(line) for line in shown) <= WIDTH
    rows = rows_after(shown, "signals before fault 1")
    assert len(rows) == 16
    assert all(len(row) == 9 and all(re.fullmatch(r"-?\d+(\.\d+)?", cell) for cell in row) for row in rows), rows
    assert not any("rad" in line for line in shown)  # angles and rates are in degrees, as everywhere else
    newest = lagging.json("faults")["log"]["entries"][0]
    rate = [signal["name"] for signal in newest["signals"]].index("joint_rate")
    assert float(rows[-1][rate + 1]) == pytest.approx(newest["samples"][-1][rate] * 57.29578, abs=1e-4)
    advice = " ".join(" ".join(line.split()) for line in shown)
    assert all(" ".join(words.split()) in advice for words in lagging.json("faults")["axes"][1]["faults"][0]["cause"].split(". "))


def test_the_journal_stays_whole_in_80_columns(servo: Bench) -> None:
    before = servo.value(GAIN)
    servo.json("set", GAIN, str(before + 0.125))
    shown = in_terminal(servo, "undo", "--list")
    servo.json("undo")
    assert max(cell_len(line) for line in shown if "journal" not in line) <= WIDTH
    name = next(n for n, line in enumerate(shown) if line.strip() == GAIN)
    assert re.fullmatch(r" +\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ +set +[\d.]+ +[\d.]+ +N m s/rad", shown[name + 1]), shown


def test_indices_names_and_values_stay_whole_in_80_columns(servo: Bench) -> None:
    shown = in_terminal(servo, "get", "azimuth.speed_loop")
    assert max(cell_len(line) for line in shown) <= WIDTH
    name = next(n for n, line in enumerate(shown) if line.strip() == GAIN)
    assert re.fullmatch(r" +0x2000:01 +[\d.]+ +N m s/rad +[\d.]+", shown[name + 1]), shown


@pytest.mark.parametrize("width", [20, 37, 60, 80, 200])
def test_a_table_breaks_no_number_and_no_word_in_any_width(width: int) -> None:
    cells = ["123456.789", "a text of some longer words", "azimuth.some_group.some_name", "-0.000123"]
    table = columns_of([("value", "right"), "meaning", "name", ("old value", "right")], [cells, cells])
    shown = " ".join(text.plain for text in lines(table, width)).split()
    for word in " ".join(cells).split():
        assert shown.count(word) >= 2, (word, width)


def test_with_json_every_error_is_json_and_keeps_its_exit_code(servo: Bench) -> None:
    for words, code, kind in (
        (("get", "nothing"), 2, "bad_input"),
        (("set", GAIN, "1e9"), 2, "bad_input"),
        (("get", "--frob"), 2, "bad_input"),
        (("frob",), 2, "bad_input"),
        (("move", "azimuth", "--by", "1e9", "--yes"), 2, "bad_input"),
        (("get", "0x1000", "--node", "99"), 3, "no_connection"),
        (("set", f"{GAIN}=800", "azimuth.friction_feedforward.coulomb_torque_positive=50"), 4, "refused"),
        (("scope", "azimuth.torque", "--trigger", "above", "--level", "1000", "--timeout", "0.2"), 6, "motion"),
    ):
        result = servo(*words, "--json")
        assert (result.code, result.out) == (code, ""), (words, result)
        error = json.loads(result.err)["error"]
        assert (error["exit_code"], error["kind"]) == (code, kind) and error["message"]
    servo.json("set", "--stage", GAIN, "700")
    found = servo("get", GAIN, "--json")
    servo.json("undo", "--staged", "--axis", "azimuth")
    assert found.code == 0 and "staged" in json.loads(found.err)["note"]


def test_the_scope_shows_degrees_and_its_level_is_in_them(servo: Bench) -> None:
    listed = servo("scope", "--list").out
    assert re.search(r"azimuth\.rate +°/s", listed) and "rad" not in listed
    result = servo("scope", "azimuth.rate", "azimuth.current", "--for", "0.2")
    row = re.search(r"azimuth\.rate +°/s +(\S+) +(\S+) +(\S+) +(\S+)", result.out)
    assert row and re.search(r"azimuth\.current +A ", result.out) and "rad" not in result.out
    csv = next(Path(servo.folder).glob("scope-*.csv")).read_text().splitlines()
    assert csv[0] == "time_s,azimuth.rate_rad_s,azimuth.current_a"
    rates = [float(line.split(",")[1]) * 57.29578 for line in csv[1:]]
    assert [float(text) for text in row.groups()[:3]] == pytest.approx(
        [min(rates), sum(rates) / len(rates), max(rates)], abs=2e-4
    )
    for level in ("20", "20 deg/s", "0.349 rad/s"):
        servo("scope", "azimuth.rate", "--trigger", "above", "--level", level, "--timeout", "0.1")
        assert servo.value("0x3000:7") == pytest.approx(0.349, rel=1e-3)
    assert servo("scope", "azimuth.rate", "--level", "3 kg").code == 2
    assert Shown("rad/s").text(1.0) == "57.2958"


@pytest.fixture(scope="module")
def schema() -> Schema:
    return load_schema(CARRIED)


@pytest.mark.parametrize(
    "typed, axis, meant",
    [
        ("kp", None, "azimuth.speed_loop.proportional_gain"),
        ("kp", "pitch", "pitch.speed_loop.proportional_gain"),
        ("pitch.Ki", None, "pitch.speed_loop.integral_gain"),
        ("position_loop.kp", None, "azimuth.position_loop.gain"),
        ("kt", None, "azimuth.motor.torque_constant"),
        ("stiction", None, "azimuth.friction_feedforward.break_away_torque_positive"),
        ("overspeed", None, "azimuth.protection.over_speed_limit"),
        ("max_speed", None, "azimuth.max_profile_velocity"),
        ("friction", None, "azimuth.friction_feedforward.model"),
    ],
)
def test_what_others_call_a_gain_is_answered_with_its_name(schema: Schema, typed: str, axis: str | None, meant: str) -> None:
    with pytest.raises(InputError, match=f"did you mean.*{re.escape(meant)}"):
        schema.find(typed, axis)


def test_set_kp_says_what_may_be_meant(servo: Bench) -> None:
    for words in (("kp",), ("kp", "800"), ("kp=800",)):
        refused = servo("set", *words)
        assert refused.code == 2 and f"did you mean {GAIN}" in refused.err
    refused = servo("set", GAIN)
    assert refused.code == 2 and f"expected {GAIN}=VALUE" in refused.err


def test_set_takes_a_negative_number_after_a_name(servo: Bench) -> None:
    limit = "azimuth.software_position_limit.min_position_limit"
    before = servo.json("get", limit)[0]["value"]
    servo.json("set", limit, "-4000000")
    assert servo.json("get", limit)[0]["value"] == -4000000
    servo.json("set", f"{limit}={before}")
    refused = servo("set", GAIN, "-5")
    assert refused.code == 2 and "-5" in refused.err and "below the lower limit" in refused.err
    assert "No such option" in servo("set", GAIN, "-x").err
