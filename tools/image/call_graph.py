# SPDX-License-Identifier: Apache-2.0
"""The call graph of an image, and the stack of each function, read from the machine code.

Functions are identified by their name, local ones with their file: "servo_node.c:reset". Calls through a pointer cannot
be read from the code: a table lists their targets, and a call that it does not list is an error. The table names the
functions of the source; the debug information shows into which function of the image one of them was inlined.
"""

import bisect
import dataclasses
import pathlib
import re
import subprocess


@dataclasses.dataclass
class Function:
    name: str
    frame_bytes: int = 0
    calls: set[int] = dataclasses.field(default_factory=set)  # addresses
    pointer_calls: list[int] = dataclasses.field(default_factory=list)  # their places


class CallGraphError(Exception):
    """Facts that the machine code does not show, and forbidden calls."""


_VARIANT = re.compile(r"\.(isra|part|constprop|lto_priv|cold)(\.\d+)?")
_CODE_LINE = re.compile(r"^ *([0-9a-f]+):\t[0-9a-f ]+\t(\S+)(?:\t(.*))?$")
_TARGET = re.compile(r"^([0-9a-f]+) <")
_VENEER = re.compile(r"^__(.+)_veneer$")
_BRANCH = re.compile(r"^(bl|b|b(?:eq|ne|cs|cc|mi|pl|vs|vc|hi|ls|ge|lt|gt|le|lr)?)(?:\.[nw])?$")


def _run(*command: str) -> list[str]:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()


def plain_name(name: str) -> str:
    """Without the suffix that the compiler adds to a function that it has changed."""
    return _VARIANT.sub("", name)


def source_functions(elf: pathlib.Path, addresses: list[int]) -> dict[int, list[str]]:
    """The functions of the source at an address, "file.c:name": the innermost of those inlined there first."""
    found: dict[int, list[str]] = {address: [] for address in addresses}
    lines = subprocess.run(["arm-none-eabi-addr2line", "-a", "-f", "-i", "-e", str(elf)], check=True, text=True,
                           capture_output=True, input="".join(f"{address:x}\n" for address in addresses)).stdout
    address, name = 0, ""
    for line in lines.splitlines():
        if line.startswith("0x"):
            address, name = int(line, 16), ""
        elif not name:
            name = line
        else:
            found[address].append(f"{pathlib.PurePath(line.rsplit(':', 1)[0]).name}:{name}")
            name = ""
    return found


def read_symbols(elf: pathlib.Path) -> dict[int, str]:
    """Name of the function at each address."""
    names: dict[int, str] = {}
    local: dict[int, str] = {}
    for line in _run("arm-none-eabi-readelf", "--syms", "--wide", str(elf)):
        part = line.split()
        if len(part) == 8 and part[3] == "FUNC":
            address = int(part[1], 16) & ~1
            (names if part[4] == "GLOBAL" else local)[address] = part[7]
    names.update({address: name for address, name in local.items() if _VENEER.match(name)})
    # Functions optimised across files have no file in the symbol table.
    only_local = sorted(address for address in local if address not in names)
    for address, sources in source_functions(elf, only_local).items():
        names[address] = f"{sources[-1].split(':')[0]}:{plain_name(local[address])}"
    return names


def _registers(operand: str) -> int:
    count = 0
    for item in operand.strip("{}").split(","):
        first, _, last = item.strip().partition("-")
        count += int(re.sub(r"\D", "", last)) - int(re.sub(r"\D", "", first)) + 1 if last else 1
    return count


def _stack_taken(mnemonic: str, operands: str) -> int:
    """Bytes by which an instruction lowers the stack pointer."""
    base = mnemonic.split(".")[0]
    if base == "push":
        return 4 * _registers(operands)
    if base == "vpush":
        return (8 if operands.lstrip("{").startswith("d") else 4) * _registers(operands)
    if base == "stmdb" and operands.startswith("sp!"):
        return 4 * _registers(operands.split(",", 1)[1].strip())
    constant = re.match(r"sp,(?: sp,)? #(\d+)", operands)
    if base in ("sub", "subw") and constant:
        return int(constant[1])
    pre_decrement = re.search(r"\[sp, #-(\d+)\]!", operands)
    if base in ("str", "strd") and pre_decrement:
        return int(pre_decrement[1])
    if base in ("sub", "subw") and operands.startswith("sp,"):
        raise CallGraphError(f"the stack pointer changes by an amount unknown before run time: {mnemonic} {operands}")
    return 0


