# SPDX-License-Identifier: Apache-2.0
"""No option of sim_host or identify that names a file to write replaces one that exists, unless --overwrite asks for it,
and none replaces what the same command reads, named or by default."""

import re
import shutil
import subprocess

import pytest
from programs import PROGRAMS, PROJECT, WRONG_INPUT

MINE = "of the user\n"
SCENARIOS = PROJECT / "sim_host/scenarios"
RANGE = "--lowest-rad -1 --highest-rad 1 --torque-nm 100 --fastest-rad-s 1"

# Program and command, with PLANT for an input; the option; for a folder each file in it, or one of each kind.
WRITERS = [
    (f"sim_host run --plant PLANT --scenario {SCENARIOS}/sine.toml", "--csv", None),
    *(("sim_host identify --plant PLANT", "--out", name) for name in (
        "azimuth/result.json", "azimuth/runs.csv", "azimuth/design.json",
        "pitch/result.json", "pitch/structure.csv", "pitch/residuals.csv")),
    (f"sim_host serve --plant PLANT --bus slcan-tcp:0 --target {SCENARIOS}/tracking.toml", "--truth", None),
    ("sim_host attack --plant PLANT --seeds 1", "--json", None),
    ("sim_host gains --plant PLANT", "--out", None),
    ("sim_host check --plant PLANT", "--learn", None),
    ("sim_host check --plant PLANT", "--junit", None),
    ("sim_host check --plant PLANT", "--out", "results.json"),
    ("sim_host check --plant PLANT", "--out", "report.html"),
    *(("sim_host experiments", "--out", name) for name in (
        "results.json", "runs/sine-seed_1.csv", "runs/sensitivity/sine-1.csv", "margins/tracker-pi-pitch.csv",
        "identification/tracker-pitch/result.json")),
    ("sim_host beliefs", "--out", "beliefs.json"),
    ("sim_host beliefs", "--out", "identification/tracker-azimuth/residuals.csv"),
    ("sim_host random-plants --plant PLANT", "--out", "random_plants.json"),
    ("sim_host random-plants --plant PLANT", "--out", "random_plants.csv"),
    ("sim_host random-plants --plant PLANT", "--out", "identification/tracker-pitch/residuals.csv"),
    ("sim_host base-motion --plant PLANT", "--out", "base_motion.json"),
    ("sim_host node-tracking --plant PLANT", "--out", "node_tracking.json"),
    (f"identify plan {RANGE} --identified PLANT", "--json", None),
    ("identify fit PLANT", "--json", None),
    ("identify fit PLANT", "--residuals", None),
    ("identify design --identified PLANT --parameters PLANT", "--json", None),
]


# Files that are read if they exist, and continued or made.
KEPT = {("sim_host serve", "--flash"), ("sim_host random-plants", "--log"), ("sim_host random-plants", "--identified")}
INPUTS = {
    *((f"sim_host {command}", "--plant") for command in (
        "run", "identify", "random-plants", "base-motion", "node-tracking", "serve", "attack", "faults", "soak", "check", "gains")),
    *((f"sim_host {command}", "--scenario") for command in ("run", "faults", "check")),
    *((f"sim_host {command}", "--data") for command in ("experiments", "identification-value", "random-plants", "bench", "check")),
    ("sim_host random-plants", "--merge"), ("sim_host serve", "--image"), ("sim_host serve", "--target"), ("sim_host check", "--gains"),
    ("sim_host check", "--limits"), ("sim_host check", "--baseline"), ("sim_host check", "--image"),
    ("identify fit", "recording"), ("identify fit", "--structure"), ("identify plan", "--identified"),
    ("identify design", "--identified"), ("identify design", "--requirements"), ("identify design", "--parameters"),
}  # fmt: skip
NO_FILES = {
    ("sim_host random-plants", "--seeds"), ("sim_host attack", "--seeds"), ("sim_host attack", "--replay-sequence"),
    ("sim_host serve", "--bus"), ("sim_host serve", "--speed"), ("sim_host serve", "--video"), ("sim_host faults", "--only"),
}  # fmt: skip


def call(command, plant, *more):
    program, *words = command.replace("PLANT", str(plant)).split()
    return subprocess.run([PROGRAMS[program], *words, *map(str, more)], capture_output=True, text=True, timeout=60)


def refused(done, command, *parts):
    assert done.returncode == WRONG_INPUT, done
    assert all(part in done.stderr for part in parts) and done.stderr.count("\n") == 1, done.stderr


def help_of(*words):
    program, *command = words
    return subprocess.run([PROGRAMS[program], *command, "--help"], capture_output=True, text=True, check=True).stdout


