# SPDX-License-Identifier: Apache-2.0
"""`identify` and `tune` on a simulated axis: their results, and that every end restores the axis.

Identification runs several times faster than real time; tuning needs real time. The test plans are the short ones of
short_identify.py; the fit is the real one.
"""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servoctl.show.number_table import read_columns

from .conftest import BUILD, FAST, SERVERS, Bench, Eventually, Served, Serving, serve

IDENTIFY = Path(os.environ.get("IDENTIFY_PROGRAM", str(BUILD / "bin" / "identify")))
SHORT = Path(__file__).with_name("short_identify.py")
PROGRAMS = {"TRACKSERVO_IDENTIFY": str(SHORT), "IDENTIFY_PROGRAM": str(IDENTIFY)}
BORROWED = (
    *(f"0x180{n}:{sub}" for n in (1, 2, 3) for sub in (1, 2, 3, 5)),
    *(f"0x1A0{n}:{sub}" for n in (1, 2, 3) for sub in (0, 1, 2)),
    *(f"0x1016:{sub}" for sub in (1, 2, 3, 4)), *(f"0x2100:{sub}" for sub in range(4, 18)),
    "0x607D:1", "0x607D:2", "0x6084", "0x60A4:1", "0x60C2:1", "0x6060", "0x6860", "0x6081",
)  # fmt: skip
TRAVEL = ("--travel-deg", "-100", "100")
NO_POSITION_LIMITS = tuple(f"azimuth.software_position_limit.{end}_position_limit=0" for end in ("min", "max"))
GAINS = ("0x2000:1", "0x2000:2")
PLANT_INERTIA = ("0x2056:1", "0x2056:2")
TRUE = {"coulomb": 6.0, "stribeck_speed_positive": 5.2e-3, "stiffness": 30000.0, "inertia": 6.0}

@pytest.fixture
def machine(servo: Bench) -> Bench:
    """servoctl, with short test plans."""
    servo.environment |= PROGRAMS
    return servo


@pytest.fixture
def own_machine(serving: Serving, tmp_path: Path) -> Iterator[tuple[Bench, Served]]:
    """The same at a servo of its own, which has just started, and which others do not need afterwards."""
    with serving(FAST) as served:
        bench = Bench(served.address, tmp_path)
        bench.environment |= PROGRAMS
        yield bench, served


def axis_state(bench: Bench, axis: str = "azimuth") -> dict[str, Any]:
    found: dict[str, Any] = bench.json("state", axis)["axes"][0]
    return found


def values(bench: Bench, names: tuple[str, ...]) -> list[Any]:
    return [row["value"] for row in bench.json("get", *names)]


def as_before(bench: Bench, before: list[Any]) -> bool:
    return values(bench, BORROWED) == before


def wait_for_experiment(bench: Bench, process: subprocess.Popen[str], eventually: Eventually) -> None:
    """Until the device runs one for the process."""
    eventually(lambda: process.poll() is not None or bench.json("get", "0x2100:2")[0]["value"] == 1, 120)
    assert process.poll() is None, process.communicate()


