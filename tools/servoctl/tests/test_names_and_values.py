# SPDX-License-Identifier: Apache-2.0
"""Names, indices, units and limits typed by a user, without a device."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from servoctl.errors import InputError
from servoctl.link.bus import parse_bus
from servoctl.objects.schema import Schema, load_schema, parse_index
from servoctl.units import number, parse_quantity

from .conftest import PARAMETERS


@pytest.fixture(scope="module")
def schema() -> Schema:
    return load_schema(PARAMETERS)


@pytest.mark.parametrize(
    "name, index, sub",
    [
        ("azimuth.speed_loop.proportional_gain", 0x2000, 1),
        ("pitch.speed_loop.proportional_gain", 0x2800, 1),
        ("azimuth.disturbance_observer.bandwidth", 0x2020, 4),
        ("azimuth.friction_feedforward.coulomb_torque_positive", 0x2030, 7),
        ("pitch.motor.torque_constant", 0x2855, 1),
        ("azimuth.statusword", 0x6041, 0),
        ("pitch.software_position_limit.max_position_limit", 0x687D, 2),
        ("producer_heartbeat_time", 0x1017, 0),
        ("identity.serial_number", 0x1018, 4),
    ],
)
def test_names_stay_as_people_have_written_them_down(schema: Schema, name: str, index: int, sub: int) -> None:
    found = schema.find(name)
    assert (found.index, found.sub) == (index, sub)


def test_every_object_has_a_name_of_its_own(schema: Schema) -> None:
    names = [p.name for p in schema]
    assert len(names) == len(set(names))


def test_a_unique_ending_is_enough_and_axis_completes(schema: Schema) -> None:
    assert schema.find("speed_loop.integral_gain", "pitch").name == "pitch.speed_loop.integral_gain"
    assert schema.find("producer_heartbeat_time").index == 0x1017
    with pytest.raises(InputError, match=r"azimuth\.speed_loop\.integral_gain or pitch\.speed_loop\.integral_gain"):
        schema.find("speed_loop.integral_gain")


@pytest.mark.parametrize("typo", ["azimuth.speed_lop.proportional_gain", "azimuth.speed_loop.proportonal_gain"])
def test_a_typo_is_answered_with_what_was_meant(schema: Schema, typo: str) -> None:
    with pytest.raises(InputError, match=r"did you mean azimuth\.speed_loop\.proportional_gain"):
        schema.find(typo)


def test_indices_are_read_in_the_usual_spellings() -> None:
    assert parse_index("0x2000:1") == (0x2000, 1)
    assert parse_index("0x2000:0x0A") == (0x2000, 10)
    assert parse_index("0x6041") == (0x6041, 0)
    assert parse_index("6007") == parse_index("6007h") == (0x6007, 0)
    assert parse_index("605E") == (0x605E, 0) and parse_index("3041:1") == (0x3041, 1)
    for text in ("0x2000:999", "12", "20000", "\u0663000", "0x2000:\u0663"):
        assert parse_index(text) is None
    assert parse_index("speed") is None


def test_units_are_converted_and_wrong_ones_refused() -> None:
    assert parse_quantity("180 deg", "rad") == pytest.approx(3.14159265)
    assert parse_quantity("2", "rad/s", "deg/s") == pytest.approx(0.034906585)
    assert parse_quantity("5 N m", "N m") == 5
    for wrong in ("5 kg", "five", "", "5 deg/s", "1_000", "\u0663", "1\u0663"):
        with pytest.raises(InputError):
            parse_quantity(wrong, "rad")


def test_limits_types_and_finiteness_are_checked_before_anything_is_sent(schema: Schema) -> None:
    gain = schema.find("azimuth.speed_loop.proportional_gain")
    assert gain.check(gain.parse("0.1")) == 0.1
    for wrong in ("-1", "1e9", "nan", "inf", "abc", "5 deg"):
        with pytest.raises(InputError, match="proportional_gain"):
            gain.check(gain.parse(wrong))
    window = schema.find("azimuth.rate_sensors.estimator_window")
    for wrong in ("1", "17", "2.5", "1_0", "\u0663"):
        with pytest.raises(InputError, match="estimator_window"):
            window.check(window.parse(wrong))


@pytest.mark.parametrize(
    "value, text", [(0.1, "0.1"), (720.0, "720.0"), (-3, "-3"), (1.7e-4, "0.00017"), (0.0, "0.0"), (1e9, "1e+09")]
)
def test_numbers_are_printed_short_and_exact(value: float, text: str) -> None:
    assert number(value) == text
    assert float(text) == value


@pytest.mark.parametrize("text", [None, "", "can0", "slcan-tcp:host", "slcan-tcp:host:99999", "usb:1"])
def test_a_wrong_bus_is_refused_with_what_would_be_right(text: str | None) -> None:
    with pytest.raises(InputError, match="slcan-tcp:HOST:PORT"):
        parse_bus(text)


@pytest.mark.parametrize(
    "content",
    [
        "",
        "[]",
        "{}",
        '{"objects": [{"index": 1}]}',
        '{"objects": [{"index": 1, "sub": 0, "name": "a", "type": "X", "access": "rw"}]}',
    ],
)
def test_a_bad_parameters_file_is_named(tmp_path: Path, content: str) -> None:
    path = tmp_path / "parameters.json"
    path.write_text(content)
    with pytest.raises(InputError, match=str(path)):
        load_schema(path)


def test_groups_select_their_members_only(schema: Schema) -> None:
    members = schema.select(["azimuth.speed_loop"])
    assert members and members == [p for p in schema if p.index == 0x2000 and p.sub > 0]


def test_the_dictionary_for_python_canopen_has_every_object(schema: Schema) -> None:
    dictionary = schema.object_dictionary()
    count = len(json.loads(PARAMETERS.read_text())["objects"])
    assert sum(len(entry) if hasattr(entry, "subindices") else 1 for entry in dictionary.values()) == count
