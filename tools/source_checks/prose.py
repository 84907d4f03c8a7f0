"""What people read in a source tree: pages, comments and messages, each with file and line.

A passage is a paragraph, a list item, a table cell, a comment or a string literal. A passage keeps the line breaks of its
source, so that a place in it has a line.
"""

import io
import re
import tokenize
from dataclasses import dataclass, replace
from pathlib import Path

from c_text import code_of, pieces_of

LEFT_OUT = {"build", "third_party", ".git", "__pycache__", "corpora", "corpus", "node_modules", ".mypy_cache", ".pytest_cache"}


@dataclass(frozen=True)
class Passage:
    file: str
    line: int
    kind: str  # "page", "comment", "message" (a string literal with a space in it) or "name" (an identifier or a word in quotes)
    text: str


# ---- Markdown

FENCE = re.compile(r"^\s*(```+|~~~+)")
BLOCK_START = re.compile(r"^\s*(?:[-*+] |\d+[.)] |#{1,6} |> )")


def markdown(text):
    block, start, fence = [], 0, None
    lines = [*text.splitlines(), ""]
    for number, line in enumerate(lines, 1):
        mark = FENCE.match(line)
        is_row = fence is None and line.lstrip().startswith("|")
        ends = fence is not None or mark or is_row or not line.strip() or BLOCK_START.match(line)
        if block and (ends or block[0].lstrip().startswith("#")):
            yield start, "page", "\n".join(block)
            block = []
        if fence is not None:
            if mark and line.strip().startswith(fence) and line.strip() == mark[1]:
                fence = None
        elif mark:
            fence = mark[1][:3]
        elif is_row:
            if not re.fullmatch(r"[\s|:-]+", line):
                for cell in re.split(r"(?<!\\)\|", line.strip().strip("|")):
                    if cell.strip():
                        yield number, "page", cell.strip()
        elif line.strip():
            if not block:
                start = number
            block.append(line)


# ---- C and C++


def comment_text(raw):
    """Replaces the marks of a comment by spaces; lines stay."""
    if raw.startswith("//"):
        return re.sub(r"^[ \t]*//[/!]?<?", lambda mark: " " * len(mark.group()), raw, flags=re.MULTILINE)
    inner = re.sub(r"^/\*+[!<]?", "", raw[:-2])
    return re.sub(r"^[ \t]*\*+(?=\s|$)", lambda mark: " " * len(mark.group()), inner, flags=re.MULTILINE)


def unescaped(text):
    return re.sub(r'\\(["\'\\])', r"\1", re.sub(r"\\[nrt]", " ", text))


def string_kind(text):
    return "message" if re.search(r"\S\s+\S", text.strip()) else "name"


def column_of(source, at):
    return at - (source.rfind("\n", 0, at) + 1)


def c_source(source):
    """Passages of comments and strings; lines of // one below the other are one comment, literals side by side one string."""
    open_piece, text, end = None, "", 0
    for piece in pieces_of(source):
        if piece.kind not in ("comment", "string"):
            continue
        own = comment_text(piece.text) if piece.kind == "comment" else unescaped(piece.text)
        gap = source[end:piece.start]
        joins = open_piece is not None and piece.kind == open_piece.kind and not gap.strip() and (
            piece.kind == "string"
            or piece.text.startswith("//") and open_piece.text.startswith("//") and gap.count("\n") == 1
            and column_of(source, piece.start) == column_of(source, open_piece.start))
        if joins:
            text += "\n" * gap.count("\n") + own
        else:
            if open_piece is not None:
                yield open_piece.line, open_piece.kind, text
            open_piece, text = piece, own
        end = piece.end
    if open_piece is not None:
        yield open_piece.line, open_piece.kind, text


def c_passages(source):
    for line, kind, text in c_source(source):
        yield line, string_kind(text) if kind == "string" else "comment", text
    for number, line in enumerate(code_of(source).splitlines(), 1):
        for name in re.findall(r"[A-Za-z_]\w*", line):
            yield number, "name", name


# ---- Python


