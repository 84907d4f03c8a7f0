# SPDX-License-Identifier: Apache-2.0
"""The object of `connect`: what its methods add to the functions that the tests of the commands judge."""

from __future__ import annotations

import dataclasses
import math
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from servoctl import InputError, Servo, ServoctlError, connect, degrees, radians
from servoctl.motion.rate_run import RatesRun, send_rates
from servoctl.motion.track_run import Record
from servoctl.motion.tracking import ACQUIRING, ON_TARGET
from servoctl.show.frames import tracking_frame

from .conftest import PACKAGE, ROOT, Bench
from .test_identify import IDENTIFY

GAIN = "azimuth.speed_loop.proportional_gain"
OBSERVER = "azimuth.disturbance_observer.bandwidth"


@pytest.fixture
def opened(servo: Bench, monkeypatch: pytest.MonkeyPatch) -> Iterator[Servo]:
    """The servo in this process, as in a script: the bus from the environment."""
    for name, value in servo.environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("TRACKSERVO_IDENTIFY", str(IDENTIFY))
    monkeypatch.chdir(servo.folder)
    with connect() as found:
        yield found


REFUSED: dict[str, Callable[[Servo], object]] = {
    "did you mean azimuth.speed_loop": lambda servo: servo["azimuth.sped_loop.proportional_gain"],
    "Give the full name.": lambda servo: servo["proportional_gain"],
    "is not a parameter of azimuth": lambda servo: servo.azimuth["pitch.speed_loop.proportional_gain"],
    "nothing to set": lambda servo: servo.set({}),
    "is given twice": lambda servo: servo.set({GAIN: 1.0, "0x2000:1": 2.0}),
    "has the unit 'm'": lambda servo: servo.set({OBSERVER: 100.0, GAIN: "700 m"}),
    "is read-only": lambda servo: servo.set({OBSERVER: 100.0, "0x1000": 1}),
    "give unlock=True to write it": lambda servo: servo.set({OBSERVER: 100.0, "azimuth.motor.torque_constant": 1.0}),
    "apply such gains with override=True": lambda servo: servo.set({OBSERVER: 100.0, GAIN: 20000.0}),
    "either to_rad or by_rad": lambda servo: servo.azimuth.move(),
    "needs a rate above 0": lambda servo: servo.azimuth.move(by_rad=0.1, rate_rad_s=-0.1),
    "would move to nan": lambda servo: servo.azimuth.move(to_rad=math.nan),
    "at most 57.29 °/s is allowed": lambda servo: servo.azimuth.move(by_rad=0.1, rate_rad_s=9.0),
    "request less, or give other limits": lambda servo: servo.azimuth.move(by_rad=radians(100.0), rate_rad_s=0.3),
    "expected more than 0": lambda servo: servo.azimuth.run(0.1, seconds=math.nan),
    "amplitude_rad_s must not be 0": lambda servo: servo.azimuth.step(0.0),
    "at most 3600 s": lambda servo: servo.record(math.inf),
    "expected both, azimuth, pitch, tracking": lambda servo: servo.record(1.0, "all"),
    "a travel of -600° to 150° exceeds": lambda servo: servo.azimuth.identify("new", travel_rad=(radians(-600), radians(150))),
    "travel_rad needs two angles in rad": lambda servo: servo.azimuth.identify("new", travel_rad=(1.0, -1.0)),
    "new/result.json: cannot be read": lambda servo: servo.azimuth.tune("new"),
    "expected bandwidth_hz, damping": lambda servo: servo.azimuth.design("new", bandwith_hz=30.0),
    "camera_id=0x541": lambda servo: servo.track(1.0),
    "is not an identifier of a camera": lambda servo: servo.track(1.0, camera_id=1),
    "a slew needs a rate above 0": lambda servo: servo.track(1.0, cue_rad=(0.0, 0.0), slew_rate_rad_s=0.0),
    "there is no axis 'yaw'": lambda servo: servo.track(1.0, axes=["yaw"]),
    "limits: File does not exist: none.toml": lambda servo: servo.check("none.toml"),
    "seeds: ": lambda servo: servo.check(seeds=[-1]),
}


def test_what_is_refused_is_said_in_the_words_of_python_and_changes_nothing(servo: Bench, opened: Servo) -> None:
    before = servo.json("get")
    for words, call in REFUSED.items():
        with pytest.raises(ServoctlError) as refused:
            call(opened)
        text = str(refused.value)
        assert words in text and text.count("\n") == 0 and not re.search(r"(?<!')--[a-z]", re.sub(r"'[^']*'", "", text)), text
    assert servo.json("get") == before
    assert [axis["state"] for axis in servo.json("state")["axes"]] == ["switch on disabled"] * 2
    assert not (servo.folder / "new").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [({"bus": "can0"}, "invalid bus 'can0'"), ({"bus": "slcan-tcp::1"}, "connection refused"), ({"node_id": 128}, "expected 1 to 127"),
     ({"node_id": 9}, "node 9 does not answer"), ({"word": "ü"}, "printable ASCII")],
)  # fmt: skip
def test_a_servo_that_is_not_there_is_said_at_once(opened: Servo, arguments: dict[str, object], words: str) -> None:
    with pytest.raises(ServoctlError, match=words):
        connect(**arguments)  # type: ignore[arg-type]


