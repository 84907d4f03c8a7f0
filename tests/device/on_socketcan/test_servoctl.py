# SPDX-License-Identifier: Apache-2.0
"""servoctl on a real SocketCAN interface: look, change, move, undo. Needs vcan0."""

import json

import pytest
from servoctl.cli import main

from device import DESCRIPTIONS

SLOW = 0.25  # of node time: User Mode Linux may be late
GAIN = "azimuth.speed_loop.proportional_gain"


@pytest.fixture
def servoctl(vcan0, tmp_path, monkeypatch, capsys):
    """Runs it in this process, because User Mode Linux takes seconds to start one; returns the output of --json."""
    monkeypatch.chdir(tmp_path)
    for name, value in (("STATE", tmp_path), ("PARAMETERS", DESCRIPTIONS / "parameters.json")):
        monkeypatch.setenv(f"SERVOCTL_{name}", str(value))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))

    def run(*words):
        capsys.readouterr()
        code = main([*words, "--bus", vcan0, "--json"])
        written = capsys.readouterr()
        assert code == 0, written.err
        return json.loads(written.out)

    return run


@pytest.mark.speed(SLOW)
def test_servoctl_looks_changes_moves_and_undoes(servoctl):
    assert [found["name"] for found in servoctl("scan")] == ["trackservo"]
    assert servoctl("info")["schema_fits"]
    before = servoctl("get", GAIN)[0]["value"]
    changed = servoctl("set", GAIN, str(before + 10))[0]
    assert (changed["old"], changed["value"], changed["in_force"]) == (before, pytest.approx(before + 10), True)
    assert servoctl("move", "azimuth", "--by", "1", "--yes")["axis"] == "azimuth"
    scope = servoctl("scope", "azimuth.rate", "azimuth.torque", "--for", "0.2")
    assert scope["frames"] == 200
    assert servoctl("undo")[0]["value"] == before
    assert [axis["state"] for axis in servoctl("state")["axes"]] == ["switch on disabled"] * 2
