# SPDX-License-Identifier: Apache-2.0
"""Guarded parameters: written with --unlock only, and the device is locked again afterwards."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from servoctl.objects.schema import load_schema

from .conftest import PARAMETERS, Bench

LIMIT = "azimuth.protection.over_speed_limit"
MOTOR = "azimuth.motor.current_limit"
GAIN = "azimuth.speed_loop.proportional_gain"
LOW_PASS = "azimuth.filters.low_pass_frequency"
SECONDS_LEFT = "0x3040:2"


def test_motor_plant_protection_limits_start_turn_home_and_board_scales_are_guarded_and_nothing_else() -> None:
    guarded = {p.index & ~0x800 for p in load_schema(PARAMETERS) if p.guarded}
    assert guarded == {0x2055, 0x2056, 0x2060, 0x2061, 0x3060, 0x607C}


def test_protection_limits_take_force_without_being_applied() -> None:
    schema = load_schema(PARAMETERS)
    assert not schema.find(LIMIT).staged and schema.find(MOTOR).staged


@pytest.mark.parametrize("name", [LIMIT, MOTOR])
def test_a_guarded_value_needs_unlock_and_is_locked_again(servo: Bench, name: str) -> None:
    before = servo.value(name)
    refused = servo("set", f"{GAIN}=701", f"{name}={before * 0.9}")
    assert refused.code == 2 and refused.err.count("\n") == 1
    assert name in refused.err and "--unlock" in refused.err
    assert servo.value(name) == before and servo.value(GAIN) != 701
    servo.json("set", f"{name}={before * 0.9}", "--unlock")
    assert servo.value(name) == pytest.approx(before * 0.9, rel=1e-6)
    assert servo.value(SECONDS_LEFT) == 0
    assert "--unlock" in servo("undo").err
    servo.json("undo", "--unlock")
    assert servo.value(name) == before and servo.value(SECONDS_LEFT) == 0


def test_a_guarded_value_that_the_device_has_already_needs_no_unlock(servo: Bench) -> None:
    before, gain = servo.value(LIMIT), servo.value(GAIN)
    servo.json("set", f"{LIMIT}={before}", f"{GAIN}={gain + 1}")
    assert servo.value(GAIN) == gain + 1
    servo.json("undo")
    assert servo.value(GAIN) == gain


def test_unstable_gains_count_with_the_override_only(servo: Bench) -> None:
    before = servo.value(LOW_PASS)
    for words in (("set", f"{LOW_PASS}=5"), ("set", "--apply")):
        refused = servo(*words)
        assert refused.code == 4 and "unstable" in refused.err and "--override-gain-check" in refused.err, refused
        servo.json("set", f"{LOW_PASS}=5", "--stage")
    servo.json("set", "--apply", "--override-gain-check")
    assert servo.value(LOW_PASS) == 5 and not servo.json("info")["axes"][0]["staged"]
    servo.json("save", "shaking.toml")
    servo.json("set", f"{LOW_PASS}={before}")
    assert "--override-gain-check" in servo("restore", "shaking.toml").err
    assert servo.value(LOW_PASS) == before
    servo.json("restore", "shaking.toml", "--override-gain-check")
    assert servo.value(LOW_PASS) == 5 and servo.value(SECONDS_LEFT) == 0
    servo.json("undo")
    servo.json("set", f"{LOW_PASS}=5", "--override-gain-check")
    assert servo.value(LOW_PASS) == 5 and servo.value(SECONDS_LEFT) == 0
    servo.json("undo")
    assert servo.value(LOW_PASS) == before


def test_a_feedforward_beyond_the_plant_counts_with_the_override_only(servo: Bench) -> None:
    name = "azimuth.speed_loop.acceleration_feedforward_inertia"
    before = servo.value(name)
    refused = servo("set", f"{name}=1000")
    text = " ".join(refused.err.split())
    assert refused.code == 4 and "2000:5" in text and "; give 0.0 .. 18.0, since 2056:1" in text, text
    assert "--override-gain-check" in text, text
    assert servo.value(name) == before
    servo.json("set", f"{name}=1000", "--override-gain-check")
    assert servo.value(name) == 1000
    servo.json("undo")
    assert servo.value(name) == before


def test_a_gains_file_is_restored_without_unlock_unless_guarded_values_differ(servo: Bench) -> None:
    servo.json("save", "gains.toml")
    gain, limit = servo.value(GAIN), servo.value(LIMIT)
    servo.json("set", GAIN, "702")
    servo.json("restore", "gains.toml")
    assert servo.value(GAIN) == gain
    servo.json("set", f"{GAIN}=702", f"{LIMIT}={limit * 0.9}", "--unlock")
    refused = servo("restore", "gains.toml")
    assert refused.code == 2 and LIMIT in refused.err and "--unlock" in refused.err
    assert servo.value(GAIN) == 702
    servo.json("restore", "gains.toml", "--unlock")
    assert servo.value(GAIN) == gain and servo.value(LIMIT) == limit and servo.value(SECONDS_LEFT) == 0


def test_a_refused_set_leaves_limits_as_they_were_and_the_lock_closed(servo: Bench) -> None:
    under = "azimuth.protection.under_voltage_limit"
    before, gain = servo.value(under), servo.value(GAIN)
    refused = servo("set", f"{GAIN}=703", f"{LIMIT}=1.0", f"{under}=900", "--unlock")
    assert refused.code == 4
    assert servo.value(under) == before and servo.value(GAIN) == gain and servo.value(LIMIT) != 1.0
    assert "2060:15" in refused.err and "2060:16" in refused.err
    assert servo.value("azimuth.protection.waiting_limits") == 0
    assert servo.value(SECONDS_LEFT) == 0


# --- the owner's word, and who the lock belongs to ----------------------------------------------------------------

WORD = "7 drums"


@pytest.fixture
def owned(servo: Bench) -> Iterator[Bench]:
    """The servo with an owner's word, which this servoctl knows; without one afterwards."""
    servo.json("lock", "set-word", "--new", WORD)
    servo.environment["SERVOCTL_WORD"] = WORD
    yield servo
    servo.environment["SERVOCTL_WORD"] = WORD
    while servo.json("lock", "status")["delay_s"]:
        pass
    assert servo.json("lock", "set-word", "--remove")["has_word"] is False


