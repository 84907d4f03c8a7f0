# SPDX-License-Identifier: Apache-2.0
"""A recording is begun, ended and opened again on the page, and holds what the page has shown, without loss."""

from __future__ import annotations

import resource
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser, Page

from servoctl.show.recording import read

from .conftest import Bench
from .page_bench import (
    Server,
    bench,
    browser,
    command_and_enable,
    jog,
    opened,
    press,
    server,
    servo,
    standing,
    take_command,
    wait_for,
    wait_for_state,
    wait_for_text,
)

__all__ = ["bench", "browser", "server", "servo"]
RECORDED_S = 2


def recorded_s(page: Page) -> float:
    """As shown."""
    return float((page.locator("#record-note").text_content() or "").split(": ")[1].split()[0])


def record_a_jog(page: Page) -> str:
    """Some seconds; the name of the file."""
    press(page.get_by_role("button", name="Record", exact=True))
    wait_for_text(page.locator("#record-note"), ".mcap: ")
    jog(page)
    wait_for(lambda: recorded_s(page) >= RECORDED_S, "some seconds")
    page.mouse.up()
    name = (page.locator("#record-note").text_content() or "").split(":")[0]
    press(page.get_by_role("button", name="End recording"))
    return name


def test_a_jog_is_recorded_and_opened_again(servo: Bench, server: Server, browser: Browser, tmp_path: Path) -> None:
    with opened(browser, server) as page:
        command_and_enable(page)
        wait_for(lambda: bool(page.evaluate("trackservo.plots.history.count > 100")), "samples")
        name = record_a_jog(page)
        page.get_by_role("tab", name="Recordings").click()
        press(page.get_by_role("button", name=f"Open {name}"))
        wait_for_text(page.locator("#recording-title"), name)
        shown = page.evaluate("({ count: trackservo.plots.source().count, end: trackservo.plots.source().end })")
        page.locator("[data-window='1']").click()
        page.locator(".plot .u-over").first.dblclick()
        assert page.evaluate("trackservo.plots.shown()") == [0, shown["end"]]  # all of it again
        assert page.locator("#pause").is_disabled()
        with page.expect_download() as found:
            page.locator("#recordings a").first.click()
        found.value.save_as(tmp_path / name)
        there = read(tmp_path / name)
        assert there.samples.values.shape[0] == 8 and page.locator(".plot .u-series .u-label").count() == 8 + 4  # the time, too
        assert there.whole and len(there.samples.ticks) == shown["count"] > 1000 * (RECORDED_S - 1)
        assert abs(there.time_s[-1] - shown["end"]) < 1e-3
        assert np.max(there.column("azimuth rate")) > 1.0
        assert page.request.get(f"{server.link}recordings/{name}/samples?from=nan").status == 404
        live = page.evaluate("trackservo.plots.seen")
        wait_for(lambda: page.evaluate("trackservo.plots.seen") > live + 100, "the live samples go on behind it")
        press(page.get_by_role("button", name="Back to live"))
        wait_for(lambda: page.evaluate("trackservo.plots.source().end") > shown["end"], "live again")


def test_a_full_disk_ends_the_recording_and_nothing_else(servo: Bench, server: Server, browser: Browser) -> None:
    """The server may write files of some bytes only, which ends a write as a full disk does."""
    before = resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE)
    with opened(browser, server) as page:
        command_and_enable(page)
        press(page.get_by_role("button", name="Record", exact=True))
        wait_for_text(page.locator("#record-note"), ".mcap: ")
        try:
            resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (FULL_BYTES, before[1]))
            wait_for_text(page.locator("#record-note"), "samples written before are readable.")
        finally:
            resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, before)
        path, told = (page.locator("#record-note").text_content() or "").split(": the recording has ended: File too large. The ")
        live = page.evaluate("trackservo.plots.seen")
        wait_for(lambda: page.evaluate("trackservo.plots.seen") > live + 100, "the live samples go on")
        wait_for_state(page, "operation enabled")
        press(page.get_by_role("button", name="End recording"))
        wait_for(lambda: page.locator("#record").text_content() == "Record", "ended")
        page.get_by_role("tab", name="Recordings").click()
        press(page.get_by_role("button", name=f"Open {Path(path).name}"))
        wait_for_text(page.locator("#recording-title"), "it was not ended, and is shown up to the last whole part")
        assert page.evaluate("trackservo.plots.source().count") >= int(told.split()[0]) > FEWEST


FULL_BYTES = 100_000
FEWEST = 1000
"""Samples in so many bytes, compressed, while the axis stands."""


def begin_step(page: Page) -> None:
    """By the page's controls."""
    page.get_by_role("tab", name="Step").click()
    press(page.get_by_role("button", name="Step …"))
    wait_for_text(page.locator("#plan-text"), "azimuth will move")
    press(page.get_by_role("button", name="Move", exact=True))


def test_signals_do_not_change_and_nothing_borrows_the_stream_during_a_recording(servo: Bench, server: Server, browser: Browser) -> None:
    with opened(browser, server) as page:
        take_command(page)
        press(page.get_by_role("button", name="Record", exact=True))
        wait_for_text(page.locator("#record-note"), " s")
        page.locator("#choice").select_option("azimuth")
        wait_for_text(page.locator("#toast"), "end the recording before you choose others")
        begin_step(page)
        wait_for_text(page.locator("#toast"), "the live view is being recorded, and this would leave a hole in it: end the recording first.")
        assert standing(servo)["state"] == "switch on disabled"
        press(page.get_by_role("button", name="End recording"))
        wait_for(lambda: page.locator("#record").text_content() == "Record", "ended")
        answer = page.request.get(server.link + "recordings/../journal.mcap")
        assert answer.status == 404
        assert page.request.get(server.link + "recordings/none.mcap/samples").text() == "there is no recording 'none.mcap'."
