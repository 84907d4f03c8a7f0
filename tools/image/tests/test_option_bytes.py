# SPDX-License-Identifier: Apache-2.0
"""Option bytes: what tools/image/board writes to a chip as delivered and to one that is already protected."""

import pathlib
import re
import shlex
import struct
import subprocess
import sys

import pytest

import option_bytes

PROJECT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(PROJECT / "tools/registers"))

import crate_registers  # noqa: E402

IMAGE = PROJECT / "build/stm32g474/bin/trackservo"
DELIVERED = {0x20: 0xFFEFF8AA, 0x2C: 0xFF00FFFF, 0x30: 0xFF00FFFF}
FIRST_PARAMETER_BYTE = 0x7B000


@pytest.fixture(name="crate", scope="session")
def fixture_crate() -> dict[str, crate_registers.Register]:
    return crate_registers.read_block(PROJECT / "third_party/stm32g4/registers", "flash")


def dry_run(runner: str, action: str) -> list[list[str]]:
    """The commands that the script would run."""
    printed = subprocess.run([PROJECT / "tools/image/board", "--dry-run", runner, action, IMAGE], check=True,
                             capture_output=True, text=True).stdout
    return [shlex.split(line) for line in printed.splitlines() if line.startswith("'")]


class Refused(Exception):
    """OpenOCD ends with this error, and the script with it."""


class Chip:
    """The chip's option registers and its flash, as OpenOCD changes them: they count from the next loading on."""

    def __init__(self, registers: dict[int, int]):
        self.written, self.loaded = dict(registers), dict(registers)
        self.done: list[str] = []

    def protected_pages(self) -> range:
        first, last = self.loaded[0x2C] & 0x7F, self.loaded[0x2C] >> 16 & 0x7F
        return range(first, last + 1)

    def run(self, commands: list[list[str]]) -> None:
        for command in commands:
            for part in [part for part in command if part not in ("openocd", "-f", "-c") and not part.endswith(".cfg")]:
                self._script(part)

    def _script(self, script: str) -> None:
        for step in re.split(r"; (?![^{]*\})", script):
            if write := re.fullmatch(r"stm32l4x option_write 0 (\w+) (\w+) (\w+)", step):
                offset, value, mask = (int(text, 0) for text in write.groups())
                self.written[offset] = self.written[offset] & ~mask | value & mask
            elif step == "flash protect 0 0 last off":
                self.written[0x2C] = self.written[0x30] = 0x00000001
            elif step == "catch {stm32l4x option_load 0}":
                self.loaded = dict(self.written)
            elif step.startswith(("program ", "flash erase_sector 0 ")):
                assert not self.protected_pages(), f"{step}: write-protected pages"
                self.done.append(step.split()[0] if step.startswith("program") else "erase")
            elif condition := re.match(r"if \{\(\[mrw 0x40022020\] & (\w+)\) != (\w+) \|\| \(\[mrw 0x4002202C\] & (\w+)\) != (\w+)\}",
                                       step):
                mask, value, wrp_mask, wrp = (int(text, 0) for text in condition.groups())
                assert (self.loaded[0x20] & mask, self.loaded[0x2C] & wrp_mask) == (value, wrp), step
                self.done.append("verify")
            elif condition := re.fullmatch(r"if \{\(\[mrw 0x40022020\] & (\w+)\) != (\w+)\} \{error \{(.*)\}\}", step):
                mask, value = int(condition[1], 0), int(condition[2], 0)
                if self.loaded[0x20] & mask != value:
                    raise Refused(condition[3])
            else:
                assert step in ("init", "reset halt", "reset run", "exit"), step


def set_fields(register: crate_registers.Register, value: int, **fields: int) -> int:
    for name, content in fields.items():
        first, width = register.fields[name]
        value = value & ~(((1 << width) - 1) << first) | content << first
    return value


def test_registers_lie_where_the_crate_says(crate):
    assert (crate["OPTR"].offset, crate["WRP1AR"].offset, crate["WRP1BR"].offset) == (0x20, 0x2C, 0x30)


OTHER_BANKS = [{"DBANK": 0}, {"BFB2": 1}, {"BFB2": 1, "DBANK": 0}]
OTHER_BITS = {"BOR_LEV": 4, "N_SWBOOT0": 0, "N_BOOT0": 1, "IWDG_STDBY": 0}


@pytest.mark.parametrize("other", [{}, OTHER_BITS])
def test_openocd_sets_the_parity_and_nothing_else(crate, other):
    optr = set_fields(crate["OPTR"], DELIVERED[0x20], **other)
    chip = Chip(DELIVERED | {0x20: optr})
    chip.run(dry_run("openocd", "flash"))
    assert chip.done == ["program", "verify"]
    # The crate calls the parity of the RAM SRAM2_PE. It is on when the bit is 0.
    assert chip.loaded[0x20] == set_fields(crate["OPTR"], optr, SRAM2_PE=0)


@pytest.mark.parametrize("banks", OTHER_BANKS)
@pytest.mark.parametrize("action", ["flash", "protect"])
def test_a_chip_with_other_banks_is_refused_and_left_as_it_is(crate, banks, action):
    chip = Chip(DELIVERED | {0x20: set_fields(crate["OPTR"], DELIVERED[0x20], **banks)})
    before = dict(chip.written)
    with pytest.raises(Refused, match="one bank"):
        chip.run(dry_run("openocd", action))
    assert (chip.written, chip.loaded, chip.done) == (before, before, [])
    with pytest.raises(ValueError, match="one bank, or starts from bank 2"):
        option_bytes.patched(copy_of(before), option_bytes.WRP_NONE)
    with pytest.raises(ValueError, match="one bank, or starts from bank 2"):
        option_bytes.check_banks(copy_of(before)[:4])


