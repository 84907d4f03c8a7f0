# SPDX-License-Identifier: Apache-2.0
"""The gains file alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from servoctl.errors import InputError
from servoctl.gains.gains_file import read_gains, write_gains
from servoctl.objects.parameter import Parameter, Value
from servoctl.objects.schema import Schema, load_schema

from .conftest import PARAMETERS


@pytest.fixture(scope="module")
def schema() -> Schema:
    return load_schema(PARAMETERS)


def defaults(schema: Schema) -> dict[Parameter, Value]:
    return {p: p.default for p in schema.tunable if p.default is not None}


def test_what_is_written_is_read_back_exactly(schema: Schema, tmp_path: Path) -> None:
    path = tmp_path / "gains.toml"
    write_gains(path, defaults(schema), {"name": "test"})
    assert read_gains(path, schema).values == defaults(schema)


def test_units_stand_in_the_comments(schema: Schema, tmp_path: Path) -> None:
    path = tmp_path / "gains.toml"
    write_gains(path, defaults(schema), {})
    line = next(text for text in path.read_text().splitlines() if text.startswith("proportional_gain"))
    assert "# N m s/rad; 0 to 1000000" in line.replace("0.0", "0").replace(".0", "")


def test_comments_of_an_existing_file_stay(schema: Schema, tmp_path: Path) -> None:
    path = tmp_path / "gains.toml"
    path.write_text("# mine\n[azimuth.speed_loop]\nproportional_gain = 1.0 # found on the dyno\n")
    gain = schema.find("azimuth.speed_loop.proportional_gain")
    write_gains(path, {gain: 2.5}, {})
    text = path.read_text()
    assert "# mine" in text and "proportional_gain = 2.5 # found on the dyno" in text


def test_a_link_stays_one_and_a_file_keeps_its_mode(schema: Schema, tmp_path: Path) -> None:
    (tmp_path / "gains.toml").write_text("# mine\n")
    (tmp_path / "gains.toml").chmod(0o600)
    (tmp_path / "link.toml").symlink_to("gains.toml")
    write_gains(tmp_path / "link.toml", defaults(schema), {})
    assert (tmp_path / "link.toml").is_symlink() and (tmp_path / "gains.toml").stat().st_mode & 0o777 == 0o600
    assert read_gains(tmp_path / "gains.toml", schema).values == defaults(schema)


@pytest.mark.parametrize(
    "body, line, words",
    [
        ("[azimuth.speed_loop]\nproportional_gian = 1.0\n", 2, "did you mean azimuth.speed_loop.proportional_gain"),
        ("[azimuth.speed_loop]\n\nproportional_gain = -1.0\n", 3, "below the lower limit"),
        ("[azimuth.speed_loop]\nproportional_gain = 'high'\n", 2, "not a number"),
        ("[azimuth.speed_loop]\nproportional_gain = nan\n", 2, "not finite"),
        ("[azimuth]\nspeed_loop.proportional_gain = 1e12\n", 2, "above the upper limit"),
        ("[azimuth]\nstatusword = 3\n", 2, "is not a gain"),
        ("[azimuth.speed_loop\nproportional_gain = 1.0\n", 1, "invalid TOML"),
        ("[azimuth.rate_sensors]\nestimator_window = 2.5\n", 2, "not a whole number"),
    ],
)
def test_a_mistake_is_reported_with_file_and_line(
    schema: Schema, tmp_path: Path, body: str, line: int, words: str
) -> None:
    path = tmp_path / "gains.toml"
    path.write_text(body)
    with pytest.raises(InputError) as caught:
        read_gains(path, schema)
    assert f"{path}:{line}:" in str(caught.value) and words in str(caught.value)


def test_an_empty_or_absent_file_is_refused(schema: Schema, tmp_path: Path) -> None:
    (tmp_path / "empty.toml").write_text("")
    for name in ("empty.toml", "absent.toml"):
        with pytest.raises(InputError, match=name):
            read_gains(tmp_path / name, schema)
