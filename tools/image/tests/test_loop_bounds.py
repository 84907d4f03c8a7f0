# SPDX-License-Identifier: Apache-2.0
"""Which loops end by themselves, and the requirements for the others."""

import pytest

import loop_bounds


def loops(source):
    return list(loop_bounds.loops_of("a.c", source))


def counts(source):
    (loop,) = loops(source)
    return loop_bounds.counts_by_itself(loop)


@pytest.mark.parametrize("source", [
    "for (int i = 0; i < 8; ++i) { f(i); }",
    "for (uint32_t i = 0; i < SERVO_AXES; i++) f(i);",
    "for (unsigned i = 0; i < sizeof parts / sizeof parts[0]; ++i) {}",
    "for (int shift = BITS / 4 * 4; shift >= 0; shift -= BITS) {}",
    "for (int i = 0; i < MOST && queue_pop(&q); ++i) {}",
    "for (int i = 0; i < 8; ++i) { other->i = 3; if (i == 4) { g(i); } }",
])
def test_a_loop_that_counts_to_a_constant(source):
    assert counts(source)


@pytest.mark.parametrize("source", [
    "for (;;) {}",
    "while (n > 0) { n /= 2; }",
    "for (int i = 0; i < count; ++i) {}",
    "for (int i = count; i > 0; --i) {}",
    "for (int i = start; i < 8; ++i) {}",
    "for (int i = 0; i < 8; --i) {}",
    "for (int i = 7; i >= 0; ++i) {}",
    "for (int i = 0; i < 8 || more; ++i) {}",
    "for (int i = 0; i < 8; ++i) { i = 0; }",
    "for (int i = 0; i < 8; ++i) { i -= 1; }",
    "for (int i = 0; i < 8; ++i) { f(&i); }",
    "for (int i = 0; i < 8; ++i) i--;",
])
def test_a_loop_that_needs_a_reason(source):
    assert not counts(source)


def test_comments_texts_and_directives_are_no_loops():
    assert loops('/* for (;;) {} */ // while (1)\n#define FOREVER for (;;)\nchar *s = "while (1) {}";') == []


def test_nested_loops_are_two():
    inner_of_outer = loops("for (int i = 0; i < 2; ++i) {\n  while (x) {}\n}")
    assert [(loop.line, loop.head) for loop in inner_of_outer] == [(1, "int i = 0; i < 2; ++i"), (2, "x")]


@pytest.mark.parametrize("source", ["do { f(); } while (x);", "again: goto again;"])
def test_other_kinds_of_loop_are_refused(source):
    with pytest.raises(ValueError):
        loops(source)


def test_a_loop_needs_its_bound_directly_above():
    assert not list(loop_bounds.errors_of("a.c", "/* Bound: 3: x is counted\n * down. */\nwhile (x) {}"))
    (error,) = loop_bounds.errors_of("a.c", "f();\nwhile (x) {}")
    assert error == "a.c:2: no bound is known for this loop (x): say it above, /* Bound: ... */"
    assert len(list(loop_bounds.errors_of("a.c", "/* Bound: 3. */\nf();\nwhile (x) {}"))) == 2
    assert list(loop_bounds.errors_of("a.c", "/* Bound: */\nwhile (x) {}"))


def test_a_bound_above_a_loop_that_counts_by_itself_is_reported():
    (error,) = loop_bounds.errors_of("a.c", "/* Bound: 8. */\nfor (int i = 0; i < 8; ++i) {}")
    assert error == "a.c: 1 of the comments /* Bound: ... */ are not above a loop that needs one"
