# SPDX-License-Identifier: Apache-2.0
"""sim_host serve --target: a target before the machine, and a camera on its bus."""

import contextlib
import csv
import math
import re
import statistics
import subprocess

import pytest
from axis import ACKNOWLEDGED, ENABLE, PP, TARGET_REACHED, Axis
from camera import LOST, ON_TARGET, TRACKING, map_camera
from device import PROJECT, SIM_HOST
from master import Master

pytestmark = pytest.mark.simulator
SCENARIO = PROJECT / "sim_host/scenarios/tracking.toml"


@pytest.fixture
def facing(serve):
    """A served target, and a master of its node."""
    with contextlib.ExitStack() as ending:

        def start(scenario, *options):
            served = serve("--target", str(scenario), *options)
            served.start = served.process.stdout.readline()
            served.wait_until_ready()
            master = Master(served.open_bus())
            ending.callback(master.close)
            return served, master

        yield start


def slew(axis, degrees):
    axis.enable(PP)
    axis.set(round(math.radians(degrees) * 1e7), 0x607A)
    axis.command(ENABLE | 0x10)
    axis.wait_until(lambda: axis.get(0x6041) & ACKNOWLEDGED)
    axis.command(ENABLE)
    axis.wait_until(lambda: axis.get(0x6041) & TARGET_REACHED, 20)


def states(node):
    return [node.sdo[0x3072][sub].raw for sub in (5, 6)]


def flights(file):
    """Rows of each flight, in order."""
    runs = []
    for row in csv.DictReader(file.read_text().splitlines()):
        values = {name: float(text) for name, text in row.items()}
        if values["flight_s"] == 0.0:
            runs.append([])
        runs[-1].append(values)
    return runs


def sigma_urad(rows, name):
    return statistics.pstdev(row[f"{name}_error_urad"] for row in rows)


def test_the_target_waits_flies_while_it_is_followed_and_waits_again(facing, tmp_path, report):
    truth = tmp_path / "truth.csv"
    served, master = facing(SCENARIO, "--truth", str(truth))
    node = master.node
    assert served.start == ("target: waits at azimuth 0.764 deg, pitch 2.862 deg; camera frames have the"
                            " identifier 541\n")
    map_camera(master)
    axes = [Axis(master, 0), Axis(master, 0x800)]
    for axis, degrees in zip(axes, (0.8, 2.8), strict=True):
        slew(axis, degrees)
    master.pass_time(3000)
    for _ in range(2):
        for axis in axes:
            axis.set(TRACKING, 0x6060)
        master.wait_until(lambda: states(node) == [ON_TARGET, ON_TARGET], 5)
        master.pass_time(12000)
        assert states(node) == [ON_TARGET, ON_TARGET]
        assert node.sdo[0x3072][3].raw == 0
        for axis, degrees in zip(axes, (0.8, 2.8), strict=True):
            slew(axis, degrees)
        assert states(node) == [0, 0]
    master.close()
    served.close()
    first, second = flights(truth)
    for flight in (first, second):
        assert flight[0]["target_azimuth_rad"] == pytest.approx(math.atan2(40, 3000), abs=1e-6)
        settled = [row for row in flight if 5 < row["flight_s"] < 11.5]
        assert len(settled) > 6000
        sigmas = [sigma_urad(settled, name) for name in ("cross_elevation", "elevation")]
        report(f"true error of the line of sight: {sigmas[0]:.1f} and {sigmas[1]:.1f} urad (1 sigma)")
        assert max(sigmas) < 5.0
        assert settled[-1]["range_m"] == pytest.approx(3000 - 20 * settled[-1]["flight_s"], abs=10)


def test_the_strobe_of_the_camera_gives_the_age_of_its_frames(facing):
    """3071:5 = 2: the frames' own age would be 20 ms, too; the window shows that it is not used."""
    _, master = facing(SCENARIO)
    node = master.node
    map_camera(master)
    node.sdo[0x3071][5].raw = 2
    node.sdo[0x3074][3].raw = 3000
    master.pass_time(1000)
    assert node.sdo[0x3074][12].raw == 2
    assert node.sdo[0x3072][7].raw in (17, 18)
    paired = node.sdo[0x3074][6].raw
    node.sdo[0x3074][2].raw = 1500
    master.pass_time(200)
    assert node.sdo[0x3074][12].raw == 0
    assert node.sdo[0x3074][8].raw == 1
    assert node.sdo[0x3072][7].raw in (20, 21)
    assert node.sdo[0x3074][6].raw - paired < 20


def test_dropouts_are_those_of_the_flight_and_after_it_there_is_no_target(facing, tmp_path):
    scenario = tmp_path / "short.toml"
    scenario.write_text(SCENARIO.read_text().replace("duration_s = 45.0", "duration_s = 8.0")
                        + "dropouts_at_s = [6.0]\ndropout_s = 0.1\n")
    truth = tmp_path / "truth.csv"
    served, master = facing(scenario, "--truth", str(truth))
    node = master.node
    map_camera(master)
    axes = [Axis(master, 0), Axis(master, 0x800)]
    for axis, degrees in zip(axes, (0.8, 2.8), strict=True):
        slew(axis, degrees)
    for axis in axes:
        axis.set(TRACKING, 0x6060)
    master.wait_until(lambda: states(node) == [LOST, LOST], 20)
    for axis in axes:
        axis.command(0)
    master.close()
    served.close()
    rows = flights(truth)[0]
    hidden = [row["flight_s"] for row in rows if not row["visible"]]
    assert hidden[:101] == pytest.approx([6 + 0.001 * i for i in range(100)] + [8.0], abs=1e-6)


def test_a_scenario_without_a_target_is_refused():
    done = subprocess.run([SIM_HOST, "serve", "--target", str(PROJECT / "sim_host/scenarios/sine.toml")],
                          stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=20)
    assert done.returncode == 2
    assert "sine.toml:" in done.stderr and "has no target" in done.stderr


@pytest.mark.parametrize(("options", "words"), [
    (["--video", ""], "is empty: expected pgm-tcp:PORT"),
    (["--video", "pgm-tcp:0", "--camera-id", "0x541"], "excludes"),
])
def test_options_without_effect_are_refused(options, words):
    done = subprocess.run([SIM_HOST, "serve", "--target", str(PROJECT / "sim_host/scenarios/tracking.toml"), *options],
                          stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=20)
    assert done.returncode == 2 and words in done.stderr, done.stderr


@pytest.mark.parametrize(("start", "words"), [
    ("[0.0, 0.0, 0.0]", "the target is at the tracker itself at 0 s"),
    ("[0.0, 1.0, -100.0]", "is beyond the end stops of tracker's pitch"),
])
def test_a_target_that_no_axis_can_reach_is_refused(tmp_path, start, words):
    scenario = tmp_path / "flight.toml"
    text = (PROJECT / "sim_host/scenarios/tracking.toml").read_text()
    scenario.write_text(re.sub(r"start_position_m = .*", f"start_position_m = {start}", text))
    done = subprocess.run([SIM_HOST, "serve", "--target", str(scenario)],
                          stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=20)
    assert done.returncode == 2 and "flight.toml:" in done.stderr and words in done.stderr, done.stderr
