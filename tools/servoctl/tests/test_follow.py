# SPDX-License-Identifier: Apache-2.0
"""servoctl follow: a trajectory is checked before anything moves, and followed in time."""

from __future__ import annotations

import csv
import json
import math
import signal
import statistics
from datetime import datetime, timedelta, timezone, tzinfo
from pathlib import Path

import pytest

from servoctl.commands import follow

from .conftest import Bench, Eventually
from .test_satellite import LINES, geostationary, other

BORROWED = ("0x1403:1", "0x1603:0", "0x1603:1", "0x1802:1", "0x1A02:1", "0x1803:1", "0x60C2:1", "0x68C2:1", "0x6060", "0x6860")
SITE = ("--site", "52.2", "21.0", "100", "--after", "2008-09-20T12:25:40", "--rehearse")


def sines(path: Path, duration_s: float, rates: bool, amplitude_deg: float = 4.0) -> Path:
    """Azimuth and pitch, up to 2.4 and 1.2 °/s, a row every 0.1 s."""
    names = ["time_s", "azimuth_deg", "pitch_deg"] + (["azimuth_rate_deg_s", "pitch_rate_deg_s"] if rates else [])
    w = 0.6
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(names)
        for i in range(round(10 * duration_s) + 1):
            t = 0.1 * i
            row = [t, amplitude_deg * math.sin(w * t), 16 + 0.5 * amplitude_deg * math.sin(w * t + 1)]
            if rates:
                row += [amplitude_deg * w * math.cos(w * t), 0.5 * amplitude_deg * w * math.cos(w * t + 1)]
            writer.writerow(row)
    return path


def borrowed(servo: Bench) -> list[int]:
    return [row["value"] for row in servo.json("get", *BORROWED)]


def states(servo: Bench) -> list[str]:
    return [axis["state"] for axis in servo.json("state")["axes"]]


def angles(servo: Bench) -> list[float]:
    return [float(axis["position_deg"]) for axis in servo.json("state")["axes"]]


