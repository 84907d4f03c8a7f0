# SPDX-License-Identifier: Apache-2.0
"""Registers of the STM32G474 from the crate `stm32g4`: generated Rust (svd2rust), read as text.

    block = read_block(folder, "rcc")
    block["CR"].offset, block["CR"].reset, block["CR"].fields["HSEON"] -> (16, 1)
"""

import dataclasses
import pathlib
import re


@dataclasses.dataclass
class Register:
    offset: int
    reset: int | None = None
    fields: dict[str, tuple[int, int]] = dataclasses.field(default_factory=dict)


_ACCESSOR = re.compile(r"///0x([0-9a-f]+)(?:\.\.0x[0-9a-f]+)? - [^\n]*\n(?:\s*///[^\n]*\n)*(?:\s*#\[[^\n]*\n|\s*///[^\n]*\n)*"
                       r"\s*pub const fn (\w+)\(")
_FIELD = re.compile(r"///Bits? (\d+)(?::(\d+))? - [^\n]*\n(?:\s*///[^\n]*\n)*(?:\s*#\[[^\n]*\n)*\s*pub fn (\w+)\(")
_RESET = re.compile(r"impl crate::Resettable for \w+ \{(?:\s*const RESET_VALUE: u32 = (0x[0-9a-f_]+);)?")


def _read_register(path: pathlib.Path, offset: int) -> Register:
    register = Register(offset)
    text = path.read_text(encoding="utf-8")
    for first, last, name in _FIELD.findall(text):
        register.fields[name.rstrip("_").upper()] = (int(first), int(last or first) - int(first) + 1)
    reset = _RESET.search(text)
    if reset:
        register.reset = int(reset[1] or "0", 16)
    return register


def read_block(folder: pathlib.Path, name: str) -> dict[str, Register]:
    """The registers of one block by name, as "CR" or "CH1.CR" where the block is made of equal parts."""
    registers: dict[str, Register] = {}
    for offset_text, accessor in _ACCESSOR.findall((folder / f"{name}.rs").read_text(encoding="utf-8")):
        path = folder / name / f"{accessor}.rs"
        offset = int(offset_text, 16)
        if path.is_file() and "RegisterSpec" in path.read_text(encoding="utf-8"):
            registers[accessor.upper()] = _read_register(path, offset)
        else:
            registers[accessor.upper()] = Register(offset)  # an element of an array
    return registers


def read_addresses(folder: pathlib.Path) -> dict[str, int]:
    """Base address of each peripheral."""
    text = (folder / "mod.rs").read_text(encoding="utf-8")
    found = re.findall(r"pub type (\w+) = crate::Periph<[^,]+, 0x([0-9a-f_]+)>", text)
    return {name: int(address, 16) for name, address in found}


def read_interrupts(folder: pathlib.Path) -> dict[str, int]:
    text = (folder / "mod.rs").read_text(encoding="utf-8")
    return {name: int(number) for name, number in re.findall(r"^    (\w+) = (\d+),$", text, re.MULTILINE)}


def elements_of(block: dict[str, Register], member: str) -> list[Register | None]:
    """The crate's counterpart of a member of our struct: one register, or the elements of an array."""
    name = member.upper()
    arrays = {"AFR": ["AFRL", "AFRH"], "CCR": [], "CH": [f"CH{n}" for n in range(1, 9)]}
    if name in arrays and arrays[name] and all(part in block for part in arrays[name]):
        return [block[part] for part in arrays[name]]
    register = block.get(name)
    without_number = block.get(name.rstrip("0123456789"))
    if register and register.reset is None and without_number and without_number.reset is not None:
        register = Register(register.offset, without_number.reset, without_number.fields)
    return [register]


def read_variant(path: pathlib.Path, field: str, variant: str) -> int | None:
    """The number of a field's named value."""
    enumeration = re.search(rf"pub enum {field} \{{(.*?)^\}}", path.read_text("utf-8"), re.DOTALL | re.MULTILINE)
    found = enumeration and re.search(rf"^\s+{variant} = (\d+),$", enumeration[1], re.MULTILINE)
    return int(found[1]) if found else None
