"""House words: finds words of the glossary in what people read, and compares docs/words.md with the glossary.

Reads pages, comments, docstrings, messages and identifiers of the whole tree (prose.py). words.toml has the glossary, the
exceptions, and the folders that are covered.
"""

import argparse
import re
import sys
import tomllib
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import prose

ROOT = Path(__file__).resolve().parents[2]
GLOSSARY = Path(__file__).parent / "words.toml"
PAGE = "docs/words.md"
SAMPLE = "docs/checks/sentences.md"  # quotes sentences as they were
LONG_SENTENCE = 25
TABLE_START, TABLE_END = "<!-- glossary -->", "<!-- end of glossary -->"

CODE_SPAN = re.compile(r"(`+)(?!`).*?(?<!`)\1(?!`)", re.DOTALL)
LINK_TARGET = re.compile(r"(?<=\])\([^()\s]*\)|<[^<>\s][^<>]*>|https?://\S+")
NAME_LIKE = re.compile(
    r'(?<![\w"])"[\w.+-]+"(?![\w"])'  # a word alone in quotes belongs to an interface
    r"|(?<![\w-])--?[A-Za-z][\w-]*"  # options
    r"|\bsim_host beliefs\b"  # a command of a program
    r"|[\w.]*\w_[\w./:-]*|\b_\w+"  # underscores
    r"|\b\w+(?:->|::)\w+|\b\w+\(\)"
    r"|\b[\w/-]*\w\.[a-z]\w*\b"  # file names and members
    r"|\$\{?\w+\}?|@\w+@|\[\[\w+\]\]"
    r"|\{[^{}\s]*\}")


@dataclass(frozen=True)
class Finding:
    file: str
    line: int
    found: str
    word: dict

    def __str__(self):
        return f'{self.file}:{self.line}: "{self.found}": write {self.word["write"]}'


def blank(match):
    return re.sub(r"[^\n]", "\x00", match.group())


def only_prose(text):
    """The text with blanks for code, link targets and names, each as long as before."""
    for pattern in (CODE_SPAN, LINK_TARGET, NAME_LIKE):
        text = pattern.sub(blank, text)
    return text


def compiled(pattern):
    return re.compile(rf"(?<![\w-])(?:{pattern.replace(' ', chr(92) + 's+')})(?![\w-])", re.IGNORECASE)


def snake_case(name):
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name)
    return "_" + words.strip("_").lower() + "_"


class Glossary:
    def __init__(self, data):
        self.words = data["words"]
        self.patterns = [(compiled(word["pattern"]), word) for word in self.words if "pattern" in word]
        self.name_patterns = [(re.compile(pattern), word) for word in self.words for pattern in word.get("names", [])]
        self.exceptions = [(compiled(item["text"]), item) for item in data["exceptions"]]
        self.used_exceptions, self.used_interfaces = set(), set()
        self.interfaces = data["interfaces"]
        self.known_names = {}

    def in_prose(self, text, file):
        """(offset, found, word) of each house word."""
        text = only_prose(text)
        excepted = []
        for pattern, item in self.exceptions:
            if "files" in item and not is_in(file, item["files"]):
                continue
            for match in pattern.finditer(text):
                excepted.append((match.start(), match.end(), item["text"]))
        for pattern, word in self.patterns:
            for match in pattern.finditer(text):
                within = [name for start, end, name in excepted if start <= match.start() and match.end() <= end]
                self.used_exceptions.update(within)
                if not within:
                    yield match.start(), " ".join(match.group().split()), word

    def in_name(self, name):
        if name not in self.known_names:
            word = next((word for pattern, word in self.name_patterns if pattern.search(snake_case(name))), None)
            if word is not None and name in self.interfaces:
                self.used_interfaces.add(name)
                word = None
            self.known_names[name] = word
        return self.known_names[name]

    def findings(self, passage):
        if passage.kind == "name":
            word = self.in_name(passage.text)
            if word is not None:
                yield Finding(passage.file, passage.line, passage.text, word)
            return
        for offset, found, word in self.in_prose(passage.text, passage.file):
            yield Finding(passage.file, passage.line + passage.text.count("\n", 0, offset), found, word)

    def table(self):
        rows = [f"| `{word['house']}` | {word['write']} |" for word in self.words]
        return "\n".join(["| house word | write |", "|---|---|", *rows])


