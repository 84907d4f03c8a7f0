# SPDX-License-Identifier: Apache-2.0
"""Studies beside the campaign, each with a file of its own: value of identification, random plants,
a turning base, and tracking in the running node.

They are run on demand (the last two by ./tools/demo --all, too); a folder without them has no table of them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .display import METRIC_TITLES, case_title, number, pretty_units, unit_title
from .experiments import experiment_title
from .load import InputError, read_json


def _read(folder: Path, name: str, command: str) -> dict[str, Any] | None:
    file = folder / name
    if not file.is_file():
        return None
    data = read_json(file)
    program = data.get("generator", {}).get("program") if isinstance(data, dict) else None
    if program != command:
        raise InputError(f"{file}: was not written by '{command}'; run it again.")
    loaded: dict[str, Any] = data
    return loaded


def read_identification_value(folder: Path) -> dict[str, Any] | None:
    """What `sim_host beliefs` wrote into the folder."""
    return _read(folder, "beliefs.json", "sim_host beliefs")


def read_random_plants(folder: Path) -> dict[str, Any] | None:
    """What `sim_host random-plants` wrote into the folder."""
    return _read(folder, "random_plants.json", "sim_host random-plants")


def read_base_motion(folder: Path) -> dict[str, Any] | None:
    """What `sim_host base-motion` wrote into the folder."""
    return _read(folder, "base_motion.json", "sim_host base-motion")


def read_node_tracking(folder: Path) -> dict[str, Any] | None:
    """What `sim_host node-tracking` wrote into the folder."""
    return _read(folder, "node_tracking.json", "sim_host node-tracking")


def _lost(runs: list[dict[str, Any]]) -> str:
    """Time without the target, the worst seed."""
    times = [run["lost_s"] for run in runs]
    if None in times:
        return "not found again"
    return f"{max(times):.2f} s" if max(times) > 0 else "never"


def _both(runs: list[dict[str, Any]], azimuth: str, pitch: str) -> str:
    """Figures of both axes, the worst seed."""
    return " and ".join(f"{max(run[name] for run in runs):.2f}" for name in (azimuth, pitch))


BASE_AXES = ("roll", "pitch", "yaw")


def base_tracking_rows(study: dict[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Head and rows: each motion and pitch, one column for each axis of the base; the worst seed."""
    cells: dict[tuple[float, float], dict[str, str]] = {}
    for item in study["tracking"]:
        worst = _both(item["runs"], "cross_elevation_sigma_urad", "elevation_sigma_urad")
        cells.setdefault((item["pitch_deg"], item["frequency_hz"]), {})[item["base_axis"]] = worst + _mark(item["meets_goal"])
    amplitude = study["tracking"][0]["amplitude_deg"]
    rows = [
        [f"{pitch:g}°", f"{amplitude:g}° at {frequency:g} Hz", *(line.get(axis, "–") for axis in BASE_AXES)]
        for (pitch, frequency), line in cells.items()
    ]
    return ["pitch", "base turns by", *(f"{axis}, µrad" for axis in BASE_AXES)], rows


