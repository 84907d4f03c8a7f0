"""A master that falls silent (6007), with unmodified python-canopen."""

import json
import time

import pytest

from drive import PP, PV, Axis, wait_until

CAPPED_S = 2.5  # 1 s of silence, the ramp, and a shared computer


@pytest.fixture
def client(connect):
    """Operational, as delivered."""
    node = connect()
    node.nmt.wait_for_heartbeat(timeout=5)
    node.nmt.state = "OPERATIONAL"
    return node


def turn(axis):
    """In pv at 2 deg/s, without the line that ends the supervision."""
    axis.set(PV, 0x6060)
    for controlword in (0x06, 0x07, 0x0F):
        axis.command(controlword)
        time.sleep(0.01)
    assert axis.state == "OPERATION ENABLED"
    axis.set(34907, 0x60FF)


@pytest.mark.parametrize("shift", [0, 0x800], ids=["azimuth", "pitch"])
def test_an_axis_stops_without_a_fault_when_its_client_is_silent_for_1_s(client, descriptions, shift):
    faults = json.loads((descriptions / "faults.json").read_text())["faults"]
    number = next(fault["number"] for fault in faults if fault["name"] == "master silent")
    axis = Axis(client, shift)
    emergencies = []
    client.emcy.add_callback(emergencies.append)
    turn(axis)
    time.sleep(CAPPED_S)
    assert [(one.code, *one.data[:2]) for one in emergencies] == [(0x8101, number, 1 if shift == 0 else 2)]
    status = axis.get(0x6041)
    assert axis.state == "SWITCH ON DISABLED" and status & 0x80
    assert axis.get(0x603F) == 0 and abs(axis.mean_rate_deg_s()) < 0.1
    turn(axis)
    wait_until(lambda: axis.get(0x6041) & 0x80 == 0, 1)
    assert axis.state == "OPERATION ENABLED"


def test_a_client_that_speaks_keeps_the_axis_turning(client):
    axis = Axis(client, 0)
    turn(axis)
    for _ in range(6):
        time.sleep(0.5)
        assert axis.state == "OPERATION ENABLED"
    assert axis.rate_deg_s == pytest.approx(2.0, abs=0.2)


def test_the_documented_line_switches_the_supervision_off(client):
    client.sdo[0x6007].raw = 0
    axis = Axis(client, 0)
    turn(axis)
    time.sleep(CAPPED_S)
    assert axis.state == "OPERATION ENABLED" and axis.rate_deg_s == pytest.approx(2.0, abs=0.2)


def test_the_documented_heartbeat_keeps_the_axis_turning_and_its_loss_is_a_fault(client):
    client.sdo[0x1016][1].raw = 0x7E << 16 | 500
    beat = client.network.send_periodic(0x77E, b"\x05", 0.1)
    time.sleep(0.2)
    axis = Axis(client, 0)
    turn(axis)
    time.sleep(CAPPED_S)
    assert axis.state == "OPERATION ENABLED"
    beat.stop()
    wait_until(lambda: axis.state in ("FAULT REACTION ACTIVE", "FAULT"), 3)
    assert axis.get(0x603F) == 0x8130


def test_a_move_by_pp_stops_before_its_target(client):
    axis = Axis(client, 0)
    turn(axis)
    axis.set(0, 0x60FF)
    wait_until(lambda: abs(axis.rate_deg_s) < 0.05, 3)
    axis.set(PP, 0x6060)
    axis.set(34907, 0x6081)
    axis.set(axis.get(0x6064) + 3490659, 0x607A)  # 20 deg
    start = axis.angle_deg
    axis.command(0x1F)
    time.sleep(CAPPED_S)
    assert 1.0 < axis.angle_deg - start < 4.5 and axis.state == "SWITCH ON DISABLED"