@pytest.mark.image
def test_one_command_finds_the_axis_and_leaves_it_as_it_was(own_machine: tuple[Bench, Served]) -> None:
    machine, served = own_machine
    before, gains = values(machine, BORROWED), machine.json("get")
    done = machine("identify", "--axis", "azimuth", *TRAVEL, "--out", "found", "--yes", "--json")
    assert done.code == 0, done.err
    found = done.data
    assert found["complete"] and found["refused"] == []
    assert found["missing_ticks"] == 0
    for name, true in TRUE.items():
        row = (
            found["parameters"].get(name)
            or json.loads((machine.folder / "found/result.json").read_text())["coulomb_mean"]
        )
        low, high = row["interval_95"]
        assert low <= true <= high, (name, row)
    assert found["parameters"]["inertia"]["value"] == pytest.approx(6.0, rel=0.1)
    assert found["parameters"]["stribeck_speed_positive"]["value"] == pytest.approx(5.2e-3, rel=0.1)
    assert as_before(machine, before) and machine.json("get") == gains
    assert [axis_state(machine, axis)["state"] for axis in ("azimuth", "pitch")] == ["switch on disabled"] * 2

    folder = machine.folder / "found"
    run = read_columns(folder / "runs.csv")
    assert np.max(np.diff(run["time_s"])) < 1.5e-3
    assert set(run["kind"]) == {1.0, 3.0, 4.0, 5.0}
    rate = np.gradient(run["joint_angle_rad"], 1e-3)
    assert np.mean(np.abs(rate - run["joint_rate_rad_s"])) < 0.02 * np.mean(np.abs(rate)) + 1e-4
    assert (folder / "residuals.csv").stat().st_size > 1000
    page = (folder / "report.html").read_text()
    for words in (
        "Stribeck curve",
        "Over the joint angle",
        "Hysteresis loop",
        "Residuals",
        "Break-away",
        "Plant for the check of gains",
        "data:image/png",
    ):
        assert words in page
    assert re.findall(r'(?:src|href)="(?!data:)', page) == []  # opens offline

    # The file is a gains file: its contents can be set, and are the identified values.
    assert machine("diff", "found/azimuth-identified.toml").code == 1
    refused = machine("restore", "found/azimuth-identified.toml")
    assert refused.code == 2 and "identified_plant.inertia" in refused.err and "--unlock" in refused.err
    machine.json("restore", "found/azimuth-identified.toml", "--unlock")
    inertia = found["parameters"]["inertia"]["value"]
    assert values(machine, ("0x2020:2", "0x2000:5", *PLANT_INERTIA)) == [pytest.approx(inertia, rel=1e-5)] * 4
    machine.json("undo", "--unlock")
    assert machine.json("get") == gains


def test_a_dry_run_moves_nothing_and_leaves_no_file(machine: Bench) -> None:
    before = values(machine, BORROWED)
    machine.json("state", "azimuth", "enable")  # otherwise wind would turn it
    here = axis_state(machine)["position_deg"]
    shown = machine("identify", "--axis", "azimuth", *TRAVEL, "--dry-run")
    assert shown.code == 0 and "hysteresis loops" in shown.out and "dry run: nothing was moved" in shown.out
    plan = machine.json("identify", "--axis", "azimuth", *TRAVEL, "--dry-run")
    assert plan["dry_run"] and plan["plan"]["experiments"] == 2
    assert axis_state(machine)["position_deg"] == pytest.approx(here, abs=0.2)
    assert as_before(machine, before)
    machine.json("state", "azimuth", "disable")
    assert not list(machine.folder.glob("identify-*"))


@pytest.mark.image
def test_an_interrupt_ends_the_experiment_and_puts_all_back(machine: Bench, eventually: Eventually) -> None:
    before, gains = values(machine, BORROWED), machine.json("get")
    machine.environment["SHORT_FAULT"] = "long"
    process = machine.start("identify", "--axis", "azimuth", *TRAVEL, "--out", "found", "--yes")
    wait_for_experiment(machine, process, eventually)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130, (out, err)
    assert (
        axis_state(machine)["state"] == "switch on disabled"
        and axis_state(machine, "pitch")["state"] == "switch on disabled"
    )
    assert machine.json("get", "0x2100:2")[0]["value"] == 3  # aborted
    assert as_before(machine, before) and machine.json("get") == gains


def test_an_experiment_that_leaves_its_limits_ends_it_all_in_one_sentence(machine: Bench) -> None:
    before = values(machine, BORROWED)
    machine.environment["SHORT_FAULT"] = "too fast"
    failed = machine("identify", "--axis", "azimuth", *TRAVEL, "--out", "found", "--yes")
    assert failed.code == 6 and "2100:15" in failed.err and failed.err.count("\n") == 1, failed.err
    assert axis_state(machine)["state"] == "switch on disabled"
    assert as_before(machine, before)


def test_a_fault_of_the_axis_ends_it(machine: Bench, eventually: Eventually) -> None:
    before = values(machine, BORROWED)
    machine.environment["SHORT_FAULT"] = "long"
    process = machine.start("identify", "--axis", "azimuth", *TRAVEL, "--out", "found", "--yes")
    wait_for_experiment(machine, process, eventually)
    machine.json("state", "azimuth", "disable")  # by another client
    out, err = process.communicate(timeout=60)
    assert process.returncode == 6 and "azimuth is in" in err, (out, err)
    assert as_before(machine, before)


