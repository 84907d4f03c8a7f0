# SPDX-License-Identifier: Apache-2.0
"""What ends `tools/release` before it makes anything: one sentence each."""

from __future__ import annotations

import os

import pytest
import releases
from releases import VERSION, must, run


@pytest.fixture
def tree(first, tmp_path):
    """A clone in which a release could be made."""
    return releases.clone(first, tmp_path / "clone")


def refused(tree, *words, version=VERSION, **environment):
    """The sentence."""
    done = run(tree, "tools/release", *words, version, **environment)
    assert done.returncode != 0 and done.stdout == "" and done.stderr.count("\n") == 1, done
    assert not (tree / "build/release").exists()
    return done.stderr


@pytest.mark.parametrize("change", ["README.md", "new file"])
def test_a_dirty_tree(tree, change):
    with (tree / change).open("a") as file:
        file.write("changed\n")
    assert "has changes that are not committed" in refused(tree)


def test_a_version_that_is_tagged_elsewhere(tree):
    must(tree, "git", "tag", f"v{VERSION}", "HEAD~1")
    assert f"version {VERSION} exists already" in refused(tree)
    assert f"version {VERSION} exists already" in refused(tree, "--prepare")


def test_a_version_that_is_made_already(tree):
    (tree / f"build/release/trackservo-{VERSION}").mkdir(parents=True)
    done = run(tree, "tools/release", VERSION)
    assert done.returncode != 0 and "exists already: remove it" in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("file", "old", "sentence"),
    [
        ("CHANGELOG.md", f"## [{VERSION}]", "CHANGELOG.md has no section"),
        ("docs/releases.md", f"| {VERSION} |", "docs/releases.md has no row for version"),
    ],
)
def test_a_page_without_the_version(tree, file, old, sentence):
    text = (tree / file).read_text("utf-8")
    assert old in text
    (tree / file).write_text(text.replace(old, old.replace(VERSION, "98.0.0")), "utf-8")
    must(tree, "git", "commit", "--quiet", "--all", "--message", "x")
    assert sentence in refused(tree)


def test_another_version_than_the_trees(tree):
    assert f"the tree has version {VERSION}" in refused(tree, version="99.0.1")
    assert "is no version" in refused(tree, version="1.2")
    assert "older than the tree's" in refused(tree, "--prepare", version="1.0.0")
    assert f"has version {VERSION} already" in refused(tree, "--prepare")


def test_a_missing_tool(tree, tmp_path):
    tools = tmp_path / "tools"
    tools.mkdir()
    for folder in ("/usr/bin", "/bin"):
        for name in os.listdir(folder):
            if name != "arm-none-eabi-gcc" and not (tools / name).exists():
                (tools / name).symlink_to(f"{folder}/{name}")
    assert "arm-none-eabi-gcc is missing: ./tools/setup release installs it." in refused(tree, PATH=str(tools))
    (tree / "build/release-venv").unlink()
    assert "./tools/setup release installs them" in refused(tree)