def is_in(file, folders):
    return any(folder == "." or file == folder or file.startswith(folder + "/") for folder in folders)


def page_with_table(page, glossary):
    before, found_start, rest = page.partition(TABLE_START)
    _, found_end, after = rest.partition(TABLE_END)
    if not found_start or not found_end:
        raise ValueError(f"{PAGE}: the marks {TABLE_START} and {TABLE_END} are missing")
    return f"{before}{TABLE_START}\n{glossary.table()}\n{TABLE_END}{after}"


def check(root, data, folders=None, with_names=True):
    """The findings in the folders (by default those that words.toml covers), and other errors as sentences."""
    glossary = Glossary(data)
    in_prose = data["covered"] if folders is None else folders
    in_names = [] if not with_names else data["names_covered"] if folders is None else folders
    findings = []
    for file in prose.files_of(root):
        if file in data["left_out"] or file == SAMPLE:
            continue
        read_prose, read_names = is_in(file, in_prose), is_in(file, in_names)
        if read_prose or read_names:
            for passage in prose.passages_of(root, file):
                if read_names if passage.kind == "name" else read_prose:
                    findings += glossary.findings(passage)
    errors = []
    if data["covered"] == ["."] and folders is None:
        for item in data["exceptions"]:
            if item["text"] not in glossary.used_exceptions:
                errors.append(f"words.toml: nothing needs the exception {item['text']}: remove it.")
    if in_names == ["."] and folders is None:
        for name in data["interfaces"]:
            if name not in glossary.used_interfaces:
                errors.append(f"words.toml: no file has the interface {name}: remove it.")
    for file in data["left_out"]:
        if not (root / file).is_file():
            errors.append(f"words.toml: {file} under left_out does not exist: remove it.")
    return findings, errors


def long_sentences(root, files):
    for file in files:
        for passage in prose.passages_of(root, file):
            for sentence in prose.sentences(passage):
                if len(prose.words_of(sentence.text)) > LONG_SENTENCE:
                    yield sentence


def main():
    parser = argparse.ArgumentParser(description="Find house words in pages, comments, messages and identifiers; words.toml has the glossary.")
    parser.add_argument("folders", nargs="*", metavar="PATH", help="files or folders to read, covered or not (default: what words.toml covers)")
    parser.add_argument("--no-names", action="store_true", help="leave identifiers out")
    parser.add_argument("--count", action="store_true", help="print the number of findings of each folder, not the findings")
    parser.add_argument("--long", action="store_true", help=f"print each sentence of the pages that has more than {LONG_SENTENCE} words")
    parser.add_argument("--update-page", action="store_true", help=f"write the glossary's table into {PAGE}")
    arguments = parser.parse_args()
    data = tomllib.loads(GLOSSARY.read_text())
    folders = [path.rstrip("/") for path in arguments.folders] or None

    page = (ROOT / PAGE).read_text()
    wanted = page_with_table(page, Glossary(data))
    if arguments.update_page:
        (ROOT / PAGE).write_text(wanted)
        page = wanted

    findings, errors = check(ROOT, data, folders, not arguments.no_names)
    if page != wanted:
        errors.append(f"{PAGE} does not have the glossary of words.toml: run tools/source_checks/words.py --update-page.")
    if arguments.count:
        for folder, count in sorted(Counter(str(Path(finding.file).parent) for finding in findings).items()):
            print(f"{count:5} {folder}")
    else:
        for finding in findings:
            print(finding)
    for error in errors:
        print(error)

    pages = [file for file in prose.files_of(ROOT) if file.endswith(".md") and (folders is None or is_in(file, folders))]
    counts = Counter()
    for sentence in long_sentences(ROOT, pages):
        counts[sentence.file] += 1
        if arguments.long:
            print(f"{sentence.file}:{sentence.line}: {len(prose.words_of(sentence.text))} words: {sentence.text}")
    print(f"Sentences of more than {LONG_SENTENCE} words in {len(pages)} pages (for information): {sum(counts.values())}; "
          f"most in {', '.join(f'{file} {count}' for file, count in counts.most_common(5)) or 'none'}.")
    print(f"{len(findings)} house words, {len(errors)} other errors.")
    return 1 if findings or errors else 0


if __name__ == "__main__":
    sys.exit(main())
