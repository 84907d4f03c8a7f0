# SPDX-License-Identifier: Apache-2.0
"""The motions of an axis to be identified: plan.json of `identify plan`, checked against the user's limits."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..show.text_file import json_of, read_text
from ..units import degrees
from .recorder import BREAK_AWAY, CHIRP, HYSTERESIS, SPEED_SWEEP, TORQUE_RAMPS

KINDS = {
    SPEED_SWEEP: "speed sweep", TORQUE_RAMPS: "torque ramps", HYSTERESIS: "hysteresis loops", CHIRP: "torque chirp",
    BREAK_AWAY: "break-away",
}  # fmt: skip
FIELDS = {
    "count": 5, "dwell_s": 6, "low_rad_s": 7, "speed_ratio": 8, "acceleration_rad_s2": 9, "amplitude_nm": 10,
    "amplitude_rad": 11, "low_hz": 12, "high_hz": 13,
}  # fmt: skip
"""Sub-indices of 0x2100 by the names that the plan uses."""
LIMIT_FIELDS = {"travel_rad": 14, "rate_rad_s": 15, "torque_nm": 16, "duration_s": 17}
_SLACK = 1.0001
COLUMNS = ("experiment", "times", "at °", "travel ± °", "max °/s", "max N m", "s")
"""Of `rows_of`."""


@dataclass(frozen=True)
class Envelope:
    """Limits for the axis: joint angles, rad, torque, N m, and rate, rad/s."""

    lowest_rad: float
    highest_rad: float
    torque_nm: float
    fastest_rad_s: float


@dataclass(frozen=True)
class Experiment:
    """One run of object 0x2100: its kind, its fields by name, and its approximate duration, s."""

    kind: int
    fields: dict[str, float]
    duration_s: float

    @property
    def name(self) -> str:
        """For people."""
        return KINDS[self.kind]

    @property
    def fastest_rad_s(self) -> float | None:
        """The fastest commanded rate; None where the bristles decide."""
        low = self.fields.get("low_rad_s", 0.0)
        if self.kind == SPEED_SWEEP:
            return float(low * self.fields.get("speed_ratio", 1.0) ** (self.fields.get("count", 1.0) - 1))
        if self.kind == HYSTERESIS:
            return 4.0 * self.fields["amplitude_rad"] / self.fields["dwell_s"]
        return low if self.kind == CHIRP else None

    @property
    def torque_nm(self) -> float | None:
        """The commanded torque; None where the loop decides."""
        return self.fields.get("amplitude_nm") if self.kind in (TORQUE_RAMPS, CHIRP, BREAK_AWAY) else None

    def reach_rad(self, travel_rad: float) -> float:
        """Approximate travel to one side of its start."""
        if self.kind in (HYSTERESIS, BREAK_AWAY):
            return self.fields["amplitude_rad"]
        if self.kind == TORQUE_RAMPS:
            return 0.0
        speed = self.fastest_rad_s or 0.0
        braking = speed**2 / self.fields.get("acceleration_rad_s2", math.inf)
        return min(travel_rad, speed * self.fields.get("dwell_s", 0.0) + braking)


@dataclass(frozen=True)
class Place:
    """A joint angle, rad, and the experiments there."""

    angle_rad: float
    experiments: tuple[Experiment, ...]


@dataclass(frozen=True)
class TestPlan:
    """All places, in order; `limits` are those of 0x2100 for every experiment; between places at `moving_rad_s`."""

    stage: str
    duration_s: float
    moving_rad_s: float
    limits: dict[str, float]
    places: tuple[Place, ...]

    def __iter__(self) -> Iterator[tuple[Place, Experiment]]:
        return ((place, experiment) for place in self.places for experiment in place.experiments)

    @property
    def experiments(self) -> int:
        """Number of experiments."""
        return sum(len(place.experiments) for place in self.places)

    def check(self, envelope: Envelope, source: str) -> None:
        """Raises InputError when the plan exceeds the limits."""
        for what, value, most, unit in (
            ("a move at", self.moving_rad_s, envelope.fastest_rad_s, "rad/s"),
            ("a rate limit of", self.limits["rate_rad_s"], envelope.fastest_rad_s, "rad/s"),
            ("a torque limit of", self.limits["torque_nm"], envelope.torque_nm, "N m"),
        ):
            if not value <= most * _SLACK:
                raise InputError(
                    f"{source}: plans {what} {value:.4g} {unit}, but at most {most:.4g} {unit} is allowed."
                )
        for place in self.places:
            if not envelope.lowest_rad <= place.angle_rad <= envelope.highest_rad:
                raise InputError(
                    f"{source}: plans experiments at {place.angle_rad:.4g} rad, outside {envelope.lowest_rad:.4g}"
                    f" to {envelope.highest_rad:.4g} rad."
                )


def rows_of(test_plan: TestPlan) -> list[tuple[str, ...]]:
    """Motion of each kind of experiment for people: axis, distance, speed, torque, duration; one row per kind."""
    alike: dict[str, list[tuple[Place, Experiment]]] = {}
    for place, experiment in test_plan:
        alike.setdefault(json.dumps([experiment.kind, experiment.fields], sort_keys=True), []).append(
            (place, experiment)
        )
    rows: list[tuple[str, ...]] = []
    for group in alike.values():
        experiment, duration_s = group[0][1], sum(each.duration_s for _, each in group)
        where, extent = _where(group, test_plan), _extent(experiment, test_plan)
        rows.append((experiment.name, str(len(group)), where, *extent, f"{duration_s:.0f}"))
    return rows


def summary_of(test_plan: TestPlan) -> str:
    """One sentence."""
    places = ", ".join(_angle(place.angle_rad) for place in test_plan.places)
    return (
        f"{test_plan.experiments} experiments at {places}°, {test_plan.duration_s:.0f} s; moves between"
        f" these angles at {degrees(test_plan.moving_rad_s):.3g} °/s."
    )


def _where(group: list[tuple[Place, Experiment]], test_plan: TestPlan) -> str:
    """The angles, or that it runs at all places."""
    angles = {place.angle_rad: None for place, _ in group}
    return "all" if len(angles) == len(test_plan.places) else ", ".join(_angle(angle) for angle in angles)


def _angle(angle_rad: float) -> str:
    """In °, without a minus before 0."""
    return f"{round(degrees(angle_rad), 1) + 0.0:.1f}"


def _extent(experiment: Experiment, test_plan: TestPlan) -> tuple[str, str, str]:
    """Path, rate and torque; the limit of the experiment where the set-up has no value."""
    rate, torque = experiment.fastest_rad_s, experiment.torque_nm
    return (
        f"{degrees(experiment.reach_rad(test_plan.limits['travel_rad'])):.3g}",
        f"{degrees(rate if rate is not None else test_plan.limits['rate_rad_s']):.3g}",
        f"{torque if torque is not None else test_plan.limits['torque_nm']:.3g}",
    )


def as_json(test_plan: TestPlan) -> dict[str, Any]:
    """For programs, in ° and s."""
    return {
        "stage": test_plan.stage, "duration_s": test_plan.duration_s, "experiments": test_plan.experiments,
        "places_deg": [degrees(place.angle_rad) for place in test_plan.places],
        "moving_deg_s": degrees(test_plan.moving_rad_s), "limits": test_plan.limits,
    }  # fmt: skip


def read_test_plan(path: Path) -> TestPlan:
    """Raises InputError with the file and its error."""
    data = json_of(read_text(path))
    try:
        if data["format"] != "trackservo-programme" or data["version"] != 1:
            raise ValueError(f"is {data['format']} version {data['version']}, not trackservo-programme version 1")
        test_plan = TestPlan(
            str(data["stage"]), _number(data["duration_s"]), _number(data["moving_rad_s"]),
            {name: _number(data["limits"][name]) for name in LIMIT_FIELDS},
            tuple(_place(row) for row in data["places"]),
        )  # fmt: skip
        if not test_plan.experiments:
            raise ValueError("contains no experiment")
        return test_plan
    except KeyError as error:
        raise InputError(f"{path}: not a test plan of 'identify plan': {error.args[0]} is missing.") from error
    except (ValueError, TypeError) as error:
        raise InputError(f"{path}: not a test plan of 'identify plan': {error}.") from error


def _place(row: dict[str, Any]) -> Place:
    return Place(_number(row["angle_rad"]), tuple(_experiment(experiment) for experiment in row["experiments"]))


def _experiment(row: dict[str, Any]) -> Experiment:
    kind = row["kind"]
    if kind not in KINDS:
        raise ValueError(f"kind {kind} is not one of {', '.join(f'{k} ({name})' for k, name in KINDS.items())}")
    unknown = set(row) - set(FIELDS) - {"kind", "duration_s"}
    if unknown:
        raise ValueError(f"an experiment has the unknown field {sorted(unknown)[0]}")
    return Experiment(kind, {name: _number(row[name]) for name in FIELDS if name in row}, _number(row["duration_s"]))


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{value!r} is not a finite number")
    return float(value)
