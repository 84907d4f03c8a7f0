"""The words check on small made-up trees."""

import tomllib

import pytest

import words

DATA = {
    "covered": ["."],
    "names_covered": ["."],
    "words": [
        {"house": "told", "write": "reported", "pattern": "told|tells?", "names": ["_told_"]},
        {"house": "stored set", "write": "parameter set", "pattern": "stored sets?"},
        {"house": "most_x", "write": "max_x", "names": [r"^_(?:k_)?most_\w"]},
    ],
    "exceptions": [],
    "interfaces": {},
    "left_out": {},
}


@pytest.fixture
def found_in(tmp_path):
    """`file:line word` of each finding, then the other errors, in a tree of these files."""

    def check(files, **data):
        for name, text in files.items():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text(text)
        findings, errors = words.check(tmp_path, {**DATA, **data})
        return [f"{finding.file}:{finding.line} {finding.found}" for finding in findings] + errors

    return check


@pytest.mark.parametrize("file, text, line", [
    ("a.md", "One\ntwo that is told.\n", 2),
    ("a.md", "| a | is told |\n", 1),
    ("a.h", "/* One\n * told. */\n", 2),
    ("a.cpp", 'error("x",\n  "was told {}");\n', 2),
    ("a.py", '"""One.\n\nTold.\n"""\n', 3),
    ("a.py", "x = 1  # told\n", 1),
    ("run.sh", "cat <<TEXT\nis told\nTEXT\n", 2),
    ("CMakeLists.txt", 'message(STATUS "is told")\n', 1),
    ("a.toml", "# is told\n", 1),
])
def test_a_house_word_is_found_in_everything_that_people_read(found_in, file, text, line):
    (found,) = found_in({file: text})
    assert found.lower() == f"{file}:{line} told".lower()


def test_a_phrase_is_found_across_lines(found_in):
    assert found_in({"a.h": "/* The stored\n * set. */\n"}) == ["a.h:1 stored set"]


@pytest.mark.parametrize("text", [
    "`told` and `a told b`\n", "```\ntold\n```\n", "[link](told.md)\n", 'key "told"\n', "option --told\n", "name is_told\n",
    "retold, toldness\n", "file told.json\n",
])
def test_code_font_links_and_names_are_not_read(found_in, text):
    assert found_in({"a.md": text}) == []


def test_identifiers_are_found_in_any_style(found_in):
    assert found_in({"a.c": "int told, is_told, kToldOnce, most_axes, kMostAxes, at_most, almost;\n"}) == [
        "a.c:1 told", "a.c:1 is_told", "a.c:1 kToldOnce", "a.c:1 most_axes", "a.c:1 kMostAxes"]
    assert found_in({"a.c": "", "a.py": 'def told(): return {"told": 1}\n'}) == ["a.py:1 told", "a.py:1 told"]


def test_names_of_interfaces_are_allowed(found_in):
    assert found_in({"a.py": 'x = {"told": 1}\n'}, interfaces={"told": "JSON key"}) == []


def test_an_interface_that_nothing_uses_is_an_error(found_in):
    assert found_in({"a.py": ""}, interfaces={"told": "JSON key"}) == ["words.toml: no file has the interface told: remove it."]


def test_an_exception_allows_a_phrase_and_must_be_used(found_in):
    exceptions = [{"text": "tell apart", "reason": "made up"}]
    assert found_in({"a.md": "We tell\napart and tell.\n"}, exceptions=exceptions) == ["a.md:2 tell"]
    assert found_in({"a.md": ""}, exceptions=exceptions) == ["words.toml: nothing needs the exception tell apart: remove it."]


def test_an_exception_can_be_for_some_files_only(found_in):
    exceptions = [{"text": "tell apart", "files": ["in"], "reason": "made up"}]
    assert found_in({"in/a.md": "tell apart", "out/a.md": "tell apart"}, exceptions=exceptions) == ["out/a.md:1 tell"]


def test_only_covered_folders_are_read(found_in):
    files = {"in/a.md": "told", "out/a.md": "told", "in/a.c": "int told;"}
    assert found_in(files, covered=["in"], names_covered=[]) == ["in/a.md:1 told"]


def test_left_out_files_are_not_read_and_must_exist(found_in):
    assert found_in({"a.md": "told"}, left_out={"a.md": "made up"}) == []
    assert found_in({"a.md": ""}, left_out={"gone.md": "made up"}) == [
        "words.toml: gone.md under left_out does not exist: remove it."]


def test_the_table_of_the_page_comes_from_the_glossary():
    page = f"Before\n{words.TABLE_START}\nold\n{words.TABLE_END}\nafter"
    text = words.page_with_table(page, words.Glossary(DATA))
    assert "| `told` | reported |" in text and "old\n<" not in text and text.startswith("Before") and text.endswith("after")
    with pytest.raises(ValueError):
        words.page_with_table("no marks", words.Glossary(DATA))


def test_every_word_and_exception_of_the_glossary_is_complete():
    data = tomllib.loads(words.GLOSSARY.read_text())
    assert all(word["write"] and (word.get("pattern") or word.get("names")) for word in data["words"])
    assert all(item["reason"] for item in data["exceptions"])
    assert all(data["interfaces"].values()) and all(data["left_out"].values())
