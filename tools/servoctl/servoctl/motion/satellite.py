# SPDX-License-Identifier: Apache-2.0
"""The pass of a satellite over a site, from two-line elements: directions of the line of sight and joint angles.

sgp4 gives position and velocity in the frame of the elements (TEME). Sidereal time turns them into the Earth's frame;
polar motion (0.3") is neglected. UT1 − UTC (below 0.9 s; the site moves by up to 420 m in that time) is 0 unless given.
Both are less than the error of any elements (about 1 km). The site is on the WGS 84 ellipsoid. The direction is the geometric one: no refraction, no light time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone

import numpy as np
from numpy.typing import NDArray
from sgp4.api import SGP4_ERRORS, Satrec, SatrecArray, jday

from ..errors import InputError
from ..units import degrees
from .trajectory import Trajectory

Real = NDArray[np.float64]

EARTH_RADIUS_KM = 6378.137
FLATTENING = 1.0 / 298.257223563
EARTH_RATE_RAD_S = 7.292115146706979e-5
ROW_S = 0.1
MOST_ROWS = 36_000
"""Of a pass: those of more than an hour are slow, and have rows further apart."""
SEARCH_STEP_S = 20.0
RISEN_S = 0.2
"""So long after its rise, which is known to 0.05 s, a satellite is above the elevation."""
SEARCH_H = 48.0
ENDLESS_S = 3600.0
"""A satellite that does not set is followed for so long."""
FIRST_YEAR, LAST_YEAR = 1957, 2056
"""What the two digits of the year in the elements can mean."""


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
    """From its rise above an elevation to its descent below it; `under_way` when it had risen before the time that was asked for,
    and not `sets` when it stays above for `SEARCH_H`: then the duration is not that of the pass."""

    begin: datetime
    duration_s: float
    highest_rad: float
    under_way: bool = False
    sets: bool = True

    @property
    def end(self) -> datetime:
        """When it sets."""
        return self.begin + timedelta(seconds=self.duration_s)


def next_pass(elements: Satrec, site: Site, after: datetime, lowest_rad: float, endless_s: float = ENDLESS_S) -> Pass:
    """The pass that is under way at this time, from then on, otherwise the first one after it.

    Passes of less than `SEARCH_STEP_S` may be missed. One that does not set within two days gets `endless_s`. Raises InputError
    when none begins within two days.
    """
    begin_s = _first(elements, site, after, lowest_rad, above=True)
    if begin_s is None:
        raise InputError(
            f"the satellite does not rise above {degrees(lowest_rad):g}° within {SEARCH_H:g} h after"
            f" {after:%Y-%m-%d %H:%M:%S} UTC: it reaches {degrees(_highest(elements, site, after, 3600.0 * SEARCH_H)):.1f}° at most."
        )
    begin = after + timedelta(seconds=begin_s)
    risen_s = RISEN_S if begin_s else 0.0
    left_s = _first(elements, site, begin + timedelta(seconds=risen_s), lowest_rad, above=False)
    length_s = endless_s if left_s is None else risen_s + left_s
    return Pass(begin, length_s, _highest(elements, site, begin, length_s), begin_s == 0.0, left_s is not None)


def _first(elements: Satrec, site: Site, after: datetime, lowest_rad: float, above: bool) -> float | None:
    """Seconds until the elevation is first above (or not above) this one, to 0.05 s; None if not within two days."""
    time_s: Real = np.arange(0.0, SEARCH_H * 3600.0, SEARCH_STEP_S, dtype=np.float64)
    rows = np.flatnonzero((directions(elements, site, after, time_s).elevation_rad > lowest_rad) == above)
    if not len(rows):
        return None
    if rows[0] == 0:
        return 0.0
    fine_s: Real = np.linspace(time_s[rows[0] - 1], time_s[rows[0]], 201, dtype=np.float64)
    return float(fine_s[np.argmin(np.abs(directions(elements, site, after, fine_s).elevation_rad - lowest_rad))])


def _highest(elements: Satrec, site: Site, begin: datetime, duration_s: float) -> float:
    """Elevation, rad."""
    time_s: Real = np.linspace(0.0, duration_s, 1000, dtype=np.float64)
    return float(directions(elements, site, begin, time_s).elevation_rad.max())


@dataclass(frozen=True)
class Base:
    """How the tracker stands, rad: the direction of joint azimuth 0, clockwise from north; about it the roll, which raises the
    left side; and the pitch, which raises the front."""

    heading_rad: float = 0.0
    roll_rad: float = 0.0
    pitch_rad: float = 0.0

    def matrix(self) -> Real:
        """From its frame (ahead, left, up) to north, west, up: yaw, then pitch, then roll."""
        (sin_h, cos_h), (sin_r, cos_r), (sin_p, cos_p) = (
            (math.sin(angle), math.cos(angle)) for angle in (self.heading_rad, self.roll_rad, self.pitch_rad)
        )
        yaw = np.array([[cos_h, sin_h, 0.0], [-sin_h, cos_h, 0.0], [0.0, 0.0, 1.0]])
        pitch = np.array([[cos_p, 0.0, -sin_p], [0.0, 1.0, 0.0], [sin_p, 0.0, cos_p]])
        roll = np.array([[1.0, 0.0, 0.0], [0.0, cos_r, -sin_r], [0.0, sin_r, cos_r]])
        return np.asarray(yaw @ pitch @ roll)


def joints_of(seen: Directions, base: Base) -> tuple[Real, Real, Real, Real]:
    """Angles of azimuth (continuous) and pitch, then their rates."""
    sin_a, cos_a = np.sin(seen.azimuth_rad), np.cos(seen.azimuth_rad)
    sin_e, cos_e = np.sin(seen.elevation_rad), np.cos(seen.elevation_rad)
    rate_a, rate_e = seen.azimuth_rate_rad_s, seen.elevation_rate_rad_s
    to_base = base.matrix().T
    x, y, z = to_base @ np.array([cos_e * cos_a, -cos_e * sin_a, sin_e])
    x_s, y_s, z_s = to_base @ np.array([
        -rate_e * sin_e * cos_a - rate_a * cos_e * sin_a, rate_e * sin_e * sin_a - rate_a * cos_e * cos_a, rate_e * cos_e,
    ])  # fmt: skip
    level = np.hypot(x, y)
    return np.unwrap(np.arctan2(y, x)), np.arctan2(z, level), (x * y_s - y * x_s) / level**2, z_s / level


def pass_trajectory(name: str, elements: Satrec, site: Site, which: Pass, base: Base, turn: float = 0.0) -> Trajectory:
    """Joint angles: azimuth counts counter-clockwise from the base's heading, plus whole turns."""
    rows = min(max(2, round(which.duration_s / ROW_S) + 1), MOST_ROWS)
    time_s: Real = np.linspace(0.0, which.duration_s, rows, dtype=np.float64)
    azimuth, pitch, azimuth_rate, pitch_rate = joints_of(directions(elements, site, which.begin, time_s), base)
    azimuth = azimuth - 2 * math.pi * round(float(azimuth[rows // 2]) / (2 * math.pi)) + 2 * math.pi * turn
    places = [f"{name}, {which.begin + timedelta(seconds=float(t)):%H:%M:%S} UTC" for t in time_s]
    return Trajectory(time_s, {0: azimuth, 1: pitch}, {0: azimuth_rate, 1: pitch_rate}, places)


def parse_time(text: str) -> datetime:
    """ISO 8601; without an offset it is UTC. Raises InputError."""
    try:
        found = datetime.fromisoformat(text.replace("Z", "+00:00"))
    except ValueError:
        raise InputError(f"'{text}' is not a time; expected e.g. 2026-11-23T05:00:00Z.") from None
    if not FIRST_YEAR <= found.year <= LAST_YEAR:
        raise InputError(f"'{text}' is not a time of a satellite; expected a year from {FIRST_YEAR} to {LAST_YEAR}.")
    return found.astimezone(timezone.utc) if found.tzinfo else found.replace(tzinfo=timezone.utc)
