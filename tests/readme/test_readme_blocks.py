# SPDX-License-Identifier: Apache-2.0
"""What counts as a command of the README, and what its marks may contain."""

from pathlib import Path

import pytest

from readme_blocks import Kind, ReadmeError, blocks_of

PROJECT = Path(__file__).resolve().parents[2]
README = PROJECT / "README.md"


def test_every_sh_block_is_found_and_no_other():
    text = "# T\n## One\n```sh\n./a\n```\n```text\nno command\n```\n## Two\n```sh\n./b --c \\\n  d\n# a comment\n./e\n```\n"
    first, second = blocks_of(text)
    assert (first.headline, first.commands, first.line) == ("One", ("./a",), 4)
    assert (second.headline, second.commands) == ("Two", ("./b --c \\\n  d", "./e"))

def test_a_background_block_names_what_it_prints_when_ready():
    (block,) = blocks_of("<!-- run: background, ready: ready -->\n```sh\n./serve\n```\n")
    assert (block.kind, block.detail, block.to_run) == (Kind.BACKGROUND, "ready", ("./serve",))

def test_hardware_names_what_is_run_on_the_emulated_board():
    (block,) = blocks_of("<!-- run: hardware, on the emulated board: ./emulate -->\n```sh\n./flash\n```\n")
    assert (block.kind, block.to_run) == (Kind.HARDWARE, ("./emulate",))

def test_only_the_test_itself_is_run_otherwise_than_printed():
    (block,) = blocks_of("<!-- run: instead: ./tools/test format -->\n```sh\n./tools/test\n```\n")
    assert block.to_run == ("./tools/test format",)
    with pytest.raises(ReadmeError, match="only ./tools/test"):
        blocks_of("<!-- run: instead: true -->\n```sh\n./tools/demo\n```\n")

@pytest.mark.parametrize(
    "text",
    [
        "<!-- run: never -->\n```sh\n./a\n```\n",
        "<!-- run: background, ready: x -->\nwords\n```sh\n./a\n```\n",
        "<!-- run: background, ready: x -->\n```text\n./a\n```\n",
        "```sh\n./a\n",
    ],
)
def test_a_mark_that_is_not_understood_or_belongs_to_nothing_is_refused(text):
    with pytest.raises(ReadmeError, match="line"):
        blocks_of(text)


def test_the_readme_itself_can_be_run():
    blocks = blocks_of(README.read_text())
    assert blocks[0].commands == ("./tools/demo",)
    assert {Kind.FOREGROUND, Kind.BACKGROUND, Kind.HARDWARE, Kind.INSTEAD} == {block.kind for block in blocks}


def test_so_can_the_page_of_a_release():
    blocks = blocks_of((PROJECT / "tools/releasing/START.md").read_text())
    assert {Kind.FOREGROUND, Kind.BACKGROUND, Kind.HARDWARE} == {block.kind for block in blocks}
