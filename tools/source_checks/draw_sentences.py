"""A sample of 100 sentences of the tree, drawn by the hash of a commit, with a verdict on each.

The sample is drawn from the tree of the commit before the one that adds the list, so nobody can choose it. Every
sentence gets sha256(hash of the commit + place and text of the sentence), and those with the lowest numbers are drawn.
The tree's own copy of this script draws, so a later change of the script does not change the draw of an old list.

    draw_sentences.py           draw from HEAD and write the list; then fill in verdict and rewrite, and commit it
    draw_sentences.py --check   the list is what its commit draws, each verdict is given, and few say "rewrite"
"""

import argparse
import hashlib
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import prose

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = Path(__file__).resolve().relative_to(ROOT)
LIST = "docs/checks/sentences.md"
DRAWN = {"comment": 40, "page": 40, "message": 20}
MAX_REWRITES = 3
MIN_WORDS = 4
CODE = (".c", ".h", ".cpp", ".hpp", ".py")
TITLES = {"comment": "Headers and comments", "page": "Pages", "message": "Messages"}


def is_drawn_from(passage):
    if passage.file == LIST:
        return False
    if passage.kind == "page":
        return True
    if passage.kind == "comment":
        return passage.file.endswith(CODE)
    in_tests = "tests" in Path(passage.file).parts
    return passage.kind == "message" and not in_tests and "source_checks" not in passage.file


def is_sentence(text):
    """At least four words of letters, and most of it is words: no format string, no pattern, no row of figures."""
    words = [word for word in text.split() if re.fullmatch(r"[\"'(`\[]*[A-Za-z][A-Za-z'-]*[\"')`\],.:;!?]*", word)]
    return len(words) >= MIN_WORDS and 2 * len(words) >= len(text.split())


def population(root):
    """For each kind, the sentences of the tree with the place of each; the same text in the same file counts once."""
    found = {kind: {} for kind in DRAWN}
    for file in sorted(prose.files_of(root)):
        for passage in prose.passages_of(root, file):
            if passage.kind in DRAWN and is_drawn_from(passage):
                for sentence in prose.sentences(passage):
                    if is_sentence(sentence.text):
                        found[passage.kind].setdefault((file, sentence.text), sentence.line)
    return found


def draw(root, commit):
    """For each kind, [place, sentence] in the order of their hashes."""
    drawn = {}
    for kind, sentences in population(root).items():
        def order(sentence):
            return hashlib.sha256(f"{commit}{sentence[0]}:{sentence[1]}".encode()).hexdigest()
        chosen = sorted(sentences, key=order)[:DRAWN[kind]]
        drawn[kind] = [[f"{file}:{sentences[file, text]}", text] for file, text in chosen]
    return drawn


def git(*arguments, root=ROOT):
    return subprocess.run(["git", "-C", str(root), *arguments], check=True, capture_output=True, text=True).stdout.strip()


def draw_of_commit(commit, root):
    """What the tree of the commit draws from itself."""
    with tempfile.TemporaryDirectory() as folder:
        archive = subprocess.run(["git", "-C", str(root), "archive", commit], check=True, capture_output=True).stdout
        subprocess.run(["tar", "-x", "-C", folder], input=archive, check=True)
        run = subprocess.run([sys.executable, str(SCRIPT), "--print", commit], cwd=folder, check=True, capture_output=True, text=True)
        return json.loads(run.stdout)


def cell(text):
    """The text in a cell of a Markdown table; a link, which leads elsewhere from here, is only its text."""
    text = re.sub(r"\[([^\[\]]*)\]\([^()\s]*\)", r"\1", text)
    return text.replace("\\", "\\\\").replace("|", "\\|")


def page_of(commit, drawn):
    lines = [
        "# Sentences drawn by lot", "",
        "A sample of what people read in this repository, and whether an engineer would rewrite it. `draw_sentences.py` in",
        "`tools/source_checks` drew it from the tree of the commit before the one that adds this page, by that commit's hash.",
        f"At most {MAX_REWRITES} of the {sum(DRAWN.values())} may be \"rewrite\".", "",
        f"Drawn from commit: `{commit}`", ""]
    for kind, sentences in drawn.items():
        lines += [f"## {TITLES[kind]}", "", "| place | sentence | verdict | rewrite |", "|---|---|---|---|"]
        lines += [f"| {place} | {cell(text)} |  |  |" for place, text in sentences]
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def read_page(page):
    """(commit, {kind: [[place, sentence]]}, [(place, verdict, rewrite)])."""
    commit = re.search(r"^Drawn from commit: `([0-9a-f]{40})`$", page, re.MULTILINE)
    if commit is None:
        raise ValueError(f'{LIST}: the line "Drawn from commit: `...`" is missing.')
    drawn, verdicts, kind = {}, [], None
    for line in page.splitlines():
        if line.startswith("## "):
            kind = next((kind for kind, title in TITLES.items() if line == f"## {title}"), None)
        elif line.startswith("| ") and not line.startswith("| place |") and kind is not None:
            cells = [part.strip() for part in re.split(r"(?<!\\)\|", line)[1:-1]]
            if len(cells) != 4:
                raise ValueError(f"{LIST}: a row needs four cells: {line}")
            place, text, verdict, rewrite = cells
            drawn.setdefault(kind, []).append([place, text])
            verdicts.append((place, verdict, rewrite))
    return commit[1], drawn, verdicts


