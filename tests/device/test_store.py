# SPDX-License-Identifier: Apache-2.0
"""Stored values survive a loss of power: the device starts again with the same --flash file."""

import contextlib
import os
import pathlib
import shutil
import struct
import subprocess

import pytest
from axis import Axis
from device import DEVICES, REAL_TIME, SIM_HOST
from master import Master

DEFAULTS, STORED, STORED_BY_ANOTHER_VERSION = 0, 1, 2
OWN_LIMIT = 12345678


@pytest.fixture
def powered(pytestconfig, tmp_path):
    """A master from power-on to power-off."""
    start = DEVICES[pytestconfig.getoption("--device")]

    @contextlib.contextmanager
    def power():
        served = start("slcan-tcp:0", REAL_TIME, "--flash", str(tmp_path / "flash"))
        master = Master(served.open_bus())
        try:
            yield master
        finally:
            master.close()
            served.close()

    return power


def test_gains_and_limits_survive_a_loss_of_power(powered):
    with powered() as master:
        assert master.number(0x3031, 1) == DEFAULTS
        azimuth = Axis(master, 0)
        kp = 1.1 * azimuth.get(0x2000, 1)
        azimuth.set(kp, 0x2000, 1)
        azimuth.set(1, 0x2070, 1)
        azimuth.set(654321, 0x607F)
        azimuth.set(-OWN_LIMIT, 0x607D, 1)
        master.node.store()
    with powered() as master:
        assert (master.number(0x3031, 1), master.number(0x3031, 2)) == (STORED, 1)
        azimuth = Axis(master, 0)
        assert azimuth.get(0x2000, 1) == pytest.approx(kp)
        assert (azimuth.get(0x607F), azimuth.get(0x607D, 1)) == (654321, -OWN_LIMIT)
        master.node.restore()
    with powered() as master:
        assert master.number(0x3031, 1) == DEFAULTS
        azimuth = Axis(master, 0)
        assert azimuth.get(0x607F) == 1000000
        assert azimuth.get(0x607D, 1) == pytest.approx(-48.52e6, rel=1e-3)  # of the plant: 278 degrees


def stored_rows(flash):
    """Index, sub-index, type and the value's bytes of each row of the newest record of a flash file
    (firmware/parameters/parameter_store.h)."""
    newest = (0, b"")
    for page in range(0, 16384, 2048):
        magic, sequence, _, rows = struct.unpack_from("<4I", flash, page)
        if magic == 0x54535631 and sequence > newest[0]:
            newest = (sequence, flash[page + 16:page + 16 + 8 * rows])
    for number, value in struct.iter_unpack("<I4s", newest[1]):
        yield number >> 16, number >> 8 & 0xFF, number & 0xFF, value


@pytest.mark.smoke
def test_a_set_stored_by_an_earlier_version_is_loaded_unchanged(powered, tmp_path):
    """stored_by_bdfab7c.flash: `sim_host serve --flash` of commit bdfab7c, with gains, limits and PDOs changed: 166 of
    362 rows differ from those of delivery."""
    fixture = pathlib.Path(__file__).with_name("stored_by_bdfab7c.flash")
    shutil.copy(fixture, tmp_path / "flash")
    with powered() as master:
        assert [master.number(0x3031, sub) for sub in (1, 6)] == [STORED_BY_ANOTHER_VERSION, 0]
        for index, sub, _, value in stored_rows(fixture.read_bytes()):
            read = master.node.sdo.upload(index, sub)
            assert read == value[:len(read)], f"{index:04X}:{sub}"


@pytest.mark.simulator
def test_a_file_that_is_no_flash_is_refused(tmp_path):
    file = tmp_path / "notes.txt"
    file.write_text("not a flash")
    run = subprocess.run([SIM_HOST, "serve", "--flash", str(file)], capture_output=True, text=True, timeout=20,
                         stdin=subprocess.DEVNULL)
    assert run.returncode != 0
    assert "20480 bytes" in run.stderr
    assert file.read_text() == "not a flash"


@pytest.mark.simulator
@pytest.mark.parametrize("kind", ["device", "pipe"])
def test_a_flash_that_is_no_regular_file_is_refused(tmp_path, kind):
    path = "/dev/null" if kind == "device" else str(tmp_path / "pipe")
    if kind == "pipe":
        os.mkfifo(path)
    run = subprocess.run([SIM_HOST, "serve", "--bus", "slcan-tcp:0", "--flash", path], capture_output=True, text=True, timeout=20,
                         stdin=subprocess.DEVNULL)
    assert run.returncode == 2
    assert run.stderr == f"sim_host: --flash: {path} is not a regular file; give one, or a new name\n"


@pytest.mark.simulator
def test_a_flash_file_from_before_there_were_pages_for_the_bus_is_taken(powered, tmp_path):
    flash = tmp_path / "flash"
    with powered() as master:
        Axis(master, 0).set(654321, 0x607F)
        master.node.store()
    flash.write_bytes(flash.read_bytes()[:16384])
    with powered() as master:
        assert Axis(master, 0).get(0x607F) == 654321
        assert [master.number(0x3050, sub) for sub in range(1, 5)] == [1, 1000, 1, 1000]
    assert flash.stat().st_size == 20480