@pytest.mark.parametrize("banks", OTHER_BANKS)
def test_options_changes_the_banks_and_erases_what_lay_in_others(crate, banks):
    optr = set_fields(crate["OPTR"], DELIVERED[0x20], **OTHER_BITS, **banks)
    chip = Chip(DELIVERED | {0x20: optr})
    chip.run(dry_run("openocd", "options"))
    assert chip.done == ["erase"]
    assert chip.loaded[0x20] == set_fields(crate["OPTR"], optr, DBANK=1, BFB2=0)
    changed = option_bytes.patched(copy_of(DELIVERED | {0x20: optr}), option_bytes.WRP_NONE, banks=True)
    assert struct.unpack_from("<I", changed)[0] == set_fields(crate["OPTR"], optr, SRAM2_PE=0, DBANK=1, BFB2=0)
    assert dry_run("stlink", "options")[1][-1] == "erase"


def test_options_asks_before_it_erases():
    for answer in ("", "n\n", "no\n"):
        ended = subprocess.run([PROJECT / "tools/image/board", "openocd", "options", IMAGE], input=answer, capture_output=True,
                               text=True)
        assert ended.returncode != 0 and "nothing was changed" in ended.stderr


def test_openocd_protects_the_pages_of_the_image_and_no_other():
    chip = Chip(DELIVERED)
    chip.run(dry_run("openocd", "flash"))
    size = IMAGE.with_suffix(".bin").stat().st_size
    assert chip.protected_pages() == range(0, -(-size // 2048))
    assert len(chip.protected_pages()) * 2048 <= FIRST_PARAMETER_BYTE


def test_a_protected_chip_is_flashed_again_and_erased():
    chip = Chip(DELIVERED)
    for action in ("flash", "flash", "erase"):
        chip.run(dry_run("openocd", action))
    assert chip.done == ["program", "verify", "program", "verify", "erase"]
    assert not chip.protected_pages()


@pytest.mark.parametrize("action", ["flash", "erase", "protect", "unprotect"])
def test_the_read_protection_changes_by_lock_and_unlock_alone(action):
    commands = " ".join(" ".join(command) for command in dry_run("openocd", action))
    assert "lock" not in commands
    assert not option_bytes.OPTR_MASK & 0xFF
    assert "stm32l4x lock 0" in dry_run("openocd", "lock")[0][-1]


def test_st_flash_writes_what_the_chip_was_delivered_with_and_the_parity_on(crate):
    _read, _check, flash, _read, _check, option = dry_run("stlink", "flash")
    assert flash[:3] == ["st-flash", "--reset", "write"]
    assert option == ["st-flash", "--area=option", "write", f"0x{set_fields(crate['OPTR'], DELIVERED[0x20], SRAM2_PE=0):08X}"]


def copy_of(registers: dict[int, int]) -> bytes:
    """The chip's option bytes: each word and its complement; the two words of PCROP are without effect here."""
    words = [registers[0x20], 0xFFFFFFFF, 0xFFFF0000, registers[0x2C], registers[0x30]]
    return b"".join(struct.pack("<II", word, ~word & 0xFFFFFFFF) for word in words)


def test_the_copy_for_the_boot_loader_has_the_registers_of_openocd():
    chip = Chip(DELIVERED)
    chip.run(dry_run("openocd", "flash"))
    protection = option_bytes.write_protection(IMAGE.with_suffix(".bin").stat().st_size)
    patched = option_bytes.patched(copy_of(DELIVERED), protection)
    words = struct.unpack("<10I", patched)
    assert all(word ^ complement == 0xFFFFFFFF for word, complement in zip(words[::2], words[1::2]))
    assert words[0] == chip.loaded[0x20] and words[2:6] == struct.unpack("<10I", copy_of(DELIVERED))[2:6]
    assert words[6] & 0x7F007F == chip.loaded[0x2C] & 0x7F007F
    assert words[8] & 0x7F > words[8] >> 16 & 0x7F, "area B protects pages"


def test_the_boot_loader_removes_the_write_protection_before_it_writes():
    programs = [(command[0], command[-1]) for command in dry_run("dfu", "flash")]
    names = [pathlib.Path(last).name for program, last in programs if program in ("python3", "dfu-util")]
    assert names == ["option_bytes.bin"] * 3 + ["trackservo.bin"] + ["option_bytes.bin", "trackservo.bin", "option_bytes.bin"]
    unprotected = option_bytes.patched(copy_of(DELIVERED | {0x2C: 0x004B0000}), option_bytes.WRP_NONE)
    assert struct.unpack_from("<I", unprotected, 0x18)[0] & 0x7F007F == 0x7F


@pytest.mark.parametrize("damaged, sentence", [
    (copy_of(DELIVERED)[:-4], "expected 40 option bytes, got 36"),
    (bytes([0xAB]) + copy_of(DELIVERED)[1:], "an option byte and its complement differ"),
    (copy_of(DELIVERED | {0x20: 0xFFEFF8BB}), "the flash is read-protected"),
])
def test_a_copy_that_could_lock_the_chip_is_refused(damaged, sentence):
    with pytest.raises(ValueError, match=sentence):
        option_bytes.patched(damaged, option_bytes.WRP_NONE)


@pytest.mark.parametrize("size", [0, 128 * 2048 + 1])
def test_an_image_beyond_bank_1_is_refused(size):
    with pytest.raises(ValueError, match="does not fit into bank 1"):
        option_bytes.write_protection(size)
