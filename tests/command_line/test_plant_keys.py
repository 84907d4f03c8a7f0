# SPDX-License-Identifier: Apache-2.0
"""Every number of a plant file at its minimum and its maximum and at the decades between: the result is a good run, or
one sentence that names the number. SIM_HOST names the program; PLANTS the folder of the shipped plants."""

import math
import os
import pathlib
import re
import subprocess

import pytest

PROJECT = pathlib.Path(__file__).parents[2]
SIM_HOST = os.environ.get("SIM_HOST", str(PROJECT / "build/host/bin/sim_host"))
SHIPPED = (PROJECT / "sim_host/plants/tracker.toml").read_text()
GOOD, NOT_CONTROLLED, WRONG_INPUT = 0, 1, 2
SET_POINT_DEG_S = 2.0
SCENARIO = f"""name = "short"
title = "Half a second of a steady speed"
kind = "speed_step"
duration_s = 1.2
rest_s = 0.2
settle_s = 0.5
axes = ["azimuth", "pitch"]
initial_azimuth_deg = -10.0
initial_pitch_deg = 20.0
speeds_deg_s = [{SET_POINT_DEG_S}]
"""

# Keys without a default, of tables that the shipped plant does not have.
MORE = {"[azimuth.structure]": {"frequency_hz": 90.0, "damping": 0.02, "inertia_share": 0.1},
        "[[base_spectrum]]": {"axis": '"roll"', "rms_deg": 0.01, "low_hz": 0.1, "high_hz": 1.0},
        "[[base_motion]]": {"axis": '"yaw"', "frequency_hz": 0.1, "amplitude_deg": 0.1}}



def tables():
    """Section, key, kind, minimum and maximum of every number, from the program's own page."""
    page = subprocess.run([SIM_HOST, "keys", "plant"], capture_output=True, text=True, check=True).stdout
    section = ""
    for line in page.splitlines():
        if line.startswith("## "):
            section = line[3:].split(",")[0].strip()
        row = re.match(r"\| `(\w+)` \| .+? \| (number|integer) from (\S+) to (\S+)", line)
        if row:
            yield section, row[1], row[2], float(row[3]), float(row[4])


def decades(kind, low, high):
    """Both ends and the powers of ten between, also of the negative side; six decades below the maximum where 0 is
    allowed."""
    found = {low, high}
    for sign in (1.0, -1.0):
        most = high if sign > 0 else -low
        if most <= 0:
            continue
        least = low if low > 0 else most * 1e-6
        exponents = range(math.ceil(math.log10(least) - 1e-9), math.floor(math.log10(most) + 1e-9) + 1)
        found |= {sign * 10.0**exponent for exponent in exponents}
    if low <= 0 <= high:
        found.add(0.0)
    if kind == "integer":
        found = {float(round(value)) for value in found}
    return sorted(value for value in found if low <= value <= high)


def plant_with(section, key, kind, value):
    """The shipped plant with one number changed."""
    text = f"{int(value)}" if kind == "integer" else repr(float(value))
    lines = SHIPPED.splitlines()
    if section == "[maxwell_slip]":
        lines[lines.index('model = "lugre"')] = 'model = "maxwell_slip"'
    if section not in lines:
        table = MORE.get(section, {}) | {key: text}
        return "\n".join([*lines[: lines.index("[design.azimuth]")], section, *(f"{k} = {v}" for k, v in table.items()),
                          *lines[lines.index("[design.azimuth]"):]])
    begin = lines.index(section) + 1
    end = next((i for i in range(begin, len(lines)) if lines[i].startswith("[")), len(lines))
    if key == "speed_loop_natural_frequency_rad_s":  # one of the two
        lines[begin:end] = [line for line in lines[begin:end] if not line.startswith("speed_loop_bandwidth_hz")]
    body = [line for line in lines[begin:end] if not line.startswith(f"{key} =")]
    assert len(body) <= end - begin
    lines[begin:end] = [f"{key} = {text}", *body]
    return "\n".join(lines)


EVERY = {"small": 8}.get(os.environ.get("TESTS_SIZE"), 1)
"""The gate tries every eighth key."""


@pytest.mark.parametrize("section, key, kind, low, high",
                         [pytest.param(*row, id=f"{row[0]}{row[1]}") for row in list(tables())[::EVERY]])
def test_a_number_of_a_plant_file_gives_a_good_run_or_is_named(tmp_path, section, key, kind, low, high):
    scenario = tmp_path / "short.toml"
    scenario.write_text(SCENARIO)
    plant = tmp_path / "plant.toml"
    outcomes = set()
    for value in decades(kind, low, high):
        plant.write_text(plant_with(section, key, kind, value))
        run = subprocess.run([SIM_HOST, "run", "--plant", plant, "--scenario", scenario], capture_output=True, text=True,
                             timeout=60)
        outcomes.add(run.returncode)
        what = f"{section} {key} = {value:g}: exit code {run.returncode}\n{run.stdout}{run.stderr}"
        if run.returncode == GOOD:
            errors = [float(error) for error in re.findall(r"rms_error +(\S+) deg/s", run.stdout)]
            assert len(errors) == 2 and max(errors) < SET_POINT_DEG_S / 2, what
            continue
        assert run.returncode in (NOT_CONTROLLED, WRONG_INPUT), what
        sentences = [line for line in run.stderr.splitlines() if not line.startswith("sim_host: warning:")]
        assert len(sentences) in (1, 2), what  # one for each axis
        assert any(key in sentence for sentence in sentences), what
        assert all(re.search(r"plant\.toml:\d+: ", sentence) and "give " in sentence for sentence in sentences), what
        assert not re.search(r"\bnan\b|\binf\b", run.stdout + run.stderr), what
    assert outcomes
