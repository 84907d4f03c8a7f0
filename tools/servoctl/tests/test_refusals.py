# SPDX-License-Identifier: Apache-2.0
"""Refusals: invalid numbers, tables that do not fit; always one sentence and the right exit code."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from servoctl import __version__
from servoctl.errors import InputError
from servoctl.motion.limits import Limits, Plan

from .conftest import PARAMETERS, Bench

GAIN = "azimuth.speed_loop.proportional_gain"
RUN = ("move", "azimuth", "--rate", "1", "--for", "1", "--yes")


SENSELESS = (
    (*RUN, "--for", "nan"),
    (*RUN, "--for", "-1"),
    (*RUN, "--for", "0"),
    (*RUN, "--for", "inf"),
    (*RUN, "--rate", "nan"),
    (*RUN, "--max-rate", "nan"),
    (*RUN, "--max-travel", "nan"),
    (*RUN, "--max-duration", "-inf"),
    (*RUN, "--max-duration", "1e999"),
    ("move", "azimuth", "--to", "nan", "--yes"),
    ("move", "azimuth", "--by", "inf", "--yes"),
    ("move", "azimuth", "--by", "1", "--rate", "0", "--yes"),
    ("move", "azimuth", "--by", "1e5", "--max-travel", "1e6", "--max-duration", "1e6", "--yes"),
    ("step", "azimuth", "--amplitude", "nan", "--yes"),
    ("step", "azimuth", "--hold", "nan", "--yes"),
    ("bode", "azimuth", "--low", "nan", "--yes"),
    ("bode", "azimuth", "--bias", "nan", "--yes"),
    ("scope", "azimuth.rate", "--rate", "nan"),
    ("scope", "azimuth.rate", "--for", "-1"),
    ("scope", "azimuth.rate", "--for", "nan"),
    ("scope", "azimuth.rate", "--pre", "-1"),
    ("scope", "azimuth.rate", "--pre", "1e300"),
    ("scope", "azimuth.rate", "--level", "nan"),
    ("scope", "azimuth.rate", "--timeout", "nan"),
    ("monitor", "--for", "nan"),
    ("log", GAIN, "--rate", "nan"),
    ("log", GAIN, "--for", "-1"),
)


def test_numbers_that_make_no_sense_are_refused_in_one_sentence(servo: Bench) -> None:
    for words in SENSELESS:
        result = servo(*words)
        reported = result.code == 2 and result.err.startswith("servoctl") and result.err.count("\n") == 1
        assert reported, (words, result)
    assert servo.json("state", "azimuth")["axes"][0]["state"] == "switch on disabled"


@pytest.mark.parametrize("field", ["rate_rad_s", "travel_rad", "duration_s"])
def test_no_limit_is_passed_by_what_is_no_number(field: str) -> None:
    fine = Limits(rate_rad_s=1.0, travel_rad=1.0, duration_s=1.0)
    plan = Plan("azimuth", "", 0.5, 0.5, 0.0, 0.5)
    plan.check(fine)
    with pytest.raises(InputError):
        plan.check(replace(fine, **dict[str, Any]({field: float("nan")})))
    wrong = {"rate_rad_s": "rate_rad_s", "travel_rad": "forward_rad", "duration_s": "duration_s"}[field]
    with pytest.raises(InputError):
        Plan(**{**vars(plan), wrong: float("nan")}).check(fine)


def test_a_folder_that_cannot_be_written_is_reported_without_traceback(servo: Bench) -> None:
    (servo.folder / "file").write_text("")
    result = servo("scope", "azimuth.rate", "--for", "0.1", "--out", "file/below")
    assert result.code == 2 and "file/below" in result.err and result.err.count("\n") == 1


def old_table(folder: Path) -> Path:
    """A table of another firmware in the cache."""
    content = json.loads(PARAMETERS.read_text())
    content["schema_hash"] ^= 1
    cache = folder / "cache" / "servoctl" / "parameters"
    cache.mkdir(parents=True)
    path = cache / f"{content['schema_hash']:08x}.json"
    path.write_text(json.dumps(content))
    return path


@pytest.mark.parametrize("kind", ["empty", "old", "broken"])
def test_another_schema_hash_is_reported_with_what_servoctl_carries_and_what_to_do(elsewhere: Bench, kind: str) -> None:
    servo = elsewhere
    if kind != "empty":
        path = old_table(servo.folder)
        if kind == "broken":
            path.write_text("{")
    reported = json.loads(PARAMETERS.read_text())["schema_hash"]
    for words in (("get", GAIN), ("set", GAIN, "700"), ("get", "0x2000:1")):
        refused = servo(*words)
        assert refused.code == (2 if "0x2000:1" in words else 7) and refused.err.count("\n") == 1
        for part in (
            f"schema hash is {reported:08X}", f"servoctl {__version__} includes {reported ^ 2:08X}",
            str(servo.folder / "cache"),
            "--parameters FILE", "SERVOCTL_PARAMETERS", "servoctl of that firmware",
            f"image of servoctl's release, {__version__}", "--type REAL32",
        ):  # fmt: skip
            assert part in refused.err, part
    assert servo.json("get", "0x2000:1", "--type", "REAL32")[0]["value"] > 0
    for known in ("scan", "state", "faults", "scope --list", "move azimuth --by 0.1 --yes"):
        assert servo(*known.split()).code == 0, known  # as in the message
    found = servo.json("info")
    assert found["schema_fits"] is False and found["parameters"] is None
    assert servo("get", GAIN, "--parameters", str(PARAMETERS)).code == 0
    assert servo("get", GAIN).code == 0  # remembered
    if kind == "old":
        assert servo("get", GAIN, "--parameters", str(path)).code == 7


def test_a_device_without_a_schema_hash_is_not_taken_for_a_trackservo(test_node: Bench) -> None:
    """Its objects may mean anything: names are refused until the user gives its table."""
    del test_node.environment["SERVOCTL_PARAMETERS"]
    refused = test_node("set", GAIN, "700")
    assert refused.code == 7 and "reports no schema hash" in refused.err and refused.err.count("\n") == 1
