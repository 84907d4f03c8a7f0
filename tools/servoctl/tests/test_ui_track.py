# SPDX-License-Identifier: Apache-2.0
"""The tracking view of the page: cue, follow and stop, with a camera that sees a still target."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Browser, Page

from servoctl.link.pdo_loan import borrowed_identifiers
from servoctl.objects.parameter import AXES

from .conftest import Bench
from .page_bench import (
    STANDSTILL_DEG_S,
    Server,
    angle,
    bench,
    browser,
    command_and_enable,
    enable,
    opened,
    press,
    rate,
    server,
    servo,
    standing,
    wait_for,
    wait_for_state,
    wait_for_text,
)
from .still_target import StillTarget

__all__ = ["bench", "browser", "server", "servo"]
CAMERA = 0x541
PLACE = (0.8, 2.8)
CUE = (0.9, 2.7)
LIVE_ANGLES_ID = borrowed_identifiers(1)[0]
"""TPDO5 of the live view, which holds the angles."""
MAX_ERROR_URAD = 100.0
MAPPING = ("0x1403:1", "0x1603:0", "0x1603:1")


def cue(page: Page) -> None:
    """Both axes to the cue, by the page's controls."""
    page.get_by_role("tab", name="Tracking").click()
    for name, value in zip(("azimuth", "pitch", "rate"), (*CUE, 20), strict=True):
        page.locator(f"#track-{name}").fill(str(value))
    press(page.locator("#track-cue"))
    wait_for_text(page.locator("#plan-text"), "pitch will move")
    press(page.get_by_role("button", name="Move", exact=True))
    for axis, place in zip(AXES, CUE, strict=True):
        wait_for(lambda a=axis, p=place: abs(angle(page, a) - p) < 0.02, f"{axis} is at the cue")  # type: ignore[misc]


def follow(page: Page) -> None:
    """By the page's controls, up to the camera's first frame."""
    press(page.locator("#track-follow"))
    wait_for_text(page.locator("#plan-text"), "will follow what the camera sees")
    assert re.search(r"azimuth from \S+°, between -\S+° and \S+°, at up to \d+\.?\d* °/s", page.locator("#plan-text").text_content() or "")
    press(page.get_by_role("button", name="Move", exact=True))


def tracking(page: Page, axis: int) -> list[str]:
    """State, error and rms of an axis, as shown."""
    return page.locator("#track-table tbody tr").nth(axis).locator("td").all_text_contents()


@pytest.mark.image
def test_a_target_is_cued_followed_lost_and_left(servo: Bench, server: Server, browser: Browser) -> None:
    with StillTarget(servo.bus, CAMERA, *PLACE, LIVE_ANGLES_ID) as target, opened(browser, server) as page:
        before = servo.json("get", *MAPPING)
        command_and_enable(page)
        enable(page, "pitch")
        cue(page)
        follow(page)
        for axis in range(len(AXES)):
            wait_for(lambda a=axis: tracking(page, a)[0] == "tracking", "on target")  # type: ignore[misc]
            wait_for(lambda a=axis: 0.0 < float(tracking(page, a)[2]) < MAX_ERROR_URAD, "rms of the error")  # type: ignore[misc]
        assert abs(angle(page, "azimuth") - PLACE[0]) < 0.02 and abs(angle(page, "pitch") - PLACE[1]) < 0.02
        wait_for_text(page.locator("#track-frames"), "0 dropped")
        assert page.evaluate("trackservo.plots.signals.filter(s => s.plot === 'following error').length") == len(AXES)

        press(page.get_by_role("button", name="Record", exact=True))
        wait_for_text(page.locator("#record-note"), ".mcap: ")
        press(page.get_by_role("button", name="End recording"))
        page.get_by_role("tab", name="Recordings").click()
        press(page.get_by_role("button", name=re.compile("^Open recording-")).first)
        wait_for_text(page.locator("#recording-title"), ".mcap")
        page.get_by_role("tab", name="Tracking").click()
        shown = tracking(page, 0)[1]
        wait_for(lambda: tracking(page, 0)[1] not in (shown, "–"), "the error is that of now")
        press(page.get_by_role("button", name="Back to live"))

        target.visible = False
        wait_for(lambda: tracking(page, 0)[0] in ("coasting", "lost"), "the target is gone")
        target.visible = True
        wait_for(lambda: tracking(page, 0)[0] == "tracking", "found again")

        press(page.locator("#track-end"))
        wait_for(lambda: tracking(page, 0)[0] == "not tracking", "no longer follows")
        wait_for(lambda: abs(rate(page)) < STANDSTILL_DEG_S, "stands")
        wait_for_state(page, "operation enabled")
        wait_for(lambda: bool(servo.json("get", *MAPPING) == before), "the mapping of RPDO4 is restored")


def test_without_a_camera_the_axes_stay_and_the_page_says_why(servo: Bench, server: Server, browser: Browser) -> None:
    with opened(browser, server) as page:
        command_and_enable(page)
        page.get_by_role("tab", name="Tracking").click()
        assert page.locator("#track-cue").is_disabled()  # pitch is off
        plan = "connection => connection.ask('plan_cue', { azimuth_deg: 270, pitch_deg: 2.7, rate_deg_s: 20 })"
        text = page.evaluate(f"({plan})(trackservo.connection)")[0]["text"]
        assert "to -90.0000°" in text and "(270.000° − 360°, which lasts longer)" in text
        here = angle(page)
        follow(page)
        wait_for_text(page.locator("#toast"), "no frame of the camera arrives")
        wait_for_state(page, "operation enabled")
        assert abs(angle(page) - here) < 0.02
        page.locator("#track-camera").fill("601")
        follow(page)
        wait_for_text(page.locator("#toast"), "not an identifier of a camera")
        assert standing(servo)["mode"] != "tracking"
