# SPDX-License-Identifier: Apache-2.0
"""Files of users in the forms that editors and spreadsheets write: read right, or refused in one sentence with file and line."""

from __future__ import annotations

import codecs
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servoctl.errors import InputError
from servoctl.gains.gains_file import parse_gains, read_gains, write_gains
from servoctl.identify.identified import NAMES, read_identified
from servoctl.identify.recorder import Recording
from servoctl.identify.recorder import read_recording as read_runs
from servoctl.identify.test_plan import LIMIT_FIELDS, read_test_plan
from servoctl.motion.trajectory import read_trajectory
from servoctl.motion.two_lines import read_entries
from servoctl.objects.fault_table import load_faults
from servoctl.objects.schema import load_schema
from servoctl.show.number_table import read_columns
from servoctl.show.recording import read as read_recording

from .conftest import PACKAGE, PARAMETERS
from .test_satellite import LINES

GAIN = "azimuth.speed_loop.proportional_gain"
SCHEMA = load_schema(PARAMETERS)


def trajectory(path: Path) -> Any:
    found = read_trajectory(path)
    return found.time_s.tolist(), found.angle_rad[0].tolist()


def gains(path: Path) -> Any:
    return {parameter.name: value for parameter, value in read_gains(path, SCHEMA).values.items()}


def elements(path: Path) -> Any:
    return [(entry.name, entry.one, entry.two, entry.satrec().satnum) for entry in read_entries(path)]


def faults(path: Path) -> Any:
    return load_faults(path).faults


def objects(path: Path) -> Any:
    return [parameter.name for parameter in load_schema(path).parameters]


def columns(path: Path) -> Any:
    return {name: values.tolist() for name, values in read_columns(path).items()}


def runs(path: Path) -> Any:
    found = read_runs(path)
    return {name: getattr(found, name).tolist() for name in Recording.__dataclass_fields__}


def plan(path: Path) -> Any:
    return read_test_plan(path)


def identified(path: Path) -> Any:
    found = read_identified(path)
    return found.estimates, found.refused


def recording(path: Path) -> Any:
    return read_recording(path)


@dataclass(frozen=True)
class Reader:
    """A reader of files with this name, and a text that it takes."""

    read: Callable[[Path], Any]
    name: str
    text: str

    def __str__(self) -> str:
        return self.name


PATH = Reader(trajectory, "path.csv", "# Größe µ\ntime_s,azimuth_deg\n0,1.5\n1,-2e-1\n")
GAINS = Reader(gains, "gains.toml", "# Größe µ\n[azimuth.speed_loop]\nproportional_gain = 1_0.5 # Größe\n")
ELEMENTS = Reader(elements, "iss.tle", f"# Größe µ\nISS\n{LINES[0]}\n{LINES[1]}\n")
JSON = [
    Reader(objects, "parameters.json", PARAMETERS.read_text()),
    Reader(faults, "faults.json", PARAMETERS.with_name("faults.json").read_text()),
]
EXPERIMENT = {"kind": 1, "duration_s": 1.0}
PLAN = {
    "format": "trackservo-programme", "version": 1, "stage": "first_look", "duration_s": 1.0, "moving_rad_s": 0.1,
    "limits": dict.fromkeys(LIMIT_FIELDS, 1.0), "places": [{"angle_rad": 0.5, "experiments": [EXPERIMENT]}], "note": "Größe",
}  # fmt: skip
FOUND = {
    "format": "trackservo-identification", "version": 1, "refused": [], "note": "Größe",
    "parameters": {name: {"value": 1.5, "unit": "Nm", "interval_95": [1.0, 2.0], "paper_method": None} for name in NAMES},
}  # fmt: skip
JSON += [
    Reader(plan, "plan.json", json.dumps(PLAN, indent=1, ensure_ascii=False) + "\n"),
    Reader(identified, "result.json", json.dumps(FOUND, indent=1, ensure_ascii=False) + "\n"),
]
RUN_TITLES = ",".join(Recording.__dataclass_fields__)
TABLES = [
    Reader(columns, "residuals.csv", "time_s,torque\n0,1\n1,2\n"),
    Reader(runs, "runs.csv", f"{RUN_TITLES}\n0,1,1,0.1,2e-3,0.5,1,2\n0.001,1,1,0.1,2e-3,0.5,1,-2\n"),
]
BY_HAND = [PATH, GAINS, ELEMENTS]
READERS = [*BY_HAND, *JSON, *TABLES]

