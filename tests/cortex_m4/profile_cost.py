#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Distribution of the instructions of the 1 kHz task: cost_node, executed by Unicorn.

    build/venv/bin/python tests/cortex_m4/profile_cost.py [IMAGE] [--mode 'cyclic velocity'] [--entry NAME]
        [--worst] [--least N]

IMAGE is build/cortex-m4-qemu/bin/cost_node. It prints the instructions of an average tick (--entry servo_node_serve: of
the deferred task after it) of each row of cost_node, or of the worst tick: by folder, by file and by function of the
source, an inlined function counted separately.
"""

import argparse
import collections
import pathlib
import struct
import subprocess

import unicorn
from unicorn import arm_const as arm

MODES = ["cyclic velocity", "cyclic position", "cyclic torque", "profile velocity", "profile position", "tracking"]
WARM_UP_TICKS = 601  # cost_node's, and the tick before the node is started
COUNTED_TICKS = 2000
TICKS_OF_MODE = WARM_UP_TICKS + COUNTED_TICKS
EXIT_OPERATIONS = (0x18, 0x20)


def run(*words: str) -> str:
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout


class Image:
    """The program in memory, with names for its addresses."""

    def __init__(self, elf: pathlib.Path):
        self.elf = elf
        self.symbols = {}
        for line in run("arm-none-eabi-nm", "--defined-only", str(elf)).splitlines():
            word = line.split()
            if len(word) == 3 and word[1] in "tT" and not word[2].startswith("$"):
                self.symbols[int(word[0], 16) & ~1] = word[2]
        self.address = {name: address for address, name in self.symbols.items()}
        self.segments = list(self.loaded(elf.read_bytes()))
        self.bytes = next(data for address, data in self.segments if address == 0)

    @staticmethod
    def loaded(file: bytes):
        """Address and bytes of each segment that is loaded (ELF32, little endian)."""
        table, size, count = struct.unpack_from("<I", file, 28)[0], *struct.unpack_from("<HH", file, 42)
        for i in range(count):
            kind, offset, address, _, length = struct.unpack_from("<5I", file, table + i * size)
            if kind == 1 and length:
                yield address, file[offset:offset + length]

    def name_addresses(self, addresses) -> dict[int, tuple[str, str]]:
        """Function and source file of each address."""
        ordered = sorted(addresses)
        text = subprocess.run(["arm-none-eabi-addr2line", "-f", "-e", str(self.elf)], check=True, capture_output=True,
                              text=True, input="\n".join(hex(a) for a in ordered)).stdout.splitlines()
        return {a: (text[2 * i], text[2 * i + 1].rsplit(":", 1)[0]) for i, a in enumerate(ordered)}

    def instructions(self, start: int, size: int) -> list[int]:
        """Addresses of the Thumb instructions in [start, start + size)."""
        found, at = [], start
        while at < start + size:
            found.append(at)
            halfword = self.bytes[at] | self.bytes[at + 1] << 8
            at += 4 if halfword >> 11 >= 0x1D else 2
        return found


class Machine:
    """QEMU's board as far as cost_node uses it: memory, a system control space that stores written values,
    semihosting."""

    def __init__(self, image: Image, entry: str, wanted_ticks: range):
        self.image = image
        self.wanted_ticks = wanted_ticks
        self.tick = 0
        self.uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        self.uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M4)
        self.uc.mem_map(0, 4 << 20)
        self.uc.mem_map(0x20000000, 4 << 20)
        self.uc.mem_map(0xE000E000, 0x1000)
        for address, data in image.segments:
            self.uc.mem_write(address, data)
        self.ended = False
        self.entry = image.address[entry]
        self.uc.hook_add(unicorn.UC_HOOK_INTR, lambda uc, number, data: uc.emu_stop())
        self.uc.hook_add(unicorn.UC_HOOK_BLOCK, self.on_block)
        self.blocks = None
        self.return_to = 0
        self.ticks = []

    def on_block(self, uc, address, size, data):
        if self.blocks is not None:
            if address == self.return_to:
                self.ticks.append(self.blocks)
                self.blocks = None
            else:
                self.blocks[address, size] += 1
        elif address == self.entry:
            self.tick += 1
            if self.tick == self.wanted_ticks.stop:
                self.ended = True
                uc.emu_stop()
            if self.tick not in self.wanted_ticks:
                return
            self.blocks = collections.Counter({(address, size): 1})
            self.return_to = uc.reg_read(arm.UC_ARM_REG_LR) & ~1

    def semihost(self, operation: int, argument: int) -> int:
        if operation in EXIT_OPERATIONS:
            self.ended = True
        if operation == 0x15:  # the command line: none
            line = int.from_bytes(self.uc.mem_read(argument, 4), "little")
            self.uc.mem_write(line, b"\0")
        return {0x01: 1, 0x09: 1}.get(operation, 0)

    def execute(self) -> None:
        words = [int.from_bytes(self.image.bytes[i:i + 4], "little") for i in (0, 4)]
        self.uc.reg_write(arm.UC_ARM_REG_SP, words[0])
        pc = words[1]
        while not self.ended:
            self.uc.emu_start(pc | 1, 0xFFFFFFFE)
            pc = self.uc.reg_read(arm.UC_ARM_REG_PC)
            answer = self.semihost(self.uc.reg_read(arm.UC_ARM_REG_R0), self.uc.reg_read(arm.UC_ARM_REG_R1))
            self.uc.reg_write(arm.UC_ARM_REG_R0, answer)
            pc += 2 if self.image.bytes[pc & ~1:(pc & ~1) + 2] == b"\xab\xbe" else 0


def count(image: Image, blocks) -> collections.Counter:
    by_address = collections.Counter()
    for (start, size), times in blocks.items():
        for address in image.instructions(start, size):
            by_address[address] += times
    return by_address


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("image", nargs="?", type=pathlib.Path,
                        default=pathlib.Path("build/cortex-m4-qemu/bin/cost_node"))
    parser.add_argument("--mode", help="only this row, as in 'cyclic velocity'")
    parser.add_argument("--entry", default="servo_node_tick", help="function of which one run is a tick")
    parser.add_argument("--worst", action="store_true")
    parser.add_argument("--least", type=int, default=20, help="leave out what takes fewer instructions")
    options = parser.parse_args()
    image = Image(options.image)
    for i, mode in enumerate(MODES):
        if options.mode not in (None, mode):
            continue
        first = 1 + i * TICKS_OF_MODE + WARM_UP_TICKS
        machine = Machine(image, options.entry, range(first, first + COUNTED_TICKS))
        machine.execute()
        ticks = machine.ticks
        counts = [count(image, blocks) for blocks in ticks]
        totals = [sum(c.values()) for c in counts]
        chosen, runs = sum(counts, collections.Counter()), len(counts)
        if options.worst:
            chosen, runs = counts[totals.index(max(totals))], 1
        names = image.name_addresses(chosen)
        tables = {"folder": collections.Counter(), "file": collections.Counter(), "function": collections.Counter()}
        for address, n in chosen.items():
            function, path = names[address]
            folder, file = (["", *path.split("/")])[-2:]
            tables["folder"][folder] += n
            tables["file"][f"{folder}/{file}"] += n
            tables["function"][function] += n
        print(f"{mode}: mean {sum(totals) / len(totals):.0f}, worst {max(totals)}")
        for kind, table in tables.items():
            print(f"  by {kind}")
            for name, n in table.most_common():
                if n / runs >= options.least:
                    print(f"  {n / runs:7.0f}  {name or 'the C library'}")


if __name__ == "__main__":
    main()