def isolation_rows(study: dict[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Head and rows: the isolation of the rms angle and, in parentheses, at the base's frequency alone."""
    frequencies = sorted({frequency for curve in study["isolation"] for frequency in curve["frequency_hz"]})
    rows = []
    for curve in study["isolation"]:
        points = dict(zip(curve["frequency_hz"], zip(curve["residual_db"], curve["isolation_db"], strict=True), strict=True))
        cells = (f"{round(points[f][0])} ({round(points[f][1])})".replace("-", "−") if f in points else "–" for f in frequencies)
        rows.append([f"{curve['axis']}, {FEEDBACKS[curve['feedback']]}", f"{curve['amplitude_deg']:g}°", *cells])
    return ["axis, rate from", "base turns by", *(f"{frequency:g} Hz" for frequency in frequencies)], rows


FEEDBACKS = {"encoder": "encoder", "fused": "encoder and gyro", "gyro": "gyro"}
"""Sources of the rate."""


def pitch_margin_rows(study: dict[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Head and rows: the azimuth's margins over the pitch, and those that gains that stay would have."""
    rows = [
        [
            f"{item['pitch_deg']:g}°",
            item["seal"],
            *(
                f"{item['computed'][name]:.1f} / {item['measured'][name]:.1f}"
                for name in ("gain_margin_db", "phase_margin_deg")
            ),
            f"{item['gains_fixed']['gain_margin_db']:.1f} dB, {item['gains_fixed']['phase_margin_deg']:.1f}°",
        ]
        for item in study["margins"]
    ]
    head = ["pitch", "seal", "gain margin, dB (computed / measured)", "phase margin, ° (computed / measured)", "if the gains did not follow"]
    return head, rows


def _mark(met: bool) -> str:
    return " ✓" if met else " ✗"


def node_tracking_rows(study: dict[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Head and rows: each target, the worst seed."""
    rows = []
    for item in study["cases"]:
        runs = item["runs"]
        follows = item["dropout_s"] > 0 or _lost(runs) == "never"  # after a dropout, errors count from 0.5 s after it
        rows.append(
            [
                _printed(item["name"]),
                _both(runs, "azimuth_sigma_urad", "pitch_sigma_urad") if follows else "–",
                _both(runs, *RIGHT_AGE) if RIGHT_AGE[0] in runs[0] else "–",
                _lost(runs),
                f"{max(run['largest_step_nm'] for run in runs):.2f}",
            ]
        )
    return ["target", "1σ, µrad", "with the right age, µrad", "lost", "torque, Nm per tick"], rows


RIGHT_AGE = ("azimuth_sigma_with_right_age_urad", "pitch_sigma_with_right_age_urad")
"""Of the same target, where the stated age of the frames is wrong."""


def _printed(name: str) -> str:
    return pretty_units(name).replace(" deg", "°").replace("m/s2", "m/s²")


def _signed(value: float, digits: int) -> str:
    return f"{value:+.{digits}f}".replace("-", "−")


def _mean_and_range(values: list[float]) -> str:
    return f"{number(sum(values) / len(values))} ({number(min(values))}…{number(max(values))})"


def _identification_value_row(figure: dict[str, Any]) -> list[str]:
    gain = figure["gain"]
    return [
        f"{experiment_title(figure['experiment'])}, {case_title(figure['case'])}: "
        f"{METRIC_TITLES[figure['metric']]}, {unit_title(figure['unit'])}",
        *(_mean_and_range(figure[name]) for name in ("identified", "exact", "wrong")),
        f"{_signed(100 * gain['mean'], 1)} ± {100 * gain['standard_error']:.1f}",
    ]


def identification_value_rows(study: dict[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Head and rows: every figure with identified, exact and wrong friction parameters, and their sum."""
    total = study["sum"]
    share = round(100 * study["generator"]["friction_parameter_error"])
    head = ["figure", "identified", "exact", f"each off by {share} %", "identified minus off, %"]
    rows = [_identification_value_row(figure) for figure in study["figures"]]
    less = total["identified_less_wrong"]
    rows.append(
        [
            "sum of all figures, each divided by its mean with parameters off",
            *(f"{total[name]['mean']:.3f}" for name in ("identified", "exact", "wrong")),
            f"**{_signed(less['mean'], 3)} ± {less['standard_error']:.3f}** (sum)",
        ]
    )
    rows.append(
        ["the same for the worst seeds", *(f"{total[f'worst_{name}']:.2f}" for name in ("identified", "exact", "wrong")), ""]
    )
    return head, rows


def random_plants_rows(tried: dict[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Head and rows: peak errors over all plants beside the paper's, axis by axis."""
    plants = tried["generator"]["plants"]
    rows = [
        [
            f"{axis.capitalize()}, {case_title(error['case'])}",
            *(number(error[name]) for name in ("median", "percentile_95", "largest")),
            number(error["paper"]) if error["paper"] is not None else "–",
            f"{error['above_paper']} of {plants:,}",
        ]
        for axis in ("azimuth", "pitch")
        for error in tried[axis]["errors"]
    ]
    head = ["peak speed error, °/s", "median", "95 % of the plants", "largest", "paper, compensated", "plants above the paper"]
    return head, rows


def stability_rows(tried: dict[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Head and rows: how many plants are not stable, and the smallest margins."""
    plants = tried["generator"]["plants"]
    rows = []
    for axis in ("azimuth", "pitch"):
        found = tried[axis]
        rows.append(
            [
                axis.capitalize(),
                f"{found['unstable']} of {plants:,}",
                f"{found['unstable_at_zenith']} of {plants:,}",
                f"{number(found['least_gain_margin_db'], 2)} dB, {found['least_phase_margin_deg']:.0f}°",
                f"{number(100 * found['most_ripple_share'], 2)} %",
            ]
        )
    head = ["axis", "unstable", "unstable with the cabin at the zenith", "smallest margins", "largest ripple, share of the motor's torque"]
    return head, rows


def worst_rows(tried: dict[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Head and rows: the worst plants of azimuth with the numbers that the error correlates with."""
    keys = [item["key"] for item in tried["azimuth"]["influences"]]
    head = ["seed", "largest error / paper's", *(f"`{key.removeprefix('azimuth.')}`" for key in keys)]
    rows = [
        [str(plant["seed"]), f"{plant['ratio']:.2f}", *(f"{plant['factors'][key]:.2f}" for key in keys)]
        for plant in tried["worst"]
    ]
    strengths = [_signed(item["correlation"], 2) for item in tried["azimuth"]["influences"]]
    rows.append(["all", "correlation with the error", *strengths])
    return head, rows
