# SPDX-License-Identifier: Apache-2.0
"""The image on the emulated board: with the option bytes that tools/image/board writes, and as ST ships the chip."""

import os
import pathlib
import re
import subprocess

import can
import pytest

import test_emulate_board as emulated

BOARD = pathlib.Path(__file__).parents[2] / "tools/image/board"
DELIVERED = {0x20: 0xFFEFF8AA, 0x2C: 0xFF00FFFF}
OPTION_BYTES_EMCY = 0x5500
RAM_PARITY, WRITE_PROTECTION, BANKS = 16, 32, 128
ONE_BANK, BANK_2 = -1 << 22, 1 << 20
STORE_ALL, SAVE, HARDWARE_ERROR = 0x1010, 0x65766173, 0x06060000
LSS_MASTER, LSS_SLAVE, LSS_CONFIGURE, LSS_NODE_ID, LSS_STORE, LSS_STORE_FAILED = 0x7E5, 0x7E4, (4, 1), 0x11, 0x17, 2


def flashed(action: str) -> dict[int, int]:
    """OPTR and WRP1AR of a chip as delivered, after the commands of this action of OpenOCD."""
    registers = dict(DELIVERED)
    printed = subprocess.run([BOARD, "--dry-run", "openocd", action, pathlib.Path(emulated.IMAGE).with_suffix("")],
                             check=True, capture_output=True, text=True).stdout
    for offset, value, mask in re.findall(r"option_write 0 (\w+) (\w+) (\w+)", printed):
        at, mask = int(offset, 0), int(mask, 0)
        registers[at] = registers[at] & ~mask | int(value, 0) & mask
    return registers


def lss_error(bus, service, value=0):
    bus.send(can.Message(arbitration_id=LSS_MASTER, data=[service, value, *bytes(6)], is_extended_id=False))
    while (message := bus.recv(20.0)) is not None:
        if message.arbitration_id == LSS_SLAVE:
            assert message.data[0] == service
            return message.data[1]
    raise AssertionError("no answer")


def check_that_it_only_talks(bus):
    """No torque, and no page is erased, which the emulated chip would report at the end."""
    for axis in (0, 0x800):
        for controlword in (0x06, 0x07, 0x0F):
            emulated.write(bus, 0x6040 + axis, 0, controlword, 2)
        assert emulated.read(bus, 0x6041 + axis, 0) & 0x4F == 0, "not ready to switch on"
    for sub in (1, 2, 3):
        assert emulated.write(bus, STORE_ALL, sub, SAVE, 4) == HARDWARE_ERROR
    bus.send(can.Message(arbitration_id=LSS_MASTER, data=[*LSS_CONFIGURE, *bytes(6)], is_extended_id=False))
    assert lss_error(bus, LSS_NODE_ID, 7) == 0
    assert lss_error(bus, LSS_STORE) == LSS_STORE_FAILED


@pytest.mark.parametrize("registers, detail, status", [
    (flashed("flash"), None, RAM_PARITY | WRITE_PROTECTION | BANKS),
    (DELIVERED, 3, BANKS),
    (DELIVERED | {0x20: flashed("flash")[0x20]}, 2, RAM_PARITY | BANKS),  # by st-flash
    (flashed("flash") | {0x20: flashed("flash")[0x20] + ONE_BANK}, 4, RAM_PARITY | WRITE_PROTECTION),
    (flashed("flash") | {0x20: flashed("flash")[0x20] + BANK_2}, 4, RAM_PARITY | WRITE_PROTECTION),
], ids=["openocd", "delivered", "st-flash", "one bank", "bank 2"])
def test_a_board_without_its_option_bytes_reports_them(registers, detail, status):
    options = [str(registers[0x20]), str(registers[0x2C])]
    with subprocess.Popen([os.environ["EMULATE_BOARD"], emulated.IMAGE, "--option-bytes", *options, "--until-stdin-ends",
                           "--speed", "0"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as board:
        address = board.stdout.readline().strip().removeprefix("slcan-tcp:")
        assert board.stdout.readline() == "ready\n"
        with emulated.open_bus(address) as bus:
            errors = [emulated.read(bus, 0x1003, entry) & 0xFFFFFFFF for entry in range(1, emulated.read(bus, 0x1003, 0) + 1)]
            assert emulated.read(bus, 0x3061, 1) & (RAM_PARITY | WRITE_PROTECTION | BANKS) == status
            if not status & BANKS:
                check_that_it_only_talks(bus)
        board.stdin.close()
        assert board.wait(timeout=60) == 0
    found = [error >> 16 & 0xFF for error in errors if error & 0xFFFF == OPTION_BYTES_EMCY]
    assert found == ([] if detail is None else [detail]), [hex(error) for error in errors]
