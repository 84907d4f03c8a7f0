"""Stored values survive a loss of power: another `sim_host serve` with the same --flash file."""

import contextlib
import subprocess

import pytest
from axis import Axis
from device import SIM_HOST
from master import Master

pytestmark = pytest.mark.simulator
DEFAULTS, STORED = 0, 1
OWN_LIMIT = 12345678


@pytest.fixture
def powered(serve, tmp_path):
    """A master from power-on to power-off."""

    @contextlib.contextmanager
    def power():
        served = serve("--flash", str(tmp_path / "flash")).wait_until_ready()
        master = Master(served.open_bus())
        yield master
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


def test_a_file_that_is_no_flash_is_refused(tmp_path):
    file = tmp_path / "notes.txt"
    file.write_text("not a flash")
    run = subprocess.run([SIM_HOST, "serve", "--flash", str(file)], capture_output=True, text=True, timeout=20,
                         stdin=subprocess.DEVNULL)
    assert run.returncode != 0
    assert "20480 bytes" in run.stderr
    assert file.read_text() == "not a flash"


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
