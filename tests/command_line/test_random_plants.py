# SPDX-License-Identifier: Apache-2.0
"""`sim_host random-plants` in pieces: with identified axes from a file, a log of its plants, and logs of several runs."""

import json
import os
import pathlib
import subprocess
import tomllib
import zlib

import pytest

PROJECT = pathlib.Path(__file__).parents[2]
SIM_HOST = os.environ.get("SIM_HOST", str(PROJECT / "build/host/bin/sim_host"))
TRACKER = PROJECT / "sim_host/plants/tracker.toml"
GOOD, WRONG_INPUT = 0, 2


def random_plants(folder, *options):
    return subprocess.run([SIM_HOST, "random-plants", "--overwrite", "--out", folder / "out", *map(str, options)], capture_output=True,
                          text=True, timeout=300)


def files_in(folder):
    return [(folder / "out" / f"random_plants.{kind}").read_bytes() for kind in ("json", "csv")]


def identified_axis(axis):
    """What `identify fit` finds on an axis of the tracker without noise; the identification itself takes a minute."""
    friction = axis["friction"]
    values = {"inertia": axis["inertia_kg_m2"], "stiffness": friction["stiffness_nm_rad"], "damping": friction["damping_nm_s_rad"]}
    for direction in ("positive", "negative"):
        stribeck = friction[direction]
        values[f"coulomb_{direction}"] = stribeck["coulomb_nm"]
        values[f"breakaway_{direction}"] = stribeck["breakaway_nm"]
        values[f"stribeck_speed_{direction}"] = stribeck["stribeck_speed_deg_s"] / 57.29577951308232
        values[f"viscous_{direction}"] = stribeck["viscous_nm_s_rad"]
    return {
        "format": "trackservo-identification", "version": 1,
        "parameters": {name: {"value": value} for name, value in values.items()},
        "checks": {"delay_s": 7e-5, "encoder_noise_rad": 5e-8, "gyro": {"used": True, "delay_s": 4.7e-4, "noise_rad_s": 7e-5}},
    }


@pytest.fixture
def identified(tmp_path):
    """A file for --identified. The commit is the one that the refusal of another one names."""
    plant = tomllib.loads(TRACKER.read_text())
    file = tmp_path / "identified.json"
    head = {"commit": "other", "plant": "tracker.toml", "plant_checksum": f"{zlib.crc32(TRACKER.read_bytes()):08x}"}
    axes = {axis: identified_axis(plant[axis]) for axis in ("azimuth", "pitch")}

    def write(commit):
        text = {"format": "trackservo-assumed-plant", "version": 1, "generator": {**head, "commit": commit}, **axes}
        file.write_text(json.dumps(text))

    write("other")
    refused = random_plants(tmp_path, "--identified", file)
    assert refused.returncode == WRONG_INPUT
    start = f"sim_host: {file}: was identified with commit other tracker.toml {head['plant_checksum']}, but this program and plant are commit "
    assert refused.stderr.startswith(start), refused.stderr
    write(refused.stderr.removeprefix(start).split()[0])
    return file


def test_shards_from_two_calls_are_merged_to_the_files_of_one(tmp_path, identified):
    one, two = tmp_path / "a.csv", tmp_path / "b.csv"
    for options in (["--seeds", "7-10", "--threads", 2], ["--seeds", "9-10", "--log", two], ["--seed", 7, "--count", 2, "--log", one]):
        done = random_plants(tmp_path, "--identified", identified, *options)
        assert done.returncode == GOOD, done.stderr
        if "--log" not in options:
            whole = files_in(tmp_path)
            assert len(list((tmp_path / "out").iterdir())) == len(whole)
    merged = random_plants(tmp_path, "--merge", two, one, "--seeds", "7-10")
    assert merged.returncode == GOOD, merged.stderr
    assert files_in(tmp_path) == whole
    lines = one.read_text()
    for left in (lines, lines[:-40]):  # all of it, and what a killed process leaves
        one.write_text(left)
        again = random_plants(tmp_path, "--identified", identified, "--seeds", "7-8", "--log", one)
        assert (again.returncode, one.read_text()) == (GOOD, lines)
    missing = random_plants(tmp_path, "--merge", one, "--seeds", "7-10")
    assert (missing.returncode, missing.stderr) == (WRONG_INPUT, f"sim_host: {one}: no line for the seeds 9-10; run them with --seeds and --log\n")


def test_a_data_folder_replaces_the_source_folder(tmp_path, identified):
    data = tmp_path / "data"
    for folder in ("plants", "scenarios", "studies"):
        (data / folder).parent.mkdir(exist_ok=True)
        subprocess.run(["cp", "-r", PROJECT / "sim_host" / folder, data / folder], check=True)
    scenario = next(data.glob("scenarios/steady_speed.toml"))
    scenario.write_text(scenario.read_text() + "# mine\n")
    log = tmp_path / "log.csv"
    assert random_plants(tmp_path, "--identified", identified, "--seeds", 2, "--log", log).returncode == GOOD
    done = random_plants(tmp_path, "--data", data, "--identified", identified, "--seeds", 2)
    assert done.returncode == GOOD, done.stderr
    other = random_plants(tmp_path, "--data", data, "--identified", identified, "--seeds", 2, "--log", log)
    assert other.returncode == WRONG_INPUT and f"{log}:1: is not" in other.stderr


@pytest.mark.parametrize("damage, says", [
    (lambda text: text[:-40], "parse error"),
    (lambda text: text.replace('"pitch": {', '"other": {'), '"pitch" is missing; give another file, or delete this one'),
    (lambda text: text.replace('"value": ', '"number": ', 1), 'azimuth: "parameters/inertia/value" is missing or not a number'),
    (lambda text: "{}", "is not a trackservo-assumed-plant of version 1; give another file"),
    (lambda text: text.replace('"plant_checksum": "', '"plant_checksum": "0'), "but this program and plant are"),
])
def test_a_damaged_file_of_identified_axes_is_refused_in_one_sentence(tmp_path, identified, damage, says):
    identified.write_text(damage(identified.read_text()))
    done = random_plants(tmp_path, "--identified", identified, "--seeds", 2)
    assert done.returncode == WRONG_INPUT
    assert done.stderr.startswith(f"sim_host: {identified}:") and done.stderr.count("\n") == 1 and says in done.stderr


@pytest.mark.parametrize("options", [
    ("--seeds", "7-7"), ("--seeds", "9-7"), ("--seeds", "1-1000001"), ("--seeds", "x"), ("--seeds", "1-5", "--count", "5"),
    ("--merge", "nowhere.csv"), ("--log", "nowhere/log.csv"), ("--identified", "nowhere/identified.json"), ("--data", "nowhere"),
])
def test_wrong_options_are_refused(tmp_path, options):
    assert random_plants(tmp_path, *options).returncode == WRONG_INPUT
