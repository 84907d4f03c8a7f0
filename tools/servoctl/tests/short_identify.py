#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`identify` with short test plans: plans a few places for the tracker's azimuth, passes everything else to
IDENTIFY_PROGRAM.

SHORT_PLACES: their angles in rad, as "-0.5 0.4". SHORT_FAULT plans a fault for a test: "too fast" gives an experiment
that exceeds its speed limit, "beyond" one outside the travel, "long" one of minutes. With SHORT_BRIEF a part takes two
seconds, and the values of the fit are made up.
"""

import json
import os
import sys
from pathlib import Path
from typing import Any

ACCELERATION_RAD_S2 = 2.5


def sweep(low_rad_s: float, ratio: float, count: int, dwell_s: float) -> dict[str, float]:
    return {"kind": 1, "low_rad_s": low_rad_s, "speed_ratio": ratio, "count": count, "dwell_s": dwell_s,
            "acceleration_rad_s2": ACCELERATION_RAD_S2, "duration_s": 2 * count * dwell_s + 1}  # fmt: skip


LOOPS = {"kind": 3, "count": 13, "dwell_s": 0.7, "amplitude_rad": 6e-4, "duration_s": 9.1}
CHIRP = {"kind": 4, "count": 1, "dwell_s": 5.0, "low_rad_s": 0.016, "amplitude_nm": 6.0, "low_hz": 1.0, "high_hz": 40.0,
         "acceleration_rad_s2": ACCELERATION_RAD_S2, "duration_s": 10.5}  # fmt: skip
BREAK_AWAY = {"kind": 5, "count": 4, "dwell_s": 1.0, "amplitude_nm": 30.0, "amplitude_rad": 1e-3, "duration_s": 5.0}
FAST = sweep(0.1, 1.45, 4, 0.3)


def experiments(identified: bool) -> list[dict[str, float]]:
    if not identified:
        return [sweep(2e-3, 3.0, 5, 0.4), LOOPS]
    slow = [sweep(7.8e-4, 1.0, 1, 0.77), sweep(1.25e-3, 1.0, 1, 0.48)]
    return [*slow, sweep(2e-3, 1.6, 11, 0.4), FAST, FAST, FAST, LOOPS, CHIRP, BREAK_AWAY]


CHIRPS = CHIRP | {"dwell_s": 8.3, "low_hz": 10.0, "high_hz": 300.0, "duration_s": 17.0}


def plan(arguments: list[str]) -> None:
    identified = "--identified" in arguments
    structure = "--structure" in arguments
    if identified:
        json.loads(Path(arguments[arguments.index("--identified") + 1]).read_text())
    torque_nm = float(arguments[arguments.index("--torque-nm") + 1])
    fastest_rad_s = float(arguments[arguments.index("--fastest-rad-s") + 1])
    fault = os.environ.get("SHORT_FAULT", "")
    angles = [float(word) for word in os.environ.get("SHORT_PLACES", "-0.4 0.3").split()]
    places: list[dict[str, Any]] = [
        {"angle_rad": angle + (10 if fault == "beyond" else 0), "experiments": [CHIRPS] if structure else experiments(identified)}
        for angle in (angles if identified else angles[:1])
    ]
    duration = sum(experiment["duration_s"] for place in places for experiment in place["experiments"]) + 4 * len(
        places
    )
    rate = 0.005 if fault == "too fast" else fastest_rad_s
    data = {"format": "trackservo-programme", "version": 1, "stage": "identification" if identified else "first_look",
            "duration_s": duration, "moving_rad_s": 0.26,
            "limits": {"travel_rad": 1.5, "rate_rad_s": rate, "torque_nm": torque_nm, "duration_s": 600.0},
            "places": places}  # fmt: skip
    if "SHORT_BRIEF" in os.environ:
        places[0]["experiments"] = [sweep(0.02, 2.0, 2, 0.4)]
        del places[1:]
        places[0]["angle_rad"] = float(arguments[arguments.index("--start-rad") + 1])
    if fault == "long":
        places[0]["experiments"] = [LOOPS | {"count": 800, "duration_s": 560.0}]
    if fault == "too fast":  # a torque that overcomes the seal
        places[0]["experiments"] = [{"kind": 2, "count": 1, "dwell_s": 4.0, "amplitude_nm": 30.0, "duration_s": 4.0}]
    Path(arguments[arguments.index("--json") + 1]).write_text(json.dumps(data))


def fit(arguments: list[str]) -> None:
    """A result of the simulated azimuth, made up."""
    assert len(Path(arguments[0]).read_text().splitlines()) > 1000
    sides = {"coulomb": 6.0, "breakaway": 9.0, "stribeck_speed": 5.2e-3, "viscous": 8.0}
    true = {f"{name}_{side}": value for name, value in sides.items() for side in ("positive", "negative")}
    true |= {"stiffness": 30000.0, "damping": 300.0, "inertia": 6.0}
    rows = {
        name: {"value": value, "unit": "", "interval_95": [0.99 * value, 1.01 * value], "paper_method": value, "start": value}
        for name, value in true.items()
    }
    constant = {"term": "1", "value": 0.1, "interval_95": [0.0, 0.2]}
    data = {
        "format": "trackservo-identification", "version": 1, "parameters": rows, "refused": [], "warnings": [],
        "coulomb_mean": rows["coulomb_positive"], "recorded_s": 2.0, "runs": 1, "paper_method_missing": [], "plant": [],
        "position": {"travel_rad": [-1.0, 1.0], "friction_level": [], "load_nm": [constant]},
        "noise": {"step_s": 1e-3, "residual_rms_nm": 0.1, "innovation_nm": 0.1},
        "checks": {
            "damping_ratio": 0.7, "damping_ratio_of_the_paper": 0.7, "damping_by_eq_15_nm_s_rad": 300.0, "delay_s": 1e-3,
            "converged": True, "gyro": {"used": False, "scale_error": 0.0, "delay_s": 0.0},
        },
    }  # fmt: skip
    Path(arguments[arguments.index("--json") + 1]).write_text(json.dumps(data))
    if "--residuals" in arguments:
        Path(arguments[arguments.index("--residuals") + 1]).write_text("time_s,residual_nm,whitened\n")


def design(arguments: list[str]) -> None:
    """Gains of the speed loop, and the object SHORT_ALSO, times SHORT_FACTOR, with the margins SHORT_MARGINS, in dB and
    degrees."""
    parameters = json.loads(Path(arguments[arguments.index("--parameters") + 1]).read_text())
    json.loads(Path(arguments[arguments.index("--identified") + 1]).read_text())
    json.loads(Path(arguments[arguments.index("--wishes") + 1]).read_text())
    factor = float(os.environ.get("SHORT_FACTOR", "0.9"))
    gain_margin_db, phase_margin_deg = (float(word) for word in os.environ.get("SHORT_MARGINS", "13 50").split())
    places = ["0x2000:1", "0x2000:2", *os.environ.get("SHORT_ALSO", "").split()]
    rows = [
        {"index": place.split(":")[0], "sub": int(place.split(":")[1]), "name": "", "unit": "", "before": parameters[place],
         "value": factor * parameters[place]} for place in places
    ]  # fmt: skip
    frequency = [1.0, 10.0, 100.0]
    data = {"format": "trackservo-design", "version": 1, "parameters": rows, "notes": ["made up by a test"],
            "predicted": {"gain_margin_db": gain_margin_db, "phase_margin_deg": phase_margin_deg, "crossover_hz": 50.0,
                          "bandwidth_hz": 30.0, "torque_noise_nm": 0.1},
            "loop_gain": {"frequency_hz": frequency, "real": [0.0] * 3,
                          "imag": [-50.0 / f for f in frequency]}}  # fmt: skip
    Path(arguments[arguments.index("--json") + 1]).write_text(json.dumps(data))


if __name__ == "__main__":
    if sys.argv[1:2] == ["plan"]:
        plan(sys.argv[2:])
    elif sys.argv[1:2] == ["fit"] and "SHORT_BRIEF" in os.environ:
        fit(sys.argv[2:])
    elif sys.argv[1:2] == ["design"] and "SHORT_REAL_DESIGN" not in os.environ:
        design(sys.argv[2:])
    else:
        program = os.environ["IDENTIFY_PROGRAM"]
        os.execv(program, [program, *sys.argv[1:]])
