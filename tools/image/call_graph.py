"""Who calls whom in an image, and what a function takes of the stack, read from the machine code.

Functions are known by their name, local ones with their file: "servo_node.c:reset". Calls through a pointer cannot be
read from the code: a table says where they may lead, and a call that it does not name is an error.
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
    calls_pointer: bool = False


class CallGraphError(Exception):
    """What the machine code cannot tell, or what it must not be."""


_FUNCTION_LINE = re.compile(r"^([0-9a-f]{8}) <(.+)>:$")
_CODE_LINE = re.compile(r"^ *([0-9a-f]+):\t[0-9a-f ]+\t(\S+)(?:\t(.*))?$")
_TARGET = re.compile(r"^([0-9a-f]+) <")
_BRANCH = re.compile(r"^(bl|b|b(?:eq|ne|cs|cc|mi|pl|vs|vc|hi|ls|ge|lt|gt|le|lr)?)(?:\.[nw])?$")


def _run(*command: str) -> list[str]:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()


def read_symbols(elf: pathlib.Path) -> dict[int, str]:
    """Name of the function at each address."""
    names: dict[int, str] = {}
    file = ""
    for line in _run("arm-none-eabi-readelf", "--syms", "--wide", str(elf)):
        part = line.split()
        if len(part) == 8 and part[3] == "FILE":
            file = part[7]
        elif len(part) == 8 and part[3] == "FUNC":
            address = int(part[1], 16) & ~1
            if part[4] == "GLOBAL":
                names[address] = part[7]
            else:
                names.setdefault(address, f"{file}:{part[7]}")
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
        raise CallGraphError(f"the stack pointer moves by what only running tells: {mnemonic} {operands}")
    return 0


def _add_code(function: Function, own_range: tuple[int, int], mnemonic: str, operands: str) -> None:
    function.frame_bytes += _stack_taken(mnemonic, operands)
    target = _TARGET.match(operands)
    if _BRANCH.match(mnemonic) and target:
        address = int(target[1], 16)
        if mnemonic == "bl" or not own_range[0] <= address < own_range[1]:
            function.calls.add(address)
    elif mnemonic == "blx" or (mnemonic == "bx" and operands != "lr"):
        function.calls_pointer = True


def read_functions(elf: pathlib.Path) -> dict[int, Function]:
    """All functions of the image by address. A branch into another function is a call, too."""
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
            _add_code(functions[current], (current, ends[current]), code[2], (code[3] or "").split(" @ ")[0].split("\t")[0])
    for function in functions.values():  # the C library's assembler branches into the middle of functions, too
        function.calls = {starts[bisect.bisect_right(starts, target) - 1] for target in function.calls}
    return functions


def resolve_pointers(functions: dict[int, Function], table: dict[str, list[str]]) -> None:
    """Adds the calls through pointers that the table names. Raises CallGraphError for what it does not, or in vain."""
    by_name: dict[str, int] = {function.name: address for address, function in functions.items()}
    unused = set(table)
    for function in functions.values():
        if not function.calls_pointer:
            continue
        plain_name = re.sub(r"\.(isra|part|constprop)\.\d+", "", function.name)
        if plain_name not in table:
            raise CallGraphError(f"{function.name} calls through a pointer: name where it may lead")
        unused.discard(plain_name)
        for target in table[plain_name]:
            if target not in by_name:
                raise CallGraphError(f"{plain_name} may call {target}, which is not in the image")
            function.calls.add(by_name[target])
    if unused:
        raise CallGraphError(f"no call through a pointer in {', '.join(sorted(unused))}")


def deepest_path(functions: dict[int, Function], root: int) -> tuple[int, list[str]]:
    """Bytes of stack below a function at worst, and the calls that lead there. Raises CallGraphError on recursion."""
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
