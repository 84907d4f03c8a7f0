# SPDX-License-Identifier: Apache-2.0
"""For whom the page works: screen readers, keyboard, touch, a tablet upright, a dark room; and the browser that it opens."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page

from .conftest import Bench
from .page_bench import (
    STANDSTILL_DEG_S,
    Server,
    bench,
    browser,
    card,
    command_and_enable,
    opened,
    rate,
    server,
    servo,
    wait_for,
    wait_for_state,
    wait_for_text,
)
from .test_page_access import Server as Site
from .test_page_access import local

__all__ = ["bench", "browser", "local", "server", "servo"]
CONTROLS = {"button", "textbox", "spinbutton", "searchbox", "combobox", "listbox", "checkbox", "slider", "tab", "link"}
FEWEST_CONTROLS = 100
SHOW_ALL = "for (const each of document.querySelectorAll('[hidden]')) each.hidden = false; document.getElementById('plan').show();"
TABLET = {"width": 820, "height": 1180}
WIDTHS = "[document.documentElement.scrollWidth, innerWidth]"


def test_every_control_has_a_label_for_a_screen_reader(local: Site, browser: Browser) -> None:
    """Also those that a state or a tab hides."""
    page = browser.new_context().new_page()
    page.goto(local.ours)
    wait_for_text(page.locator("#link"), "no connection")
    page.evaluate(SHOW_ALL)
    nodes = page.context.new_cdp_session(page).send("Accessibility.getFullAXTree")["nodes"]
    page.context.close()
    found = [(node["role"]["value"], node.get("name", {}).get("value", "")) for node in nodes if not node["ignored"]]
    controls = [(role, name) for role, name in found if role in CONTROLS]
    assert len(controls) > FEWEST_CONTROLS
    assert [role for role, name in controls if not name.strip()] == []


def colour(page: Page, element: str, what: str) -> float:
    """Its brightness, 0 to 1."""
    text = page.evaluate("([element, what]) => getComputedStyle(document.querySelector(element))[what]", [element, what])
    return sum(int(part) for part in text[text.index("(") + 1 : -1].split(",")[:3]) / (3 * 255)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_tablet_upright_needs_no_scrolling_to_the_side(servo: Bench, server: Server, browser: Browser, scheme: str) -> None:
    with opened(browser, server, viewport=TABLET, has_touch=True, color_scheme=scheme) as page:
        wait_for(lambda: page.locator("#gains tbody tr").count() > 5, "the gains are there")
        for tab in page.locator("[role=tab]:visible").all():
            tab.tap()
            wide, room = page.evaluate(WIDTHS)
            assert wide <= room, tab.text_content()
        back, text = colour(page, "body", "backgroundColor"), colour(page, "body", "color")
        assert (back > 0.8 and text < 0.3) if scheme == "light" else (back < 0.2 and text > 0.7)


@pytest.mark.parametrize("how", ["space bar", "touch"])
def test_a_jog_without_a_mouse_lasts_as_long_as_it_is_held(servo: Bench, server: Server, browser: Browser, how: str) -> None:
    with opened(browser, server, viewport=TABLET, has_touch=True) as page:
        command_and_enable(page)
        plus = card(page, "azimuth").locator(".plus")
        wait_for(plus.is_enabled, "the axis can be jogged")
        plus.scroll_into_view_if_needed()
        inspector = page.context.new_cdp_session(page)
        if how == "touch":
            box = plus.bounding_box()
            assert box is not None
            place = {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}
            inspector.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [place]})
        else:
            plus.focus()
            page.keyboard.down(" ")
        wait_for(lambda: abs(rate(page)) > 1.0, "the axis jogs")
        if how == "touch":
            inspector.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        else:
            page.keyboard.up(" ")
        wait_for(lambda: abs(rate(page)) < STANDSTILL_DEG_S, "stands after the release")
        wait_for_state(page, "operation enabled")


def test_each_event_is_shown_once_whatever_the_clock_does(servo: Bench, server: Server, browser: Browser) -> None:
    """The server sends those of before again after a lost link; the time of one may be earlier than that of the one before it."""
    with opened(browser, server) as page:
        for number, time_s in ((1001, 2e9), (1002, 1e9), (1002, 1e9)):
            event = {"run": 1, "number": number, "time": time_s, "kind": "bad", "text": f"event {number}"}
            page.evaluate("event => trackservo.connection.handlers.events([event])", event)
        shown = page.locator("#events li").all_text_contents()
        assert [sum(f"event {number}" in text for text in shown) for number in (1001, 1002)] == [1, 1]


def test_bus_load_and_lost_samples_are_said(servo: Bench, server: Server, browser: Browser) -> None:
    """Four frames in every tick; the servo runs at half of real time, which halves its share of the bus."""
    with opened(browser, server) as page:
        wait_for(lambda: bool(page.evaluate("trackservo.plots.history.count > 500")), "samples")
        wait_for(lambda: 10 < float((page.locator("#load").text_content() or "0").split()[0].replace("–", "0")) < 65, "the load")
        assert (page.locator("#load").text_content() or "").endswith(" %")
        assert int(page.locator("#lost").text_content() or "-1") >= 0
        wait_for_text(page.locator("#rate"), "1000 Hz")
        assert "on the bus" in (page.locator("#lost").get_attribute("title") or "")


def test_the_page_is_opened_in_the_browser_of_its_user(tmp_path: Path) -> None:
    """The one that BROWSER names, as webbrowser of Python does."""
    named = tmp_path / "browser"
    named.write_text(f'#!/bin/sh\necho "$1" > {tmp_path / "link"}\n', encoding="utf-8")
    named.chmod(0o755)
    bench = Bench("slcan-tcp:127.0.0.1:9", tmp_path)
    bench.environment |= {"BROWSER": f"{named} %s", "PATH": os.environ["PATH"]}
    process = bench.start("ui", "--port", "0", "--json")
    assert process.stdout is not None
    try:
        text = ""
        while "}" not in text:
            text += process.stdout.readline()
        wait_for(lambda: (tmp_path / "link").exists() and bool((tmp_path / "link").read_text()), "opened")
        assert (tmp_path / "link").read_text().strip() == json.loads(text)["link"]
    finally:
        process.terminate()
        process.communicate(timeout=20)


def test_without_a_bus_or_a_simulator_a_sentence_says_what_to_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    nowhere = Bench("", tmp_path)
    nowhere.environment |= {"SIM_HOST": str(tmp_path / "none"), "PATH": ""}
    refused = nowhere("ui", "--no-browser", "--port", "0")
    assert refused.code == 2 and "add --bus or set SERVOCTL_BUS to" in refused.err and "--demo starts a simulator instead." in refused.err
    monkeypatch.setattr("servoctl.sim_host.starts", lambda: (tmp_path,))
    refused = nowhere("ui", "--demo", "--no-browser", "--port", "0")
    assert refused.code == 2 and "is not built: run './tools/demo' in the checkout" in refused.err and refused.err.count("\n") == 1