FORMS: dict[str, Callable[[str], bytes]] = {
    "UTF-8": lambda text: text.encode(),
    "UTF-8 with BOM": lambda text: text.encode("utf-8-sig"),
    "two BOMs": lambda text: f"\ufeff{text}".encode("utf-8-sig"),
    "UTF-16 little endian": lambda text: codecs.BOM_UTF16_LE + text.encode("utf-16-le"),
    "UTF-16 big endian": lambda text: codecs.BOM_UTF16_BE + text.encode("utf-16-be"),
    "UTF-32": lambda text: text.encode("utf-32"),
    "Latin-1": lambda text: text.encode("latin-1", errors="replace"),
    "CR LF": lambda text: text.replace("\n", "\r\n").encode(),
    "CR": lambda text: text.replace("\n", "\r").encode(),
    "BOM and CR LF": lambda text: text.replace("\n", "\r\n").encode("utf-8-sig"),
    "no end of the last line": lambda text: text.rstrip("\n").encode(),
    "empty lines at the end": lambda text: f"{text}\n\n".encode(),
    "NUL at the end": lambda text: f"{text}\0\0".encode(),
    "end of file of DOS": lambda text: f"{text}\x1a".encode(),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("reader", READERS, ids=str)
def test_every_form_is_read_as_the_plain_one(tmp_path: Path, reader: Reader, form: str) -> None:
    (tmp_path / "plain").mkdir()
    (tmp_path / "plain" / reader.name).write_bytes(reader.text.encode())
    (tmp_path / reader.name).write_bytes(FORMS[form](reader.text))
    assert reader.read(tmp_path / reader.name) == reader.read(tmp_path / "plain" / reader.name)


@pytest.mark.parametrize("reader", READERS, ids=str)
def test_a_pipe_is_read_as_a_file(tmp_path: Path, reader: Reader) -> None:
    (tmp_path / "plain").mkdir()
    plain, pipe = tmp_path / "plain" / reader.name, tmp_path / reader.name
    plain.write_text(reader.text)
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_bytes, args=(reader.text.encode("utf-8-sig"),))
    writer.start()
    assert reader.read(pipe) == reader.read(plain)
    writer.join()


BAD: dict[str, bytes] = {
    "empty": b"",
    "only a BOM": codecs.BOM_UTF8,
    "only line ends": b"\r\n\r\n",
    "UTF-16 without BOM": "time_s,azimuth_deg\n0,1\n".encode("utf-16-le"),
    "half a character of UTF-16": codecs.BOM_UTF16_LE + "time".encode("utf-16-le") + b"x",
    "broken UTF-8 after a BOM": codecs.BOM_UTF8 + b"time_s\n\xff\n",
    "bytes of a program": bytes(range(256)) * 20,
    "many brackets": b"a = " + b"[" * 100_000,
    "an archive": b"PK\x03\x04" + bytes(100),
}


@pytest.mark.parametrize("bad", BAD)
@pytest.mark.parametrize("reader", [*BY_HAND, *JSON, Reader(recording, "still.mcap", "")], ids=str)
def test_what_is_no_such_file_is_refused_with_its_name(tmp_path: Path, reader: Reader, bad: str) -> None:
    path = tmp_path / reader.name
    path.write_bytes(BAD[bad])
    with pytest.raises(InputError) as refused:
        reader.read(path)
    assert str(refused.value).startswith(str(path)) and "\n" not in str(refused.value) and refused.value.code == 2


@pytest.mark.parametrize("reader", READERS, ids=str)
def test_a_folder_a_missing_file_and_a_device_are_refused(tmp_path: Path, reader: Reader) -> None:
    for path, words in ((tmp_path, "is not a file"), (tmp_path / "none", "No such file"), (Path("/dev/zero"), "is not a file")):
        with pytest.raises(InputError, match=words):
            reader.read(path)


# --- numbers in a table -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", [
    "time_s;azimuth_deg\n0;1.5\n1;-0.2\n",
    "time_s;azimuth_deg\n0;1,5\n1,0;-0,2\n",
    "time_s\tazimuth_deg\n0\t1.5\n1\t-0.2\n",
    "time_s\tazimuth_deg\n0\t1,5\n1\t-0,2\n",
    "sep=;\ntime_s;azimuth_deg\n0;1,5\n1;-0,2\n",
    '"time_s","azimuth_deg"\n"0","1.5"\n"1","-.2"\n',
    '"time_s";"azimuth_deg"\n"0";"1,5"\n"1";"-2e-1"\n',
    "time_s , azimuth_deg\n 0 , 1.5 \n +1. ,\t-0.2\n",
    "\n\n# no\ntime_s,azimuth_deg\n\n0,1.5\n   # no\n1,-20E-2\n",
])  # fmt: skip
def test_every_separator_and_decimal_comma_is_understood(tmp_path: Path, text: str) -> None:
    path = tmp_path / "path.csv"
    path.write_text(text)
    assert trajectory(path) == ([0.0, 1.0], np.radians([1.5, -0.2]).tolist())