def options_with_a_word():
    """Command and option of each option whose value is any word; a choice of some words names no file."""
    for program in PROGRAMS:
        commands = re.findall(r"^  ([a-z][\w-]*)", help_of(program).partition("Subcommands:")[2], re.MULTILINE)
        assert commands
        for command in commands:
            for option in re.findall(r"^  (\S+) TEXT(?!:\{)", help_of(program, command), re.MULTILINE):
                yield f"{program} {command}", option.split(",")[0]


def test_every_option_that_names_a_file_is_in_a_list_of_this_test():
    written = {(" ".join(command.split()[:2]).replace("beliefs", "identification-value"), option) for command, option, _ in WRITERS}
    assert set(options_with_a_word()) == written | KEPT | INPUTS | NO_FILES


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


def test_the_truth_of_the_second_node_is_left_alone(plant, tmp_path):
    second = tmp_path / "truth.csv.2"
    second.write_text(MINE)
    command = f"sim_host serve --plant PLANT --nodes 2 --target {SCENARIOS}/tracking.toml"
    refused(call(command, plant, "--truth", tmp_path / "truth.csv"), command, "--truth", str(second), "exists already")
    assert second.read_text() == MINE


@pytest.mark.parametrize("command, option", [(c, o) for c, o, result in WRITERS if not result and "PLANT" in c])
def test_overwrite_does_not_replace_what_the_command_reads(plant, tmp_path, command, option):
    before = plant.read_text()
    another_name = tmp_path / "another-name"
    another_name.symlink_to(plant)
    for name in (plant, another_name, tmp_path / "." / plant.name):
        refused(call(command, plant, option, name, "--overwrite"), command, option, "reads it")
    assert plant.read_text() == before


SHIPPED = PROJECT / "sim_host"


@pytest.mark.parametrize("command, option, file", [
    ("sim_host attack --seeds 1", "--json", "plants/tracker.toml"),
    (f"sim_host serve --bus slcan-tcp:0 --until-stdin-ends --target {SCENARIOS}/tracking.toml", "--truth", "plants/tracker.toml"),
    (f"sim_host serve --bus slcan-tcp:0 --until-stdin-ends --target {SCENARIOS}/tracking.toml", "--truth", "scenarios/tracking.toml"),
    ("sim_host check --seeds 1", "--junit", "plants/tracker.toml"),
    ("sim_host check --seeds 1", "--junit", "limits/tracker.toml"),
    ("sim_host check --seeds 1", "--learn", "scenarios/sine.toml"),
])  # fmt: skip
def test_overwrite_does_not_replace_what_the_command_reads_by_default(tmp_path, command, option, file):
    path = SHIPPED / file
    before = path.read_bytes()
    another_name = tmp_path / "another-name"
    another_name.symlink_to(path)
    try:
        for name in (path, another_name):
            refused(call(command, "none", option, name, "--overwrite"), command, option, "reads it")
        assert path.read_bytes() == before
    finally:
        if path.read_bytes() != before:  # else another test, at the same time, would find it empty for a moment
            path.write_bytes(before)


def test_what_is_read_by_default_from_another_data_folder_is_not_replaced(tmp_path):
    for folder in ("plants", "scenarios", "limits"):
        shutil.copytree(SHIPPED / folder, tmp_path / folder)
    command = f"sim_host check --data {tmp_path} --seeds 1"
    file = tmp_path / "plants/tracker.toml"
    refused(call(command, "none", "--junit", file, "--overwrite"), command, "--junit", "reads it")
    assert file.read_bytes() == (SHIPPED / "plants/tracker.toml").read_bytes()


def test_no_option_writes_the_file_that_another_one_continues(plant, tmp_path):
    command = "sim_host random-plants --plant PLANT --count 2"
    log = tmp_path / "random_plants.csv"
    refused(call(command, plant, "--out", tmp_path, "--log", log), command, "another option writes")
    log.write_text(MINE)
    refused(call(command, plant, "--out", tmp_path, "--log", log, "--overwrite"), command, "--out", "reads it")
    assert log.read_text() == MINE


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


def test_the_files_of_the_second_node_are_its_own(tmp_path):
    command = f"sim_host serve --bus slcan-tcp:0 --nodes 2 --target {SCENARIOS}/tracking.toml"
    for truth, flash in ((tmp_path / "a", tmp_path / "a.2"), (tmp_path / "b.2", tmp_path / "b")):
        refused(call(command, "none", "--truth", truth, "--flash", flash), command, "another option writes")
        assert not list(tmp_path.iterdir())


def test_a_device_and_a_pipe_are_written_without_asking(plant):
    done = call(f"identify plan {RANGE}", plant, "--json", "/dev/stdout")
    assert done.returncode == 0 and '"stage": "first_look"' in done.stdout, done
