"""No option of sim_host or identify that names a file to write replaces one that exists, unless --overwrite asks for it,
and none replaces what the same command reads."""

import subprocess

import pytest
from programs import PROGRAMS, PROJECT, WRONG_INPUT

MINE = "of the user\n"
SCENARIOS = PROJECT / "sim_host/scenarios"
RANGE = "--lowest-rad -1 --highest-rad 1 --torque-nm 100 --fastest-rad-s 1"

# Program and command, with PLANT for an input; the option; for a folder the file in it by which its result is known.
WRITERS = [
    (f"sim_host run --plant PLANT --scenario {SCENARIOS}/sine.toml", "--csv", None),
    ("sim_host identify --plant PLANT", "--out", "azimuth/result.json"),
    ("sim_host identify --plant PLANT", "--out", "pitch/result.json"),
    (f"sim_host serve --plant PLANT --bus slcan-tcp:0 --target {SCENARIOS}/tracking.toml", "--truth", None),
    ("sim_host attack --plant PLANT --seeds 1", "--json", None),
    ("sim_host gains --plant PLANT", "--out", None),
    ("sim_host check --plant PLANT", "--learn", None),
    ("sim_host check --plant PLANT", "--junit", None),
    ("sim_host check --plant PLANT", "--out", "results.json"),
    ("sim_host check --plant PLANT", "--out", "report.html"),
    ("sim_host experiments", "--out", "results.json"),
    ("sim_host beliefs", "--out", "beliefs.json"),
    ("sim_host random-plants --plant PLANT", "--out", "random_plants.json"),
    ("sim_host base-motion --plant PLANT", "--out", "base_motion.json"),
    ("sim_host passes --plant PLANT", "--out", "passes.json"),
    ("sim_host node-tracking --plant PLANT", "--out", "node_tracking.json"),
    (f"identify plan {RANGE} --identified PLANT", "--json", None),
    ("identify fit PLANT", "--json", None),
    ("identify fit PLANT", "--residuals", None),
    ("identify design --identified PLANT --parameters PLANT", "--json", None),
]


def call(command, plant, *more):
    program, *words = command.replace("PLANT", str(plant)).split()
    return subprocess.run([PROGRAMS[program], *words, *map(str, more)], capture_output=True, text=True, timeout=60)


def refused(done, command, *parts):
    assert done.returncode == WRONG_INPUT[command.split()[0]], done
    assert all(part in done.stderr for part in parts) and done.stderr.count("\n") == 1, done.stderr


@pytest.fixture
def plant(tmp_path):
    file = tmp_path / "plant.toml"
    file.write_text((PROJECT / "sim_host/plants/tracker.toml").read_text())
    return file


@pytest.mark.parametrize("command, option, result", WRITERS, ids=lambda value: str(value).replace(" ", "_")[:40])
def test_a_file_that_exists_is_left_alone(plant, tmp_path, command, option, result):
    given = tmp_path / "given"
    file = given / result if result else given
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(MINE)
    refused(call(command, plant, option, given), command, option, str(file), "exists already", "--overwrite")
    assert file.read_text() == MINE


@pytest.mark.parametrize("command, option", [(c, o) for c, o, result in WRITERS if not result and "PLANT" in c])
def test_overwrite_does_not_replace_what_the_command_reads(plant, tmp_path, command, option):
    before = plant.read_text()
    another_name = tmp_path / "another-name"
    another_name.symlink_to(plant)
    for name in (plant, another_name, tmp_path / "." / plant.name):
        refused(call(command, plant, option, name, "--overwrite"), command, option, "reads it")
    assert plant.read_text() == before


def test_each_speed_of_a_run_has_a_file_that_is_left_alone_or_replaced(plant, tmp_path):
    command = f"sim_host run --plant PLANT --scenario {SCENARIOS}/steady_speed.toml --csv"
    csv = tmp_path / "run.csv"
    assert call(command, plant, csv).returncode == 0
    *others, last = sorted(tmp_path.glob("run-*.csv"))
    assert others and not csv.exists()
    written = last.read_text()
    for file in others:
        file.unlink()
    last.write_text(MINE)
    refused(call(command, plant, csv), command, "--csv", str(last), "exists already")
    assert last.read_text() == MINE and not any(file.exists() for file in others)
    assert call(command, plant, csv, "--overwrite").returncode == 0 and last.read_text() == written


def test_two_options_do_not_write_one_file(plant, tmp_path):
    command = "sim_host check --plant PLANT"
    refused(call(command, plant, "--learn", tmp_path / "one", "--junit", tmp_path / "one"), command, "another option writes")


def test_a_device_and_a_pipe_are_written_without_asking(plant):
    done = call(f"identify plan {RANGE}", plant, "--json", "/dev/stdout")
    assert done.returncode == 0 and '"stage": "first_look"' in done.stdout, done
