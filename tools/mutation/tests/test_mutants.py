# SPDX-License-Identifier: Apache-2.0
"""Which mutants are drawn, and how the list of equivalent ones follows the source."""

import datetime
import re
import sys
from collections import Counter

from equivalent import Equivalents
from mutants import loop_ends, mutants_of
from mutate import arguments, is_too_low

SOURCE = """\
#include "base/scalar.h"

/* Counts up to 7
 * and no further. */
int count(int value) {
  if (value >= 7) { /* full */
    return 7; // says 8
  }
  return value + 1;
}
"""


def drawn(source, seed=1, file="firmware/base/count.c"):
    return sorted(mutants_of(file, source), key=lambda mutant: mutant.rank(seed))


def texts(mutants):
    return [(mutant.before, mutant.after) for mutant in mutants]


def test_a_mutant_changes_one_line_of_code_and_no_comment():
    mutants = drawn(SOURCE)
    assert ("return value + 1;", "return value - 1;") in texts(mutants)
    assert {mutant.line for mutant in mutants} == {5, 6, 7, 8, 9, 10}
    assert not any("full" in text or "8 " in text for pair in texts(mutants) for text in pair)


def test_a_low_score_of_few_mutants_may_be_chance():
    assert not is_too_low(Counter(killed=50, survived=10), 90.0)
    assert is_too_low(Counter(killed=48, survived=12), 90.0)
    assert is_too_low(Counter(killed=255, survived=45), 90.0)
    assert not is_too_low(Counter(killed=6), 90.0)


def test_the_mutated_source_differs_in_this_line_alone():
    mutant = next(mutant for mutant in drawn(SOURCE) if mutant.after == "return value - 1;")
    before, after = SOURCE.split("\n"), mutant.apply(SOURCE).split("\n")
    assert after[8] == "  return value - 1;"
    assert [index for index, line in enumerate(before) if re.sub(r"/[/*].*|^ \*.*", "", line).rstrip() != after[index].rstrip()] == [8]


def test_a_seed_draws_the_same_mutants_of_a_line_that_has_moved():
    moved = SOURCE.replace("int count", "static const int kOther = 3;\n\nint count")
    kept = [pair for pair in texts(drawn(moved)) if "kOther" not in pair[0]]
    assert kept == texts(drawn(SOURCE))


def test_the_seed_is_the_date_unless_one_is_given(monkeypatch):
    for words in ([], ["--seed", "47"]):
        monkeypatch.setattr(sys, "argv", ["mutate", *words])
        days = [int(f"{datetime.datetime.now(datetime.UTC):%Y%m%d}"), arguments().seed, int(f"{datetime.datetime.now(datetime.UTC):%Y%m%d}")]
        assert days[1] == 47 if words else days[0] <= days[1] <= days[2]


def test_lines_have_the_same_chance_whatever_their_number_of_mutants():
    first = [drawn(SOURCE, seed)[0] for seed in range(400)]
    counts = {line: sum(mutant.line == line for mutant in first) for line in range(5, 11)}
    assert all(40 <= count <= 100 for count in counts.values()), counts


def test_of_a_header_only_the_bodies_of_functions_are_mutated():
    header = "typedef struct {\n  int limit;\n} box;\n\n#define MOST 3\n\nstatic inline int twice(int x) {\n  return 2 * x;\n}\n"
    assert {mutant.before for mutant in drawn(header, file="firmware/base/box.h")} == {"return 2 * x;"}
    assert "#define MOST 3" in {mutant.before for mutant in drawn(header, file="firmware/base/box_list.h")}


LOOPS = """\
void every(int *values, int count) {
  for (int i = 0; i < count;
       i++) {
    if (values[i] == 0) {
      values[i] = 1;
    }
  }
  while (count > 0) {
    count--;
    if (count == 3) {
      count = 2;
    } else {
      count = 1;
    }
    count -= 2;
  }
}
"""


def test_a_continue_at_the_end_of_a_loop_is_no_mutant():
    lines = {mutant.line for mutant in drawn(LOOPS) if mutant.after == mutant.before + "\ncontinue;"}
    assert lines & {5, 6, 15} == set()
    assert {9, 11, 13, 14} <= lines
    assert loop_ends(LOOPS) == {5, 6, 15}


ENTRY = """\
[[equivalent]]
file = "firmware/base/count.c"
line = "return value + 1;"
mutants = ["return value - 1;"]
reason = "example"
"""


def test_an_equivalent_mutant_is_found_wherever_its_line_moves_and_is_stale_without_it():
    equivalents = Equivalents(ENTRY)
    for source in (SOURCE, "\n\n" + SOURCE):
        mutants = drawn(source)
        assert [mutant.after for mutant in mutants if equivalents.reason(mutant)] == ["return value - 1;"]
        assert equivalents.stale("firmware/base/count.c", mutants) == []
    for source in (SOURCE.replace("value + 1", "value + 2"), SOURCE.replace("  return value + 1;\n", "")):
        assert len(equivalents.stale("firmware/base/count.c", drawn(source))) == 1


def test_an_entry_with_the_line_before_it_names_one_of_several_equal_lines():
    source = SOURCE.replace("    return 7; // says 8", "    value--;\n    return value + 1;")
    found = {}
    for previous in ("value--;", "}", "if (value >= 8) {"):
        equivalents = Equivalents(ENTRY + f'previous = "{previous}"\n')
        found[previous] = [mutant.line for mutant in drawn(source) if equivalents.reason(mutant)]
        assert (equivalents.stale("firmware/base/count.c", drawn(source)) == []) == bool(found[previous])
    assert found == {"value--;": [8], "}": [10], "if (value >= 8) {": []}
