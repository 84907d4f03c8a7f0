"""Drawing and checking a sample in a small repository."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import draw_sentences

CHECKS = Path(draw_sentences.__file__).parent


def git(root, *arguments):
    identity = ["-c", "user.name=Test", "-c", "user.email=test@example.com"]
    return subprocess.run(["git", "-C", str(root), *identity, *arguments], check=True, capture_output=True, text=True).stdout.strip()


def numbered(text, count=60):
    return [text.format(chr(ord("a") + i // 26) + chr(ord("a") + i % 26)) for i in range(count)]


@pytest.fixture
def repository(tmp_path):
    shutil.copytree(CHECKS, tmp_path / "tools/source_checks", ignore=shutil.ignore_patterns("tests", "__pycache__"))
    files = {
        "docs/page.md": "\n\n".join(numbered("Page sentence with letters {}.")),
        "firmware/a.c": "\n".join(numbered("/* A comment with letters {}. */\nint x;")),
        "sim_host/b.cpp": "\n".join(numbered('fail("a message with letters {}");')),
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text + "\n")
    git(tmp_path, "init", "-q", "-b", "main")
    git(tmp_path, "add", "-A")
    git(tmp_path, "commit", "-q", "-m", "start")
    return tmp_path


def write_list(root, rewrites=0):
    commit = git(root, "rev-parse", "HEAD")
    page = draw_sentences.page_of(commit, draw_sentences.draw_of_commit(commit, root))
    verdicts = iter(["| rewrite | better |"] * rewrites + ["| ok |  |"] * 100)
    page = re.sub(r"\|  \|  \|$", lambda _: next(verdicts), page, flags=re.MULTILINE)
    (root / draw_sentences.LIST).parent.mkdir(exist_ok=True)
    (root / draw_sentences.LIST).write_text(page)


def commit_all(root):
    git(root, "add", "-A")
    git(root, "commit", "-q", "-m", "more")


def test_a_drawn_list_with_verdicts_passes_before_and_after_its_commit(repository):
    write_list(repository, rewrites=3)
    assert draw_sentences.check(repository)[0] == []
    commit_all(repository)
    (repository / "docs/page.md").write_text("All pages are new now.\n")
    commit_all(repository)
    errors, summary = draw_sentences.check(repository)
    assert errors == [] and summary.startswith("100 sentences, 3 to be rewritten; compared with the draw")


def test_the_script_of_the_tree_draws_and_writes_the_list(repository):
    subprocess.run([sys.executable, "tools/source_checks/draw_sentences.py"], cwd=repository, check=True)
    errors, _ = draw_sentences.check(repository)
    assert len(errors) == 100 and 'the verdict is ""' in errors[0]


def test_another_commit_draws_other_sentences(repository):
    first = draw_sentences.draw(repository, "0" * 40)
    assert first == draw_sentences.draw(repository, "0" * 40)
    assert first != draw_sentences.draw(repository, "1" * 40)
    assert {kind: len(drawn) for kind, drawn in first.items()} == draw_sentences.DRAWN


def test_a_sentence_that_was_exchanged_is_found(repository):
    write_list(repository)
    page = (repository / draw_sentences.LIST).read_text()
    (repository / draw_sentences.LIST).write_text(re.sub(r"Page sentence with letters \w+", "A sentence that I like more", page, count=1))
    (error,) = draw_sentences.check(repository)[0]
    assert '"Pages" is not what' in error


def test_a_list_of_another_commit_than_the_parent_is_found(repository):
    write_list(repository)
    git(repository, "commit", "-q", "--allow-empty", "-m", "between")
    commit_all(repository)
    (error,) = draw_sentences.check(repository)[0]
    assert "but the commit before the one that adds it is" in error


def test_too_many_rewrites_and_missing_verdicts_are_found(repository):
    write_list(repository, rewrites=4)
    (error,) = draw_sentences.check(repository)[0]
    assert "4 sentences are to be rewritten, at most 3 may be" in error
    page = (repository / draw_sentences.LIST).read_text()
    (repository / draw_sentences.LIST).write_text(page.replace("| rewrite | better |", "| rewrite |  |", 1).replace("| ok |  |", "| fine |  |", 1))
    errors = draw_sentences.check(repository)[0]
    assert any("needs the rewritten sentence" in error for error in errors) and any('the verdict is "fine"' in error for error in errors)


def test_a_missing_list_and_a_missing_history_are_said(repository, tmp_path_factory):
    assert "does not exist" in draw_sentences.check(repository)[0][0]
    write_list(repository)
    commit_all(repository)
    git(repository, "commit", "-q", "--allow-empty", "-m", "after")
    clone = tmp_path_factory.mktemp("clone")
    subprocess.run(["git", "clone", "-q", "--depth", "1", f"file://{repository}", str(clone)], check=True)
    errors, summary = draw_sentences.check(clone)
    assert errors == [] and "NOT compared with the draw" in summary


def test_bars_in_a_sentence_do_not_break_the_row():
    drawn = {"comment": [["a.h:1", "one | two three four"]], "page": [], "message": []}
    page = draw_sentences.page_of("0" * 40, drawn)
    assert draw_sentences.read_page(page)[1] == {"comment": [["a.h:1", draw_sentences.cell("one | two three four")]]}


def test_a_link_in_a_sentence_is_its_text():
    assert draw_sentences.cell("See [the page](../page.md#top) and `code`.") == "See the page and `code`."


@pytest.mark.parametrize("text, expected", [
    ("The drive is in fault.", True), ("Three words only.", False), ("%d %s %5.2f %s %s of the whole row", False),
    ("Unknown option \"{}\": choose one of these: {}.", True), ("2060 4 12 17 18 19 the row is long", False),
])
def test_what_counts_as_a_sentence(text, expected):
    assert draw_sentences.is_sentence(text) == expected
