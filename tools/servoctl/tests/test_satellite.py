"""The geometry of a pass, judged by Skyfield, which shares the propagator sgp4 and nothing else. No device is needed."""

from __future__ import annotations

import math
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import pytest
from skyfield.api import EarthSatellite, load, wgs84

from servoctl.errors import InputError
from servoctl.satellite import Real, Site, directions, is_elements, next_pass, parse_time, pass_trajectory, read_elements

LINES = (
    "1 25544U 98067A   08264.51782528 -.00002182  00000-0 -11606-4 0  2927",
    "2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537",
)
"""The elements that Wikipedia's article on two-line elements shows."""
AFTER = datetime(2008, 9, 20, 12, 25, 40, tzinfo=timezone.utc)
PLACES = ((52.2, 21.0, 100.0), (-33.9, 18.4, 1500.0), (0.0, -179.9, 0.0))


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
        joints = pass_trajectory(name, satellite, site, found, math.radians(90.0), turn)
        north = directions(satellite, site, found.begin, joints.time_s).azimuth_rad
        offset = (math.radians(90.0) - north - joints.angle_rad[0]) / (2 * math.pi)
        assert np.ptp(offset) < 1e-12 and offset[0] == pytest.approx(round(float(offset[0])), abs=1e-9)
        assert joints.angles(0, joints.time_s[:-1] + 0.05) == pytest.approx(
            joints.angle_rad[0][:-1] + 0.05 * joints.rate_rad_s[0][:-1], abs=1e-5
        )


@pytest.mark.parametrize("lines, words", [
    ((LINES[0],), ("iss.tle:2", "line 2")),
    ((LINES[0][:-1] + "8", LINES[1]), ("iss.tle:2", "checksum is 8, expected 7")),
    ((LINES[0], LINES[1][:-3]), ("iss.tle:3", "69 characters", "66")),
    ((LINES[0], LINES[1].replace("25544", "25545")[:-1] + "8"), ("iss.tle:3", "25545 differs from 25544")),
    ((*LINES, *LINES), ("iss.tle:4", "second satellite")),
])  # fmt: skip
def test_damaged_elements_are_refused_with_their_line(tmp_path: Path, lines: tuple[str, ...], words: tuple[str, ...]) -> None:
    path = elements(tmp_path, *lines)
    assert is_elements(path)
    with pytest.raises(InputError) as refused:
        read_elements(path)
    assert all(word in str(refused.value) for word in words), refused.value


def test_a_satellite_that_never_rises_is_refused(tmp_path: Path) -> None:
    _, satellite = read_elements(elements(tmp_path, *LINES))
    with pytest.raises(InputError, match="does not rise above 10°"):
        next_pass(satellite, Site(math.radians(85.0), 0.0, 0.0), AFTER, math.radians(10))


def test_times_are_utc_unless_they_say_otherwise() -> None:
    assert parse_time("2026-11-23T05:00:00Z") == parse_time("2026-11-23T05:00:00") == parse_time("2026-11-23T06:00:00+01:00")
    with pytest.raises(InputError, match="'tomorrow' is not a time"):
        parse_time("tomorrow")
    for text in ("0001-01-01T00:00:00+14:00", "9999-12-31T23:59:59"):
        with pytest.raises(InputError, match="expected a year from 1957 to 2056"):
            parse_time(text)
