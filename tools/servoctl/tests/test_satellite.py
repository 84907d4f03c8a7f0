# SPDX-License-Identifier: Apache-2.0
"""The geometry of a pass, judged by Skyfield, which shares the propagator sgp4 and nothing else. No device is needed."""

from __future__ import annotations

import math
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sgp4.api import Satrec
from sgp4.io import compute_checksum
from skyfield.api import EarthSatellite, load, wgs84

from servoctl.errors import InputError
from servoctl.motion.satellite import (
    SEARCH_H,
    Base,
    Real,
    Site,
    directions,
    joints_of,
    next_pass,
    parse_time,
    pass_trajectory,
)
from servoctl.motion.two_lines import TwoLines, choose, is_elements, read_entries
from servoctl.show.text_file import read_text

LINES = (
    "1 25544U 98067A   08264.51782528 -.00002182  00000-0 -11606-4 0  2927",
    "2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537",
)
"""The elements that Wikipedia's article on two-line elements shows."""
AFTER = datetime(2008, 9, 20, 12, 25, 40, tzinfo=timezone.utc)
PLACES = ((52.2, 21.0, 100.0), (-33.9, 18.4, 1500.0), (0.0, -179.9, 0.0))


def read_elements(path: Path, wanted: str = "", when: datetime = AFTER) -> tuple[str, Satrec]:
    """Name and elements of one satellite."""
    chosen = choose(read_entries(path), wanted, when)
    return chosen.name, chosen.satrec()


def with_checksum(line: str) -> str:
    return line[:68] + str(compute_checksum(line))


def other(number: str, epoch: str = "08264.51782528") -> tuple[str, str]:
    """The same orbit with another number, or other elements of it."""
    return (
        with_checksum(LINES[0].replace("25544", number).replace("08264.51782528", epoch)),
        with_checksum(LINES[1].replace("25544", number)),
    )


def geostationary(longitude_deg: float) -> tuple[str, str]:
    """Elements of AFTER that stand over this longitude, to a few degrees."""
    one = "1 90001U 08001A   08264.51782528  .00000000  00000-0  00000-0 0    10"
    for anomaly in range(0, 360, 4):
        two = f"2 90001   0.0500 000.0000 0001000 000.0000 {anomaly:03d}.0000  1.00273791    10"
        satellite = Satrec.twoline2rv(with_checksum(one), with_checksum(two))
        seen = directions(satellite, Site(0.0, math.radians(longitude_deg), 0.0), AFTER, np.zeros(1))
        if seen.elevation_rad[0] > math.radians(85):
            return with_checksum(one), with_checksum(two)
    raise AssertionError


def elements(folder: Path, *lines: str, name: str = "ISS (ZARYA)") -> Path:
    path = folder / "iss.tle"
    path.write_text("\n".join([name, *lines]) + "\n")
    return path


@pytest.mark.parametrize("latitude, longitude, height", PLACES)
def test_directions_agree_with_skyfield_within_a_microradian(
    tmp_path: Path, latitude: float, longitude: float, height: float
) -> None:
    name, satellite = read_elements(elements(tmp_path, *LINES))
    scale = load.timescale(builtin=True)  # its own tables: nothing is downloaded
    dut1 = float(scale.from_datetime(AFTER).dut1)
    site = Site(math.radians(latitude), math.radians(longitude), height, dut1)
    found = next_pass(satellite, site, AFTER, math.radians(10))
    time_s: Real = np.linspace(0.0, found.duration_s, 60, dtype=np.float64)
    ours = directions(satellite, site, found.begin, time_s)
    times = scale.from_datetimes([found.begin + timedelta(seconds=float(t)) for t in time_s])
    sky = (EarthSatellite(*LINES, name, scale) - wgs84.latlon(latitude, longitude, height)).at(times)
    elevation, azimuth, distance = sky.altaz()
    turn = np.remainder(azimuth.radians - ours.azimuth_rad + math.pi, 2 * math.pi) - math.pi
    assert np.abs(turn * np.cos(ours.elevation_rad)).max() < 1e-6
    assert np.abs(elevation.radians - ours.elevation_rad).max() < 1e-6
    assert np.abs(distance.km - ours.range_km).max() < 1e-3
    assert elevation.degrees[0] == pytest.approx(10.0, abs=0.01) and elevation.degrees[-1] == pytest.approx(10.0, abs=0.01)
    assert found.highest_rad == pytest.approx(elevation.radians.max(), abs=1e-3)
    without = directions(satellite, Site(site.latitude_rad, site.longitude_rad, height), found.begin, time_s)
    assert np.abs(without.elevation_rad - ours.elevation_rad).max() < 1e-3  # 0.48 s of UT1 - UTC


