"""Every loop of the firmware and its maximum number of iterations.

A loop counts by itself when it is `for (T i = A; i < B; ++i)` (or with another step, or downwards, or with an `&&` that
ends it earlier), A and B are constant, and nothing in it changes i. All others need a line in loop_bounds.toml: by file
and condition, the bound and its reason. A loop without a line is an error, and so is a line without a loop.
"""

import re
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ["firmware", "hal"]
NOT_IN_AN_IMAGE = ["hal/host/", "hal/cortex_m4_qemu/"]

COUNTED = re.compile(r"^(?:[\w ]+?[\w*] )(?P<i>\w+) = (?P<first>[^;]+); (?P=i) (?P<test><|<=|>|>=|!=) (?P<bound>[^;&|?]+)(?: && [^;]+)?; "
                     r"(?P<step>\+\+(?P=i)|(?P=i)\+\+|--(?P=i)|(?P=i)--|(?P=i) [-+]= [\w ]+)$")
SIZE_OF = re.compile(r"sizeof \(?[\w.>\[\]-]+\)?")
CONSTANT = re.compile(r"^(?:[A-Z][A-Z0-9_]*|\d\w*|[-+*/() ])+$")


@dataclass(frozen=True)
class Loop:
    file: str
    line: int
    head: str  # between the brackets of for or while, in one line
    body: str
    is_for: bool

    @property
    def condition(self):
        if not self.is_for:
            return self.head
        return self.head.split(";")[1].strip()


def blanked(text):
    """Replaces comments, texts, characters and directives by spaces; line numbers stay."""
    def blank(match):
        return re.sub(r"[^\n]", " ", match.group(0))
    pattern = r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|^[ \t]*#(?:\\\n|[^\n])*'
    return re.sub(pattern, blank, text, flags=re.DOTALL | re.MULTILINE)


def end_of(text, start, opening, closing):
    """Position after the bracket that closes the one at `start`."""
    depth = 0
    for at in range(start, len(text)):
        depth += (text[at] == opening) - (text[at] == closing)
        if depth == 0:
            return at + 1
    raise ValueError("unclosed bracket")


def body_at(text, start):
    start += len(text[start:]) - len(text[start:].lstrip())
    if text[start] == "{":
        return text[start:end_of(text, start, "{", "}")]
    return text[start:text.index(";", start) + 1]


def loops_of(file, source):
    text = blanked(source)
    if re.search(r"\bgoto\b", text):
        raise ValueError(f"{file}: goto is not allowed: it can form a loop that this check misses")
    if re.search(r"\bdo\s*\{", text):
        raise ValueError(f"{file}: do ... while is not supported: use for or while")
    for match in re.finditer(r"\b(for|while)\s*\(", text):
        opening = match.end() - 1
        closing = end_of(text, opening, "(", ")")
        head = " ".join(source[opening + 1:closing - 1].split())
        line = text.count("\n", 0, match.start()) + 1
        yield Loop(file, line, head, body_at(text, closing), match.group(1) == "for")


def is_changed_in(name, body):
    changed = rf"(?<![\w.>])(?:\+\+|--){name}\b|(?<![\w.>]){name}\s*(?:\+\+|--|[-+*/%&|^]=|<<=|>>=|=(?!=))|&{name}\b(?!\s*[\[.])"
    return re.search(changed, body) is not None


def counts_by_itself(loop):
    match = COUNTED.match(loop.head) if loop.is_for else None
    if match is None:
        return False
    downwards = match["step"].startswith("--") or match["step"].endswith("--") or "-=" in match["step"]
    right_direction = match["test"] in ((">", ">=") if downwards else ("<", "<="))
    ends = (match["first"], match["bound"])
    constant = all(CONSTANT.match(SIZE_OF.sub("1", end).strip()) for end in ends)
    return right_direction and constant and not is_changed_in(match["i"], loop.body)


def all_loops(root):
    for room in ROOMS:
        for path in sorted((root / room).rglob("*.[ch]")):
            file = path.relative_to(root).as_posix()
            if path.parent.name != "tests" and not any(file.startswith(out) for out in NOT_IN_AN_IMAGE):
                yield from loops_of(file, path.read_text())


def errors_of(loops, bounds):
    needed = set()
    for loop in loops:
        if counts_by_itself(loop):
            continue
        needed.add((loop.file, loop.condition))
        if loop.condition not in bounds.get(loop.file, {}):
            yield f"{loop.file}:{loop.line}: no bound known for this loop ({loop.condition or 'endless'})"
    for file, conditions in bounds.items():
        for condition, reason in conditions.items():
            if (file, condition) not in needed:
                yield f"loop_bounds.toml: {file} has no such loop, or the loop has a constant bound: {condition}"
            elif not reason.strip():
                yield f"loop_bounds.toml: {file}: no reason given for {condition}"


def main():
    loops = list(all_loops(ROOT))
    bounds = tomllib.loads((Path(__file__).parent / "loop_bounds.toml").read_text())
    errors = list(errors_of(loops, bounds))
    for error in errors:
        print(error)
    by_themselves = sum(counts_by_itself(loop) for loop in loops)
    print(f"{len(loops)} loops: {by_themselves} with a constant bound, {len(loops) - by_themselves} with a reason, "
          f"{len(errors)} errors.")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