def test_without_a_bus_connect_says_where_to_name_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("SERVOCTL_BUS", raising=False)
    with pytest.raises(InputError, match="name it in connect or in SERVOCTL_BUS"):
        connect()


def test_a_script_and_the_command_line_share_journal_and_undo(servo: Bench, opened: Servo) -> None:
    before = opened[GAIN]
    changes = opened.azimuth.set({"speed_loop.proportional_gain": "700 N m s/rad"})
    assert [(change.old, change.new) for change in changes] == [(before, 700.0)] and servo.value(GAIN) == 700.0
    assert servo.json("undo", "--list")[-1]["command"] == "set"
    servo.json("undo")
    assert opened[GAIN] == before
    with opened.azimuth.trial({"speed_loop.proportional_gain": 690.0}):
        assert servo.value(GAIN) == 690.0
    assert opened[GAIN] == before


def test_a_motion_is_recorded_in_every_tick_and_leaves_the_axis_as_it_was(servo: Bench, opened: Servo) -> None:
    before = servo.json("state")
    with opened.recording("azimuth") as live:
        end_rad = opened.azimuth.run(radians(2.0), seconds=1.0)
    frame = live.recording.frame()
    assert live.missing == 0 and frame.index.name == "time_s"
    assert np.diff(frame.index) == pytest.approx(1e-3)
    steady = frame[frame["azimuth_demanded_rate_deg_s"] > 1.999]
    assert len(steady) > 500 and steady["azimuth_rate_deg_s"].mean() == pytest.approx(2.0, abs=0.01)
    assert frame["azimuth_angle_deg"].iloc[-1] == pytest.approx(degrees(end_rad), abs=0.2)  # wind
    back_rad = opened.azimuth.move(to_rad=end_rad - radians(2.0), rate_rad_s=radians(10.0))
    assert back_rad == pytest.approx(end_rad - radians(2.0), abs=2e-4)
    state = servo.json("state")
    assert state["nmt"] == before["nmt"] and [axis["state"] for axis in state["axes"]] == ["switch on disabled"] * 2


@pytest.mark.real_time
def test_a_disturbed_step_is_repeated(opened: Servo, monkeypatch: pytest.MonkeyPatch) -> None:
    runs: list[RatesRun] = []

    def first_without_a_step(*arguments: Any, **options: Any) -> RatesRun:
        runs.append(send_rates(*arguments, **options))
        return runs[-1] if len(runs) > 1 else dataclasses.replace(runs[0], demand=np.zeros_like(runs[0].demand))

    monkeypatch.setattr("servoctl.axis.send_rates", first_without_a_step)
    assert {record[0] for record in opened.azimuth.step(radians(1.0), hold_s=0.5)} <= {"forward", "backward"}
    assert len(runs) > 1


def test_a_check_judges_the_gains_in_force(servo: Bench, opened: Servo) -> None:
    one = [ROOT / "sim_host/scenarios/sine.toml"]
    with pytest.warns(UserWarning, match="is meant for 20 seeds"):
        good = opened.check(scenarios=one, seeds=[1], out="good")
    assert good["kept"].all() and {"loop", "sine"} == {*good["scenario"]}
    assert (servo.folder / "good/report.html").exists()
    with opened.azimuth.trial({"speed_loop.proportional_gain": "500 N m s/rad"}), pytest.warns(UserWarning):
        weak = opened.check(scenarios=one, seeds=[1])
    failed = weak[weak["kept"].eq(False)]
    assert "crossover_hz" in set(failed["figure"]) and set(failed["axis"]) == {"azimuth"}


def test_a_frame_without_pandas_is_refused_before_anything_moves(opened: Servo, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    calls: list[Callable[[], object]] = [lambda: opened.record(1.0), lambda: opened.track(1.0, camera_id=0x541), opened.check]
    for call in calls:
        with pytest.raises(InputError, match=r"install 'servoctl\[frames\]'"):
            call()
    assert opened.azimuth.state() == "switch on disabled"


def test_an_error_counts_only_while_the_axis_follows() -> None:
    record = Record([1], [(0.0, [ACQUIRING]), (0.02, [ON_TARGET])], np.array([[0.0, 1e-3], [0.0, 2e-3], [0.0, 3e-3], [0.0, 4e-3]]))
    frame = tracking_frame(record)
    assert list(frame.columns) == ["pitch_error_rad", "pitch_state"] and list(frame.index) == [0.0, 0.01, 0.02, 0.03]
    assert frame["pitch_error_rad"].isna().tolist() == [True, True, False, False] and frame["pitch_error_rad"].iloc[3] == 4e-3
    assert frame["pitch_state"].tolist() == ["acquiring", "acquiring", "tracking", "tracking"]


def test_the_plots_choose_no_window_system() -> None:
    """A notebook has its own."""
    code = "import sys, servoctl.plots; assert 'matplotlib.pyplot' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], cwd=PACKAGE, check=True)
