#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares the board's register definitions and pin table with public descriptions of the chip.

    check_registers.py [--crates FOLDER] [--headers FOLDER]

Compares every register (offset, value after reset), field (position, width), address, interrupt number, DMA request and
pin of hal/chips/stm32g4 and of its boards. A definition without counterpart is an error, unless exceptions.toml gives a reason. The definitions
are compiled for the host, not parsed, so that the comparison uses the values that the firmware gets.
"""

import argparse
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib

import core_registers
import crate_registers
import pin_functions

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = pathlib.Path(__file__).resolve().parent

# The crate's blocks that one of our structs describes.
BLOCKS = {"gpio": ["gpioa", "gpiob", "gpioc"], "dma_ch": ["dma1/ch"]}
CORE = {"nvic", "scb", "mpu", "dwt", "dcb"}


class Definitions:
    """Definitions in the headers: structs by name, macros, enumerators, all as the compiler sees them."""

    def __init__(self, headers: pathlib.Path):
        self.headers = headers
        self.text = "".join(file.read_text("utf-8") for file in sorted(headers.glob("*.h")))
        self.structs = {name: self._members(body) for body, name in
                        re.findall(r"typedef struct \{([^}]*)\} (\w+)_registers;", self.text)}
        self.addresses = {name: (block, int(address, 16)) for name, block, address in
                          re.findall(r"#define (\w+) \(\((\w+)_registers \*\)0x([0-9A-F]+)u\)", self.text)}
        constants = re.findall(r"#define ([A-Z]\w+) (?!\(\()[^\n]+", self.text)
        enumerators = re.findall(r"\b([A-Z][A-Z0-9_]+) = ", self.text)
        self.values = self._compile([name for name in constants if not name.startswith("TRACKSERVO")] + enumerators)

    @staticmethod
    def _members(body: str) -> dict[str, str]:
        """Name, and how its first element is written."""
        code = re.sub(r"/\*.*?\*/", "", body, flags=re.DOTALL)
        return {name: f"{name}[0]" if array else name for name, array in re.findall(r"\b(\w+)(\[\d+\])?;", code)
                if not name.startswith("reserved_")}

    def _compile(self, names: list[str]) -> dict[str, int]:
        """Values of the names, offsets as "struct.member", and of arrays the distance of elements as "struct.member.stride"."""
        lines = ["#include <stdio.h>"] + [f'#include "registers/{file.name}"' for file in sorted(self.headers.glob("*.h"))]
        lines.append("int main(void) {")
        lines += [f'printf("{name} %lu\\n", (unsigned long)(uint32_t)({name}));' for name in names]
        for block, members in self.structs.items():
            for member, element in members.items():
                lines.append(f'printf("{block}.{member} %zu\\n", offsetof({block}_registers, {member}));')
                lines.append(f'printf("{block}.{member}.stride %zu\\n", sizeof((({block}_registers *)0)->{element}));')
        lines.append("return 0; }")
        with tempfile.TemporaryDirectory() as folder:
            source, program = pathlib.Path(folder, "values.c"), pathlib.Path(folder, "values")
            source.write_text("\n".join(lines), "utf-8")
            subprocess.run(["cc", "-std=c11", f"-I{self.headers.parent}", "-o", program, source], check=True)
            printed = subprocess.run([program], check=True, capture_output=True, text=True).stdout
        return {name: int(value) for name, value in map(str.split, printed.splitlines())}


class Check:
    def __init__(self, definitions: Definitions, crates: pathlib.Path, exceptions: dict[str, dict]):
        self.ours = definitions
        self.crates = crates
        self.exceptions = exceptions
        self.unused_exceptions = set(exceptions)
        self.compared = 0
        self.wrong: list[str] = []
        self.known: set[str] = set()  # names that were compared

    def compare(self, name: str, ours: int, theirs: int | None) -> None:
        self.known.add(name)
        if name in self.exceptions:
            self.unused_exceptions.discard(name)
            theirs = self.exceptions[name]["value"]
        if theirs is None:
            self.wrong.append(f"{name}: not in the crates; add its value and the reason to exceptions.toml")
        elif ours != theirs:
            self.wrong.append(f"{name}: ours {ours:#x}, theirs {theirs:#x}")
        else:
            self.compared += 1

    def block(self, name: str) -> None:
        for source in BLOCKS.get(name, [name]):
            theirs = crate_registers.read_block(self.crates / "registers", source)
            prefix = source.upper().replace("DMA1/CH", "DMA_CH")
            for member in self.ours.structs[name]:
                for index, element in enumerate(crate_registers.elements_of(theirs, member)):
                    self.register(name, prefix, member, index, element)

    def register(self, block: str, prefix: str, member: str, index: int, theirs: crate_registers.Register | None) -> None:
        name = f"{prefix}_{member.upper()}"
        if theirs is None:
            self.wrong.append(f"{name}: not in the crate")
            return
        offset, stride = self.ours.values[f"{block}.{member}"], self.ours.values[f"{block}.{member}.stride"]
        self.compare(f"{name} offset {index}", offset + stride * index, theirs.offset)
        if index == 0:
            if theirs.reset is not None or f"{name}_RESET" in self.exceptions:
                self.compare(f"{name}_RESET", self.ours.values.get(f"{name}_RESET", 0), theirs.reset)
            for macro in [macro for macro in self.ours.values if macro.startswith(f"{name}_") and macro != f"{name}_RESET"]:
                self.field(macro, macro.removeprefix(f"{name}_"), theirs)

    def field(self, macro: str, field: str, theirs: crate_registers.Register) -> None:
        if field in theirs.fields:
            position, width = theirs.fields[field]
            self.compare(macro, self.ours.values[macro], ((1 << width) - 1) << position)
        elif macro in self.exceptions:
            self.compare(macro, self.ours.values[macro], None)

    def addresses(self) -> None:
        theirs = crate_registers.read_addresses(self.crates / "registers") | core_registers.read_addresses(self.crates / "core")
        for name, (_, address) in self.ours.addresses.items():
            self.compare(f"{name} address", address, theirs.get(name))

    def core(self) -> None:
        for block in sorted(CORE):
            theirs = core_registers.read_offsets(self.crates / "core" / f"{block}.rs")
            for member in self.ours.structs[block]:
                self.compare(f"{block}.{member}", self.ours.values[f"{block}.{member}"], theirs.get(member))

    def interrupts(self, header: pathlib.Path) -> None:
        theirs = crate_registers.read_interrupts(self.crates / "registers")
        for name, number in re.findall(r"(\w+)_INTERRUPT = (\d+)", header.read_text("utf-8")):
            crate_name = "TIM6_DACUNDER" if name == "TIM6_DAC" else {"TIM1_BRK": "TIM1_BRK_TIM15"}.get(name, name)
            self.compare(f"{name}_INTERRUPT", int(number), theirs.get(crate_name))

    def named_values(self, table: dict[str, list[str]]) -> None:
        for name, (block, register, field, variant) in table.items():
            theirs = crate_registers.read_variant(self.crates / "registers" / block / f"{register}.rs", field, variant)
            self.compare(name, self.ours.values[name], theirs)

    def requests(self) -> None:
        theirs = pin_functions.read_dma_requests(self.crates / "pins")
        for name, value in self.ours.values.items():
            if name.startswith("DMAMUX_") and not name.startswith("DMAMUX_CCR"):
                self.compare(name, value, theirs.get(name.removeprefix("DMAMUX_")))

    def pins(self, source: pathlib.Path, uses: dict[str, str]) -> None:
        ours = pin_functions.read_our_pins(source)
        theirs = pin_functions.read_functions(self.crates / "pins")
        for pin, function in ours.items():
            use = uses.get(pin)
            if use is None:
                self.wrong.append(f"{pin}: missing in values.toml")
            elif (pin, use) not in theirs:
                self.wrong.append(f"{pin}: not known to the crate as {use}")
            else:
                self.compare(f"{pin} as {use}", function, theirs[pin, use])

    def everything_was_compared(self) -> None:
        for name in self.ours.values:
            if "." not in name and name not in self.known:
                self.compare(name, self.ours.values[name], None)
        self.wrong += [f"exceptions.toml: {name} is not needed" for name in sorted(self.unused_exceptions)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--crates", type=pathlib.Path, default=ROOT / "third_party/stm32g4")
    parser.add_argument("--headers", type=pathlib.Path, default=ROOT / "hal/chips/stm32g4/registers")
    parser.add_argument("--pins", type=pathlib.Path, default=ROOT / "hal/boards/nucleo_g474/pins.c")
    options = parser.parse_args()
    if not options.crates.is_dir():
        print(f"check_registers.py: no crates in {options.crates}: run ./tools/setup test.", file=sys.stderr)
        return 2
    tables = tomllib.loads((HERE / "values.toml").read_text("utf-8"))
    exceptions = tomllib.loads((HERE / "exceptions.toml").read_text("utf-8"))
    check = Check(Definitions(options.headers), options.crates, exceptions)
    for block in check.ours.structs:
        if block not in CORE:
            check.block(block)
    check.core()
    check.addresses()
    check.interrupts(options.headers.parent / "interrupts.h")
    check.named_values(tables["values"])
    check.requests()
    check.pins(options.pins, tables["pins"])
    check.everything_was_compared()
    for line in check.wrong:
        print(line)
    print(f"{check.compared} register and pin facts match, {len(check.wrong)} do not.")
    return 1 if check.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