@pytest.mark.parametrize("text, line, words", [
    ("time_s,azimuth_deg\n0,0,1,5\n1,0,1,6\n", 2, "4 values, but the title line has 2 columns; a decimal comma needs semicolons or tabs"),
    ("time_s;azimuth_deg\n0;1.234,5\n1;2\n", 2, "azimuth_deg is '1.234,5'"),
    ("time_s,azimuth_deg\n0,1\n1,NaN\n", 3, "azimuth_deg is 'NaN'"),
    ("time_s,azimuth_deg\n0,1\n1,-inf\n", 3, "azimuth_deg is '-inf'"),
    ("time_s,azimuth_deg\n0,1\n1,1e400\n", 3, "azimuth_deg is '1e400'"),
    ("time_s,azimuth_deg\n0,1\n1,1_000\n", 3, "azimuth_deg is '1_000'"),
    ("time_s,azimuth_deg\n0,1\n1,0x10\n", 3, "azimuth_deg is '0x10'"),
    ("time_s,azimuth_deg\n0,1\n1,\n", 3, "azimuth_deg is ''"),
    ("time_s,azimuth_deg\n0,1\n1,\u0661\n", 3, "azimuth_deg is '\u0661'"),
    ("time_s,azimuth_deg\r0,1\r\r1,x\r", 4, "azimuth_deg is 'x'"),
    ("time_s,azimuth_deg\n0,1\x0b\n1,2 3\n", 3, "azimuth_deg is '2 3'"),
    ("time_s azimuth_deg\n0 1\n1 2\n", 1, "unknown column 'time_s azimuth_deg'"),
])  # fmt: skip
def test_a_number_that_is_none_is_named_with_its_line(tmp_path: Path, text: str, line: int, words: str) -> None:
    path = tmp_path / "path.csv"
    path.write_text(text, encoding="utf-8", newline="")
    with pytest.raises(InputError) as refused:
        read_trajectory(path)
    assert str(refused.value).startswith(f"{path}:{line}: ") and words in str(refused.value)


@pytest.mark.parametrize("read, titles", [(columns, "time_s,run"), (runs, RUN_TITLES)], ids=["columns", "runs"])
@pytest.mark.parametrize("bad", ["1e400", "-inf", "1_000", "0x10", "", "1 2", "1,5", "\u0661", "1;5"])
def test_a_bad_number_in_a_table_of_ours_is_named_with_its_line(tmp_path: Path, read: Callable[[Path], Any], titles: str, bad: str) -> None:
    path = tmp_path / "runs.csv"
    rest = ",1" * titles.count(",")
    path.write_text(f"{titles}\n0{rest}\n\n{bad}{rest}\n", encoding="utf-8")
    with pytest.raises(InputError) as refused:
        read(path)
    assert str(refused.value).startswith(f"{path}:4: ") and "\n" not in str(refused.value)


def test_a_table_of_ours_may_have_no_gyro(tmp_path: Path) -> None:
    path = tmp_path / "runs.csv"
    path.write_text(f"{RUN_TITLES}\n0,1,1,0,0,nan,0,0\n0.001,1,1,0,0,NaN,0,0\n")
    assert np.isnan(read_runs(path).inertial_rate_rad_s).all()
    path.write_text("time_s,run\n0,1\n")
    with pytest.raises(InputError, match="runs.csv:1: is not the title line of a recording"):
        read_runs(path)


@pytest.mark.parametrize("reader", JSON, ids=str)
@pytest.mark.parametrize("number, words", [
    ("NaN", "NaN is not a number"), ("-Infinity", "-Infinity is not a number"), ("1e400", "1e400 is not a number"),
    ("1" + "0" * 400, "100000000000... is not a number"), ("1_000", "delimiter"), ("1,5", "delimiter|property name|expecting"), ("0x10", "delimiter"),
])  # fmt: skip
def test_a_number_that_is_none_in_json_is_refused(tmp_path: Path, reader: Reader, number: str, words: str) -> None:
    path = tmp_path / reader.name
    path.write_text(f'{{"version": {number}}}\n')
    with pytest.raises(InputError, match=f"{reader.name}:?1?: invalid JSON: .*({words})"):
        reader.read(path)