def test_a_bus_that_goes_away_is_reported_in_one_sentence(own_machine: tuple[Bench, Served], eventually: Eventually) -> None:
    machine, served = own_machine
    machine.environment["SHORT_FAULT"] = "long"
    running = machine.start("identify", "--axis", "azimuth", *TRAVEL, "--out", "found", "--yes")
    wait_for_experiment(machine, running, eventually)
    served.process.kill()
    _, err = running.communicate(timeout=30)
    assert running.returncode == 3 and err.startswith("servoctl: ") and err.count("\n") == 1, err


def test_a_killed_one_is_noticed_and_the_next_one_puts_its_pdos_back(
    own_machine: tuple[Bench, Served], eventually: Eventually
) -> None:
    machine, _ = own_machine
    before = values(machine, BORROWED)
    machine.environment["SHORT_FAULT"] = "long"
    process = machine.start("identify", "--axis", "azimuth", *TRAVEL, "--out", "found", "--yes")
    wait_for_experiment(machine, process, eventually)
    process.kill()
    process.wait()
    eventually(lambda: axis_state(machine)["state"] == "fault" and abs(axis_state(machine)["rate_deg_s"]) < 0.1, 15.0)
    for axis in ("azimuth", "pitch"):
        machine.json("state", axis, "reset")
    machine.environment["SHORT_FAULT"] = "too fast"
    assert machine("identify", "--axis", "azimuth", *TRAVEL, "--out", "found", "--overwrite", "--yes").code == 6
    after = values(machine, BORROWED)
    pdos = 21
    assert after[:pdos] == before[:pdos]


@pytest.mark.parametrize(
    "words, expected",
    [
        (("--travel-deg", "50", "-50"), "lower one first"),
        (("--travel-deg", "-50", "290"), "607D:2"),
        (("--travel-deg", "-50", "nan"), "'nan' is not a finite number"),
        ((*TRAVEL, "--speed-deg-s", "0"), "--speed-deg-s"),
        ((*TRAVEL, "--identify-program", "nowhere"), "nowhere"),
        ((*TRAVEL,), "--yes"),
        (("--travel-deg", "140", "160", "--yes"), "outside 140"),
    ],
)
def test_what_is_missing_or_makes_no_sense_is_reported_in_one_sentence(
    machine: Bench, words: tuple[str, ...], expected: str
) -> None:
    if "140" in words:
        machine.environment["SHORT_PLACES"] = "2.6"
    refused = machine("identify", "--axis", "azimuth", *words, "--out", "found")
    assert refused.code in (2, 6) and expected in refused.err and refused.err.count("\n") == 1, refused


def test_a_plan_beyond_the_travel_is_not_carried_out(machine: Bench) -> None:
    machine.environment["SHORT_FAULT"] = "beyond"
    refused = machine("identify", "--axis", "azimuth", *TRAVEL, "--out", "found", "--yes")
    assert refused.code == 2 and "outside -1.745" in refused.err and refused.err.count("\n") == 1


def test_without_the_program_it_says_how_to_build_it(machine: Bench) -> None:
    import shutil

    from .conftest import PACKAGE

    shutil.copytree(PACKAGE / "servoctl", machine.folder / "lib" / "servoctl")
    machine.environment |= {"PYTHONPATH": str(machine.folder / "lib"), "PATH": "/nowhere"}
    del machine.environment["TRACKSERVO_IDENTIFY"]
    refused = machine("identify", "--axis", "azimuth", *TRAVEL, "--yes")
    assert refused.code == 2 and "cmake --build --preset host --target identify" in refused.err


# --- tune -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def tunable(servo: Bench) -> Bench:
    """In real time, with a result to tune from."""
    (servo.folder / "found").mkdir()
    (servo.folder / "found/result.json").write_text(json.dumps(a_result()))
    servo.environment |= PROGRAMS
    return servo


