# SPDX-License-Identifier: Apache-2.0
"""How things are called, coloured and written for readers: names, units, numbers."""

from __future__ import annotations

import math
import re

from .load import Figure

CONTROLLER_TITLES = {
    "pi": "PI",
    "pi_vob": "PI + VOB",
    "pi_ftc": "PI + FTC",
    "pi_vob_ftc": "PI + VOB + FTC",
    "pi_coulomb": "PI + Coulomb FF",
    "pi_best": "best PI",
    "least_error": "least error",
}
"""Short names in the paper's words: VOB is the velocity disturbance observer, FTC the friction compensation."""

CONTROLLER_COLOURS = {
    "pi": "#7c8696",
    "pi_vob": "#3f7fd6",
    "pi_ftc": "#d68a1c",
    "pi_vob_ftc": "#0e9f7b",
    "pi_coulomb": "#9a6bd0",
    "pi_best": "#d4587f",
    "least_error": "#8a9a1f",
}
"""One colour per controller in every figure; each stands out on a light and on a dark page."""

METRIC_TITLES = {
    "peak_error": "peak speed error",
    "rms_error": "rms speed error",
    "time_to_90_percent": "time to 90 %",
    "overshoot": "overshoot",
    "overshoot_above_friction_free": "overshoot above friction-free",
    "overshoot_over_friction_free": "overshoot ÷ friction-free one",
    "tracking_sigma": "tracking error 1σ",
    "torque_noise": "torque noise",
    "reduction": "error removed",
}

FRICTION_TITLES = {"lugre": "LuGre", "maxwell_slip": "Maxwell-slip", "none": "friction-free"}

CONDITION_TITLES = {"sliding": "sliding", "pre_sliding": "pre-sliding"}

UNIT_TITLES = {"deg/s": "°/s", "urad": "µrad", "Nm": "N·m", "deg": "°", "points": "points", "ratio": "ratio"}

PLANT_TITLES = {"tracker": "tracker plant", "paper_simulation": "paper's simulated plant"}
"""The two simulated machines; no figure mixes them."""

HIGHER_IS_BETTER = {"reduction"}

MISSING = "–"


def controller_title(name: str) -> str:
    """Short name of a controller."""
    return CONTROLLER_TITLES.get(name, name)


def controller_colour(name: str) -> str:
    """Colour of a controller, the same in every figure."""
    return CONTROLLER_COLOURS.get(name, "#8a8a5c")


def plant_title(name: str) -> str:
    """Which simulated machine, in words."""
    return PLANT_TITLES.get(name, name)


def unit_title(unit: str) -> str:
    """A unit as it is written in print."""
    return UNIT_TITLES.get(unit, unit)


def case_title(case: str) -> str:
    """A case's name with printed units."""
    return pretty_units(case)


def pretty_units(text: str) -> str:
    """Replace the plain spelling of units and signs in a text by the printed one."""
    text = re.sub(r"\s*\bdeg/s\b", " °/s", text)
    text = re.sub(r"\burad\b", "µrad", text)
    return text.replace(" .. ", "…").replace("<=", "≤").replace(">=", "≥").replace("+/-", "±").replace("+-", "±")


def plain_number(value: float | None) -> str:
    """A number as it was given (the paper's figures keep their own digits)."""
    return MISSING if value is None else f"{value:.4g}".replace("-", "−")


def number(value: float | None, digits: int = 3) -> str:
    """A number with `digits` significant digits, never in exponent form above 1e-6."""
    if value is None or not math.isfinite(value):
        return MISSING
    if value == 0.0:
        return "0"
    rounded = float(f"{value:.{digits - 1}e}")
    places = digits - 1 - math.floor(math.log10(abs(rounded)))
    return f"{rounded:.{min(max(places, 0), 9)}f}".replace("-", "−")


def with_spread(value: float | None, spread: float | None) -> str:
    """A value and its standard deviation over the seeds, e.g. '0.00871 ± 0.0004'."""
    if value is None:
        return MISSING
    return number(value) if not spread else f"{number(value)} ± {number(spread, 1)}"


def over_seeds(figure: Figure) -> str:
    """A mean with its standard deviation, a median with its range, e.g. '17.0 (15.0…22.0)'."""
    if figure.statistic != "median" or figure.low is None or figure.high is None or figure.low == figure.high:
        return with_spread(figure.value, figure.spread)
    return f"{number(figure.value)} ({number(figure.low)}…{number(figure.high)})"


def without_seeds(text: str) -> str:
    """The mean or median alone, of a text of `over_seeds`."""
    return text.split(" ± ")[0].split(" (")[0]


def span(values: list[float], digits: int = 3) -> str:
    """Smallest to largest of some numbers, once when they read the same; `digits` 0 rounds to whole numbers."""
    low, high = (f"{v:.0f}" if digits == 0 else number(v, digits) for v in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def case_order(case: str) -> tuple[float, str]:
    """Sorting key: by the first number in the name, then by the name."""
    found = re.search(r"\d+(\.\d+)?", case)
    return (float(found.group()) if found else math.inf, "" if "paper" in case else case)


def gain(before: float | None, after: float | None) -> str:
    """How much smaller: '29 × smaller', or empty when it cannot be said."""
    if before is None or after is None or after <= 0.0 or before <= 0.0:
        return ""
    factor = before / after
    return f"{factor:.0f} × smaller" if factor >= 9.5 else f"{factor:.1f} × smaller" if factor >= 1.05 else "no gain"
