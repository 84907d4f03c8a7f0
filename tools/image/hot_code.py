#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Links an image with its hot code in the RAM from which the processor fetches without waiting.

    hot_code.py --script hot_code.ld --pointers indirect_calls.toml -- LINK COMMAND ... -o IMAGE.elf ...

The linker script includes SCRIPT, which names the functions of that RAM. The hot code is what the interrupts of ROOTS
can call, in this order and nearest first, as far as the RAM has room. It is read from the linked image: the command runs
again when the image calls other functions than SCRIPT names. The code of a function does not depend on its place, so the
second image calls the same functions.
"""

import bisect
import pathlib
import re
import subprocess
import sys
import tomllib
from typing import Callable

import call_graph

# The most urgent first. Handlers of faults are not among them: they must work when this RAM does not.
ROOTS = ["adc1_2_interrupt", "tim1_brk_interrupt", "tim8_brk_interrupt", "tim6_dac_interrupt", "pre_tick_interrupt",
         "fdcan1_it0_interrupt"]

# Of 32 KiB; the rest is for the linker's jumps between this RAM and the flash: 24 bytes today.
LIMIT_BYTES = 32 * 1024 - 128

NOTHING = "/* nothing yet */\n"

SECTION = re.compile(r"^ (\.text\S*)\s+0x([0-9a-f]+)\s+0x([0-9a-f]+) (.+)$", re.MULTILINE)


def option(command: list[str], name: str) -> pathlib.Path:
    return pathlib.Path(command[command.index(name) + 1])


def map_of(command: list[str]) -> pathlib.Path:
    return next(pathlib.Path(word.removeprefix("-Wl,-Map=")) for word in command if word.startswith("-Wl,-Map="))


def read_sections(link_map: pathlib.Path) -> dict[int, tuple[str, int, str]]:
    """Name, bytes and file of each input section of code, by address."""
    text = re.sub(r"^( \.text\S+)\n +", r"\1 ", link_map.read_text("utf-8"), flags=re.MULTILINE)  # long names stand alone
    return {int(address, 16): (name, int(size, 16), file) for name, address, size, file in SECTION.findall(text)
            if int(address, 16) != 0 and int(size, 16) != 0}


def pattern_of(name: str, file: str) -> str:
    """How the linker script selects a section: that of a library by its member, since it is often just ".text"."""
    member = re.search(r"([\w.+-]+)\(([\w.+-]+)\)$", file)
    return f"*{member[1]}:{member[2]}({name})" if member and name == ".text" else f"*({name})"


def reachable(functions: dict[int, call_graph.Function], root: int, place: Callable[[int], tuple[str, int]]) -> list[int]:
    """All that `root` can call, itself first, nearest first; equally near ones in the order of `place`."""
    found = [root]
    known = {root}
    layer = [root]
    while layer:
        layer = sorted({callee for caller in layer for callee in functions[caller].calls} - known, key=place)
        known.update(layer)
        found += layer
    return found


def select(elf: pathlib.Path, link_map: pathlib.Path, table: dict[str, list[str]]) -> tuple[list[str], int]:
    """What the script shall name, and its bytes."""
    functions = call_graph.read_functions(elf)
    call_graph.resolve_pointers(elf, functions, table)
    by_name = {function.name: address for address, function in functions.items()}
    sections = read_sections(link_map)
    starts = sorted(sections)

    def section_of(address: int) -> int:
        return starts[bisect.bisect_right(starts, address) - 1]

    def place(address: int) -> tuple[str, int]:
        """The same wherever the section lies."""
        start = section_of(address)
        return pattern_of(sections[start][0], sections[start][2]), address - start

    chosen: set[str] = set()
    used = 0
    patterns = []
    for address in (found for root in ROOTS for found in reachable(functions, by_name[root], place)):
        pattern = place(address)[0]
        room = (sections[section_of(address)][1] + 7) // 8 * 8
        if pattern not in chosen and used + room <= LIMIT_BYTES:
            patterns.append(pattern)
            used += room
        chosen.add(pattern)
    return patterns, used


def main() -> int:
    split = sys.argv.index("--")
    own, command = sys.argv[1:split], sys.argv[split + 1:]
    script, pointers = option(own, "--script"), option(own, "--pointers")
    table = {name: entry["calls"] for name, entry in tomllib.loads(pointers.read_text("utf-8")).items()}
    if not script.exists():
        script.write_text(NOTHING, "utf-8")
    for _ in range(4):
        linked = subprocess.run(command, check=False, stderr=subprocess.PIPE, text=True)
        if linked.returncode != 0 and script.read_text("utf-8") != NOTHING:
            script.write_text(NOTHING, "utf-8")  # code that has grown since the last link does not fit any more
            continue
        print(linked.stderr, end="", file=sys.stderr)
        if linked.returncode != 0:
            return linked.returncode
        try:
            patterns, used = select(option(command, "-o"), map_of(command), table)
        except (call_graph.CallGraphError, KeyError) as error:
            print(f"hot_code.py: {error}", file=sys.stderr)
            return 1
        text = f"/* {used} bytes of hot code, by tools/image/hot_code.py */\n" + "".join(f"{line}\n" for line in patterns)
        if text == script.read_text("utf-8"):
            return 0
        script.write_text(text, "utf-8")
    print("hot_code.py: the functions of the image change with the place of its code", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