@pytest.mark.image
def test_the_lock_is_opened_and_closed_by_hand(servo: Bench) -> None:
    assert servo.json("lock", "status") == {"open_s": 0, "has_word": False, "delay_s": 0}
    assert 55 <= servo.json("lock", "open")["open_s"] <= 60
    assert servo.json("lock", "close")["open_s"] == 0


@pytest.mark.image
def test_with_an_owners_word_guarded_values_need_it(owned: Bench) -> None:
    limit = owned.value(LIMIT)
    assert owned.json("lock", "status")["has_word"] is True
    owned.json("set", f"{LIMIT}={limit * 0.9}", "--unlock")
    owned.json("undo", "--unlock")
    del owned.environment["SERVOCTL_WORD"]
    missing = owned("set", f"{LIMIT}={limit * 0.9}", "--unlock")
    assert missing.code == 2 and "--word" in missing.err and missing.err.count("\n") == 1
    too_long = owned("get", LIMIT, "--word", "ninechars")
    assert too_long.code == 2 and "1 to 8" in too_long.err
    wrong = owned("set", f"{LIMIT}={limit * 0.9}", "--unlock", "--word", "open")
    assert wrong.code == 4 and "wrong access word" in wrong.err and wrong.err.count("\n") == 1
    delayed = owned("lock", "open", "--word", WORD)
    assert delayed.code == 4 and "accepts no word for another" in delayed.err
    assert owned.value(LIMIT) == limit


def test_nobody_reads_the_word_and_no_saved_file_has_it(owned: Bench) -> None:
    for sub in (1, 3, 4):
        assert owned("get", f"0x3040:{sub}").code == 2
    owned.json("save", "gains.toml")
    text = (owned.folder / "gains.toml").read_text()
    assert WORD not in text and "access" not in text
    assert all(WORD not in path.read_text() for path in (owned.folder / "state").glob("*"))


def test_guarded_values_and_the_word_change_only_without_torque(servo: Bench) -> None:
    limit = servo.value(LIMIT)
    servo.json("state", "pitch", "enable")
    try:
        for words in (("set", f"{LIMIT}={limit * 0.9}", "--unlock"), ("lock", "set-word", "--new", WORD)):
            refused = servo(*words)
            assert refused.code == 4 and "pitch has torque" in refused.err and refused.err.count("\n") == 1
        servo.json("set", f"{GAIN}=704", "--unlock")  # a gain needs no lock
        servo.json("undo")
    finally:
        servo.json("state", "pitch", "disable")
    assert servo.value(LIMIT) == limit and servo.json("lock", "status")["has_word"] is False


@pytest.mark.parametrize("word", ["", "123456789", "grün", "a\tb"])
def test_a_word_that_cannot_be_one_is_refused(servo: Bench, word: str) -> None:
    refused = servo("lock", "set-word", "--new", word) if word else servo("lock", "set-word")
    assert refused.code == 2 and refused.err.count("\n") == 1
    assert servo.json("lock", "status")["has_word"] is False
