# SPDX-License-Identifier: Apache-2.0
"""Changelog and table of stored sets: what --prepare writes, and what is refused."""

import changelog
import prepare
import pytest
import stored_sets
from errors import ReleaseError

LOG = "# Changelog\n\n## [Unreleased]\n\n### Bus\n\n- New.\n\n## [0.1.0] - 2026-12-01\n\n- First.\n"


def test_a_closed_section_has_what_was_not_released_yet():
    closed = changelog.closed(LOG, "0.2.0", "2027-01-02")
    assert changelog.notes(closed, "0.2.0") == "### Bus\n\n- New."
    assert changelog.notes(closed, "0.1.0") == "- First."
    assert changelog.sections(closed)["Unreleased"] == (None, "")


@pytest.mark.parametrize(("log", "version"), [(LOG, "0.1.0"), (LOG.replace("### Bus\n\n- New.\n", ""), "0.2.0")])
def test_a_version_that_exists_and_an_empty_section_are_refused(log, version):
    with pytest.raises(ReleaseError):
        changelog.closed(log, version, "2027-01-02")


@pytest.mark.parametrize("version", ["Unreleased", "0.3.0"])
def test_a_section_that_is_open_or_missing_has_no_notes(version):
    with pytest.raises(ReleaseError, match="has no section"):
        changelog.notes(LOG, version)


def device(*rows):
    return {"schema_hash": 0xABC, "objects": [{"index": index, "sub": 1, "type": "REAL32", "stored": True} for index in rows]}


def test_the_row_counts_what_becomes_of_earlier_sets():
    earlier = {"0.2.0": stored_sets.stored(device(1, 2, 3)), "0.1.0": stored_sets.stored(device(1, 9))}
    row = stored_sets.row("0.3.0", "2027-01-02", device(1, 2, 3), earlier)
    assert row == (
        "| 0.3.0 | 2027-01-02 | 00000ABC | 3 | 0.2.0: kept; 0.1.0: kept, 1 values dropped and 2 new values at their defaults |\n"
    )


def test_a_page_whose_row_does_not_fit_the_build_is_refused():
    page = stored_sets.with_row(f"# Releases\n\n{stored_sets.HEAD}", stored_sets.row("0.1.0", "2027-01-02", device(1), {}))
    stored_sets.check(page, "0.1.0", device(1))
    for version, built in (("0.2.0", device(1)), ("0.1.0", device(1, 2))):
        with pytest.raises(ReleaseError):
            stored_sets.check(page, version, built)


@pytest.mark.parametrize("version", ["1", "1.2", "01.0.0", "1.0.0-rc1", "1000000.1000.1000"])
def test_what_is_no_version_is_refused(version):
    with pytest.raises(ReleaseError, match="is no version"):
        prepare.number_of(version)


def test_an_older_number_than_the_trees_is_refused():
    cmake = "project(\n  trackservo\n  VERSION 0.10.0\n)\n"
    assert "VERSION 0.10.1" in prepare.with_number(cmake, "0.10.1")
    with pytest.raises(ReleaseError, match="older"):
        prepare.with_number(cmake, "0.9.0")
