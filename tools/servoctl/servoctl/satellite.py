"""The pass of a satellite over a site, from two-line elements: directions of the line of sight and joint angles.

sgp4 gives position and velocity in the frame of the elements (TEME). Sidereal time turns them into the Earth's frame;
polar motion (0.3") is neglected. UT1 − UTC (below 0.9 s; the site moves by up to 420 m in that time) is 0 unless given.
Both are less than the error of any elements (about 1 km). The site is on the WGS 84 ellipsoid. The direction is the geometric one: no refraction, no light time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sgp4.api import SGP4_ERRORS, Satrec, SatrecArray, jday
from sgp4.io import compute_checksum

from .errors import InputError
from .trajectory import MAX_BYTES, Trajectory
from .units import degrees

Real = NDArray[np.float64]

EARTH_RADIUS_KM = 6378.137
FLATTENING = 1.0 / 298.257223563
EARTH_RATE_RAD_S = 7.292115146706979e-5
ROW_S = 0.1
SEARCH_STEP_S = 20.0
SEARCH_H = 48.0
FIRST_YEAR, LAST_YEAR = 1957, 2056
"""What the two digits of the year in the elements can mean."""
_LINE_LENGTH = 69


@dataclass(frozen=True)
class Site:
    """Geodetic latitude and longitude (east), rad, and height above the ellipsoid, m; UT1 − UTC there and then."""

    latitude_rad: float
    longitude_rad: float
    height_m: float
    ut1_minus_utc_s: float = 0.0


@dataclass(frozen=True)
class Directions:
    """Azimuth clockwise from north (continuous), elevation (rad), their rates, and the distance (km)."""

    azimuth_rad: Real
    elevation_rad: Real
    azimuth_rate_rad_s: Real
    elevation_rate_rad_s: Real
    range_km: Real


def is_elements(path: Path) -> bool:
    """A file with two-line elements, and not a CSV."""
    try:
        if not path.is_file() or path.stat().st_size > MAX_BYTES:
            return False
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError):
        return False
    return any(line.startswith("1 ") and len(line.rstrip()) >= 60 for line in lines) or path.suffix.lower() == ".tle"


def read_elements(path: Path) -> tuple[str, Satrec]:
    """Name and elements of the one satellite in the file; raises InputError with file and line."""
    lines = [(n, line.rstrip()) for n, line in enumerate(path.read_text(encoding="utf-8-sig").splitlines(), 1) if line.strip()]
    firsts = [i for i, (_, line) in enumerate(lines) if line.startswith("1 ")]
    if not firsts:
        raise InputError(f"{path}:1: no line of elements begins with '1 '; expected a name, line 1 and line 2.")
    if len(firsts) > 1:
        raise InputError(f"{path}:{lines[firsts[1]][0]}: a second satellite begins here; give a file with one.")
    first = firsts[0]
    if first + 1 >= len(lines) or not lines[first + 1][1].startswith("2 "):
        raise InputError(f"{path}:{lines[first][0]}: line 2 of the elements must follow, which begins with '2 '.")
    for number, line in lines[first : first + 2]:
        if len(line) != _LINE_LENGTH:
            raise InputError(f"{path}:{number}: a line of elements has {_LINE_LENGTH} characters, this one has {len(line)}.")
        if str(compute_checksum(line)) != line[-1]:
            raise InputError(f"{path}:{number}: the checksum is {line[-1]}, expected {compute_checksum(line)}: the line is damaged.")
    one, two = lines[first][1], lines[first + 1][1]
    if one[2:7] != two[2:7]:
        raise InputError(f"{path}:{lines[first + 1][0]}: satellite {two[2:7]} differs from {one[2:7]} in line 1.")
    try:
        elements = Satrec.twoline2rv(one, two)
    except ValueError as error:
        raise InputError(f"{path}:{lines[first][0]}: {error}.") from error
    name = lines[first - 1][1].removeprefix("0 ").strip() if first else f"satellite {one[2:7].strip()}"
    return name, elements


def _sidereal_rad(julian: Real, fraction: Real) -> Real:
    """Greenwich mean sidereal time of 1982, of which TEME is defined."""
    centuries = ((julian - 2451545.0) + fraction) / 36525.0
    seconds = (
        67310.54841 + (876600.0 * 3600.0 + 8640184.812866) * centuries + 0.093104 * centuries**2 - 6.2e-6 * centuries**3
    )
    return np.asarray(np.remainder(seconds / 240.0, 360.0) * (math.pi / 180.0))


def _site_km(site: Site) -> tuple[Real, Real]:
    """Its place in the Earth's frame, and the matrix to east, north, up."""
    sin_lat, cos_lat = math.sin(site.latitude_rad), math.cos(site.latitude_rad)
    sin_lon, cos_lon = math.sin(site.longitude_rad), math.cos(site.longitude_rad)
    squared = FLATTENING * (2.0 - FLATTENING)
    normal_km = EARTH_RADIUS_KM / math.sqrt(1.0 - squared * sin_lat**2)
    height_km = 1e-3 * site.height_m
    ground_km = (normal_km + height_km) * cos_lat
    place = np.array([ground_km * cos_lon, ground_km * sin_lon, (normal_km * (1.0 - squared) + height_km) * sin_lat])
    local = np.array([
        [-sin_lon, cos_lon, 0.0],
        [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat],
        [cos_lat * cos_lon, cos_lat * sin_lon, sin_lat],
    ])  # fmt: skip
    return place, local