def errors_of_verdicts(verdicts):
    for place, verdict, rewrite in verdicts:
        if verdict not in ("ok", "rewrite"):
            yield f'{LIST}: {place}: the verdict is "{verdict}"; it must be "ok" or "rewrite".'
        elif verdict == "rewrite" and not rewrite:
            yield f"{LIST}: {place}: a verdict \"rewrite\" needs the rewritten sentence."
    rewrites = sum(verdict == "rewrite" for _, verdict, _ in verdicts)
    if rewrites > MAX_REWRITES:
        yield f"{LIST}: {rewrites} sentences are to be rewritten, at most {MAX_REWRITES} may be."


def errors_of_draw(root, commit, drawn):
    """Compares the list with the draw of its commit. Nothing is compared when the clone lacks the commit."""
    adding = git("log", "--reverse", "--format=%H", f"-S{commit}", "--", LIST, root=root).splitlines()
    parent = git("rev-parse", f"{adding[0]}^", root=root) if adding else git("rev-parse", "HEAD", root=root)
    if parent != commit:
        yield f"{LIST} was drawn from {commit[:10]}, but the commit before the one that adds it is {parent[:10]}: draw again."
    expected = {kind: [[place, cell(text)] for place, text in sentences] for kind, sentences in draw_of_commit(commit, root).items()}
    for kind, sentences in expected.items():
        if drawn.get(kind, []) != sentences:
            given = drawn.get(kind, [])
            first = next((i for i, (a, b) in enumerate(zip(given, sentences)) if a != b), min(len(given), len(sentences)))
            yield f"{LIST}: \"{TITLES[kind]}\" is not what {commit[:10]} draws, from row {first + 1} on: draw again."


def has_commit(root, commit):
    return subprocess.run(["git", "-C", str(root), "cat-file", "-e", f"{commit}^{{commit}}"], capture_output=True).returncode == 0


def check(root):
    """The errors, and what was checked in a sentence."""
    page = root / LIST
    if not page.is_file():
        return [f"{LIST} does not exist: run {SCRIPT} to draw it."], ""
    commit, drawn, verdicts = read_page(page.read_text())
    errors = list(errors_of_verdicts(verdicts))
    counts = {kind: len(sentences) for kind, sentences in drawn.items()}
    if counts != DRAWN:
        errors.append(f"{LIST} has {counts} sentences; it must have {DRAWN}.")
    summary = f"{len(verdicts)} sentences, {sum(verdict == 'rewrite' for _, verdict, _ in verdicts)} to be rewritten"
    if has_commit(root, commit):
        errors += errors_of_draw(root, commit, drawn)
        return errors, f"{summary}; compared with the draw of {commit[:10]}."
    return errors, f"{summary}; NOT compared with the draw: this clone does not have {commit[:10]} (fetch the whole history)."


def main():
    parser = argparse.ArgumentParser(description=f"Draw {sum(DRAWN.values())} sentences by the hash of HEAD into {LIST}, or check that list.")
    parser.add_argument("--check", action="store_true", help="check the committed list and its verdicts")
    parser.add_argument("--print", metavar="HASH", dest="commit", help="print what this tree draws by that hash, as JSON")
    arguments = parser.parse_args()
    if arguments.commit:
        json.dump(draw(ROOT, arguments.commit), sys.stdout)
        return 0
    if arguments.check:
        errors, summary = check(ROOT)
        for line in [*errors, summary]:
            print(line)
        return 1 if errors else 0
    commit = git("rev-parse", "HEAD")
    (ROOT / LIST).parent.mkdir(parents=True, exist_ok=True)
    (ROOT / LIST).write_text(page_of(commit, draw_of_commit(commit, ROOT)))
    print(f"{LIST} has the sentences of {commit[:10]}. Fill in the verdicts (ok or rewrite) and commit it as the next commit.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