def test_rates_are_those_of_the_angles_and_joints_turn_in_the_opposite_sense(tmp_path: Path) -> None:
    name, satellite = read_elements(elements(tmp_path, *LINES))
    site = Site(math.radians(52.2), math.radians(21.0), 100.0)
    found = next_pass(satellite, site, AFTER, math.radians(10))
    time_s: Real = np.arange(0.0, 200.0, 0.5, dtype=np.float64)
    seen = directions(satellite, site, found.begin, time_s)
    for angle, rate in (
        (seen.azimuth_rad, seen.azimuth_rate_rad_s), (seen.elevation_rad, seen.elevation_rate_rad_s),
    ):  # fmt: skip
        assert np.gradient(angle, 0.5)[1:-1] == pytest.approx(rate[1:-1], abs=2e-7)
    for turn in (-1, 0, 1):
        joints = pass_trajectory(name, satellite, site, found, Base(math.radians(90.0)), turn)
        north = directions(satellite, site, found.begin, joints.time_s).azimuth_rad
        offset = (math.radians(90.0) - north - joints.angle_rad[0]) / (2 * math.pi)
        assert np.ptp(offset) < 1e-12 and offset[0] == pytest.approx(round(float(offset[0])), abs=1e-9)
        assert joints.angles(0, joints.time_s[:-1] + 0.05) == pytest.approx(
            joints.angle_rad[0][:-1] + 0.05 * joints.rate_rad_s[0][:-1], abs=1e-5
        )


def test_a_tilted_tracker_looks_in_the_same_direction(tmp_path: Path) -> None:
    """Each joint angle, put back through scipy's rotations, is the direction over the ground; the rates are its slope."""
    satellite = Satrec.twoline2rv(*LINES)
    found = next_pass(satellite, SITE, AFTER, TEN)
    time_s: Real = np.arange(0.0, found.duration_s, 0.5, dtype=np.float64)
    seen = directions(satellite, SITE, found.begin, time_s)
    heading, roll, pitch = math.radians(143.0), math.radians(7.0), math.radians(-4.0)
    azimuth, elevation, azimuth_rate, elevation_rate = joints_of(seen, Base(heading, roll, pitch))
    base = Rotation.from_euler("ZYX", [-heading, -pitch, roll])
    for row in range(len(time_s)):
        sight = (base * Rotation.from_euler("ZY", [azimuth[row], -elevation[row]])).apply([1.0, 0.0, 0.0])
        level = math.cos(seen.elevation_rad[row])
        wanted = [
            level * math.cos(seen.azimuth_rad[row]), -level * math.sin(seen.azimuth_rad[row]), math.sin(seen.elevation_rad[row]),
        ]  # fmt: skip
        assert sight == pytest.approx(wanted, abs=1e-12)
    assert np.gradient(azimuth, 0.5)[1:-1] == pytest.approx(azimuth_rate[1:-1], abs=1e-4)
    assert np.gradient(elevation, 0.5)[1:-1] == pytest.approx(elevation_rate[1:-1], abs=1e-4)


@pytest.mark.parametrize("lines, words", [
    ((LINES[0],), ("iss.tle:2", "line 2")),
    ((LINES[0][:-1] + "8", LINES[1]), ("iss.tle:2", "checksum is 8, expected 7")),
    ((LINES[0], LINES[1][:-3]), ("iss.tle:3", "69 characters", "66")),
    ((LINES[0], LINES[1].replace("25544", "25545")[:-1] + "8"), ("iss.tle:3", "25545 differs from 25544")),
    ((LINES[1],), ("iss.tle:2", "line 1")),
    ((LINES[0] + "7", LINES[1]), ("iss.tle:2", "69 characters", "70")),
    ((LINES[0], LINES[1].replace(".4627", "é4627")), ("iss.tle:3", "ASCII")),
    ((LINES[0][:40], LINES[1]), ("iss.tle:2", "69 characters", "40")),
    ((with_checksum(LINES[0].replace("08264.5178", "08264.51X8")), LINES[1]), ("iss.tle:2", "08264.51X8", "columns 19 to 32")),
    ((with_checksum(LINES[0].replace("-.00002182", " ,00002182")), LINES[1]), ("iss.tle:2", ",00002182' in columns 34 to 43")),
    ((with_checksum(LINES[0].replace(" 00000-0", " 0000O-0")), LINES[1]), ("iss.tle:2", "' 0000O-0' in columns 45 to 52")),
    ((with_checksum(LINES[0].replace("-11606-4", "-11606,4")), LINES[1]), ("iss.tle:2", "'-11606,4' in columns 54 to 61")),
    ((LINES[0], with_checksum(LINES[1].replace("51.6416", "nn.6416"))), ("iss.tle:3", "NN.6416", "columns 9 to 16")),
    ((LINES[0], "ISS", LINES[1]), ("iss.tle:2", "line 2")),
])  # fmt: skip
def test_damaged_elements_are_refused_with_their_line(tmp_path: Path, lines: tuple[str, ...], words: tuple[str, ...]) -> None:
    path = elements(tmp_path, *lines)
    assert is_elements(read_text(path))
    with pytest.raises(InputError) as refused:
        read_elements(path)
    assert all(word in str(refused.value) for word in words), refused.value


