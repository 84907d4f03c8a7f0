"""Guarded parameters: written with --unlock only, and the device is locked again afterwards."""

from __future__ import annotations

import pytest

from servoctl.schema import load_schema

from .conftest import PARAMETERS, Bench

LIMIT = "azimuth.protection.over_speed_limit"
MOTOR = "azimuth.motor.current_limit"
GAIN = "azimuth.speed_loop.proportional_gain"
SECONDS_LEFT = "0x3040:2"


def test_motor_protection_limits_and_board_scales_are_guarded_and_nothing_else() -> None:
    guarded = {p.index & ~0x800 for p in load_schema(PARAMETERS) if p.guarded}
    assert guarded == {0x2055, 0x2060, 0x3060}


def test_protection_limits_take_force_without_being_applied() -> None:
    schema = load_schema(PARAMETERS)
    assert not schema.find(LIMIT).staged and schema.find(MOTOR).staged


@pytest.mark.parametrize("name", [LIMIT, MOTOR])
def test_a_guarded_value_needs_unlock_and_is_locked_again(servo: Bench, name: str) -> None:
    before = servo.value(name)
    refused = servo.here("set", f"{GAIN}=701", f"{name}={before * 0.9}")
    assert refused.code == 2 and refused.err.count("\n") == 1
    assert name in refused.err and "--unlock" in refused.err
    assert servo.value(name) == before and servo.value(GAIN) != 701
    servo.json("set", f"{name}={before * 0.9}", "--unlock")
    assert servo.value(name) == pytest.approx(before * 0.9, rel=1e-6)
    assert servo.value(SECONDS_LEFT) == 0
    assert "--unlock" in servo.here("undo").err
    servo.json("undo", "--unlock")
    assert servo.value(name) == before and servo.value(SECONDS_LEFT) == 0


def test_a_guarded_value_that_the_device_has_already_needs_no_unlock(servo: Bench) -> None:
    before, gain = servo.value(LIMIT), servo.value(GAIN)
    servo.json("set", f"{LIMIT}={before}", f"{GAIN}={gain + 1}")
    assert servo.value(GAIN) == gain + 1
    servo.json("undo")
    assert servo.value(GAIN) == gain


def test_a_gains_file_is_restored_without_unlock_unless_guarded_values_differ(servo: Bench) -> None:
    servo.json("save", "gains.toml")
    gain, limit = servo.value(GAIN), servo.value(LIMIT)
    servo.json("set", GAIN, "702")
    servo.json("restore", "gains.toml")
    assert servo.value(GAIN) == gain
    servo.json("set", f"{GAIN}=702", f"{LIMIT}={limit * 0.9}", "--unlock")
    refused = servo.here("restore", "gains.toml")
    assert refused.code == 2 and LIMIT in refused.err and "--unlock" in refused.err
    assert servo.value(GAIN) == 702
    servo.json("restore", "gains.toml", "--unlock")
    assert servo.value(GAIN) == gain and servo.value(LIMIT) == limit and servo.value(SECONDS_LEFT) == 0


def test_a_refused_set_leaves_limits_as_they_were_and_the_lock_closed(servo: Bench) -> None:
    under = "azimuth.protection.under_voltage_limit"
    before, gain = servo.value(under), servo.value(GAIN)
    refused = servo.here("set", f"{GAIN}=703", f"{LIMIT}=1.0", f"{under}=900", "--unlock")
    assert refused.code == 4
    assert servo.value(under) == before and servo.value(GAIN) == gain and servo.value(LIMIT) != 1.0
    assert "2060:15" in refused.err and "2060:16" in refused.err
    assert servo.value("azimuth.protection.waiting_limits") == 0
    assert servo.value(SECONDS_LEFT) == 0
