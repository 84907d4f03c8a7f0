#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks an image's flash, RAM and stack against its budget, and that it uses neither heap nor recursion.

    budget.py IMAGE.elf --stack-usage FOLDER --pointers indirect_calls.toml

FOLDER contains the compiler's *.su files. Exit code 1: something is over budget.
"""

import argparse
import dataclasses
import pathlib
import re
import subprocess
import sys
import tomllib

import call_graph

KIB = 1024
FLASH_BUDGET = 192 * KIB
RAM_BUDGET = 80 * KIB
SCOPE_BYTES = 32 * KIB
LEVEL_BUDGET = 4 * KIB

# An exception pushes 26 words with the FPU's registers, and one more to align (ARMv7-M, B1.5.7).
EXCEPTION_FRAME_BYTES = 27 * 4

# Priority, and the code that runs there.
LEVELS = [
    ("driver fault (0)", ["tim1_brk_interrupt", "tim8_brk_interrupt"]),
    ("current loop (1)", ["adc1_2_interrupt"]),
    ("tick (2)", ["tim6_dac_interrupt", "pre_tick_interrupt"]),
    ("CAN (3)", ["fdcan1_it0_interrupt"]),
    ("service (4)", ["pendsv_exception"]),
    ("background", ["reset_handler"]),
]

HEAP = re.compile(r"^_?_?(malloc|calloc|realloc|free|_malloc_r|_free_r|sbrk|_sbrk|_sbrk_r)$")


@dataclasses.dataclass
class Row:
    what: str
    used: int
    budget: int
    note: str = ""


def section_sizes(elf: pathlib.Path) -> dict[str, int]:
    lines = subprocess.run(["arm-none-eabi-size", "-A", str(elf)], check=True, capture_output=True,
                           text=True).stdout.splitlines()
    return {part[0]: int(part[1]) for part in map(str.split, lines) if len(part) == 3 and part[1].isdigit()}


def memory_rows(elf: pathlib.Path) -> list[Row]:
    size = section_sizes(elf)
    flash = sum(size.get(name, 0) for name in (".version_block", ".hot_code", ".text", ".ARM.exidx", ".data")) + 0x200
    ram = sum(size.get(name, 0) for name in (".noinit", ".data", ".bss"))
    return [Row("flash", flash, FLASH_BUDGET),
            Row("static RAM", ram, RAM_BUDGET, f"of which the scope {SCOPE_BYTES}"),
            Row("hot code in CCM RAM", size.get(".hot_code", 0), 32 * KIB),
            Row("RAM with stack", ram + size[".stack"], 96 * KIB, f"the chip's; stack {size['.stack']}")]


def read_stack_usage(folder: pathlib.Path) -> dict[str, int]:
    """From the compiler: the largest frame of any function of this file and name."""
    usage: dict[str, int] = {}
    for file in folder.rglob("*.su"):
        for line in file.read_text(encoding="utf-8").splitlines():
            place, frame, kind = line.split("\t")
            if "dynamic" in kind and "bounded" not in kind:
                raise call_graph.CallGraphError(f"{place}: the stack frame has an unknown size")
            source, _, _, name = place.rsplit(":", 3)
            name = name.split(".")[0]
            for key in (name, f"{pathlib.PurePath(source).name}:{name}"):
                usage[key] = max(usage.get(key, 0), int(frame))
    return usage


def raise_to_compilers_word(functions: dict[int, call_graph.Function], usage: dict[str, int]) -> None:
    """The larger value of compiler and code counts: library functions have only the code."""
    for function in functions.values():
        function.frame_bytes = max(function.frame_bytes, usage.get(call_graph.plain_name(function.name), 0))


def stack_rows(elf: pathlib.Path, usage: dict[str, int], table: dict[str, list[str]]) -> tuple[list[Row], list[str]]:
    functions = call_graph.read_functions(elf)
    raise_to_compilers_word(functions, usage)
    call_graph.resolve_pointers(elf, functions, table)
    address_of = {function.name: address for address, function in functions.items()}
    rows, paths, total = [], [], 0
    for level, roots in LEVELS:
        depth, path = max(call_graph.deepest_path(functions, address_of[root]) for root in roots)
        rows.append(Row(f"stack, {level}", depth, LEVEL_BUDGET))
        paths.append(f"{level}: {' > '.join(path)}")
        total += depth
    total += (len(LEVELS) - 1) * EXCEPTION_FRAME_BYTES
    rows.append(Row("stack, all at once", total, section_sizes(elf)[".stack"], "with exception frames"))
    return rows, paths


def heap_symbols(elf: pathlib.Path) -> list[str]:
    lines = subprocess.run(["arm-none-eabi-nm", str(elf)], check=True, capture_output=True, text=True).stdout.split()
    return sorted({name for name in lines if HEAP.match(name)})


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("elf", type=pathlib.Path)
    parser.add_argument("--stack-usage", type=pathlib.Path, required=True, help="folder of the compiler's *.su files")
    parser.add_argument("--pointers", type=pathlib.Path, required=True, help="targets of calls through pointers")
    parser.add_argument("--paths", action="store_true", help="also print the deepest call chain of each level")
    options = parser.parse_args()
    table = {name: entry["calls"] for name, entry in tomllib.loads(options.pointers.read_text("utf-8")).items()}
    try:
        stack, paths = stack_rows(options.elf, read_stack_usage(options.stack_usage), table)
    except call_graph.CallGraphError as error:
        print(f"budget.py: {error}", file=sys.stderr)
        return 1
    rows = memory_rows(options.elf) + stack
    print(f"{'':32}{'bytes':>8}{'budget':>9}")
    for row in rows:
        verdict = "" if row.used <= row.budget else "  OVER"
        print(f"{row.what:32}{row.used:8}{row.budget:9}{verdict}{'  ' + row.note if row.note else ''}")
    if options.paths:
        print("\n".join(paths))
    heap = heap_symbols(options.elf)
    print(f"heap: {', '.join(heap) if heap else 'none'}; recursion: none")
    return 1 if heap or any(row.used > row.budget for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