def without_expressions(text):
    """The text of an f-string with {} for each expression, also for one with an f-string in it."""
    text = text.replace("{{", "").replace("}}", "")
    while (shorter := re.sub(r"\{[^{}]+\}", "\x00", text)) != text:
        text = shorter
    return text.replace("\x00", "{}")


def python_passages(source):
    strings, comments, before = [], [], tokenize.NEWLINE
    statement_starts_after = (tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT)

    def finish():
        if strings:
            first = strings[0][0]
            text = "".join("\n" * (token.start[0] - last) + body for (token, body), last in
                           zip(strings, [first.start[0], *(token.end[0] for token, _ in strings)]))
            docstring = starts_statement and ends_statement
            yield first.start[0], "comment" if docstring else string_kind(text), text
            strings.clear()

    starts_statement = ends_statement = False
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            if not token.string.startswith("#!"):
                comments.append((token.start, token.string, token.line))
            continue
        if token.type == tokenize.STRING:
            if not strings:
                starts_statement = before in statement_starts_after
            prefix, body = re.match(r"(?s)([A-Za-z]*)(?:\"\"\"|'''|\"|')(.*?)(?:\"\"\"|'''|\"|')$", token.string).groups()
            if "b" not in prefix.lower():
                body = body if "r" in prefix.lower() else unescaped(body)
                strings.append((token, without_expressions(body) if "f" in prefix.lower() else body))
            before = token.type
            continue
        if token.type == tokenize.NL:
            continue
        ends_statement = token.type in (tokenize.NEWLINE, tokenize.ENDMARKER)
        yield from finish()
        if token.type == tokenize.NAME:
            yield token.start[0], "name", token.string
        before = token.type
    yield from finish()
    yield from hash_comments([(line, column, text, source_line[:column].strip() == "") for (line, column), text, source_line in comments])


def hash_comments(comments):
    """Comments (line, column, text, alone in its line) that stand one below the other are one passage."""
    block, at = [], None
    for line, column, text, alone in comments:
        text = re.sub(r"^#+:?", "", text)
        if block and alone and at == (line - 1, column):
            block.append(text)
        else:
            if block:
                yield start, "comment", "\n".join(block)
            block, start = [text], line
        at = (line, column)
    if block:
        yield start, "comment", "\n".join(block)


# ---- shell, CMake, TOML, YAML and other files with comments after #

SHELL = re.compile(
    r"<<-?\s*(?P<q>['\"]?)(?P<mark>\w+)(?P=q)[^\n]*\n(?P<here>.*?)\n\s*(?P=mark)(?=\n|$)"
    r"|(?P<comment>(?<![^\s;])#[^\n]*)"
    r"|\"(?P<double>(?:\\.|[^\"\\])*)\""
    r"|'(?P<single>[^']*)'"
    r"|\\.",
    re.DOTALL)


def hash_passages(source):
    comments = []
    for match in SHELL.finditer(source):
        line = source.count("\n", 0, match.start()) + 1
        if match["comment"] is not None:
            if not match["comment"].startswith("#!"):
                start = source.rfind("\n", 0, match.start()) + 1
                comments.append((line, match.start() - start, match["comment"], not source[start:match.start()].strip()))
        elif match["here"] is not None:
            for offset, text in paragraphs(match["here"]):
                yield line + 1 + offset, "message", text
        else:
            text = match["double"] if match["double"] is not None else match["single"]
            if text and string_kind(text) == "message":
                yield line, "message", unescaped(text)
    yield from hash_comments(comments)


def toml_passages(source):
    comments = []
    pattern = r"(?P<long>(?:\"\"\"|''').*?(?:\"\"\"|'''))|\"(?P<double>(?:\\.|[^\"\\\n])*)\"|'(?P<single>[^'\n]*)'|(?P<comment>#[^\n]*)"
    for match in re.finditer(pattern, source, re.DOTALL):
        line = source.count("\n", 0, match.start()) + 1
        if match["comment"] is not None:
            start = source.rfind("\n", 0, match.start()) + 1
            comments.append((line, match.start() - start, match["comment"], not source[start:match.start()].strip()))
        else:
            text = next(part for part in (match["long"], match["double"], match["single"]) if part is not None)
            if string_kind(text) == "message":
                yield line, "message", unescaped(text)
    yield from hash_comments(comments)


