# SPDX-License-Identifier: Apache-2.0
"""Writes a small invented results folder that follows the contract, for developing and testing the report.

Run as `python make_sample.py DIR`. The numbers are made up; nothing here is a result.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

RATE_HZ = 250.0
SEEDS = [1, 2, 3, 4, 5]
CONTROLLERS = {
    "pi": ("PI", "PI alone, tuned to the speed loop's bandwidth."),
    "pi_vob": ("PI + VOB", "PI with the velocity disturbance observer."),
    "pi_ftc": ("PI + FTC", "PI with LuGre friction feedforward."),
    "pi_vob_ftc": ("PI + VOB + FTC", "PI with observer and LuGre friction feedforward."),
    "pi_coulomb": ("PI + Coulomb", "PI with Coulomb and viscous feedforward, as drives usually have."),
    "pi_best": ("best PI", "PI tuned by an optimiser for this scenario, with the same margins."),
    "least_error": ("least error", "Both, designed for the least rate error in the identified wind."),
}
# Share of PI's error that each controller leaves: (LuGre plant, Maxwell-slip plant).
SHARE = {
    "pi": (1.0, 1.0), "pi_vob": (0.18, 0.19), "pi_ftc": (0.30, 0.62), "pi_vob_ftc": (0.04, 0.09),
    "pi_coulomb": (0.45, 0.55), "pi_best": (0.70, 0.72), "least_error": (0.03, 0.07),
}  # fmt: skip
STEADY = {"0.1": (0.086, 0.016), "0.2": (0.084, 0.015), "0.4": (0.095, 0.018), "1": (0.078, 0.014), "2": (0.082, 0.015)}
STEADY_SHARE = {"pi": 1.0, "pi_vob": 0.112, "pi_ftc": 0.97, "pi_vob_ftc": 0.11, "pi_coulomb": 0.99, "pi_best": 0.72, "least_error": 0.08}
START_MS = {"pi": 172.0, "pi_vob": 61.0, "pi_ftc": 15.0, "pi_vob_ftc": 12.0, "pi_coulomb": 33.0, "pi_best": 118.0, "least_error": 8.0}
MARGINS = {"pi": (12.1, 62.0), "pi_vob": (8.4, 46.0), "pi_ftc": (12.1, 62.0), "pi_vob_ftc": (8.4, 46.0)}


def make_sample(folder: Path) -> Path:
    """Write results.json and every CSV into `folder`; returns it."""
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    (folder / "margins").mkdir(exist_ok=True)
    document = {
        "schema_version": 1,
        "generator": {
            "program": "sim_host experiments", "version": "1.2.3", "git": "abc1234", "seeds": SEEDS, "quick": False,
            "friction_parameter_error": 0.15,
        },
        "plants": [_plant("tracker", "Two-axis tracker", 4.0e4), _plant("paper_simulation", "The paper's simulation", 308.1)],
        "identified": [_identified(folder, "tracker", "azimuth"), _identified(folder, "tracker", "pitch")],
        "controllers": [{"name": n, "title": t, "text": x} for n, (t, x) in CONTROLLERS.items()],
        "rows": _rows(),
        "sensitivity": _sensitivity(),
        "runs": _runs(folder),
        "margins": _margins(folder),
        "benchmark": {"real_time_factor": 812.0, "core_tick_ns": 640.0},
        "requirements": _requirements(),
    }  # fmt: skip
    (folder / "results.json").write_text(json.dumps(document, indent=1), encoding="utf-8")
    (folder / "beliefs.json").write_text(json.dumps(_identification_value()), encoding="utf-8")
    (folder / "random_plants.json").write_text(json.dumps(_random_plants()), encoding="utf-8")
    (folder / "base_motion.json").write_text(json.dumps(_base_motion()), encoding="utf-8")
    (folder / "node_tracking.json").write_text(json.dumps(_node_tracking()), encoding="utf-8")
    return folder


def _identification_value() -> dict[str, Any]:
    estimate = {"mean": 1.0, "standard_error": 0.01}
    figure = {
        "experiment": "sine", "case": "1 deg/s, 0.1 Hz", "metric": "peak_error", "unit": "deg/s",
        "identified": [0.004, 0.006], "exact": [0.004, 0.005], "wrong": [0.005, 0.007],
        "gain": {"mean": -0.167, "standard_error": 0.02},
    }  # fmt: skip
    return {
        "generator": {"program": "sim_host beliefs", "git": "abc1234", "seeds": [1, 2], "friction_parameter_error": 0.15},
        "figures": [figure],
        "sum": {
            "identified": {"mean": 0.833, "standard_error": 0.01}, "exact": estimate, "wrong": estimate,
            "identified_less_wrong": {"mean": -0.167, "standard_error": 0.02}, "identified_less_exact": estimate,
            "worst_identified": 1.0, "worst_exact": 0.9, "worst_wrong": 1.2,
        },
    }  # fmt: skip


def _random_plants() -> dict[str, Any]:
    axis = {
        "above_paper": 3, "unstable": 1, "unstable_at_zenith": 2, "least_gain_margin_db": 7.25, "least_phase_margin_deg": 39.6,
        "most_ripple_share": 0.005,
        "errors": [
            {"case": "0.1 deg/s", "unit": "deg/s", "paper": 0.016, "median": 0.009, "percentile_95": 0.013, "largest": 0.017, "above_paper": 3},
            {"case": "3 deg/s", "unit": "deg/s", "paper": None, "median": 0.010, "percentile_95": 0.014, "largest": 0.018, "above_paper": 0},
        ],
        "influences": [{"key": "azimuth.load.wind_gust_rms_nm", "correlation": -0.5}],
    }  # fmt: skip
    return {
        "generator": {
            "program": "sim_host random-plants", "git": "abc1234", "plant": "tracker", "plants": 1000, "seed": 1,
            "share": 0.3, "numbers": 84,
        },
        "failing": 4,
        "above_paper": 5,
        "azimuth": axis,
        "pitch": axis,
        "worst": [{"seed": 985, "ratio": 1.21, "factors": {"azimuth.load.wind_gust_rms_nm": 1.29}}],
        "without_result": [{"seed": 12, "reason": "the firmware refuses the parameters"}],
    }  # fmt: skip


def _plant(name: str, title: str, stiffness: float) -> dict[str, Any]:
    friction = {
        "stiffness_nm_rad": stiffness, "damping_nm_s_rad": 108.46,
        "positive": {"coulomb_nm": 10.0, "breakaway_nm": 14.0, "stribeck_speed_rad_s": 0.002, "viscous_nm_s_rad": 11.876},
        "negative": {"coulomb_nm": 9.5, "breakaway_nm": 13.4, "stribeck_speed_rad_s": 0.002, "viscous_nm_s_rad": 11.9},
    }  # fmt: skip
    return {
        "name": name, "title": title, "file": f"sim_host/plants/{name}.toml",
        "assumptions": [
            {"topic": "gyro", "text": "0.0002 deg/s/sqrt(Hz), fibre-optic class; a ten times noisier one alone shakes a 30 Hz loop by 0.06 deg/s."},
            {"topic": "wind", "text": "Coloured torque, 0.3 Nm standard deviation, 3 Hz corner; the paper names wind but prints no figure."},
            {"topic": "Coulomb torque", "text": "Table 1 is not in the text; 10 Nm is chosen < break-away 14 Nm & said so."},
        ],
        "friction": {"azimuth": friction, "pitch": friction},
    }  # fmt: skip


IDENTIFIED = {
    "coulomb_positive": ("Nm", 10.0), "breakaway_positive": ("Nm", 14.0), "stribeck_speed_positive": ("rad/s", 0.002),
    "viscous_positive": ("Nm s/rad", 11.876), "coulomb_negative": ("Nm", 9.5), "breakaway_negative": ("Nm", 13.4),
    "stribeck_speed_negative": ("rad/s", 0.002), "viscous_negative": ("Nm s/rad", 11.9), "stiffness": ("Nm/rad", 4.0e4),
    "damping": ("Nm s/rad", 108.46), "inertia": ("kg m2", 6.0),
}  # fmt: skip


def _identified(folder: Path, plant: str, axis: str) -> dict[str, Any]:
    """Every parameter 1 % too large with an interval of 4 %, but the inertia, whose interval misses."""
    place = f"identification/{plant}-{axis}"
    (folder / place).mkdir(parents=True, exist_ok=True)
    turn = axis == "azimuth"
    position = {
        "basis": "turn" if turn else "travel", "travel_rad": [-3.0, 3.0],
        "friction_level": [{"term": "cos(angle)" if turn else "P1(travel)", "value": 0.05}],
    }  # fmt: skip
    (folder / place / "result.json").write_text(json.dumps({"position": position}), encoding="utf-8")
    noise = np.random.default_rng(1).normal(size=2000)
    rows = "\n".join(f"{0.005 * i:.3f},{value:.4f}" for i, value in enumerate(noise))
    (folder / place / "residuals.csv").write_text(f"time_s,whitened\n{rows}\n", encoding="utf-8")
    parameters = [
        {
            "name": name, "unit": unit, "true": true, "identified": 1.01 * true, "low": (1.005 if name == "inertia" else 0.97) * true,
            "high": 1.05 * true, "paper_method": None if name == "damping" else 2.0 * true,
        }
        for name, (unit, true) in IDENTIFIED.items()
    ]  # fmt: skip
    breakaway = {"count": 12, "mean_nm": 13.1, "deviation_nm": 0.4}
    return {
        "plant": plant, "axis": axis, "seed": 1001, "first_look_s": 74.0, "recorded_s": 408.0, "parameters": parameters,
        "breakaway": {"positive": breakaway, "negative": breakaway}, "folder": place,
    }  # fmt: skip


def _seeds(metric: str, value: float | None) -> dict[str, Any]:
    """What the seeds say: 4 % of spread, and twice that of range."""
    return {
        "statistic": "median" if metric == "time_to_90_percent" else "mean", "value": value,
        "spread": None if value is None else round(0.04 * abs(value), 6),
        "low": None if value is None else value - 0.08 * abs(value),
        "high": None if value is None else value + 0.08 * abs(value), "seeds": len(SEEDS),
    }  # fmt: skip


def _row(experiment: str, case: str, plant: str, friction: str, controller: str, metric: str, unit: str,
         value: float | None, paper: tuple[float | None, float | None] = (None, None), goal: str | None = None,
         met: bool | None = None, axis: str = "azimuth", reproduced: bool | None = None) -> dict[str, Any]:  # fmt: skip
    return {
        "experiment": experiment, "case": case, "plant": plant, "friction": friction, "controller": controller,
        "axis": axis, "metric": metric, "unit": unit,
        **_seeds(metric, value),
        "paper_uncompensated": paper[0], "paper_compensated": paper[1], "goal": goal, "met": met,
        "reproduced": reproduced,
    }  # fmt: skip


def _rows() -> list[dict[str, Any]]:
    rows = []
    for friction_index, friction in enumerate(["lugre", "maxwell_slip"]):
        for name in CONTROLLERS:
            judged = friction == "lugre"
            share = SHARE[name][friction_index]
            rows += _sine_and_step_rows(friction, name, share, judged)
            rows += _steady_rows(friction, name, judged)
            rows += _start_rows(friction, name, 1.0 if judged else 1.4, judged)
            rows += _tracking_rows(friction, name, share, judged)
    rows.append(_row("tracking", "paper loop", "tracker", "none", "pi", "tracking_sigma", "urad", 7.9))
    rows.append(_row("tracking", "improved loop", "tracker", "none", "pi", "tracking_sigma", "urad", 3.1))
    return rows


def _goal(name: str, judged: bool, value: float, baseline: tuple[float, float] | None, most: float | None,
          unit_format: str = "{:g}") -> tuple[str | None, bool | None]:  # fmt: skip
    """Goal text and mark: a band for PI, an upper limit for the compensated controller."""
    if judged and name == "pi" and baseline:
        centre, width = baseline
        return f"{centre:g} +- {width:.2g}", abs(value - centre) <= width
    if judged and name in ("pi_vob_ftc", "least_error") and most is not None:
        return "<= " + unit_format.format(most), value <= most
    return None, None


def _requirement(command: str, case: str, axis: str | None, metric: str, unit: str, value: float | None, limit: float) -> dict[str, Any]:
    return {
        "command": command, "git": "abc1234", "plant": "tracker", "case": case, "axis": axis, "metric": metric, "unit": unit,
        "statistic": "largest", "value": value, "low": 0.5, "high": value, "seeds": 5, "goal": f"<= {limit:g}",
        "met": value is not None and value <= limit,
    }  # fmt: skip


def _requirements() -> list[dict[str, Any]]:
    node = "sim_host node-tracking"
    return [
        _requirement(node, "fly-by, predictive loop", "azimuth", "sigma", "urad", 2.22, 2.5),
        _requirement(node, "fly-by, predictive loop", "pitch", "sigma", "urad", 2.75, 3.0),
        _requirement(node, "fly-by, predictive loop", None, "frames_dropped", "1", 0.0, 0.0),
        _requirement(node, "pass at 88 deg, 500 m", None, "time_lost", "s", 4.61, 1.153),
        _requirement(node, "pass at 89 deg, 500 m", None, "time_lost", "s", None, 1.5),
        _requirement("sim_host base-motion", "base turns by 1 deg at 0.3 Hz, pitch 60 deg", "azimuth", "sigma", "urad", 2.1, 14.0),
    ]


def _base_motion() -> dict[str, Any]:
    def tracking(axis: str, sigma: float, met: bool) -> dict[str, Any]:
        runs = [{"seed": seed, "cross_elevation_sigma_urad": sigma - 0.1 * seed, "elevation_sigma_urad": 1.5} for seed in (1, 2)]
        return {"base_axis": axis, "frequency_hz": 0.3, "amplitude_deg": 1.0, "pitch_deg": 60.0, "meets_goal": met, "runs": runs}

    def curve(axis: str, feedback: str, residual: list[float], alone: list[float]) -> dict[str, Any]:
        return {"axis": axis, "feedback": feedback, "amplitude_deg": 0.5, "frequency_hz": [1.0, 5.0], "residual_db": residual, "isolation_db": alone}

    margins = [{"gain_margin_db": gain, "phase_margin_deg": phase} for gain, phase in ((12.1, 49.7), (11.8, 49.2), (6.4, 35.1))]
    return {
        "generator": {"program": "sim_host base-motion", "git": "abc1234", "plant": "tracker", "seeds": [1, 2]},
        "goal": {"sigma_urad": 14.0, "isolation_db": 40.0, "isolation_hz": 1.0, "isolation_deg": 0.5, "gain_margin_db": 6.0, "phase_margin_deg": 40.0},
        "tracking": [tracking("roll", 2.2, True), tracking("yaw", 20.1, False)],
        "isolation": [
            curve(axis, feedback, residual, alone)
            for axis in ("azimuth", "pitch")
            for feedback, residual, alone in (("encoder", [-0.1, -1.1], [-0.1, -1.0]), ("gyro", [59.0, 41.0], [74.5, 50.0]))
        ],
        "margins": [
            {"pitch_deg": 89.0, "seal": "sliding", "meets_goal": True, "computed": margins[0], "measured": margins[1], "gains_fixed": margins[2]}
        ],
    }


def _node_tracking() -> dict[str, Any]:
    def run(seed: int, sigma: float, lost: float | None = 0.0, **more: float) -> dict[str, Any]:
        return {"seed": seed, "azimuth_sigma_urad": sigma, "pitch_sigma_urad": sigma + 0.5, "largest_step_nm": 1.25, "lost_s": lost, "frames_dropped": 0, **more}

    def case(name: str, met: bool, *runs: dict[str, Any], dropout_s: float = 0.0) -> dict[str, Any]:
        return {"name": name, "meets_goal": met, "dropout_s": dropout_s, "runs": list(runs)}

    age = {"azimuth_sigma_with_right_age_urad": 2.0, "pitch_sigma_with_right_age_urad": 2.4}
    return {
        "generator": {"program": "sim_host node-tracking", "git": "abc1234", "plant": "tracker", "seeds": [1, 2]},
        "cases": [
            case("fly-by, predictive loop", True, run(1, 2.1), run(2, 2.2)),
            case("pass at 88 deg, 500 m up", False, run(1, 80.0, 4.61), run(2, 80.0, None)),
            case("fly-by, stated age +10 ms wrong", True, run(1, 2.0, **age), run(2, 2.1, **age)),
            case("fly-by, 1 s without the target", True, run(1, 2.2, 0.1), run(2, 2.3, 0.17), dropout_s=1.0),
        ],
    }


def _sine_and_step_rows(friction: str, name: str, share: float, judged: bool) -> list[dict[str, Any]]:
    value = 0.2513 * share
    plant = "paper_simulation"
    above = 24.3 * share
    alone = judged and name == "pi"
    if alone:
        above = -10.6  # the wrong sign
    return [
        _row("sine", "1 deg/s, 0.1 Hz", plant, friction, name, "peak_error", "deg/s", value, (0.25, 0.02),
             *_goal(name, judged, value, (0.25, 0.01), 0.010), reproduced=True if alone else None),
        _row("sine", "1 deg/s, 0.1 Hz", plant, friction, name, "rms_error", "deg/s", value / 3.7),
        _row("step_disturbed", "1 deg/s, 0.02 deg/s at 2 Hz", plant, friction, name, "overshoot_above_friction_free", "points",
             above, (25.0, None), *_goal(name, judged, above, None, 2.0), reproduced=False if alone else None),
        _row("step_disturbed", "1 deg/s, 0.02 deg/s at 2 Hz", plant, friction, name, "overshoot_over_friction_free", "ratio",
             1.0 + above / 12.0, (1.25, None), reproduced=False if alone else None),
    ]  # fmt: skip


def _steady_rows(friction: str, name: str, judged: bool) -> list[dict[str, Any]]:
    rows = []
    for speed, paper in STEADY.items():
        case, value = f"{speed} deg/s", paper[0] * 1.03 * STEADY_SHARE[name]
        rows.append(_row("steady_speed", case, "tracker", friction, name, "peak_error", "deg/s", value, paper,
                         *_goal(name, judged, value, (paper[0], 0.15 * paper[0]), 0.010)))  # fmt: skip
        rows.append(_row("steady_speed", case, "tracker", friction, name, "torque_noise", "Nm",
                         {"pi": 0.021, "pi_best": 0.034}.get(name, 0.021) * (3.2 if "vob" in name else 1.0)))  # fmt: skip
        if name == "pi_vob_ftc" and judged:
            reduction = 100.0 * (1.0 - STEADY_SHARE[name])
            rows.append(_row("steady_speed", case, "tracker", friction, name, "reduction", "%", reduction,
                             (None, 100.0 * (1 - paper[1] / paper[0])), ">= 83", reduction >= 83))  # fmt: skip
            rows.append(_row("steady_speed", case, "tracker", friction, name, "peak_error", "deg/s", value * 0.9, paper,
                             axis="pitch"))  # fmt: skip
    return rows


def _start_rows(friction: str, name: str, slower: float, judged: bool) -> list[dict[str, Any]]:
    rows = []
    for speed, factor in (("0.1", 1.0), ("0.2", 0.6), ("1", 0.25)):
        first = judged and speed == "0.1"
        value: float | None = START_MS[name] * factor * slower
        goal, met = None, None
        if first and name == "pi":
            goal, met = ">= 100", True
        if first and name == "pi_vob_ftc":
            goal, met = "<= 25", True
        if not judged and speed == "0.1" and name == "pi":
            value = None
        rows.append(_row("low_speed_start", f"{speed} deg/s", "tracker", friction, name, "time_to_90_percent", "ms", value,
                         goal=goal, met=met))  # fmt: skip
        over = {"pi": 34.0, "pi_vob": 16.0, "pi_ftc": 9.0, "pi_vob_ftc": 11.6}.get(name, 18.0) * slower
        goal, met = ("<= 10", over <= 10.0) if first and name == "pi_vob_ftc" else (None, None)
        rows.append(
            _row(
                "low_speed_start",
                f"{speed} deg/s",
                "tracker",
                friction,
                name,
                "overshoot",
                "%",
                over,
                goal=goal,
                met=met,
            )
        )
    return rows


def _tracking_rows(friction: str, name: str, share: float, judged: bool) -> list[dict[str, Any]]:
    rows = []
    for case, base, most, paper in (
        ("paper loop", 54.9, 12.0, (56.44, 14.86)),
        ("improved loop", 31.0, 6.0, (None, None)),
    ):
        value = float(np.hypot(base * share, 8.0 if case == "paper loop" else 3.2))
        band = (56.44, 0.15 * 56.44) if case == "paper loop" else None
        rows.append(_row("tracking", case, "tracker", friction, name, "tracking_sigma", "urad", value, paper,
                         *_goal(name, judged, value, band, most)))  # fmt: skip
    return rows


def _sensitivity() -> list[dict[str, Any]]:
    """A wider weave that misses its goal, and a source switched off."""
    return [
        _varied("weave of the UAV", ("5 m", "8 m"), ("tracking", "paper loop", "tracking_sigma", "urad"),
                "pi_vob_ftc", (9.4, 16.9), ("<= 12", False)),
        _varied("weave of the UAV", ("5 m", "8 m"), ("tracking", "paper loop", "tracking_sigma", "urad"),
                "pi", (54.9, 57.0), ("48 .. 65", True)),
        _varied("jitter of the encoder", ("on", "off"), ("low_speed_start", "0.1 deg/s", "time_to_90_percent", "ms"),
                "pi_vob_ftc", (12.0, 11.0), ("<= 25", True)),
        _varied("jitter of the encoder", ("on", "off"), ("steady_speed", "0.1 deg/s", "rms_error", "deg/s"),
                "pi_vob_ftc", (0.002, 0.001), (None, None)),
    ]  # fmt: skip


def _varied(name: str, setting: tuple[str, str], figure: tuple[str, str, str, str], controller: str,
            values: tuple[float, float], goal: tuple[str | None, bool | None]) -> dict[str, Any]:  # fmt: skip
    experiment, case, metric, unit = figure
    return {
        "variation": name, "kind": "source" if setting[1] == "off" else "choice", "shipped_setting": setting[0], "varied_setting": setting[1], "experiment": experiment,
        "case": case, "plant": "tracker", "controller": controller, "axis": "azimuth", "metric": metric, "unit": unit,
        "shipped": _seeds(metric, values[0]), **_seeds(metric, values[1]), "goal": goal[0], "met": goal[1],
    }  # fmt: skip


def _runs(folder: Path) -> list[dict[str, Any]]:
    runs = []
    frictions = ["lugre", "maxwell_slip"]
    for friction in frictions:
        for name in CONTROLLERS:
            share = SHARE[name][frictions.index(friction)]
            runs.append(
                _run(folder, "sine", "1 deg/s, 0.1 Hz", "paper_simulation", friction, name, "fig11", 5.0, 30.0, share)
            )
            runs.append(
                _run(
                    folder,
                    "step_disturbed",
                    "1 deg/s, 0.02 deg/s at 2 Hz",
                    "paper_simulation",
                    friction,
                    name,
                    "fig9",
                    0.0,
                    8.0,
                    share,
                )
            )
            for speed in ("0.1", "0.2", "1"):
                runs.append(
                    _run(
                        folder, "low_speed_start", f"{speed} deg/s", "tracker", friction, name, "fig14", 0.0, 2.0, share
                    )
                )
            for speed in STEADY:
                runs.append(
                    _run(folder, "steady_speed", f"{speed} deg/s", "tracker", friction, name, None, 3.0, 10.0, share)
                )
            for case in ("paper loop", "improved loop"):
                runs.append(_run(folder, "tracking", case, "tracker", friction, name, "fig16", 4.0, 30.0, share))
    runs.append(
        _run(
            folder,
            "step_disturbed",
            "1 deg/s, 0.02 deg/s at 2 Hz",
            "paper_simulation",
            "none",
            "pi",
            "fig9",
            0.0,
            8.0,
            0.0,
        )
    )
    runs.append(_run(folder, "tracking", "paper loop", "tracker", "none", "pi", "fig16", 4.0, 30.0, 0.0))
    return runs


def _run(folder: Path, experiment: str, case: str, plant: str, friction: str, controller: str, figure: str | None,
         settling: float, duration: float, share: float) -> dict[str, Any]:  # fmt: skip
    plain_case = case.replace(" ", "_").replace("/", "_per_").replace(",", "")
    name = f"runs/{experiment}-{plain_case}-{friction}-{controller}-1.csv"
    time = np.arange(0.0, duration, 1.0 / RATE_HZ)
    random = np.random.default_rng(len(name))
    columns = _signals(experiment, case, controller, share, time, random)
    _write_run(folder / name, time, columns)
    return {
        "experiment": experiment, "case": case, "plant": plant, "friction": friction, "controller": controller,
        "axis": "azimuth", "seed": 1, "csv": name, "figure": figure, "settling_s": settling,
    }  # fmt: skip


def _signals(
    experiment: str, case: str, controller: str, share: float, time: np.ndarray, random: np.random.Generator
) -> dict[str, np.ndarray]:
    degree = np.pi / 180.0
    noise = np.convolve(random.normal(size=time.size), np.ones(5) / 5.0, mode="same")
    speed = degree * (float(case.split()[0]) if case[0].isdigit() else 0.3)
    if experiment == "sine":
        reference = speed * np.sin(2 * np.pi * 0.1 * time)
        since = np.mod(time - 2.5 + 2.5, 5.0)
        error = (
            0.25 * degree * share * np.sign(np.sin(2 * np.pi * 0.1 * time)) * since / 0.35 * np.exp(1 - since / 0.35)
        )
    elif experiment == "tracking":
        reference = speed * np.sin(2 * np.pi * 0.05 * time)
        error = 0.02 * degree * share * noise
    else:
        reference = np.where(time >= 0.5, speed, 0.0)
        lag = max(START_MS[controller], 8.0) * 1e-3 / 2.3 * (1.0 if share else 0.2)
        since = np.clip(time - 0.5, 0.0, None)
        swing = 1.0 + (0.35 * share) * np.exp(-since / 0.8) * np.sin(2 * np.pi * 1.1 * since)
        error = reference - reference * (1 - np.exp(-since / lag)) * swing
        error += 0.03 * degree * max(share, 0.1) * noise
    friction = 12.0 * np.tanh((reference - error) / (0.05 * degree))
    feedforward = 0.93 * 12.0 * np.tanh(reference / (0.02 * degree)) * ("ftc" in controller or "coulomb" in controller)
    estimate = (friction - feedforward) * ("vob" in controller) * 0.97
    track = 1e-6 * (
        np.hypot(54.9 * share, 8.0)
        * np.convolve(random.normal(size=time.size + 124), np.ones(125) / 125**0.5, mode="valid")
    )
    return {
        "reference_rad_s": reference, "rate_rad_s": reference - error, "measured_rate_rad_s": reference - error,
        "joint_rate_rad_s": reference - error, "joint_angle_rad": np.cumsum(reference - error) / RATE_HZ,
        "torque_nm": friction + 0.02 * noise, "friction_nm": friction, "friction_feedforward_nm": feedforward,
        "disturbance_estimate_nm": estimate, "load_nm": 0.1 * noise,
        "tracking_error_rad": track if experiment == "tracking" else np.zeros_like(time),
    }  # fmt: skip


def _write_run(file: Path, time: np.ndarray, columns: dict[str, np.ndarray]) -> None:
    names = ["time_s"] + [f"{axis}_{name}" for axis in ("azimuth", "pitch") for name in columns]
    table = np.column_stack([time, *columns.values(), *columns.values()])
    np.savetxt(file, table, fmt="%.6g", delimiter=",", header=",".join(names), comments="")


def _margins(folder: Path) -> list[dict[str, Any]]:
    entries = []
    for name, (gain, phase) in MARGINS.items():
        for condition in ("sliding", "pre_sliding"):
            for axis in ("azimuth", "pitch"):
                entries.append(_margin(folder, name, axis, condition, gain, phase))
    for study in ("steady_speed on tracker", "tracking on tracker, improved loop"):
        entries.append(_margin(folder, "pi_best", "azimuth", "sliding", 6.6, 40.1, study))
    return entries


def _margin(folder: Path, controller: str, axis: str, condition: str, gain: float, phase: float,
            study: str | None = None) -> dict[str, Any]:  # fmt: skip
    name = f"margins/tracker-{controller}-{(study or 'all').replace(' ', '_')}-{axis}-{condition}.csv"
    frequency = np.logspace(-1, 2.6, 160)
    s = 2j * np.pi * frequency
    crossover = 2 * np.pi * (18.0 if "vob" not in controller else 24.0)
    loop = crossover / s * (1 + 12.0 / s) * np.exp(-s * 0.0025)
    if condition == "pre_sliding":
        loop *= s**2 / (s**2 + 40.0 * s + 60.0**2)
    magnitude, angle = 20 * np.log10(np.abs(loop)), np.degrees(np.unwrap(np.angle(loop)))
    measured = axis == "azimuth" and condition == "sliding"
    with (folder / name).open("w", encoding="utf-8") as stream:
        stream.write("frequency_hz,computed_magnitude_db,computed_phase_deg,measured_magnitude_db,measured_phase_deg\n")
        for index in range(frequency.size):
            shown = f"{magnitude[index] + 0.2:.4f},{angle[index] - 1.0:.4f}" if measured and index % 8 == 0 else ","
            stream.write(f"{frequency[index]:.5g},{magnitude[index]:.4f},{angle[index]:.4f},{shown}\n")
    return {
        "plant": "tracker", "controller": controller, "study": study, "axis": axis, "condition": condition,
        "gain_margin_db": gain,
        "phase_margin_deg": phase, "crossover_hz": crossover / 6.28, "closed_loop_bandwidth_hz": 30.4,
        "measured_gain_margin_db": gain - 0.3 if measured else None,
        "measured_phase_margin_deg": phase - 1.5 if measured else None, "response_csv": name,
    }  # fmt: skip


if __name__ == "__main__":
    print(make_sample(Path(sys.argv[1])))
