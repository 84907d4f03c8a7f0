# SPDX-License-Identifier: Apache-2.0
"""Guided commissioning on the page: dry run, first look, identify, design and tune by its own controls, with short test
plans and a made-up fit; the real ones are tried by test_identify.py, whose commands use the same library."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page

from .conftest import Bench, bring_to_rest
from .page_bench import (
    Listener,
    Server,
    bench,
    browser,
    check_stopped,
    listener,
    opened,
    press,
    remember,
    running,
    seen,
    servo,
    standing,
    take_command,
    wait_for,
    wait_for_text,
)
from .test_identify import PROGRAMS

__all__ = ["bench", "browser", "listener", "servo"]
GAIN = "azimuth.speed_loop.proportional_gain"
FILES = {
    "first_look_plan.json", "first_look.csv", "first_look.json", "plan.json", "runs.csv", "structure_plan.json",
    "structure.csv", "result.json", "residuals.csv", "azimuth-identified.toml", "report.html", "progress.json",
}  # fmt: skip
"""As `servoctl identify` writes them."""


@pytest.fixture(scope="module")
def server(bench: Bench) -> Iterator[Server]:
    """With short test plans."""
    bench.environment |= PROGRAMS | {"SHORT_BRIEF": "yes", "SHORT_MARGINS": "8 30"}
    bring_to_rest(bench)
    with running(bench) as started:
        yield started


def step(page: Page, name: str) -> None:
    page.locator(f"[data-step='{name}']").click()


def start(page: Page, button: str = "Start …") -> None:
    """And the reader agrees to what will move."""
    wait_for_text(page.locator("#co-go"), button)
    press(page.locator("#co-go"))
    wait_for_text(page.locator("#plan-text"), "will move")
    press(page.get_by_role("button", name="Move", exact=True))


def folder_of(bench: Bench) -> Path:
    return next((bench.folder / "state" / "commissioning").glob("identify-azimuth-*"))


@pytest.mark.image
def test_an_axis_is_identified_and_tuned_in_steps_that_can_be_left(
    servo: Bench, server: Server, browser: Browser, listener: Listener
) -> None:
    with opened(browser, server) as page:
        take_command(page)
        page.get_by_role("tab", name="Commission").click()
        here = standing(servo)["position_deg"]
        press(page.locator("#co-dry"))
        wait_for_text(page.locator("#co-note"), "dry run: nothing was moved")
        wait_for_text(page.locator("#co-result"), "speed sweep")
        assert not list((servo.folder / "state").glob("commissioning/*"))
        assert standing(servo)["state"] == "switch on disabled" and abs(standing(servo)["position_deg"] - here) < 0.2

        wait_for_text(page.locator("#co-go"), "Start …")
        press(page.locator("#co-go"))
        wait_for_text(page.locator("#plan-text"), "azimuth will move")
        page.locator("#co-axis").select_option("1")  # what moves is what the plan has shown
        press(page.get_by_role("button", name="Move", exact=True))
        wait_for_text(page.locator("#co-progress-text"), "azimuth, first look: speed sweep")
        wait_for(lambda: page.evaluate("trackservo.plots.signals.length") == 3, "the plot shows what is recorded")
        remember(page, "keydown")
        page.keyboard.press("Escape")
        check_stopped(servo, "Esc during the first look", listener, seen(page))
        wait_for_text(page.locator("#co-note"), "first look: left; it can be taken up again")

        page.reload()  # taken up by another page
        take_command(page)
        page.get_by_role("tab", name="Commission").click()
        start(page, "Take up …")
        wait_for_text(page.locator("#co-note"), "first look: done")
        step(page, "identify")
        start(page)
        wait_for_text(page.locator("#co-note"), "identify: done")
        wait_for_text(page.locator("#co-result"), "bristle stiffness σ0")
        assert page.locator("#co-plot canvas").count() == 1
        wait_for_text(page.locator("#link"), "operational")
        assert not page.locator("#start-node").is_visible()
        folder = folder_of(servo)
        assert {path.name for path in folder.iterdir()} == FILES
        report = page.request.get(f"{server.link}commissioning/{folder.name}/report.html")
        assert "Stribeck curve" in report.text() and "script" not in report.headers["content-security-policy"]
        assert page.request.get(f"{server.link}commissioning/{folder.name}/..%2Fx.json").status == 404

        design_and_tune(servo, page, folder)


def design_and_tune(servo: Bench, page: Page, folder: Path) -> None:
    """The new gain is in force, and the reports are those of `servoctl tune`."""
    before = servo.value(GAIN)
    step(page, "design")
    page.locator("#co-least_gain_margin_db").fill("6")
    press(page.locator("#co-go"))
    wait_for_text(page.locator("#co-result"), "Predicted: gain margin 8 dB")
    assert servo.value(GAIN) == before
    step(page, "tune")
    page.locator("#co-periods").fill("2")
    start(page, "Try on the axis …")
    wait_for_text(page.locator("#co-note"), "azimuth has the new gains")
    assert servo.value(GAIN) == pytest.approx(0.9 * before, rel=1e-6)
    assert (folder / "tune.html").is_file() and (folder / "azimuth-active.toml").is_file()
    wait_for_text(page.locator("#co-result"), "phase margin")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")  # nothing is cut
    servo.json("undo")
    assert servo.value(GAIN) == before
    assert standing(servo)["state"] == "switch on disabled"