def hash_comments_of(source):
    comments = []
    for match in re.finditer(r"(?:^|(?<=\s))#[^\n]*", source):
        line = source.count("\n", 0, match.start()) + 1
        start = source.rfind("\n", 0, match.start()) + 1
        comments.append((line, match.start() - start, match.group(), not source[start:match.start()].strip()))
    yield from hash_comments(comments)


def block_comments_of(source):
    for match in re.finditer(r"/\*.*?\*/", source, re.DOTALL):
        yield source.count("\n", 0, match.start()) + 1, "comment", comment_text(match.group())


def template_text(source):
    """Text of an HTML template: blanks for tags, expressions, styles and scripts."""
    def blank(match):
        return re.sub(r"[^\n]", " ", match.group())
    text = re.sub(r"<(script|style)\b.*?</\1>|\{#.*?#\}|\{%.*?%\}|\{\{.*?\}\}", blank, source, flags=re.DOTALL)
    text = re.sub(r"<[^>]*>", blank, text, flags=re.DOTALL)
    for offset, paragraph in paragraphs(text):
        yield offset + 1, "message", paragraph


def paragraphs(text):
    """(lines before it, text) of the pieces between empty lines; a list item is a piece of its own."""
    block, start = [], 0
    for number, line in enumerate([*text.split("\n"), ""]):
        if block and (not line.strip() or BLOCK_START.match(line)):
            yield start, "\n".join(block)
            block = []
        if line.strip():
            if not block:
                start = number
            block.append(line)


# ---- the tree

READERS = {
    ".md": markdown, ".c": c_passages, ".h": c_passages, ".cpp": c_passages, ".hpp": c_passages, ".py": python_passages,
    ".sh": hash_passages, ".cmake": hash_passages, "CMakeLists.txt": hash_passages, ".toml": toml_passages,
    ".yml": hash_comments_of, ".awk": hash_comments_of, ".cfg": hash_comments_of, ".in": hash_comments_of,
    ".ld": block_comments_of, ".css": block_comments_of, ".j2": template_text,
}


def reader_of(path):
    if path.name in READERS:
        return READERS[path.name]
    if path.suffix in READERS:
        return READERS[path.suffix]
    if path.suffix == "":
        with path.open("rb") as file:
            if re.match(rb"#!.*\b(?:ba|da)?sh\b", file.readline()):
                return hash_passages
    return None


def files_of(root):
    """Every file that people read, from the root of the tree."""
    pending = [Path(root)]
    while pending:
        for path in sorted(pending.pop().iterdir()):
            if path.is_symlink():
                continue
            if path.is_dir():
                if path.name not in LEFT_OUT:
                    pending.append(path)
            elif reader_of(path) is not None:
                yield path.relative_to(root).as_posix()


def passages_of(root, file):
    path = Path(root) / file
    for line, kind, text in reader_of(path)(path.read_text()):
        yield Passage(file, line, kind, text)


# ---- sentences

END = re.compile(r"(?<=[^\s.][.!?])[\"')\]]*\s+(?=[\"'(\[`]*[A-Z0-9`])")
ABBREVIATION = re.compile(r"(?:\b(?:e\.g|i\.e|cf|vs|al|[Ff]ig|[Ee]qs?|No|Nos|Sec|ch|approx|resp|etc|p|pp)\.|\b[A-Z]\.)$")


def sentences(passage):
    """The sentences of a passage as passages, in one line each."""
    for offset, paragraph in paragraphs(passage.text):
        at, line = 0, passage.line + offset
        cuts = [match.end() for match in END.finditer(paragraph)
                if not ABBREVIATION.search(paragraph[:match.start()].rstrip("\"')]"))]
        for cut in [*cuts, len(paragraph)]:
            raw = paragraph[at:cut]
            text = " ".join(re.sub(r"^\s*(?:[-*+] |\d+[.)] |#{1,6} |> )", "", raw).split())
            if text:
                skipped = len(raw) - len(raw.lstrip())
                yield replace(passage, line=line + paragraph.count("\n", 0, at + skipped), text=text)
            at = cut


def words_of(sentence):
    return [word for word in sentence.split() if re.search(r"[A-Za-z]", word)]