def test_a_satellite_that_never_rises_is_refused(tmp_path: Path) -> None:
    _, satellite = read_elements(elements(tmp_path, *LINES))
    with pytest.raises(InputError, match="does not rise above 10°.*it reaches -?[0-9.]+° at most"):
        next_pass(satellite, Site(math.radians(85.0), 0.0, 0.0), AFTER, math.radians(10))


def test_times_are_utc_unless_they_say_otherwise() -> None:
    assert parse_time("2026-11-23T05:00:00Z") == parse_time("2026-11-23T05:00:00") == parse_time("2026-11-23T06:00:00+01:00")
    with pytest.raises(InputError, match="'tomorrow' is not a time"):
        parse_time("tomorrow")
    for text in ("0001-01-01T00:00:00+14:00", "9999-12-31T23:59:59"):
        with pytest.raises(InputError, match="expected a year from 1957 to 2056"):
            parse_time(text)


ONE, TWO = LINES
NAME_24 = "STARLINK-1234 DARK SAT 2"
FORMS: dict[str, tuple[str | bytes, str]] = {
    "3LE": (f"0 ISS (ZARYA)\n{ONE}\n{TWO}\n", "ISS (ZARYA)"),
    "no name line": (f"{ONE}\n{TWO}", "satellite 25544"),
    "an empty name": (f"0\n{ONE}\n{TWO}\n", "satellite 25544"),
    "a name of 24 characters": (f"{NAME_24}\n{ONE}\n{TWO}\n", NAME_24),
    "a name padded to 24 characters": (f"{'ISS (ZARYA)':24}\r\n{ONE}\r\n{TWO}\r\n", "ISS (ZARYA)"),
    "CR LF": (f"ISS\r\n{ONE}\r\n{TWO}\r\n", "ISS"),
    "CR alone": (f"ISS\r{ONE}\r{TWO}\r", "ISS"),
    "blank lines": (f"\n\nISS\n\n  \n{ONE}\n\n\t\n{TWO}\n\n", "ISS"),
    "trailing blanks": (f"ISS  \t\n{ONE}   \n{TWO}\t \n", "ISS"),
    "leading blanks": (f"  ISS\n  {ONE}\n  {TWO}\n", "ISS"),
    "lower case": (f"iss\n{ONE.lower()}\n{TWO.lower()}\n", "iss"),
    "comments": (f"# of today\nISS\n# epoch\n{ONE}\n{TWO}\n", "ISS"),
    "BOM": (f"\ufeffISS\n{ONE}\n{TWO}\n".encode(), "ISS"),
    "BOM without a name": (f"\ufeff{ONE}\n{TWO}\n".encode(), "satellite 25544"),
    "UTF-16": (f"ISS\r\n{ONE}\r\n{TWO}\r\n".encode("utf-16"), "ISS"),
    "Latin-1": (f"CAF\xc9\n{ONE}\n{TWO}\n".encode("latin-1"), "CAF\xc9"),
    "a name that begins with 1": (f"1 KUNS-PF\n{ONE}\n{TWO}\n", "1 KUNS-PF"),
    "a name that begins with 2": (f"2 A SAT\n{ONE}\n{TWO}\n", "2 A SAT"),
    "NUL at the end": (f"ISS\n{ONE}\n{TWO}\n\0", "ISS"),
}  # fmt: skip


@pytest.mark.parametrize("suffix", ["tle", "txt"])
@pytest.mark.parametrize("form", FORMS)
def test_every_form_of_the_file_is_read(tmp_path: Path, form: str, suffix: str) -> None:
    text, expected = FORMS[form]
    path = tmp_path / f"iss.{suffix}"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    assert is_elements(read_text(path))
    name, satellite = read_elements(path)
    assert name == expected and satellite.satnum == 25544 and satellite.inclo == pytest.approx(math.radians(51.6416))


