"""Text files in the forms that editors and spreadsheets write: sim_host and identify say of each what they say of the plain
one, with the same line."""

import codecs
import os
import subprocess
import threading

import pytest
from programs import PROGRAMS, PROJECT, WRONG_INPUT

PLANT, SCENARIO = PROJECT / "sim_host/plants/tracker.toml", PROJECT / "sim_host/scenarios/sine.toml"
HEADER = "time_s,run,kind,joint_angle_rad,joint_rate_rad_s,inertial_rate_rad_s,torque_nm,reference\n"

# Command with FILE, the file's text, and a part of the answer.
READERS = {
    "plant": (f"sim_host run --plant FILE --scenario {SCENARIO}", "# Größe\n" + PLANT.read_text(), "rms"),
    "scenario": (f"sim_host run --plant {PLANT} --scenario FILE", "# Größe\n" + SCENARIO.read_text(), "rms"),
    "gains": ("sim_host check --gains FILE", "# Größe\n[azimuth.speed_loop]\nproportional_gain = -1\n", ":3: azimuth."),
    "limits": ("sim_host check --limits FILE", "# Größe\n\nnonsense = 1\n", ":3: nonsense"),
    "recording": ("identify fit FILE", HEADER + "0,1,1,0,0,0,0,0\n0.001,1,1,x,0,0,0,0\n", ":3: joint_angle_rad is 'x'"),
    "result": ("identify design --identified FILE --parameters none --json none", '{"format":\n "other"}\n', "is not a"),
}

FORMS = {
    "UTF-8 with BOM": lambda text: text.encode("utf-8-sig"),
    "UTF-16 little endian": lambda text: codecs.BOM_UTF16_LE + text.encode("utf-16-le"),
    "UTF-16 big endian": lambda text: codecs.BOM_UTF16_BE + text.encode("utf-16-be"),
    "UTF-32": lambda text: text.encode("utf-32"),
    "Latin-1": lambda text: text.encode("latin-1", errors="replace"),
    "CR LF": lambda text: text.replace("\n", "\r\n").encode(),
    "CR": lambda text: text.replace("\n", "\r").encode(),
    "UTF-16 and CR LF": lambda text: text.replace("\n", "\r\n").encode("utf-16"),
    "no end of the last line": lambda text: text.rstrip("\n").encode(),
    "NUL at the end": lambda text: f"{text}\0\0".encode(),
    "end of file of DOS": lambda text: f"{text}\x1a".encode(),
}


def answer(reader, file):
    program, *words = READERS[reader][0].replace("FILE", str(file)).split()
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
    assert code == WRONG_INPUT[READERS[reader][0].split()[0]] and not out
    assert str(file) in err and "save it as UTF-8" in err and err.count("\n") == 1, err
