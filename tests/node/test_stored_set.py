"""Stored values survive a loss of power: another `sim_host serve` with the same --flash file."""

import contextlib
import subprocess

import canopen
import pytest
from canopen.profiles.p402 import BaseNode402

from conftest import DESCRIPTIONS, NODE_ID, SIM_HOST, Served
from drive import PV, Axis

SAVE, LOAD = 0x65766173, 0x64616F6C
DEFAULTS, STORED, OLDER = 0, 1, 3
OWN_LIMIT = 12345678


@contextlib.contextmanager
def powered(flash):
    """A node from power-on to power-off."""
    served = Served("slcan-tcp:0", "--flash", str(flash))
    network = canopen.Network(bus=served.open_bus())
    network.connect()
    node = BaseNode402(NODE_ID, str(DESCRIPTIONS / "trackservo.eds"))
    network.add_node(node)
    node.nmt.wait_for_heartbeat(timeout=5)
    try:
        yield node
    finally:
        network.disconnect()
        served.close()


def change(node, speed_limit):
    kp = Axis(node, 0).get(0x2000, 1)
    Axis(node, 0).set(1.1 * kp, 0x2000, 1)
    Axis(node, 0).set(1, 0x2070, 1)
    Axis(node, 0).set(speed_limit, 0x607F)
    Axis(node, 0).set(-OWN_LIMIT, 0x607D, 1)
    return 1.1 * kp


def test_gains_and_limits_survive_a_loss_of_power(tmp_path):
    flash = tmp_path / "flash"
    with powered(flash) as node:
        assert node.sdo[0x3031][1].raw == DEFAULTS
        kp = change(node, 654321)
        node.sdo[0x1010][1].raw = SAVE
    with powered(flash) as node:
        assert (node.sdo[0x3031][1].raw, node.sdo[0x3031][2].raw) == (STORED, 1)
        assert Axis(node, 0).get(0x2000, 1) == pytest.approx(kp)
        assert Axis(node, 0).get(0x607F) == 654321
        assert Axis(node, 0).get(0x607D, 1) == -OWN_LIMIT
        node.sdo[0x1011][1].raw = LOAD
    with powered(flash) as node:
        assert node.sdo[0x3031][1].raw == DEFAULTS
        assert Axis(node, 0).get(0x607F) == 1000000
        assert Axis(node, 0).get(0x607D, 1) == pytest.approx(-48.52e6, rel=1e-3)  # of the plant: 278 degrees


def test_a_damaged_set_is_skipped_and_reported(tmp_path):
    flash = tmp_path / "flash"
    with powered(flash) as node:
        for speed_limit in (600001, 600002):
            Axis(node, 0).set(speed_limit, 0x607F)
            node.sdo[0x1010][1].raw = SAVE
    contents = bytearray(flash.read_bytes())
    newest = contents.rindex(b"1VST")
    contents[newest + 200] ^= 1
    flash.write_bytes(contents)
    with powered(flash) as node:
        assert Axis(node, 0).get(0x607F) == 600001
        assert (node.sdo[0x3031][1].raw, node.sdo[0x3031][3].raw) == (OLDER, 1)
        history = [node.sdo[0x1003][sub].raw for sub in range(1, node.sdo[0x1003][0].raw + 1)]
        assert 0x04016310 in history  # source 4, detail 1
        assert Axis(node, 0).get(0x6041) & 0x4F == 0x08  # both axes wait for a fault reset
        assert node.sdo[0x1001].raw != 0


def test_nothing_is_stored_while_an_axis_has_torque(node, azimuth):
    azimuth.enable(PV)
    with pytest.raises(canopen.SdoAbortedError) as refused:
        node.sdo[0x1010][1].raw = SAVE
    assert refused.value.code == 0x08000022
    azimuth.command(0)


def test_a_file_that_is_no_flash_is_refused(tmp_path):
    file = tmp_path / "notes.txt"
    file.write_text("not a flash")
    run = subprocess.run([SIM_HOST, "serve", "--flash", str(file)], capture_output=True, text=True, timeout=20,
                         stdin=subprocess.DEVNULL)
    assert run.returncode != 0
    assert "20480 bytes" in run.stderr
    assert file.read_text() == "not a flash"


def test_a_flash_file_from_before_there_were_pages_for_the_bus_is_taken(tmp_path):
    flash = tmp_path / "flash"
    with powered(flash) as node:
        Axis(node, 0).set(654321, 0x607F)
        node.sdo[0x1010][1].raw = SAVE
    flash.write_bytes(flash.read_bytes()[:16384])
    with powered(flash) as node:
        assert Axis(node, 0).get(0x607F) == 654321
        assert [node.sdo[0x3050][sub].raw for sub in range(1, 5)] == [1, 1000, 1, 1000]
    assert flash.stat().st_size == 20480
