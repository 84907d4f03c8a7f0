# SPDX-License-Identifier: Apache-2.0
"""Streams to the page for minutes and judges it: lost samples, drawn frames, memory. A command for people, not for CI:

    cd tools/servoctl && ../../build/venv/bin/python -m tests.stream_for_minutes --minutes 10

It starts `servoctl ui --demo` and headless Chromium, and exits with 1 when a requirement is not met. Run it on a computer
that does nothing else.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from playwright.sync_api import Browser, CDPSession, Page, sync_playwright

from .conftest import CHROMIUM, SIM_HOST, Bench
from .page_bench import Server, opened, rate, running, wait_for

SETTLED_S = 60.0
"""Memory counts from here on."""
MIN_FRAMES_PER_S = 30.0
SAMPLES_PER_S = 1000.0
MIN_SAMPLES_SHARE = 0.999
"""Of the samples by this computer's clock: the last ones are still on their way, and the clocks differ."""
MAX_GROWTH_SHARE = 0.05
"""Of the memory, from the first minute to the end: garbage that is not yet collected."""
EVERY_S = 10.0
PAGE_COUNTS = "({ frames: trackservo.plots.frames, seen: trackservo.plots.seen, lost: Number(document.getElementById('lost').textContent) })"


@dataclass(frozen=True)
class Look:
    """One look at the page and the server."""

    time_s: float
    frames: int
    samples: int
    lost: int
    page_mb: float
    """Objects of the script and of the document, and the arrays that hold the samples."""
    server_mb: float


def resident_mb(process: int) -> float:
    """VmRSS."""
    status = Path(f"/proc/{process}/status").read_text(encoding="ascii")
    return int(next(line for line in status.splitlines() if line.startswith("VmRSS")).split()[1]) / 1024


def look(page: Page, inspector: CDPSession, server: Server, begun_s: float) -> Look:
    """After a collection of garbage in the page."""
    inspector.send("HeapProfiler.collectGarbage")
    used = inspector.send("Runtime.getHeapUsage")
    heap = sum(used.get(part, 0.0) for part in ("usedSize", "embedderHeapUsedSize", "backingStorageSize")) / 1e6
    found = page.evaluate(PAGE_COUNTS)
    return Look(
        time.monotonic() - begun_s, found["frames"], found["seen"], found["lost"], heap, resident_mb(server.process.pid)
    )


def stream(browser: Browser, minutes: float) -> list[Look]:
    """Prints a line every ten seconds."""
    looks = []
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench("slcan-tcp:127.0.0.1:9", Path(folder))
        bench.environment["SIM_HOST"] = SIM_HOST
        with running(bench, "--demo") as server, opened(browser, server, draws_rarely=False) as page:
            wait_for(lambda: abs(rate(page)) > 1.0, "the axis moves")
            wait_for(lambda: page.evaluate("trackservo.plots.frames") > 30, "the plots are drawn")
            inspector = page.context.new_cdp_session(page)
            begun_s = time.monotonic()
            end_s = begun_s + 60.0 * minutes
            looks.append(look(page, inspector, server, begun_s))
            while (left_s := end_s - time.monotonic()) > 0.0:
                page.wait_for_timeout(1e3 * min(EVERY_S, left_s))
                looks.append(look(page, inspector, server, begun_s))
                show(looks[-2], looks[-1])
    return looks


def frames_per_s(before: Look, now: Look) -> float:
    return (now.frames - before.frames) / (now.time_s - before.time_s)


def show(before: Look, now: Look) -> None:
    print(
        f"{now.time_s:6.0f} s  {now.samples - before.samples:6d} samples  {now.lost:4d} lost  {frames_per_s(before, now):5.1f} frames/s"
        f"  page {now.page_mb:6.2f} MB  server {now.server_mb:6.1f} MB",
        flush=True,
    )


def judge(looks: list[Look]) -> list[str]:
    """The requirements that are not met, a sentence each."""
    first, last = looks[0], looks[-1]
    settled = next((each for each in looks if each.time_s >= SETTLED_S), last)
    slowest = min(frames_per_s(a, b) for a, b in zip(looks, looks[1:], strict=False))
    wrong = []
    if last.lost > first.lost:
        wrong.append(f"{last.lost - first.lost} samples were lost; none may be.")
    came, passed_s = last.samples - first.samples, last.time_s - first.time_s
    if came < MIN_SAMPLES_SHARE * SAMPLES_PER_S * passed_s:
        wrong.append(f"{came} samples came in {passed_s:.1f} s; {SAMPLES_PER_S:g} per second are required.")
    if slowest < MIN_FRAMES_PER_S:
        wrong.append(f"{slowest:.1f} frames/s were drawn at least; {MIN_FRAMES_PER_S:g} are required.")
    for name, before, after in (
        ("page", settled.page_mb, last.page_mb), ("server", settled.server_mb, last.server_mb),
    ):  # fmt: skip
        if after > (1.0 + MAX_GROWTH_SHARE) * before:
            wrong.append(f"the memory of the {name} grew from {before:.1f} to {after:.1f} MB after the first minute.")
    return wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0)
    minutes = parser.parse_args().minutes
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        looks = stream(browser, minutes)
        browser.close()
    wrong = judge(looks)
    for sentence in wrong:
        print(sentence)
    passed_s = looks[-1].time_s - looks[0].time_s
    print(f"{looks[-1].samples - looks[0].samples} samples of 8 signals in {passed_s:.1f} s: {'not held' if wrong else 'held'}.")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