def _add_code(function: Function, own_range: tuple[int, int], address: int, mnemonic: str, operands: str) -> None:
    function.frame_bytes += _stack_taken(mnemonic, operands)
    target = _TARGET.match(operands)
    if _BRANCH.match(mnemonic) and target:
        callee = int(target[1], 16)
        if mnemonic == "bl" or not own_range[0] <= callee < own_range[1]:
            function.calls.add(callee)
    elif mnemonic == "blx" or (mnemonic == "bx" and operands != "lr"):
        function.pointer_calls.append(address)


def read_functions(elf: pathlib.Path) -> dict[int, Function]:
    """All functions of the image by address. A branch into another function is a call too."""
    names = read_symbols(elf)
    starts = sorted(names)
    ends = dict(zip(starts, starts[1:] + [1 << 32]))
    functions = {address: Function(name) for address, name in names.items()}
    current = None
    for line in _run("arm-none-eabi-objdump", "--disassemble", str(elf)):
        code = _CODE_LINE.match(line)
        if not code:
            continue
        address = int(code[1], 16)
        current = address if address in functions else current
        if current is not None:
            operands = (code[3] or "").split(" @ ")[0].split("\t")[0]
            if code[2] == ".word" and address == current + 4 and _VENEER.match(functions[current].name):
                functions[current].calls.add(int(operands, 16) & ~1)  # a jump made by the linker, to a place out of reach
            _add_code(functions[current], (current, ends[current]), address, code[2], operands)
    for function in functions.values():  # the C library's assembler branches into the middle of functions, too
        function.calls = {starts[bisect.bisect_right(starts, target) - 1] for target in function.calls}
    veneers = {address: function.calls for address, function in functions.items() if _VENEER.match(function.name)}
    for function in functions.values():
        function.calls = {target for callee in function.calls for target in veneers.get(callee, {callee})}
    return functions


def resolve_pointers(elf: pathlib.Path, functions: dict[int, Function], table: dict[str, list[str]]) -> None:
    """Adds the calls through pointers that the table lists. Raises CallGraphError for a call without an entry, and for
    an entry without a call."""
    by_name: dict[str, int] = {function.name: address for address, function in functions.items()}
    # Link-time optimisation makes global functions local; the table need not know.
    by_name.update({name.split(":")[-1]: address for name, address in by_name.items() if ":" in name} | by_name)
    unused = set(table)
    sources = source_functions(elf, [call for function in functions.values() for call in function.pointer_calls])
    for function in functions.values():
        for call in function.pointer_calls:
            caller = sources[call][0] if sources[call][0] != "??:??" else plain_name(function.name)
            entry = caller if caller in table else caller.split(":")[-1]
            if entry not in table:
                raise CallGraphError(f"{caller} calls through a pointer: list its possible targets")
            unused.discard(entry)
            for target in table[entry]:
                if target not in by_name:
                    raise CallGraphError(f"{entry} may call {target}, which is not in the image")
                function.calls.add(by_name[target])
    if unused:
        raise CallGraphError(f"no call through a pointer in {', '.join(sorted(unused))}")


def deepest_path(functions: dict[int, Function], root: int) -> tuple[int, list[str]]:
    """Maximum bytes of stack below a function, and the calls that lead there. Raises CallGraphError on recursion."""
    known: dict[int, tuple[int, list[str]]] = {}
    path: list[int] = []

    def visit(address: int) -> tuple[int, list[str]]:
        if address in path:
            circle = [functions[a].name for a in path[path.index(address):]]
            raise CallGraphError(f"recursion: {' -> '.join(circle)}")
        if address not in known:
            path.append(address)
            function = functions[address]
            below = max((visit(callee) for callee in sorted(function.calls)), default=(0, []), key=lambda found: found[0])
            known[address] = (function.frame_bytes + below[0], [function.name, *below[1]])
            path.pop()
        return known[address]

    return visit(root)
