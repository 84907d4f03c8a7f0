# SPDX-License-Identifier: Apache-2.0
"""The machine as units of FMI 3.0, run by fmpy: they are valid, and move as `sim_host run` does with the same seed."""

from __future__ import annotations

import csv
import os
import re
import subprocess
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

PROJECT = Path(__file__).resolve().parents[2]
BUILT = Path(os.environ.get("HOST_BUILD", PROJECT / "build/host"))
AXES = ("azimuth", "pitch")
SCENARIO = """
name = "units"
title = "Both axes together, through standstill"
kind = "speed_sine"
axes = ["azimuth", "pitch"]
duration_s = 6.0
rest_s = 0.5
speeds_deg_s = [2.0]
frequency_hz = 0.5
initial_azimuth_deg = 10.0
initial_pitch_deg = 30.0
"""


def fmu_file(name: str) -> Path:
    return BUILT / f"fmu/trackservo_{name}.fmu"


class Instance:
    """A running unit, by names of variables."""

    def __init__(self, name: str, folder: Path, **start: float | str | bool) -> None:
        fmpy.extract(str(fmu_file(name)), str(folder))
        description = fmpy.read_model_description(str(folder))
        self.variables = {variable.name: variable for variable in description.modelVariables}
        self.messages: list[str] = []
        self.unit = FMU3Slave(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.unit.instantiate(loggingOn=True, logMessage=self._log)
        self.set(**start)

    def _log(self, _environment: object, _status: int, _category: bytes, message: bytes) -> None:
        self.messages.append(message.decode())

    def begin(self) -> None:
        self.unit.enterInitializationMode(startTime=0.0)
        self.unit.exitInitializationMode()

    def _call(self, verb: str, name: str, *values: object) -> list[object]:
        variable = self.variables[name]
        call = getattr(self.unit, f"{verb}{variable.type}")
        return call([variable.valueReference], *values)

    def set(self, **values: float | str | bool) -> None:
        for name, value in values.items():
            self._call("set", name.replace("__", "."), [value])

    def get(self, name: str) -> float:
        return self._call("get", name)[0]

    def step(self, time_s: float, size_s: float) -> None:
        self.unit.doStep(currentCommunicationPoint=time_s, communicationStepSize=size_s)

    def refuses(self, words: str, call: str, *values: object, **named: object) -> None:
        """This call fails, and the importer is told why in one sentence."""
        before = len(self.messages)
        with pytest.raises(FMICallException):
            getattr(self, call)(*values, **named)
        (message,) = self.messages[before:]
        assert words in message, message

    def end(self) -> None:
        self.unit.terminate()
        self.unit.freeInstance()


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> dict[str, np.ndarray]:
    """The rows of `sim_host run`, one each ms."""
    folder = tmp_path_factory.mktemp("run")
    (folder / "scenario.toml").write_text(SCENARIO, "utf-8")
    plant = PROJECT / "sim_host/plants/tracker.toml"
    subprocess.run(
        [BUILT / "bin/sim_host", "run", "--plant", plant, "--scenario", "scenario.toml", "--seed", "7", "--csv", "rows.csv"],
        cwd=folder, check=True, capture_output=True,
    )  # fmt: skip
    with (folder / "rows.csv").open() as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def sine(time_s: float) -> tuple[float, float]:
    """Rate and acceleration of the scenario, at this time."""
    w, rate = 2.0 * np.pi * 0.5, np.deg2rad(2.0)
    t = time_s - 0.5
    return (0.0, 0.0) if t < 0.0 else (rate * np.sin(w * t), rate * w * np.cos(w * t))


PARAMETERS = {"seed": 7, "azimuth__start_angle_rad": np.deg2rad(10.0), "pitch__start_angle_rad": np.deg2rad(30.0)}
COLUMNS = {  # of the rows, at a time; what the unit has then
    "joint_angle_rad": "joint_angle_rad",
    "joint_rate_rad_s": "joint_rate_rad_s",
    "rate_rad_s": "inertial_rate_rad_s",
    "torque_nm": "motor_torque_nm",
    "friction_nm": "friction_torque_nm",
    "load_nm": "load_torque_nm",
}
SIGNALS = {  # of the tick that begins then; what the unit has at its end
    "measured_rate_rad_s": "measured_rate_rad_s",
    "friction_feedforward_nm": "friction_feedforward_nm",
    "disturbance_estimate_nm": "disturbance_estimate_nm",
}


@pytest.mark.parametrize("name", ["plant", "servo"])
def test_the_unit_is_valid(name: str) -> None:
    assert validate_fmu(str(fmu_file(name))) == []


def test_the_units_move_as_sim_host_run_does(run: dict[str, np.ndarray], tmp_path: Path) -> None:
    """The servo's unit by the scenario's set-points, and the plant's by the duties of the servo's, in steps of 50 us."""
    servo = Instance("servo", tmp_path / "servo", **PARAMETERS)
    plant = Instance("plant", tmp_path / "plant", **PARAMETERS)
    servo.begin()
    plant.begin()
    seen: dict[str, list[float]] = {f"{axis}_{column}": [] for axis in AXES for column in (*COLUMNS, *SIGNALS)}
    of_plant: dict[str, list[float]] = {f"{axis}_{column}": [] for axis in AXES for column in COLUMNS}
    readings = [f"{axis}.{name}" for axis in AXES for name in ("encoder_angle_rad", "gyro_rate_rad_s")]
    for tick in range(len(run["time_s"])):
        rate, acceleration = sine(tick * 1e-3)
        for axis in AXES:
            servo.set(**{f"{axis}__rate_set_point_rad_s": rate, f"{axis}__acceleration_set_point_rad_s2": acceleration})
            for column, variable in COLUMNS.items():
                seen[f"{axis}_{column}"].append(servo.get(f"{axis}.{variable}"))
                of_plant[f"{axis}_{column}"].append(plant.get(f"{axis}.{variable}"))
        sampled = [plant.get(reading) for reading in readings]
        for period in range(20):
            for axis in AXES:
                plant.set(**{f"{axis}__duty": servo.get(f"{axis}.duty"), f"{axis}__bridge_on": servo.get(f"{axis}.bridge_on")})
            time_s = tick * 1e-3 + period * 50e-6
            servo.step(time_s, 50e-6)
            plant.step(time_s, 50e-6)
        assert sampled == [servo.get(reading) for reading in readings]
        for axis in AXES:
            for column, variable in SIGNALS.items():
                seen[f"{axis}_{column}"].append(servo.get(f"{axis}.{variable}"))
    servo.end()
    plant.end()
    for unit in (seen, of_plant):
        for column, values in unit.items():
            spread = np.ptp(run[column])
            assert spread > 0.0, column
            worst = np.max(np.abs(np.array(values) - run[column])) / spread
            assert worst <= 1e-9, (column, worst)


def test_the_example_of_the_page_gives_its_figures(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    page = (PROJECT / "docs/fmi.md").read_text("utf-8")
    (example,) = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    monkeypatch.chdir(PROJECT)
    exec(compile(example.replace("build/host", str(BUILT)), "docs/fmi.md", "exec"), {})
    (shown,) = re.findall(r"^```text\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    assert capsys.readouterr().out.endswith(shown)


def test_equal_seeds_give_equal_runs_after_a_reset_too(tmp_path: Path) -> None:
    one = Instance("plant", tmp_path / "one", seed=3)
    runs = []
    for _ in range(2):
        one.begin()
        one.set(azimuth__duty=0.3)
        one.step(0.0, 0.1)
        runs.append([one.get(name) for name in ("azimuth.joint_angle_rad", "azimuth.gyro_rate_rad_s", "pitch.current_reading_a")])
        one.unit.terminate()
        one.unit.reset()
        assert one.get("azimuth.duty") == 0.0 and one.get("time") == 0.0 and one.get("seed") == 1
        one.set(seed=3)
    assert runs[0] == runs[1] and runs[0][0] > 1e-6
    one.unit.freeInstance()


def test_what_is_wrong_is_refused_with_a_sentence(tmp_path: Path) -> None:
    unit = Instance("plant", tmp_path / "plant")
    unit.set(plant_file="traker.toml")
    unit.unit.enterInitializationMode(startTime=0.0)
    before = len(unit.messages)
    with pytest.raises(FMICallException):
        unit.unit.exitInitializationMode()
    assert "traker.toml" in unit.messages[before]
    unit.set(plant_file="tracker.toml")
    unit.unit.exitInitializationMode()
    unit.refuses("is a parameter; set it before the simulation", "set", seed=2)
    unit.refuses("azimuth.duty: nan; expected a finite number.", "set", azimuth__duty=float("nan"))
    unit.refuses("expected -100000 to 100000 N.m", "set", azimuth__external_torque_nm=1e6)
    unit.refuses("expected a whole number of PWM periods of 50 us", "step", 0.0, 1.7e-4)
    unit.refuses("expected 0 s, where the last step ended", "step", 0.1, 1e-3)
    unit.refuses("is an output; it cannot be set", "set", azimuth__joint_angle_rad=1.0)
    unit.step(0.0, 1e-3)
    assert unit.get("time") == pytest.approx(1e-3)
    unit.end()


@pytest.mark.parametrize(
    ("name", "start", "said"),
    [
        ("plant", {"pitch__start_angle_rad": 2.0}, "pitch.start_angle_rad: a start at 114.592 deg is beyond"),
        ("servo", {"controller": "pi_best"}, "controller: pi_best belongs to one scenario of 'sim_host run'"),
        ("servo", {"controller": "pid"}, "pi_vob_ftc"),
        ("servo", {"friction_parameter_error": 1.0}, "friction_parameter_error: 1; expected 0 to 0.5."),
    ],
)
def test_a_wrong_parameter_is_refused_at_the_start(name: str, start: dict[str, float | str], said: str, tmp_path: Path) -> None:
    unit = Instance(name, tmp_path / name, **start)
    with pytest.raises(FMICallException):
        unit.begin()
    assert said in unit.messages[-1]


def test_an_importer_may_add_up_the_time_for_hours(tmp_path: Path) -> None:
    """10,000 s after the beginning, in steps of 0.1 s whose sum is off by 1.6e-8 s."""
    unit = Instance("plant", tmp_path / "plant", azimuth__bridge_on=False, pitch__bridge_on=False)
    unit.unit.enterInitializationMode(startTime=1e4)
    unit.unit.exitInitializationMode()
    time_s = 1e4
    for _ in range(100):
        unit.step(time_s, 0.1)
        time_s += 0.1
    assert unit.get("time") == time_s
    unit.end()


@pytest.mark.parametrize(("torque", "load_nm", "motor_nm"), [("external_torque_nm", -2.0, 0.0), ("disturbance_nm", 0.0, 2.0)])
def test_torques_act_where_the_page_says(torque: str, load_nm: float, motor_nm: float, tmp_path: Path) -> None:
    """2 N m for 2 ms: from outside it is a load on the joint, as a disturbance a torque of the motor. Against a twin without it."""
    twins = [Instance("servo", tmp_path / name) for name in ("with", "without")]
    for unit in twins:
        unit.begin()
        unit.step(0.0, 0.2)
    twins[0].set(**{f"pitch__{torque}": 2.0})
    for unit in twins:
        unit.step(0.2, 2e-3)
    with_it, without = ({name: unit.get(f"pitch.{name}") for name in ("load_torque_nm", "motor_torque_nm")} for unit in twins)
    assert with_it["load_torque_nm"] - without["load_torque_nm"] == pytest.approx(load_nm, abs=0.2)
    assert with_it["motor_torque_nm"] - without["motor_torque_nm"] == pytest.approx(motor_nm, abs=0.4)
    twins[0].set(pitch__enabled=False)
    twins[0].step(0.202, 0.02)
    assert twins[0].get("pitch.motor_current_a") == 0.0 and not twins[0].get("pitch.bridge_on")
    for unit in twins:
        unit.end()


def test_a_unit_of_another_version_is_not_made(tmp_path: Path) -> None:
    fmpy.extract(str(fmu_file("plant")), str(tmp_path))
    unit = FMU3Slave(guid="other", unzipDirectory=str(tmp_path), modelIdentifier="trackservo_plant", instanceName="x")
    with pytest.raises(Exception, match="Failed to instantiate"):
        unit.instantiate()