def a_result() -> dict[str, Any]:
    """As `identify fit` writes it, of the simulated azimuth."""
    sides = {"coulomb": 6.0, "breakaway": 9.0, "stribeck_speed": 5.2e-3, "viscous": 8.0}
    true = {f"{name}_{side}": value for name, value in sides.items() for side in ("positive", "negative")}
    true |= {"stiffness": 30000.0, "damping": 300.0, "inertia": 6.0}
    rows = {
        name: {
            "value": value,
            "unit": "",
            "interval_95": [0.99 * value, 1.01 * value],
            "paper_method": value,
            "start": value,
        }
        for name, value in true.items()
    }
    return {"format": "trackservo-identification", "version": 1, "parameters": rows, "refused": []}


TUNE = (
    "tune", "--axis", "azimuth", "--from", "found", "--periods", "2", "--high", "150", "--travel-deg", "-270", "270",
)  # fmt: skip


@pytest.mark.image
@pytest.mark.smoke
@pytest.mark.real_time
def test_gains_whose_margins_hold_stay_and_undo_takes_them_back(tunable: Bench) -> None:
    """An identified plant, which only --unlock writes, is left out with a note."""
    before, plant = values(tunable, GAINS), values(tunable, PLANT_INERTIA)
    tunable.environment |= {"SHORT_ALSO": " ".join(PLANT_INERTIA), "SHORT_MARGINS": "12 50"}
    words = (*TUNE, "--gain-margin-db", "8")
    shown = tunable(*words, "--dry-run")
    assert shown.code == 0 and "identified_plant.inertia" in shown.out and "--unlock" in shown.err
    done = tunable(*words, "--yes", "--json")
    assert done.code == 0 and "--unlock" in done.err, done.err
    assert values(tunable, PLANT_INERTIA) == plant
    assert done.data["kept"] and [row["wished"] for row in done.data["margins"]] == [True, False]
    assert json.loads((tunable.folder / "found/wishes.json").read_text()) == {"least_gain_margin_db": 8.0}
    assert values(tunable, GAINS) == [pytest.approx(0.9 * value, rel=1e-6) for value in before]
    assert tunable("diff", "found/azimuth-active.toml").code == 0
    page = (tunable.folder / "found/tune.html").read_text()
    assert "The new gains were kept" in page and "data:image/png" in page
    assert tunable.json("info")["axes"][0]["differs_from_stored"]  # nothing was stored
    tunable.json("undo")
    assert values(tunable, GAINS) == before


@pytest.mark.real_time
def test_gains_whose_margins_do_not_hold_are_taken_back_and_it_says_by_how_much(tunable: Bench) -> None:
    before = tunable.json("get")
    tunable.environment["SHORT_MARGINS"] = "25 50"
    missed = tunable(*TUNE, "--yes")
    assert missed.code == 1 and "too low" in missed.err and "old gains" in missed.err
    assert tunable.json("get") == before
    assert not tunable.json("info")["axes"][0]["staged"]
    assert "old gains were restored" in (tunable.folder / "found/tune.html").read_text()
    assert tunable("diff", "found/azimuth-active.toml").code == 0


@pytest.mark.real_time
def test_a_design_that_changes_the_motor_asks_for_unlock_before_it_moves_and_takes_it(tunable: Bench) -> None:
    """With unlock, the identified plant is written as well."""
    motor = "azimuth.motor.torque_constant"
    before, gains, plant = tunable.value(motor), values(tunable, GAINS), values(tunable, PLANT_INERTIA)
    tunable.environment |= {
        "SHORT_ALSO": " ".join(("0x2055:1", *PLANT_INERTIA)), "SHORT_MARGINS": "12 50", "SHORT_FACTOR": "0.95",
    }  # fmt: skip
    shown = tunable(*TUNE, "--dry-run")
    assert shown.code == 0 and motor in shown.err and "--unlock" in shown.err
    refused = tunable(*TUNE, "--gain-margin-db", "8", "--yes")
    *notes, sentence = refused.err.splitlines()
    assert refused.code == 2 and motor in sentence and "--unlock" in sentence, refused
    assert len(notes) == 1 and "identified plant" in notes[0], notes
    assert (tunable.value(motor), values(tunable, GAINS)) == (before, gains)
    assert "will move" not in refused.out
    done = tunable(*TUNE, "--gain-margin-db", "8", "--yes", "--unlock", "--json")
    assert done.code == 0 and done.data["kept"], done.err
    assert tunable.value(motor) == pytest.approx(0.95 * before, rel=1e-6)
    assert "azimuth.identified_plant.inertia" in {row["name"] for row in done.data["changed"]}
    assert values(tunable, PLANT_INERTIA) == [pytest.approx(0.95 * value, rel=1e-6) for value in plant]
    assert "identified_plant.inertia" in (tunable.folder / "found/tune.html").read_text()
    tunable.json("undo", "--unlock")
    assert tunable.value(motor) == before and values(tunable, PLANT_INERTIA) == plant