def directions(elements: Satrec, site: Site, begin: datetime, time_s: Real) -> Directions:
    """Of the satellite at these times after `begin`; raises InputError when the elements do not reach so far."""
    whole, part = jday(begin.year, begin.month, begin.day, begin.hour, begin.minute, begin.second + 1e-6 * begin.microsecond)
    julian, fraction = np.full(len(time_s), whole), part + time_s / 86400.0
    errors, position_km, velocity_km_s = (values[0] for values in SatrecArray([elements]).sgp4(julian, fraction))
    if errors.any():
        first = int(np.flatnonzero(errors)[0])
        reason = SGP4_ERRORS.get(int(errors[first]), "unknown error")
        raise InputError(f"the elements give no position {time_s[first]:.0f} s after {begin:%Y-%m-%d %H:%M:%S} UTC: {reason}.")
    angle = _sidereal_rad(julian, fraction + site.ut1_minus_utc_s / 86400.0)
    cosine, sine = np.cos(angle), np.sin(angle)

    def turned(v: Real) -> Real:
        return np.column_stack([cosine * v[:, 0] + sine * v[:, 1], cosine * v[:, 1] - sine * v[:, 0], v[:, 2]])

    place, local = _site_km(site)
    fixed = turned(position_km)
    moving = turned(velocity_km_s) + EARTH_RATE_RAD_S * np.column_stack([fixed[:, 1], -fixed[:, 0], np.zeros(len(fixed))])
    east, north, up = (local @ (fixed - place).T)
    east_s, north_s, up_s = (local @ moving.T)
    ground_squared = east**2 + north**2
    ground = np.sqrt(ground_squared)
    squared = ground_squared + up**2
    ground_s = (east * east_s + north * north_s) / ground
    return Directions(
        np.unwrap(np.arctan2(east, north)), np.arctan2(up, ground), (north * east_s - east * north_s) / ground_squared,
        (ground * up_s - up * ground_s) / squared, np.sqrt(squared),
    )  # fmt: skip


@dataclass(frozen=True)
class Pass:
    """From its rise above an elevation to its descent below it."""

    begin: datetime
    duration_s: float
    highest_rad: float


def next_pass(elements: Satrec, site: Site, after: datetime, lowest_rad: float) -> Pass:
    """The first one that begins after this time and lasts at least `SEARCH_STEP_S`; raises InputError when none does
    within two days."""
    time_s: Real = np.arange(0.0, SEARCH_H * 3600.0, SEARCH_STEP_S, dtype=np.float64)
    above = directions(elements, site, after, time_s).elevation_rad > lowest_rad
    rises = np.flatnonzero(~above[:-1] & above[1:])
    sets = np.flatnonzero(above[:-1] & ~above[1:])
    for rise in rises:
        following = sets[sets > rise]
        if len(following):
            break
    else:
        raise InputError(
            f"the satellite does not rise above {degrees(lowest_rad):g}° within {SEARCH_H:g} h after"
            f" {after:%Y-%m-%d %H:%M:%S} UTC."
        )
    edges = []
    for row in (rise, following[0]):
        fine_s: Real = np.linspace(time_s[row], time_s[row + 1], 201, dtype=np.float64)
        elevation = directions(elements, site, after, fine_s).elevation_rad
        edges.append(float(fine_s[np.argmin(np.abs(elevation - lowest_rad))]))
    inside_s: Real = np.linspace(edges[0], edges[1], 1000, dtype=np.float64)
    inside = directions(elements, site, after, inside_s).elevation_rad
    return Pass(after + timedelta(seconds=edges[0]), edges[1] - edges[0], float(inside.max()))


def pass_trajectory(name: str, elements: Satrec, site: Site, which: Pass, heading_rad: float, turn: float = 0.0) -> Trajectory:
    """Joint angles: azimuth counts counter-clockwise from `heading_rad` (clockwise from north), plus whole turns."""
    rows = max(2, round(which.duration_s / ROW_S) + 1)
    time_s: Real = np.linspace(0.0, which.duration_s, rows, dtype=np.float64)
    seen = directions(elements, site, which.begin, time_s)
    azimuth = heading_rad - seen.azimuth_rad
    azimuth = azimuth - 2 * math.pi * round(float(azimuth[rows // 2]) / (2 * math.pi)) + 2 * math.pi * turn
    places = [f"{name}, {which.begin + timedelta(seconds=float(t)):%H:%M:%S} UTC" for t in time_s]
    return Trajectory(
        time_s, {0: azimuth, 1: seen.elevation_rad}, {0: -seen.azimuth_rate_rad_s, 1: seen.elevation_rate_rad_s}, places
    )


def age_days(elements: Satrec, when: datetime) -> float:
    """How old the elements are then."""
    whole, part = jday(when.year, when.month, when.day, when.hour, when.minute, float(when.second))
    return float(whole - elements.jdsatepoch + part - elements.jdsatepochF)


def parse_time(text: str) -> datetime:
    """ISO 8601; without an offset it is UTC. Raises InputError."""
    try:
        found = datetime.fromisoformat(text.replace("Z", "+00:00"))
    except ValueError:
        raise InputError(f"'{text}' is not a time; expected e.g. 2026-11-23T05:00:00Z.") from None
    if not FIRST_YEAR <= found.year <= LAST_YEAR:
        raise InputError(f"'{text}' is not a time of a satellite; expected a year from {FIRST_YEAR} to {LAST_YEAR}.")
    return found.astimezone(timezone.utc) if found.tzinfo else found.replace(tzinfo=timezone.utc)
