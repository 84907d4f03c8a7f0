# SPDX-License-Identifier: Apache-2.0
"""Comments and string literals of C and C++ sources, each with its line."""

import re
from dataclasses import dataclass

TOKEN = re.compile(
    r'(?P<comment>//(?:\\\n|[^\n])*|/\*.*?\*/)'
    r'|(?P<include>^[ \t]*#[ \t]*include[^\n]*)'
    r'|(?P<raw>R"(?P<mark>[^()\\\s]{0,16})\((?P<body>.*?)\)(?P=mark)")'
    r'|(?P<string>"(?:\\.|[^"\\\n])*")'
    r"|(?P<char>(?<![0-9A-Fa-f])'(?:\\.|[^'\\\n])+')",
    re.DOTALL | re.MULTILINE)


@dataclass(frozen=True)
class Piece:
    kind: str  # "comment", "include", "string" or "char"
    line: int
    start: int
    end: int
    text: str  # as it stands in the source; a raw string without its marks


def pieces_of(source):
    line, at = 1, 0
    for match in TOKEN.finditer(source):
        line += source.count("\n", at, match.start())
        at = match.start()
        if match["raw"] is not None:
            yield Piece("string", line, match.start(), match.end(), match["body"])
        else:
            kind = match.lastgroup
            text = match.group()
            yield Piece(kind, line, match.start(), match.end(), text[1:-1] if kind == "string" else text)


def code_of(source):
    """The source with spaces for its comments, texts and includes; lines stay where they are."""
    parts, at = [], 0
    for piece in pieces_of(source):
        parts += [source[at:piece.start], re.sub(r"[^\n]", " ", source[piece.start:piece.end])]
        at = piece.end
    return "".join(parts) + source[at:]