@pytest.mark.real_time
def test_an_interrupt_while_new_gains_are_tried_brings_the_old_ones_back(
    tunable: Bench, eventually: Eventually
) -> None:
    before = tunable.json("get")
    process = tunable.start(*TUNE, "--yes")
    eventually(lambda: values(tunable, GAINS)[0] != before[0]["value"], 20)
    eventually(lambda: axis_state(tunable)["state"] == "operation enabled", 20)
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60) == 130
    assert tunable.json("get") == before
    assert axis_state(tunable)["state"] == "switch on disabled"


@pytest.mark.parametrize(
    "words, expected",
    [
        (("--axis", "pitch"), "belongs to azimuth, not to pitch"),
        (("--axis", "azimuth", "--travel-deg", "-1000", "-900"), "2060:9"),
        (("--axis", "azimuth", "--travel-deg", "-278", "-277"), "beyond --travel-deg -278 -277"),
        (("--axis", "azimuth", "--bias", "0"), "--bias must not be 0"),
    ],
)
def test_tune_refuses_what_is_not_of_this_axis_or_would_leave_the_travel(
    tunable: Bench, words: tuple[str, ...], expected: str
) -> None:
    result = a_result() | {"machine": {"axis": "azimuth"}}
    (tunable.folder / "found/result.json").write_text(json.dumps(result))
    tunable.json("set", *NO_POSITION_LIMITS)
    refused = tunable("tune", *words, "--from", "found", "--yes")
    tunable.json("undo")
    assert refused.code == 2 and expected in refused.err and refused.err.count("\n") == 1, refused


def test_an_identification_is_not_written_over(machine: Bench) -> None:
    (machine.folder / "found").mkdir()
    (machine.folder / "found/result.json").write_text("{}")
    refused = machine("identify", "--axis", "azimuth", *TRAVEL, "--out", "found", "--yes")
    assert refused.code == 2 and "'found/result.json' exists already" in refused.err


def test_a_dry_run_of_tune_shows_the_design_and_changes_nothing(tunable: Bench) -> None:
    before = tunable.json("get")
    shown = tunable(*TUNE, "--dry-run")
    assert shown.code == 0 and "proportional_gain" in shown.out and "predicted" in shown.out
    assert tunable.json("get") == before
    assert [path.name for path in (tunable.folder / "found").iterdir()] == ["result.json"]


def test_tune_and_bode_refuse_a_simulator_that_is_faster_than_real_time(tmp_path: Path) -> None:
    """How fast a board is emulated is up to the computer."""
    (tmp_path / "found").mkdir()
    (tmp_path / "found/result.json").write_text(json.dumps(a_result()))
    with serve(FAST, server=SERVERS["sim"]) as served:
        machine = Bench(served.address, tmp_path)
        machine.environment |= PROGRAMS
        gains = machine.json("get")
        for words in (TUNE, ("bode", "azimuth")):
            refused = machine(*words, "--yes")
            assert refused.code == 6 and "--speed 1" in refused.err
        assert machine.json("get") == gains


def test_a_folder_without_a_result_is_reported(tunable: Bench) -> None:
    (tunable.folder / "found/result.json").write_text("{}")
    refused = tunable(*TUNE, "--dry-run")
    assert refused.code == 2 and "trackservo-identification" in refused.err and refused.err.count("\n") == 1
