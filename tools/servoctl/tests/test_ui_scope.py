# SPDX-License-Identifier: Apache-2.0
"""The scope of the device on the page: a trigger with time before it, during a motion of the page."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser

from .conftest import Bench
from .page_bench import (
    Server,
    bench,
    browser,
    card,
    command_and_enable,
    jog,
    opened,
    press,
    server,
    servo,
    take_command,
    wait_for,
    wait_for_text,
)

__all__ = ["bench", "browser", "server", "servo"]
LEVEL_DEG_S = 1.0
PRE_S, SECONDS = 0.2, 0.8


@pytest.mark.image
def test_a_jog_triggers_the_scope_and_the_capture_is_shown(
    servo: Bench, server: Server, browser: Browser, tmp_path: Path
) -> None:
    with opened(browser, server) as page:
        command_and_enable(page)
        page.get_by_role("tab", name="Scope").click()
        wait_for(lambda: page.locator("#scope-signals option").count() > 8, "the signals are there")
        page.locator("#scope-trigger").select_option("rising")
        page.locator("#scope-on").select_option(label="azimuth.rate")
        for name, value in (("level", LEVEL_DEG_S), ("pre", PRE_S), ("seconds", SECONDS)):
            page.locator(f"#scope-{name}").fill(str(value))
        press(page.locator("#scope-arm"))
        wait_for_text(page.locator("#scope-phase"), "waits for the trigger")
        jog(page)
        wait_for_text(page.locator("#scope-phase"), "complete")
        page.mouse.up()
        wait_for_text(page.locator("#scope-note"), "when both axes are off")
        press(card(page, "azimuth").get_by_role("button", name="Disable"))
        wait_for_text(page.locator("#scope-note"), "the trigger is at 0 s")
        assert page.locator("#scope-plot canvas").count() == 2  # °/s and N m
        with page.expect_download() as found:
            press(page.locator("#scope-save"))
        found.value.save_as(tmp_path / "scope.csv")
        time_s, rate_deg_s, torque = np.loadtxt(tmp_path / "scope.csv", delimiter=",", skiprows=1, unpack=True)
        assert len(time_s) == round(1000 * SECONDS) and abs(time_s[0] + PRE_S) < 0.002
        assert np.max(rate_deg_s[time_s < -0.001]) < LEVEL_DEG_S <= rate_deg_s[np.searchsorted(time_s, -1e-9)]
        assert np.max(np.abs(torque)) > 0.0


def test_a_forced_trigger_and_a_wrong_request(servo: Bench, server: Server, browser: Browser) -> None:
    with opened(browser, server) as page:
        take_command(page)
        page.get_by_role("tab", name="Scope").click()
        wait_for(lambda: page.locator("#scope-signals option").count() > 8, "the signals are there")
        page.locator("#scope-pre").fill("2")
        press(page.locator("#scope-arm"))
        wait_for_text(page.locator("#toast"), "must be shorter than the capture of 1 s")
        page.locator("#scope-pre").fill("0")
        page.locator("#scope-trigger").select_option("above")
        page.locator("#scope-level").fill("1000")
        press(page.locator("#scope-arm"))
        wait_for_text(page.locator("#scope-phase"), "waits for the trigger")
        press(page.locator("#scope-force"))
        wait_for_text(page.locator("#scope-note"), "1000 frames every 1 ms")
