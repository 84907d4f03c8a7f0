# SPDX-License-Identifier: Apache-2.0
"""The one-line mutants of a C file, and which of them a seed draws.

The mutation operators are those of universalmutator for C. A mutant's rank depends on the seed, the file, the line's
text and the mutated text, and not on the line's number. An edit therefore changes only the mutants of the edited lines,
and the rest of a sample stays as it was.
"""

import contextlib
import hashlib
import io
import math
import re
import sys
from dataclasses import dataclass
from pathlib import Path

from universalmutator import mutator

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/source_checks"))
from c_text import code_of, pieces_of  # noqa: E402

RULES = ["universal.rules", "c_like.rules", "c.rules"]
# Declarations of a header change nothing that runs; of other headers only the bodies of functions are mutated.
LISTS = re.compile(r"_list\.h$")
FUNCTION_START = re.compile(r"^static inline\b")


@dataclass(frozen=True)
class Mutant:
    file: str  # from the project's folder
    line: int
    before: str  # the line without its comments and outer blanks
    after: str  # likewise; two lines where a statement is added
    occurrence: int  # among the lines of the file with this text
    siblings: int  # mutants of the same line
    previous: str = ""  # the line before, likewise

    def rank(self, seed):
        """The smaller, the earlier drawn: each line has the same chance, whatever its number of mutants."""
        key = "\0".join([str(seed), self.file, self.before, str(self.occurrence), self.after])
        uniform = (int.from_bytes(hashlib.sha256(key.encode()).digest()[:7], "big") + 1) / 2**56
        return -math.log(uniform) * self.siblings

    def apply(self, source):
        """The whole source with this mutant. The line loses its comment; its indentation stays."""
        lines = without_comments(source).split("\n")
        old = lines[self.line - 1]
        assert old.strip() == self.before, f"{self.file}:{self.line} is not the line that was mutated"
        indentation = old[:len(old) - len(old.lstrip())]
        lines[self.line - 1] = "\n".join(indentation + part for part in self.after.split("\n"))
        return "\n".join(lines)


def without_comments(source):
    """The source with spaces for its comments; lines stay where they are."""
    parts, at = [], 0
    for piece in pieces_of(source):
        if piece.kind == "comment":
            parts += [source[at:piece.start], re.sub(r"[^\n]", " ", source[piece.start:piece.end])]
            at = piece.end
    return "".join(parts) + source[at:]


def code_lines(file, source):
    """The numbers of the lines that are mutated."""
    lines = source.split("\n")
    if not file.endswith(".h") or LISTS.search(file):
        return set(range(1, len(lines) + 1))
    chosen, inside = set(), False
    for number, line in enumerate(lines, 1):
        if FUNCTION_START.match(line):
            inside = True
        elif line.startswith("}"):
            inside = False
        elif inside and line.startswith(" "):
            chosen.add(number)
    return chosen


def loop_ends(source):
    """The numbers of the lines after which a `continue` changes nothing, because the body of a loop ends there."""
    lines = code_of(source).split("\n")
    opened, after = [], {}  # of each open brace, whether it is that of a loop; the same after each line
    statement, parentheses = "", 0
    for number, line in enumerate(lines, 1):
        for character in line + " ":
            parentheses += (character == "(") - (character == ")")
            if character == "{":
                opened.append(re.match(r"(for|while)\b", statement.strip()) is not None)
            elif character == "}" and opened:
                opened.pop()
            ends = character in "{}" or (character == ";" and parentheses == 0)
            statement = "" if ends else statement + character
        after[number] = list(opened)
    found = set()
    for number in after:
        place, following = after[number], number
        while place and following < len(lines) and lines[following].strip() in ("}", ""):
            if lines[following].strip() == "}" and place[-1]:
                found.add(number)
                break
            following += 1
            place = after[following]
    return found


def mutants_of(file, source):
    """All mutants of a file, by line. Two that differ in blanks only count once, a `continue` at the end of a loop's body
    not at all."""
    source = without_comments(source)
    ends = loop_ends(source)
    lines = source.split("\n")
    wanted = code_lines(file, source)
    with contextlib.redirect_stdout(io.StringIO()):
        found = mutator.mutants_regexp([line + "\n" for line in lines], ruleFiles=RULES, ignorePatterns=[])
    texts = {}
    for number, mutated, *_ in found:
        before = lines[number - 1].strip()
        after = "\n".join(part.strip() for part in mutated.strip().split("\n"))
        if number in ends and after == before + "\ncontinue;":
            continue
        if number in wanted and re.sub(r"\s", "", after) != re.sub(r"\s", "", before):
            texts.setdefault(number, {}).setdefault(re.sub(r"[ \t]+", " ", after), after)
    seen, result = {}, []
    for number in sorted(texts):
        before = lines[number - 1].strip()
        occurrence = seen[before] = seen.get(before, -1) + 1
        previous = next((line.strip() for line in reversed(lines[:number - 1]) if line.strip()), "")
        result += [Mutant(file, number, before, after, occurrence, len(texts[number]), previous) for after in texts[number].values()]
    return result
