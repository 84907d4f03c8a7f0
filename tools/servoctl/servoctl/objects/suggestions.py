# SPDX-License-Identifier: Apache-2.0
"""Possible meanings of an unknown name: a symbol, a typo, or words of a name or of its help."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence

from .parameter import AXES, Parameter

SYMBOLS: dict[str, tuple[str, ...]] = {
    "kp": ("speed_loop.proportional_gain", "position_loop.gain", "tracking_loop.proportional_gain"),
    "ki": ("speed_loop.integral_gain", "tracking_loop.integral_gain"),
    "kv": ("position_loop.gain",),
    "kt": ("motor.torque_constant",),
    "km": ("motor.torque_constant",),
    "ke": ("motor.back_emf_constant",),
    "r": ("motor.winding_resistance",),
    "l": ("motor.winding_inductance",),
    "j": ("disturbance_observer.inertia", "speed_loop.acceleration_feedforward_inertia"),
    "speed": ("max_profile_velocity", "profile_velocity"),
    "max_speed": ("max_profile_velocity", "protection.over_speed_limit"),
    "stiction": ("friction_feedforward.break_away_torque_positive", "friction_feedforward.break_away_torque_negative"),
    "vob": ("disturbance_observer.bandwidth", "disturbance_observer.on"),
    "dob": ("disturbance_observer.bandwidth", "disturbance_observer.on"),
    "ftc": ("friction_feedforward.gain", "friction_feedforward.model"),
    "sigma0": ("friction_feedforward.bristle_stiffness",),
    "sigma1": ("friction_feedforward.bristle_damping",),
    "sigma2": ("friction_feedforward.viscous_coefficient_positive", "friction_feedforward.viscous_coefficient_negative"),
    "tc": ("friction_feedforward.coulomb_torque_positive", "friction_feedforward.coulomb_torque_negative"),
    "ts": ("friction_feedforward.break_away_torque_positive", "friction_feedforward.break_away_torque_negative"),
    "vs": ("friction_feedforward.stribeck_speed_positive", "friction_feedforward.stribeck_speed_negative"),
}
"""Their names in the literature and in other tools, and the endings of our names, best first."""
MOST = 4
SHORTEST_WORD = 3
MIN_LIKENESS = 0.7
"""Of two texts, by difflib; "stiction" and "protection" are 0.67."""


def suggest(wanted: str, parameters: Sequence[Parameter], axis: str | None = None) -> list[str]:
    """Names for `wanted` (lower case, with underscores), best first; at most MOST, of one axis where one is named."""
    head, dot, rest = wanted.partition(".")
    if head in AXES and dot:
        axis, wanted = head, rest
    usable = [p for p in parameters if axis is None or p.name.startswith(axis + ".")]
    ordered = sorted(usable, key=lambda p: not p.tunable)  # gains before other objects
    words = [word for word in re.split(r"[^a-z0-9]+", wanted) if word]
    reported = max((len(word) for word in words), default=0) >= SHORTEST_WORD
    return (
        _of_symbol(wanted, usable)
        or [p.name for p in ordered if reported and all(word in p.name for word in words)]
        or _of_typo(wanted, usable)
        or [p.name for p in ordered if reported and all(word in f"{p.title} {p.help}".lower() for word in words)]
    )[:MOST]


def _of_symbol(wanted: str, parameters: Sequence[Parameter]) -> list[str]:
    group, _, symbol = wanted.rpartition(".")
    endings = SYMBOLS.get(symbol, ())
    narrowed = [ending for ending in endings if group in ending]
    return [p.name for ending in narrowed or endings for p in parameters if p.name.endswith("." + ending)]


def _of_typo(wanted: str, parameters: Sequence[Parameter]) -> list[str]:
    """Close to a name, to one without its axis, or to the last part of one."""
    by_part: dict[str, list[str]] = {}
    for p in parameters:
        for part in (p.name, p.name.split(".", 1)[-1], p.name.rsplit(".", 1)[-1]):
            by_part.setdefault(part, []).append(p.name)
    close = difflib.get_close_matches(wanted, by_part, n=3, cutoff=MIN_LIKENESS)
    return list(dict.fromkeys(name for part in close for name in by_part[part]))[:3]