@pytest.mark.real_time
@pytest.mark.parametrize("rates", [True, pytest.param(False, marks=(pytest.mark.smoke, pytest.mark.image))])
@pytest.mark.alone
def test_both_axes_follow_a_file_in_time_and_everything_is_put_back(servo: Bench, rates: bool) -> None:
    """The loops leave some µrad; 1 ms in time would be 30 µrad at the median and 16 µrad at the lower quartile. The lower
    quartile counts: a loaded computer is late with many set-points, and never early."""
    sines(servo.folder / "path.csv", 3.0 if rates else 1.5, rates)
    before = borrowed(servo)
    done = servo("follow", "path.csv", "--slew-rate", "20", "--plot", "error.png", "--json", "--yes")
    assert done.code == 0, done.err
    *lines, found = [json.loads(line) for line in done.out.splitlines()]
    assert len(lines) >= 1 and all(line["azimuth_rms_urad"] < 500 for line in lines)
    for axis in found["axes"]:
        assert axis["rms_urad"] < 1000 and abs(axis["delay_ms"]) < 5.0, axis
    with (servo.folder / "error.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    for name in ("azimuth", "pitch"):
        assert statistics.quantiles([abs(float(row[f"{name}_error_urad"])) for row in rows], n=4)[0] < 30
    assert found["samples"] > (2400 if rates else 1200)
    assert [(servo.folder / name).stat().st_size > 1000 for name in found["files"]] == [True, True]
    assert states(servo) == ["switch on disabled"] * 2 and borrowed(servo) == before


@pytest.mark.real_time
@pytest.mark.image
def test_a_satellite_is_followed_from_its_elements(servo: Bench) -> None:
    """A dry run shows the whole pass; the motion is its first seconds."""
    (servo.folder / "iss.tle").write_text("\n".join(["ISS (ZARYA)", *LINES]) + "\n")
    shown = servo("follow", "iss.tle", *SITE, "--dry-run")
    assert shown.code == 0 and "ISS (ZARYA), pass of 2008-09-20 18:22:15 UTC, 284 s, up to 22.0°" in shown.out, shown
    assert "between -202.702° and -95.292°" in shown.out
    short = servo("follow", "iss.tle", *SITE, "--seconds", "2.5", "--heading", "143", "--slew-rate", "20", "--json", "--yes")
    assert short.code == 0, short.err
    found = json.loads(short.out.splitlines()[-1])
    assert found["samples"] > 2000
    for axis in found["axes"]:
        assert axis["rms_urad"] < 1000, axis
    refused = servo("follow", "iss.tle", "--yes")
    assert refused.code == 2 and "--site 52.2 21.0 100" in refused.err
    past = servo("follow", "iss.tle", *SITE[:-1], "--yes")
    assert past.code == 2 and "which is past" in past.err


def put_clock(monkeypatch: pytest.MonkeyPatch, begin: datetime) -> None:
    """The clock of the command goes on from this time."""
    shift = begin - datetime.now(timezone.utc)

    class Clock(datetime):
        @classmethod
        def now(cls, tz: tzinfo | None = None) -> Clock:
            at = datetime.now(tz) + shift
            return cls.combine(at.date(), at.time(), tz)

    monkeypatch.setattr(follow, "datetime", Clock)


RISE = datetime(2008, 9, 20, 18, 22, 15, tzinfo=timezone.utc)


@pytest.mark.real_time
def test_a_pass_is_waited_for_and_begins_on_time(servo: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """The clock of the command is put to 7 s before the pass of 2008."""
    (servo.folder / "iss.tle").write_text("\n".join(["ISS (ZARYA)", *LINES]) + "\n")
    put_clock(monkeypatch, RISE - timedelta(seconds=7))
    here = angles(servo)[0]
    words = ("iss.tle", *SITE[:-1], "--heading", str(202.7 + here), "--seconds", "1.5", "--json", "--yes")
    monkeypatch.setattr(follow, "READY_S", 3.0)
    done = servo("follow", *words, "--slew-rate", "20")
    assert done.code == 0, done.err
    first, found = json.loads(done.out.splitlines()[0]), json.loads(done.out.splitlines()[-1])
    assert first["time_s"] < 2.0 and found["samples"] > 1200
    for axis in found["axes"]:
        assert axis["rms_urad"] < 1000, axis


@pytest.mark.real_time
def test_a_pass_under_way_is_joined_in_time(servo: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """At 100 s after the rise, by both ways to say so: the pass that is under way now, or that began after a given time."""
    (servo.folder / "iss.tle").write_text("\n".join(["ISS (ZARYA)", *LINES]) + "\n")
    monkeypatch.setattr(follow, "READY_S", 3.0)
    for after in (False, True):
        put_clock(monkeypatch, RISE + timedelta(seconds=100))
        words = [*SITE[:4], *(SITE[4:6] if after else ()), "--heading", "143", "--seconds", "1.5", "--slew-rate", "20", "--yes"]
        shown = servo("follow", "iss.tle", *words, "--dry-run")
        assert shown.code == 0 and "joins it at 18:24:" in shown.out, shown
        assert ("pass of 2008-09-20 18:22:15" if after else "which sets at 18:26:59 UTC") in shown.out
        done = servo("follow", "iss.tle", *words, "--interval", "0.5", "--json")
        assert done.code == 0, done.err
        *lines, found = [json.loads(line) for line in done.out.splitlines()]
        begun_s = 100 if after else 0
        assert all(begun_s + 3 < line["time_s"] < begun_s + 60 for line in lines) and found["samples"] > 1200
        for axis in found["axes"]:
            assert axis["rms_urad"] < 1000 and abs(axis["delay_ms"]) < 10, axis


def test_a_pass_that_is_nearly_over_is_left_to_the_next_one(servo: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    (servo.folder / "iss.tle").write_text("\n".join(["ISS (ZARYA)", *LINES]) + "\n")
    put_clock(monkeypatch, RISE + timedelta(seconds=270))
    shown = servo("follow", "iss.tle", *SITE[:4], "--heading", "143", "--seconds", "5", "--dry-run", "--yes")
    assert shown.code == 0 and "pass of 2008-09-20 19:5" in shown.out and "joins" not in shown.out, shown


@pytest.mark.real_time
def test_a_satellite_that_never_sets_is_followed_from_now_on(servo: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    (servo.folder / "geo.txt").write_text("\n".join(geostationary(21.0)))
    put_clock(monkeypatch, RISE)
    monkeypatch.setattr(follow, "READY_S", 3.0)
    words = ("follow", "geo.txt", *SITE[:4], "--heading", "180", "--slew-rate", "20")
    shown = servo.json(*words, "--dry-run")["plan"]
    assert "does not set within 48 h" in shown["text"] and "for 3600 s; --seconds changes that" in shown["text"]
    assert shown["seconds"] == pytest.approx(3600, abs=0.5) and shown["begin"].startswith("2008-09-20T18:22:")
    later = servo.json(*words, "--after", "2008-09-20T19:00:00", "--seconds", "60", "--dry-run")["plan"]
    assert later["begin"].startswith("2008-09-20T19:00:00") and later["seconds"] == pytest.approx(60, abs=0.5)
    refused = servo(*words, "--seconds", "100000", "--dry-run")
    assert refused.code == 2 and "give --seconds up to 86400" in refused.err and refused.err.count("\n") == 1
    done = servo(*words, "--seconds", "2", "--json", "--yes")
    assert done.code == 0, done.err
    found = json.loads(done.out.splitlines()[-1])
    assert found["samples"] > 1500 and all(axis["rms_urad"] < 500 for axis in found["axes"])


def test_of_several_satellites_the_first_is_announced(servo: Bench) -> None:
    lines = ["ISS (ZARYA)", *LINES, "NOAA 15", *other("25338")]
    (servo.folder / "all.txt").write_text("\r\n".join(lines))
    words = ("follow", "all.txt", *SITE, "--dry-run")
    first = servo(*words)
    assert first.code == 0 and "ISS (ZARYA), pass of" in first.out and "2 satellites" in first.err and "--satellite" in first.err
    named = servo(*words, "--satellite", "noaa")
    assert named.code == 0 and "NOAA 15, pass of" in named.out and "2 satellites" not in named.err
    refused = servo(*words, "--satellite", "GOES")
    assert refused.code == 2 and "no satellite 'GOES'" in refused.err and refused.err.count("\n") == 1
    sines(servo.folder / "path.csv", 1.0, True)
    refused = servo("follow", "path.csv", "--satellite", "ISS", "--dry-run")
    assert refused.code == 2 and "--satellite" in refused.err


def test_nothing_moves_when_a_row_breaks_a_limit_or_the_file_is_bad(servo: Bench) -> None:
    for axis in ("azimuth", "pitch"):
        servo.json("state", axis, "enable")
    before = angles(servo)
    for text, words in (
        ("time_s,azimuth_deg\n0,0\n10,100\n20,290\n", ("path.csv:3: at 10 s azimuth would move to 290", "607D:2")),
        ("time_s,pitch_deg\n0,16\n10,17\n10.1,30\n30,31\n", ("path.csv:3: at 10 s pitch would turn at", "607F")),
        ("time_s,pitch_deg,pitch_rate_deg_s\n0,16,0\n1,16,0\n2,20,40\n9,30,0\n", ("path.csv:3: at 1 s pitch would", "6083")),
        ("time_s,azimuth_deg\n0,0\n1,x\n2,1\n", ("path.csv:3", "'x'")),
    ):
        (servo.folder / "path.csv").write_text(text)
        refused = servo("follow", "path.csv", "--yes")
        assert refused.code == 2 and all(word in refused.err for word in words), refused
    sines(servo.folder / "path.csv", 1.0, True)
    assert servo("follow", "path.csv").code == 2  # nobody has confirmed
    assert servo("follow", "path.csv", "--dry-run").code == 0
    assert servo("follow", "path.csv", "--site", "1", "2", "3", "--yes").code == 2
    assert servo("follow", "missing.csv", "--yes").code == 2
    assert angles(servo) == pytest.approx(before, abs=0.01)
    for axis in ("azimuth", "pitch"):
        servo.json("state", axis, "disable")


@pytest.mark.real_time
def test_interrupting_stops_both_axes_and_puts_all_back(servo: Bench, eventually: Eventually) -> None:
    sines(servo.folder / "path.csv", 30.0, True)
    before = borrowed(servo)
    process = servo.start("follow", "path.csv", "--slew-rate", "20", "--yes")

    def follows() -> bool:
        return [axis["mode"] for axis in servo.json("state")["axes"]] == ["csp", "csp"]

    eventually(follows, 30.0)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60) == 130
    assert states(servo) == ["switch on disabled"] * 2 and borrowed(servo) == before


def test_a_file_that_fits_a_turn_away_is_followed_there_and_one_that_fits_nowhere_is_refused(servo: Bench) -> None:
    """The travel is ±278°; the file's is 298° to 302°, then 180° to 714°."""
    path = servo.folder / "path.csv"
    path.write_text("time_s,azimuth_deg\n0,298\n4,302\n", encoding="utf-8")
    shown = servo("follow", "path.csv", "--dry-run")
    assert shown.code == 0, shown.err
    assert "azimuth from -62.0" in shown.out and "-360° from the file's angles" in shown.out, shown.out
    rows = "".join(f"{t},{180 + 6 * t}\n" for t in range(90))
    path.write_text(f"time_s,azimuth_deg\n{rows}", encoding="utf-8")
    refused = servo("follow", "path.csv", "--dry-run")
    assert refused.code == 2 and "-360° lasts longest" in refused.err, refused
    assert "path.csv:78: at 76 s azimuth would move to 282.000°, beyond its software limit 607D:2" in refused.err, refused.err
