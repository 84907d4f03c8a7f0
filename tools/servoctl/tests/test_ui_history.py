# SPDX-License-Identifier: Apache-2.0
"""The samples that a page keeps and draws, without a servo: the last 60 s, and a gap where samples are missing."""

from __future__ import annotations

from typing import Any

import pytest
from playwright.sync_api import Browser

from .page_bench import browser
from .test_page_access import Server, local

__all__ = ["browser", "local"]
SHOWN_S = 60.0
HOLE_S = 0.5
HOLE_AT_S = 170.0
FEED = """async ([seconds, holeAt, hole, windows]) => {
  const { History } = await import("./history.js");
  const history = new History([0, 1], 1);
  const room = history.time.length;
  const batch = 25;
  let most = 0;
  for (let tick = 4294967295 - 20000, fed = 0; fed < 1000 * seconds; fed += batch, tick += batch) {
    if (fed === 1000 * holeAt) tick += 1000 * hole;
    const buffer = new ArrayBuffer(8 + 4 * batch * 3);
    new Uint32Array(buffer, 0, 2).set([batch, 2]);
    new Uint32Array(buffer, 8, batch).set(Array.from({ length: batch }, (_, i) => (tick + i) % 4294967296));
    new Float32Array(buffer, 8 + 4 * batch, batch).set(Array.from({ length: batch }, (_, i) => Math.sin(0.01 * (fed + i))));
    new Float32Array(buffer, 8 + 8 * batch, batch).fill(7);
    history.add(buffer);
    most = Math.max(most, history.count);
  }
  const views = windows.map(([from, to, pixels]) => history.view([0, 1], from, to, pixels));
  return { most, room, grown: history.time.length - room, begin: history.begin, end: history.end,
           views: views.map(([time, ...columns]) => ({ time, columns })) };
}"""


@pytest.fixture(scope="module")
def fed(local: Server, browser: Browser) -> Any:
    """What a page has kept of 200 s with a hole, whose ticks wrap, and what it draws of it."""
    page = browser.new_context().new_page()
    page.goto(local.ours)
    windows = [[141.0, 201.0, 800], [HOLE_AT_S - 0.1, HOLE_AT_S + HOLE_S + 0.1, 800], [180.0, 190.0, 800]]
    found = page.evaluate(FEED, [200, HOLE_AT_S, HOLE_S, windows])
    page.context.close()
    return found


def test_a_page_keeps_the_last_minute_and_its_memory_does_not_grow(fed: Any) -> None:
    assert fed["grown"] == 0 and fed["most"] <= fed["room"] == 2 * 1000 * SHOWN_S
    assert fed["end"] == pytest.approx(200 + HOLE_S - 0.001)
    assert fed["end"] - fed["begin"] == pytest.approx(SHOWN_S + HOLE_S - 0.001)


@pytest.mark.parametrize("window", [0, 1])
def test_missing_samples_are_drawn_as_one_gap(fed: Any, window: int) -> None:
    view = fed["views"][window]
    for column in view["columns"]:
        gaps = [n for n, value in enumerate(column) if value is None]
        assert len(gaps) == 1 and len(column) == len(view["time"])
        assert view["time"][gaps[0] - 1] == pytest.approx(HOLE_AT_S - 0.001)
        assert HOLE_AT_S - 0.001 < view["time"][gaps[0]] < HOLE_AT_S + HOLE_S
        assert view["time"][gaps[0] + 1] == pytest.approx(HOLE_AT_S + HOLE_S)


def test_a_line_without_missing_samples_is_whole_with_its_extremes(fed: Any) -> None:
    view = fed["views"][2]
    sine, constant = view["columns"]
    assert None not in sine and set(constant) == {7}
    assert len(view["time"]) <= 2 * 800 + 2 and sorted(view["time"]) == view["time"]
    assert max(sine) == pytest.approx(1.0, abs=1e-4) and min(sine) == pytest.approx(-1.0, abs=1e-4)