def test_a_million_rows_of_ours_are_read_and_a_bad_one_is_named(tmp_path: Path) -> None:
    count = 1_000_000
    path = tmp_path / "residuals.csv"
    path.write_text("time_s,torque\n" + "".join(f"{i},{i % 7}.5\n" for i in range(count)))
    assert len(read_columns(path)["time_s"]) == count
    path.write_text(path.read_text() + "x,1\n")
    with pytest.raises(InputError, match=f"residuals.csv:{count + 2}: time_s is 'x'"):
        read_columns(path)


def test_a_million_rows_are_read_or_refused(tmp_path: Path) -> None:
    count = 1_000_000
    path = tmp_path / "path.csv"
    path.write_text("time_s;azimuth_deg\r\n" + "".join(f"{i};{i % 7},5\r\n" for i in range(count)), newline="")
    assert len(read_trajectory(path).time_s) == count
    path.write_text(path.read_text() + "x;1\n")
    with pytest.raises(InputError, match=f"path.csv:{count + 2}: time_s is 'x'"):
        read_trajectory(path)
    (tmp_path / "gains.toml").write_text("# nothing\n" * count)
    with pytest.raises(InputError, match="gains.toml: has more than 0.1 MB"):
        gains(tmp_path / "gains.toml")


# --- values of a gains file -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("value, words", [
    ("true", "'true' is not a number; expected"),
    ("2026-11-23", "'2026-11-23' is not a number"),
    ("2026-11-23T05:00:00Z", "is not a number"),
    ("05:00:00", "'05:00:00' is not a number"),
    ("[1.0, 2.0]", "'[1.0, 2.0]' is not a number"),
    ("'1.0'", "'1.0' is not a number"),
    ("nan", "nan is not finite"),
    ("-inf", "-inf is not finite"),
    ("1e400", "inf is not finite"),
    ("1" + "0" * 400, "100000000000... is beyond every limit"),
])  # fmt: skip
def test_a_gain_that_is_no_number_is_named(value: str, words: str) -> None:
    with pytest.raises(InputError) as refused:
        parse_gains(f"[azimuth.speed_loop]\n\nproportional_gain = {value}\n", Path("gains.toml"), SCHEMA)
    assert str(refused.value).startswith(f"gains.toml:3: {GAIN}: ") and words in str(refused.value)


@pytest.mark.parametrize("text, words", [
    (f"{GAIN} = 1{'0' * 5000}\n", "invalid TOML"),
    (f"{GAIN} = 1,5\n", "gains.toml:1: invalid TOML"),
    (f"{GAIN} = 1__0\n", "invalid TOML"),
    (f"{GAIN} = 1.0\n# \u2028 \x85\n{GAIN} = 2.0\n", "gains.toml:3: invalid TOML: "),
    (f"# \u2028\n\n{GAIN} = true\n", "gains.toml:3: "),
    ("[[azimuth]]\nspeed_loop.proportional_gain = 1.0\n", "gains.toml:1: unknown parameter 'azimuth'"),
    ("device = 3\n", "contains no gains"),
])  # fmt: skip
def test_a_gains_file_that_is_none_is_refused(text: str, words: str) -> None:
    with pytest.raises(InputError) as refused:
        parse_gains(text, Path("gains.toml"), SCHEMA)
    assert str(refused.value).startswith("gains.toml:") and words in str(refused.value)


def test_a_gains_file_of_windows_is_updated_with_its_comments(tmp_path: Path) -> None:
    path = tmp_path / "gains.toml"
    path.write_bytes("# Größe\r\n[azimuth.speed_loop]\r\nproportional_gain = 1.0 # mine\r\n".encode("utf-16"))
    write_gains(path, {SCHEMA.find(GAIN): 2.5}, {})
    text = path.read_text(encoding="utf-8")
    assert text.startswith("# Größe\n[azimuth.speed_loop]\nproportional_gain = 2.5 # mine\n")


# --- the command ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("text, words", [
    ("\ufefftime_s;azimuth_deg\r\n0;1,5\r\n1;x\r\n", "/dev/stdin:3: azimuth_deg is 'x'"),
    ("", "/dev/stdin:1: a trajectory needs a title line"),
])  # fmt: skip
def test_a_bad_pipe_is_one_sentence_and_code_2(tmp_path: Path, text: str, words: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "servoctl", "follow", "/dev/stdin", "--dry-run"], input=text.encode(), capture_output=True, timeout=60,
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(PACKAGE), "SERVOCTL_BUS": "slcan-tcp:127.0.0.1:1"},
    )  # fmt: skip
    err = done.stderr.decode()
    assert done.returncode == 2 and words in err and err.count("\n") == 1, done