def test_of_several_satellites_the_first_is_taken_or_the_one_that_is_named(tmp_path: Path) -> None:
    path = tmp_path / "all.txt"
    lines = ["ISS (ZARYA)", *LINES, "NOAA 15", *other("25338"), "NOAA 18", *other("28654"), *other("T0001")]
    path.write_text("\r\n\r\n".join(lines), encoding="utf-8")
    entries = read_entries(path)
    assert [entry.name for entry in entries] == ["ISS (ZARYA)", "NOAA 15", "NOAA 18", "satellite T0001"]

    def found(wanted: str) -> TwoLines:
        return choose(entries, wanted, AFTER)

    assert found("").number == "25544"
    assert {found(text).number for text in ("noaa 18", "28654", "028654", " NOAA 18 ", "18")} == {"28654"}
    assert found("t0001").satrec().satnum == 270_001  # alpha-5: T is 27
    for text, words in (("NOAA", "part of several names: NOAA 15, NOAA 18"), ("GOES", "no satellite 'GOES'; it has ISS")):
        with pytest.raises(InputError, match=words):
            found(text)


def test_of_several_elements_of_a_satellite_the_nearest_in_time_are_taken(tmp_path: Path) -> None:
    path = tmp_path / "history.txt"
    old, new = other("25544", "08260.50000000"), other("25544", "08263.50000000")
    path.write_text("\n".join([*old, *new, *LINES]), encoding="utf-8")
    assert [choose(read_entries(path), "", AFTER - timedelta(days=days)).one[20:23] for days in (0, 1, 4)] == ["264", "263", "260"]


def test_damage_elsewhere_in_the_file_does_not_count(tmp_path: Path) -> None:
    path = tmp_path / "all.txt"
    path.write_text("\n".join([*LINES, *other("25338")])[:-1] + "x", encoding="utf-8")
    assert read_elements(path)[0] == "satellite 25544"
    with pytest.raises(InputError, match="all.txt:4: the checksum is X"):
        read_elements(path, "25338")


def test_a_csv_file_has_no_elements(tmp_path: Path) -> None:
    for text in ("time_s,azimuth_deg\n1 ,2\n2 ,3\n", "1 25544U,2\n", "", "0 ISS\n"):
        (tmp_path / "path.csv").write_text(text)
        assert not is_elements(read_text(tmp_path / "path.csv"))


# --- satellites that are above the horizon already --------------------------------------------------------------------

SITE = Site(math.radians(52.2), math.radians(21.0), 100.0)
TEN = math.radians(10)


def test_a_pass_under_way_lasts_until_the_satellite_sets(tmp_path: Path) -> None:
    _, satellite = read_elements(elements(tmp_path, *LINES))
    whole = next_pass(satellite, SITE, AFTER, TEN)
    assert whole.sets and not whole.under_way
    for passed_s in (1.0, 100.0, whole.duration_s - 2.0):
        rest = next_pass(satellite, SITE, whole.begin + timedelta(seconds=passed_s), TEN)
        assert rest.under_way and rest.sets and rest.begin == whole.begin + timedelta(seconds=passed_s)
        assert abs((rest.end - whole.end).total_seconds()) < 0.25
    following = next_pass(satellite, SITE, whole.end + timedelta(seconds=1), TEN)
    assert not following.under_way and following.begin > whole.end


def test_a_satellite_that_does_not_set_is_followed_as_long_as_is_said() -> None:
    satellite = Satrec.twoline2rv(*geostationary(21.0))
    found = next_pass(satellite, SITE, AFTER, TEN, 1234.0)
    assert found.under_way and not found.sets and found.begin == AFTER and found.duration_s == 1234.0
    assert 25 < math.degrees(found.highest_rad) < 35
    with pytest.raises(InputError, match="does not rise"):
        next_pass(Satrec.twoline2rv(*geostationary(-150.0)), SITE, AFTER, TEN)


def test_one_that_rises_and_then_stays_is_followed_from_its_rise() -> None:
    """A drift of 6° per day brings it over the horizon within two days; it sets weeks later."""
    one, two = geostationary(-56.0)
    satellite = Satrec.twoline2rv(one, with_checksum(two.replace(" 1.00273791", " 1.01940000")))
    found = next_pass(satellite, SITE, AFTER, math.radians(-1.0), 600.0)
    assert not found.sets and not found.under_way and timedelta(hours=1) < found.begin - AFTER < timedelta(hours=SEARCH_H)


def test_a_long_pass_has_no_more_rows_than_can_be_checked() -> None:
    satellite = Satrec.twoline2rv(*geostationary(21.0))
    found = next_pass(satellite, SITE, AFTER, TEN, 24 * 3600.0)
    assert len(pass_trajectory("GEO", satellite, SITE, found, Base()).time_s) == 36_000
