"""Studies beside the campaign, each with a file of its own: value of identification, random plants, and a search for
unpublished numbers that give the paper's Fig. 9.

They are run on demand (the last one by ./tools/demo, too); a folder without them has no table of them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .display import METRIC_TITLES, case_title, number, unit_title
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


def read_fig9_scan(folder: Path) -> dict[str, Any] | None:
    """What `sim_host fig9-scan` wrote into the folder."""
    return _read(folder, "fig9_scan.json", "sim_host fig9-scan")


def fig9_rows(scan: dict[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Head and rows: both readings of Fig. 9, and the set with the largest change."""
    matching, paper = scan["matching"], scan["paper"]
    points, ratio = scan["most_points"], scan["most_ratio"]
    rows = [
        [
            f"difference: +{paper['points']:g} points",
            f"{scan['matching_points']} of {matching}",
            f"{_signed(points['overshoot_percent'] - points['free_overshoot_percent'], 1)} points",
            *_set_words(points),
        ],
        [
            f"ratio: × {paper['ratio']:g} or more",
            f"{scan['matching_ratio']} of {matching}",
            f"× {ratio['overshoot_percent'] / ratio['free_overshoot_percent']:.2f}",
            *_set_words(ratio),
        ],
    ]
    head = ["“the overshoot increases by 25 %” read as", "sets with this result", "largest result", "overshoot without → with friction", "numbers of that set"]
    return head, rows


def _set_words(found: dict[str, Any]) -> list[str]:
    return [
        f"{found['free_overshoot_percent']:.1f} → {found['overshoot_percent']:.1f} %",
        f"Tc {found['coulomb_nm']:.2f}, Ts {found['breakaway_nm']:.2f} Nm, θ̇s {found['stribeck_speed_deg_s']:.2f} °/s, "
        f"ωn {found['natural_frequency_rad_s']:.2f} rad/s, ζ {found['damping']:.2f}, set-point weight "
        f"{found['setpoint_weight']:g}, disturbance as {found['disturbance']}, phase {found['disturbance_phase_deg']:.0f}°",
    ]


def fig9_sentence(scan: dict[str, Any]) -> str:
    """What was scanned."""
    setup, (low, high) = scan["generator"], scan["fig7_deg_s"]
    return (
        f"{setup['samples']:,} random sets (seed {setup['seed']}) of the numbers that the paper does not print, with the published J, σ0, "
        "σ1 and σ2. The unpublished numbers are Tc, Ts, Stribeck speed, PI gains, set-point weight, and the kind and phase of the "
        f"disturbance. {scan['matching']} sets give the ±{low:g} to {high:g} °/s of Fig. 7."
    )


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
