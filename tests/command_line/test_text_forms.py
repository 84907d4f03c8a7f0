# SPDX-License-Identifier: Apache-2.0
"""Text files in the forms that editors and spreadsheets write: sim_host and identify say of each what they say of the plain
one, with the same line."""

import codecs
import json
import os
import subprocess
import threading
import tomllib

import pytest
from programs import PROGRAMS, PROJECT, WRONG_INPUT
from test_random_plants import GOOD, files_in, identified, identified_axis, random_plants  # noqa: F401 - a fixture

PLANT, SCENARIO = PROJECT / "sim_host/plants/tracker.toml", PROJECT / "sim_host/scenarios/sine.toml"
RANGE = "--lowest-rad -1 --highest-rad 1 --torque-nm 100 --fastest-rad-s 1"
RESULT = identified_axis(tomllib.loads(PLANT.read_text())["pitch"])
HEADER = "time_s,run,kind,joint_angle_rad,joint_rate_rad_s,inertial_rate_rad_s,torque_nm,reference\n"

# Command with FILE, and GOOD for a good result of an identification; the file's text, and a part of the answer.
OTHER_JSON = '{"format":\n "other",\n "note": "Größe"}\n'
READERS = {
    "plant": (f"sim_host run --plant FILE --scenario {SCENARIO}", "# Größe\n" + PLANT.read_text(), "rms"),
    "scenario": (f"sim_host run --plant {PLANT} --scenario FILE", "# Größe\n" + SCENARIO.read_text(), "rms"),
    "gains": ("sim_host check --gains FILE", "# Größe\n[azimuth.speed_loop]\nproportional_gain = -1\n", ":3: azimuth."),
    "limits": ("sim_host check --limits FILE", "# Größe\n\nnonsense = 1\n", ":3: nonsense"),
    "recording": ("identify fit FILE", HEADER + "0,1,1,0,0,0,0,0\n0.001,1,1,x,0,0,0,0\n", ":3: joint_angle_rad is 'x'"),
    "result": ("identify design --identified FILE --parameters none --json none", OTHER_JSON, "is not a trackservo-identification"),
    "requirements": ("identify design --identified GOOD --requirements FILE --parameters none --json none", OTHER_JSON, '"format"'),
    "parameters": ("identify design --identified GOOD --parameters FILE --json none", OTHER_JSON, "format"),
    "first look": (f"identify plan {RANGE} --identified FILE", OTHER_JSON, "is not of format trackservo-identification"),
    "baseline": ("sim_host check --baseline FILE", OTHER_JSON, "its format is not"),
}


FORMS = {
    "UTF-8 with BOM": lambda text: text.encode("utf-8-sig"),
    "two BOMs": lambda text: f"\ufeff{text}".encode("utf-8-sig"),
    "UTF-16 little endian": lambda text: codecs.BOM_UTF16_LE + text.encode("utf-16-le"),
    "UTF-16 big endian": lambda text: codecs.BOM_UTF16_BE + text.encode("utf-16-be"),
    "UTF-32": lambda text: text.encode("utf-32"),
    "Latin-1": lambda text: text.encode("latin-1", errors="replace"),
    "CR LF": lambda text: text.replace("\n", "\r\n").encode(),
    "CR": lambda text: text.replace("\n", "\r").encode(),
    "UTF-16 and CR LF": lambda text: text.replace("\n", "\r\n").encode("utf-16"),
    "empty lines at the end": lambda text: f"{text}\n\n".encode(),
    "no end of the last line": lambda text: text.rstrip("\n").encode(),
    "NUL at the end": lambda text: f"{text}\0\0".encode(),
    "end of file of DOS": lambda text: f"{text}\x1a".encode(),
}


def answer(reader, file):
    good = file.with_name("good.json")
    good.write_text(json.dumps(RESULT))
    program, *words = READERS[reader][0].replace("FILE", str(file)).replace("GOOD", str(good)).split()
    done = subprocess.run([PROGRAMS[program], *words], capture_output=True, text=True, timeout=60)
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize("reader", READERS)
def test_every_form_is_read_as_the_plain_one_also_from_a_pipe(tmp_path, reader):
    file = tmp_path / "file"
    text = READERS[reader][1]
    file.write_text(text)
    plain = answer(reader, file)
    assert READERS[reader][2] in plain[1] + plain[2], plain
    for form, written in FORMS.items():
        file.write_bytes(written(text))
        assert answer(reader, file) == plain, form
    file.unlink()
    os.mkfifo(file)
    writer = threading.Thread(target=file.write_bytes, args=(text.encode("utf-16"),))
    writer.start()
    assert answer(reader, file) == plain
    writer.join()


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("bytes_", [b"a = 1\n\0b = 2\n", codecs.BOM_UTF16_LE + b"\x00\xd8", b"\x7fELF\0\0\1"], ids=["NUL", "no UTF-16", "program"])
def test_what_is_no_text_is_refused_in_one_sentence(tmp_path, reader, bytes_):
    file = tmp_path / "file"
    file.write_bytes(bytes_)
    code, out, err = answer(reader, file)
    assert code == WRONG_INPUT and not out
    assert str(file) in err and "save it as UTF-8" in err and err.count("\n") == 1, err


