# SPDX-License-Identifier: Apache-2.0
"""`sim_host run` prints its assumptions, and a meaningless run has its own exit code."""

import os
import pathlib
import re
import subprocess

import pytest

PROJECT = pathlib.Path(__file__).parents[2]
SIM_HOST = os.environ.get("SIM_HOST", str(PROJECT / "build/host/bin/sim_host"))
SHIPPED = (PROJECT / "sim_host/plants/tracker.toml").read_text()
GOOD, NOT_CONTROLLED, WRONG_INPUT = 0, 1, 2


def run(plant, scenario, *options):
    scenario = PROJECT / "sim_host/scenarios" / f"{scenario}.toml"
    return subprocess.run([SIM_HOST, "run", "--plant", plant, "--scenario", scenario, *options], capture_output=True,
                          text=True, timeout=120)


@pytest.fixture
def plant(tmp_path):
    """A shipped plant, with some texts replaced everywhere."""

    def make(**replaced):
        text = SHIPPED
        for key, (old, new) in replaced.items():
            assert f"{key} = {old}\n" in text
            text = text.replace(f"{key} = {old}\n", f"{key} = {new}\n")
        file = tmp_path / "plant.toml"
        file.write_text(text)
        return file

    return make


@pytest.mark.parametrize("options, says", [
    ([], "assumed friction: every parameter 15 % off, with signs drawn from seed 1; --friction-parameter-error 0: exact"),
    (["--friction-parameter-error", "0"], "assumed friction: the exact parameters of the plant"),
    (["--controller", "pi"], "assumed friction: none (pi does not compensate friction)"),
])
def test_the_first_line_says_which_friction_the_controller_assumes(plant, options, says):
    done = run(plant(), "low_speed_start", *options)
    assert done.returncode == GOOD and done.stdout.splitlines()[0] == says, done


def test_a_machine_that_never_starts_has_not_reached_its_speed(plant):
    done = run(plant(current_limit_a=("16.0", "1.0")), "low_speed_start")
    times = re.findall(r"time_to_90_percent +(.+)", done.stdout)
    assert times == ["not reached"] * 6
    assert done.returncode == NOT_CONTROLLED
    assert all(": azimuth.motor.torque_constant_nm_a: azimuth is not controlled (" in line
               and "the motor gives 2.5 Nm" in line and "current_limit_a = 1)" in line and "give at least" in line
               for line in done.stderr.splitlines() if "azimuth is not" in line), done.stderr


def test_an_inertia_that_is_too_large_is_named_with_the_range_that_works(plant):
    done = run(plant(inertia_kg_m2=("2.5", "1e5")), "low_speed_start")
    assert done.returncode == WRONG_INPUT and done.stdout == ""
    line = SHIPPED.splitlines().index("inertia_kg_m2 = 2.5") + 1
    said = re.search(rf"plant\.toml:{line}: pitch\.inertia_kg_m2: 1e\+05 .* give (\S+) to (\S+), or design\.pitch\.",
                     done.stderr)
    assert said and done.stderr.count("\n") == 1, done.stderr
    for inertia in said.groups():
        assert run(plant(inertia_kg_m2=("2.5", inertia)), "low_speed_start").returncode != WRONG_INPUT
    assert run(plant(inertia_kg_m2=("2.5", str(2 * float(said[2])))), "low_speed_start").returncode == WRONG_INPUT


def test_a_machine_that_is_thrown_about_is_not_controlled(plant):
    """It printed 318 deg/s of error and exit code 0."""
    done = run(plant(inertia_kg_m2=("2.5", "1e-5")), "sine")
    assert done.returncode == NOT_CONTROLLED
    said = [line for line in done.stderr.splitlines() if "warning" not in line]
    assert len(said) == 1 and ": pitch.inertia_kg_m2: pitch is not controlled (it reaches " in said[0], done.stderr
    assert "nan" not in done.stderr


def test_a_target_that_leaves_the_image_is_lost(plant):
    done = run(plant(wind_gust_rms_nm=("3.63", "100.0")), "tracking")
    assert done.returncode == NOT_CONTROLLED
    assert ": azimuth.load.wind_gust_rms_nm: azimuth is not controlled (" in done.stderr and "give at most" in done.stderr


@pytest.mark.parametrize("scenario", ["sine", "step_disturbed", "low_speed_start", "tracking"])
@pytest.mark.parametrize("controller", ["pi", "pi_vob_ftc"])
def test_shipped_runs_are_good(plant, scenario, controller):
    done = run(plant(), scenario, "--controller", controller)
    assert (done.returncode, done.stderr) == (GOOD, "")


@pytest.mark.parametrize("command", ["experiments", "beliefs", "random-plants", "passes", "node-tracking", "faults", "soak", "attack"])
def test_threads_are_one_per_processor_everywhere(command):
    page = subprocess.run([SIM_HOST, command, "--help"], capture_output=True, text=True, check=True).stdout
    processors = min(64, len(os.sched_getaffinity(0)))
    assert re.search(rf"--threads .*={processors}\b", page), page
