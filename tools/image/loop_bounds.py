# SPDX-License-Identifier: Apache-2.0
"""Every loop of the firmware and its maximum number of iterations.

A loop counts by itself when it is `for (T i = A; i < B; ++i)` (or with another step, or downwards, or with an `&&` that
ends it earlier), A and B are constant, and nothing in it changes i. Above every other loop a comment says its bound and
why it holds: /* Bound: ... */. A loop without this comment is an error, and so is the comment without such a loop.
"""

import re
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ["firmware", "hal"]
NOT_IN_AN_IMAGE = ["hal/host/", "hal/boards/cortex_m4_qemu/"]

COUNTED = re.compile(r"^(?:[\w ]+?[\w*] )(?P<i>\w+) = (?P<first>[^;]+); (?P=i) (?P<test><|<=|>|>=|!=) (?P<bound>[^;&|?]+)(?: && [^;]+)?; "
                     r"(?P<step>\+\+(?P=i)|(?P=i)\+\+|--(?P=i)|(?P=i)--|(?P=i) [-+]= [\w ]+)$")
SIZE_OF = re.compile(r"sizeof \(?[\w.>\[\]-]+\)?")
BOUND = re.compile(r"/\*\s*Bound:(?P<reason>(?:[^*]|\*(?!/))*)\*/")
CONSTANT = re.compile(r"^(?:[A-Z][A-Z0-9_]*|\d\w*|[-+*/() ])+$")


@dataclass(frozen=True)
class Loop:
    file: str
    line: int
    head: str  # between the brackets of for or while, in one line
    body: str
    is_for: bool
    reason: str  # of the comment above, "" without one


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


def reason_above(source, start):
    """What the comment directly above says."""
    comments = list(BOUND.finditer(source, 0, start))
    return " ".join(comments[-1]["reason"].split()) if comments and not source[comments[-1].end():start].strip() else ""


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
        yield Loop(file, line, head, body_at(text, closing), match.group(1) == "for", reason_above(source, match.start()))


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


def sources(root):
    for room in ROOMS:
        for path in sorted((root / room).rglob("*.[ch]")):
            file = path.relative_to(root).as_posix()
            if path.parent.name != "tests" and not any(file.startswith(out) for out in NOT_IN_AN_IMAGE):
                yield file, path.read_text()


def errors_of(file, source):
    loops = list(loops_of(file, source))
    for loop in loops:
        if not counts_by_itself(loop) and not loop.reason:
            yield f"{file}:{loop.line}: no bound is known for this loop ({loop.head}): say it above, /* Bound: ... */"
    needed = sum(not counts_by_itself(loop) and bool(loop.reason) for loop in loops)
    written = len(BOUND.findall(source))
    if written > needed:
        yield f"{file}: {written - needed} of the comments /* Bound: ... */ are not above a loop that needs one"


def main():
    found = dict(sources(ROOT))
    errors = [error for file, source in found.items() for error in errors_of(file, source)]
    for error in errors:
        print(error)
    loops = [loop for file, source in found.items() for loop in loops_of(file, source)]
    by_themselves = sum(counts_by_itself(loop) for loop in loops)
    print(f"{len(loops)} loops: {by_themselves} with a constant bound, {len(loops) - by_themselves} with a reason, "
          f"{len(errors)} errors.")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
