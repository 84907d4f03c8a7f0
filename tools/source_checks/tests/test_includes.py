# SPDX-License-Identifier: Apache-2.0
"""The include check on small made-up trees."""

import pytest

import includes

LAYERS = {
    "top_folders": ["low", "high"],
    "from_outside": ["unity.h"],
    "include_roots": {"low": ["low", "high"], "high": ["high"]},
    "may_include": {"low/base": [], "low/control": ["low/base"], "low/node": ["low/base", "low/control"], "high": ["low"]},
}
CLEAN = {
    "low/base/angle.h": "",
    "low/control/pi.h": '#include "base/angle.h"\n',
    "low/control/pi.c": '#include "control/pi.h"\n#include <math.h>\n',
    "low/node/node.c": '#include "control/pi.h"\n',
    "high/run.cpp": '#include "node/node.h"\n',
    "low/node/node.h": "",
}


@pytest.fixture
def errors_of(tmp_path):
    """What the check finds in the clean tree with these files changed or added."""

    def check(files=None, layers=None):
        for name, text in {**CLEAN, **(files or {})}.items():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text(text)
        return includes.check(tmp_path, {**LAYERS, **(layers or {})})[1]

    return check


def test_a_clean_tree_has_no_errors(errors_of):
    assert errors_of() == []


def test_a_circle_of_two_is_named_with_its_lines(errors_of):
    free = {"may_include": {"low/base": ["low"], "low/control": ["low"], "low/node": ["low"], "high": ["low"]}}
    (error,) = errors_of({"low/base/angle.h": '\n#include "control/pi.h"\n'}, free)
    assert error.splitlines() == [
        "Include circle between folders: low/base -> low/control -> low/base",
        "    low/base/angle.h:2 includes low/control/pi.h",
        "    low/control/pi.h:1 includes low/base/angle.h",
    ]


def test_a_circle_of_three_is_named_with_its_lines(errors_of):
    free = {"may_include": {"low": [], "high": ["low"]}}
    (error,) = errors_of({"low/base/angle.h": '#include "node/node.h"\n'}, free)
    assert error.splitlines() == [
        "Include circle between folders: low/base -> low/node -> low/control -> low/base",
        "    low/base/angle.h:1 includes low/node/node.h",
        "    low/node/node.c:1 includes low/control/pi.h",
        "    low/control/pi.h:1 includes low/base/angle.h",
    ]


def test_a_folder_and_its_sub_folder_can_make_a_circle(errors_of):
    errors = errors_of({
        "high/part/part.hpp": '#include "run.hpp"\n',
        "high/run.hpp": "",
        "high/run.cpp": '#include "part/part.hpp"\n',
    })
    assert [error.splitlines()[0] for error in errors] == ["Include circle between folders: high -> high/part -> high"]


def test_two_circles_are_two_errors(errors_of):
    free = {"may_include": {"low": [], "high": []}}
    errors = errors_of({
        "low/base/angle.h": '#include "control/pi.h"\n',
        "high/run.cpp": '#include "part/part.hpp"\n',
        "high/part/part.hpp": '#include "top.hpp"\n',
        "high/top.hpp": "",
    }, free)
    assert sorted(error.splitlines()[0] for error in errors) == [
        "Include circle between folders: high -> high/part -> high",
        "Include circle between folders: low/base -> low/control -> low/base",
    ]


def test_folders_of_a_large_circle_that_the_shortest_leaves_out_are_named(errors_of):
    free = {"may_include": {"low": [], "high": ["low"]}}
    (error,) = errors_of({"low/base/angle.h": '#include "node/node.h"\n#include "control/pi.h"\n'}, free)
    assert error.splitlines()[0] == "Include circle between folders: low/base -> low/control -> low/base"
    assert error.splitlines()[-1] == "    other folders that include each other here: low/node"


def test_an_arrow_upwards_is_an_error(errors_of):
    (error,) = errors_of({"low/control/up.c": '#include "base/angle.h"\n#include "drive/high.h"\n', "low/drive/high.h": ""},
                         {"may_include": {**LAYERS["may_include"], "low/drive": []}})
    assert error.startswith("low/control/up.c:2 includes low/drive/high.h, but low/control may include only: low/control, low/base.")


def test_a_folder_without_a_layer_is_an_error(errors_of):
    assert errors_of({"low/new/new.c": ""}) == ["low/new has no line in layers.toml: say under may_include what it may include."]


def test_a_layer_without_a_folder_is_an_error(errors_of):
    layers = {"may_include": {**LAYERS["may_include"], "low/gone": []}}
    assert errors_of(layers=layers) == ["layers.toml names low/gone, but no source lies there."]


def test_an_include_that_means_two_files_is_an_error(errors_of):
    (error,) = errors_of({"high/base/angle.h": "", "high/run.cpp": '#include "base/angle.h"\n'})
    assert error.startswith('high/run.cpp:1: "base/angle.h" is ambiguous: it can be high/base/angle.h or low/base/angle.h.')


def test_a_file_beside_and_one_below_a_root_are_two(errors_of):
    (error,) = errors_of({"low/top.h": "", "low/node/top.h": "", "low/node/node.c": '#include "top.h"\n'},
                         {"may_include": {"low": [], "high": ["low"]}})
    assert error.startswith('low/node/node.c:1: "top.h" is ambiguous: it can be low/node/top.h or low/top.h.')


def test_one_file_found_twice_is_not_ambiguous(errors_of):
    assert errors_of({"high/own.hpp": "", "high/run.cpp": '#include "own.hpp"\n'}) == []


def test_an_include_that_is_not_found_is_an_error(errors_of):
    (error,) = errors_of({"low/node/node.c": '#include "control/pid.h"\n'})
    assert error.startswith('low/node/node.c:1: "control/pid.h" is not found')


def test_a_root_that_the_folder_does_not_use_is_not_searched(errors_of):
    (error,) = errors_of({"low/node/node.c": '#include "run.hpp"\n', "high/run.hpp": ""})
    assert "is not found" in error


def test_files_from_outside_and_includes_in_comments_are_not_read(errors_of):
    assert errors_of({"low/node/node.c": '#include "unity.h"\n/*\n#include "gone.h"\n*/\n// #include "gone.h"\n'}) == []


def test_a_path_with_dots_is_resolved(errors_of):
    assert errors_of({"high/part/part.cpp": '#include "../run.hpp"\n', "high/run.hpp": ""}) == []


def test_the_tests_of_a_block_may_include_everything_but_other_tests(errors_of):
    assert errors_of({"low/control/tests/test_pi.c": '#include "control/pi.h"\n#include "node/node.h"\n#include "bench.h"\n',
                      "low/control/tests/bench.h": ""}) == []
    (error,) = errors_of({"low/node/tests/test_node.c": '#include "control/tests/bench.h"\n'})
    assert error.startswith("low/node/tests/test_node.c:1 includes low/control/tests/bench.h, but the tests of a block")