def test_a_log_of_random_plants_in_every_form_is_merged_and_continued_as_the_plain_one(tmp_path, identified):
    log, pipe = tmp_path / "log.csv", tmp_path / "pipe"
    run = ("--identified", identified, "--seeds", "7-8", "--log", log)
    assert random_plants(tmp_path, *run).returncode == GOOD
    plain, files = log.read_text(), files_in(tmp_path)
    for form, written in FORMS.items():
        log.write_bytes(written(plain))
        for options in (("--merge", log), run):
            done = random_plants(tmp_path, *options)
            assert done.returncode == GOOD and files_in(tmp_path) == files, (form, options, done.stderr)
        assert log.read_text().rstrip("\n\0\x1a") == plain.rstrip("\n"), form
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_bytes, args=(plain.encode("utf-16"),))
    writer.start()
    assert random_plants(tmp_path, "--merge", pipe).returncode == GOOD and files_in(tmp_path) == files
    writer.join()
    assert "is not a regular file" in random_plants(tmp_path, *run[:-1], pipe).stderr


@pytest.mark.parametrize("cut, line", [(20, 4), (400, 3)])
def test_a_log_that_is_cut_off_is_refused_by_merge_and_completed_by_log(tmp_path, identified, cut, line):
    log = tmp_path / "log.csv"
    run = ("--identified", identified, "--seeds", "7-8", "--threads", 1, "--log", log)
    assert random_plants(tmp_path, *run).returncode == GOOD
    plain = log.read_text()
    log.write_text(plain[:-cut])
    done = random_plants(tmp_path, "--merge", log)
    expected = f"sim_host: {log}:{line}: the file ends within this line; continue its run with --log {log}\n"
    assert (done.returncode, done.stderr) == (WRONG_INPUT, expected)
    assert random_plants(tmp_path, *run).returncode == GOOD and log.read_text() == plain


def refused(reader, file, line):
    code, out, err = answer(reader, file)
    assert code == WRONG_INPUT and not out and err.count("\n") == 1, (code, out, err)
    assert f" {file}:{line}: " in err, err


# A file with %s for a number, and what is no number there: TOML takes 1_0.
NO_NUMBERS = ["1e400", "nan", "1,5", "1;5", "1__0", "", "x", "\u0661"]
NUMBERS = {
    **dict.fromkeys(("gains",), "# Größe\n[azimuth.speed_loop]\nproportional_gain = %s\n"),
    **dict.fromkeys(("result", "requirements", "parameters", "first look", "baseline"), '{"note": "Größe",\n "format":\n  %s}\n'),
    "recording": HEADER + "0,1,1,0,0,0,0,0\n0.001,1,1,%s,0,0,0,0\n",
    "plant": "# Größe\n\nsupply_v = %s\n",
    "scenario": '# Größe\nname = "sine"\ntitle = "sine"\nkind = "speed_sine"\nduration_s = %s\n',
    "limits": "# Größe\n[learned]\nseeds = %s\n",
}


@pytest.mark.parametrize("number", NO_NUMBERS)
@pytest.mark.parametrize("reader", READERS)
def test_a_number_that_is_none_is_named_with_its_line(tmp_path, reader, number):
    file = tmp_path / "file"
    file.write_text(NUMBERS[reader] % number)
    refused(reader, file, 1 + NUMBERS[reader].partition("%s")[0].count("\n"))


@pytest.mark.parametrize("bytes_", [b"", codecs.BOM_UTF8, b"\r\n\r\n"], ids=["empty", "only a BOM", "only line ends"])
@pytest.mark.parametrize("reader", READERS)
def test_a_file_without_a_text_is_refused_in_one_sentence(tmp_path, reader, bytes_):
    file = tmp_path / "file"
    file.write_bytes(bytes_)
    code, out, err = answer(reader, file)
    assert code == WRONG_INPUT and not out and err.count("\n") == 1 and f" {file}:" in err, (code, out, err)


@pytest.mark.parametrize("reader", READERS)
def test_a_million_lines_are_read(tmp_path, reader):
    count = 1_000_000
    file = tmp_path / "file"
    rows = "".join(f"{1e-3 * i:.3f},1,1,0,0,0,0,0\n" for i in range(count))
    bad = {"recording": HEADER + rows + "x,1,1,0,0,0,0,0\n"}.get(reader, "\n" * (count + 1) + "]\n")
    file.write_text(bad)
    refused(reader, file, count + 2)
