"""What counts as a page, a comment, a message or a name, and where a sentence ends."""

import textwrap

import pytest

import prose


def passages(reader, source, *kinds):
    return [(line, text) for line, kind, text in reader(source) if kind in kinds]


def plain(found):
    return [(line, " ".join(text.split())) for line, text in found]


def test_markdown_is_paragraphs_items_headings_and_cells():
    source = "# Title\nA paragraph\nof two lines.\n\n- one\n  more\n- two\n\n| a | b c |\n|---|---|\n| `x` | d |\n"
    assert plain(passages(prose.markdown, source, "page")) == [
        (1, "# Title"), (2, "A paragraph of two lines."), (5, "- one more"), (7, "- two"), (9, "a"), (9, "b c"), (11, "`x`"), (11, "d")]


def test_markdown_leaves_code_blocks_out():
    source = "Before.\n```sh\nnot read\n```\nAfter.\n~~~\nnot read\n~~~\n"
    assert plain(passages(prose.markdown, source, "page")) == [(1, "Before."), (5, "After.")]


def test_c_comments_lose_their_marks_and_keep_their_lines():
    source = "/* One\n * two. */\nint x; /* three */\n// four\n// five\nint y; // six\n"
    assert passages(prose.c_passages, source, "comment")[0][1].count("\n") == 1
    assert plain(passages(prose.c_passages, source, "comment")) == [(1, "One two."), (3, "three"), (4, "four five"), (6, "six")]


def test_c_strings_side_by_side_are_one_message():
    source = 'f("one "\n  "two\\n", "name", R"(three "x" four)", "a" B "c d");\n#include "no message.h"\n'
    assert plain(passages(prose.c_passages, source, "message")) == [(1, "one two"), (2, 'three "x" four'), (2, "c d")]


def test_c_comments_within_strings_and_strings_within_comments():
    source = 'char *s = "/* no comment */"; // a "string" in it\nint n = 1\'000\'000; /* it\'s one */\n'
    assert plain(passages(prose.c_passages, source, "comment")) == [(1, 'a "string" in it'), (2, "it's one")]


def test_c_names_come_from_code_and_from_strings_of_one_word():
    source = '/* comment */ int kept = f("word", "two words");\n'
    assert {text for _, text in passages(prose.c_passages, source, "name")} == {"int", "kept", "f", "word"}


def test_python_docstrings_are_comments_and_other_strings_messages():
    source = textwrap.dedent('''\
        """Of the module."""
        # one
        # two
        def f(x):
            """Of f."""
            raise Error(f"value {x.kept} is "
                        "wrong")  # why
        ''')
    assert plain(passages(prose.python_passages, source, "comment")) == [
        (1, "Of the module."), (5, "Of f."), (2, "one two"), (7, "why")]
    assert plain(passages(prose.python_passages, source, "message")) == [(6, "value {} is wrong")]
    assert "raise" in {text for _, text in passages(prose.python_passages, source, "name")}


def test_expressions_in_python_strings_are_not_read():
    source = 'say(f"stored{f\'; CRC {crc}\' if crc else \'\'} and {{braces}}.")\n'
    assert plain(passages(prose.python_passages, source, "message")) == [(1, "stored{} and braces.")]


def test_shell_comments_strings_and_usage_texts():
    source = "#!/bin/sh\n# one\n# two\nn=$#\ncat <<'TEXT'\nusage of this\n\n  more text\nTEXT\ndie \"no such file\" 'name'\n"
    assert plain(passages(prose.hash_passages, source, "comment")) == [(2, "one two")]
    assert plain(passages(prose.hash_passages, source, "message")) == [(6, "usage of this"), (8, "more text"), (10, "no such file")]


def test_toml_comments_and_strings():
    source = '# why\nkey = "two words" # not "this"\nname = "one"\n'
    assert plain(passages(prose.toml_passages, source, "comment")) == [(1, "why"), (2, 'not "this"')]
    assert plain(passages(prose.toml_passages, source, "message")) == [(2, "two words")]


def test_templates_are_read_without_tags_and_expressions():
    source = "<p class='x'>One {{ value }}\ntwo</p>\n\n<script>not read</script>\n"
    assert plain(passages(prose.template_text, source, "message")) == [(1, "One two")]


def test_files_without_suffix_are_read_when_they_are_scripts(tmp_path):
    for name, text in {"run": "#!/usr/bin/env bash\n", "LICENSE": "Text\n", "build/x.md": "", "docs/a.md": "", "x.bin": ""}.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    assert sorted(prose.files_of(tmp_path)) == ["docs/a.md", "run"]


@pytest.mark.parametrize("text, expected", [
    ("One. Two!  Three?", ["One.", "Two!", "Three?"]),
    ("At 1.5 ms, e.g. now, it ends. `code` follows.", ["At 1.5 ms, e.g. now, it ends.", "`code` follows."]),
    ("See Fig. 3 of it. (Then this.)", ["See Fig. 3 of it.", "(Then this.)"]),
    ("- an item. Its second\n  line.\n- next", ["an item.", "Its second line.", "next"]),
])
def test_sentences(text, expected):
    assert [sentence.text for sentence in prose.sentences(prose.Passage("a.md", 1, "page", text))] == expected


def test_a_sentence_knows_its_line():
    passage = prose.Passage("a.h", 10, "comment", " One\n two. Three\n four.\n\n Five.")
    assert [(sentence.line, sentence.text) for sentence in prose.sentences(passage)] == [
        (10, "One two."), (11, "Three four."), (14, "Five.")]
