# SPDX-License-Identifier: Apache-2.0
"""The page end to end: headless Chromium uses its controls, and a listener on the bus judges what they do there. All tests
share one server."""

from __future__ import annotations

import time

import pytest
from playwright.sync_api import Browser, Page

from servoctl.units import degrees

from .conftest import Bench
from .page_bench import (
    STANDSTILL_DEG_S,
    Listener,
    Server,
    bench,
    browser,
    card,
    check_stopped,
    command_and_enable,
    jog,
    listener,
    opened,
    press,
    rate,
    remember,
    running,
    seen,
    server,
    servo,
    standing,
    take_command,
    wait_for,
    wait_for_state,
    wait_for_text,
)

__all__ = ["bench", "browser", "listener", "server", "servo"]
GAIN = "azimuth.speed_loop.proportional_gain"
SECOND_GAIN = "azimuth.speed_loop.integral_gain"


@pytest.mark.image
@pytest.mark.smoke
def test_open_enable_jog_change_a_gain_undo_and_disable(servo: Bench, server: Server, browser: Browser) -> None:
    with opened(browser, server) as page:
        wait_for(lambda: page.locator("#gains tbody tr").count() > 5, "the gains are there")
        page.locator("#gain-filter").fill("speed loop")
        before = servo.value(GAIN)
        command_and_enable(page)
        jog(page)
        page.mouse.up()
        wait_for(lambda: abs(rate(page)) < STANDSTILL_DEG_S, "stands after the jog")
        wait_for_state(page, "operation enabled")
        change_a_gain_and_undo(servo, page, before)
        move_and_swing(servo, page)


def change_a_gain_and_undo(servo: Bench, page: Page, before: float) -> None:
    """And the device has each value."""
    wanted, other = round(1.05 * before, 2), servo.value(SECOND_GAIN)
    for name, value in ((GAIN, wanted), (SECOND_GAIN, 0.9 * other)):
        page.locator(f"#gains tr[data-name='{name}'] input").fill(str(value))
    press(page.get_by_role("button", name="Apply", exact=True))
    wait_for_text(page.locator("#gain-note"), "2 gains applied in one piece")
    assert servo.value(GAIN) == pytest.approx(wanted) and servo.value(SECOND_GAIN) == pytest.approx(0.9 * other)
    press(page.get_by_role("button", name="Undo last change"))
    wait_for_text(page.locator("#gain-note"), "undone")
    assert servo.value(GAIN) == before and servo.value(SECOND_GAIN) == other


def move_and_swing(servo: Bench, page: Page) -> None:
    """A move by an angle arrives; a motion back and forth is ended, and the axis disabled."""
    azimuth = card(page, "azimuth")
    azimuth.locator(".move-angle").fill("2")
    press(azimuth.locator(".move"))
    wait_for_text(page.locator("#plan-text"), "at up to 5 °/s")
    jog(page)  # to another place: the plan goes
    page.mouse.up()
    assert page.locator("#plan").is_hidden()
    wait_for(lambda: abs(rate(page)) < STANDSTILL_DEG_S, "stands after the jog")
    here = standing(servo)["position_deg"]
    press(azimuth.locator(".move"))
    wait_for(page.locator("#plan").is_visible, "a new plan")
    assert abs(standing(servo)["position_deg"] - here) < 0.01  # nothing has moved yet
    press(page.get_by_role("button", name="Move", exact=True))
    wait_for(lambda: abs(standing(servo)["position_deg"] - here - 2) < 0.01, "arrives")

    swing(page, "30")
    press(azimuth.get_by_role("button", name="End motion"))
    wait_for(lambda: abs(rate(page)) < STANDSTILL_DEG_S, "stands")
    ended = standing(servo)["position_deg"]
    assert ended - here < 25  # nowhere near the end of the travel
    press(azimuth.get_by_role("button", name="Disable"))
    wait_for_state(page, "switch on disabled")
    assert abs(standing(servo)["position_deg"] - ended) < 0.5


def swing(page: Page, angle_deg: str) -> None:
    """Azimuth moves back and forth."""
    azimuth = card(page, "azimuth")
    azimuth.locator(".move-angle").fill(angle_deg)
    press(azimuth.get_by_role("button", name="Back and forth by this angle"))
    press(page.get_by_role("button", name="Move", exact=True))
    wait_for(lambda: rate(page) > 4.0, "moves back and forth")


def measure_step(page: Page) -> None:
    """By the page's controls, up to the motion itself."""
    page.get_by_role("tab", name="Step").click()
    page.locator("#step-hold").fill("0.3")
    press(page.get_by_role("button", name="Step …"))
    wait_for_text(page.locator("#plan-text"), "azimuth will move: 0 → 1")
    press(page.get_by_role("button", name="Move", exact=True))


def measure_undisturbed_step(page: Page) -> None:
    """Again, as its reader would, while a busy computer has disturbed both directions."""
    note = page.locator("#step-note")
    for _ in range(5):
        measure_step(page)
        wait_for_text(note, "the step runs")
        wait_for_text(note, "measured")
        if note.inner_text() != "not measured":
            return
    raise AssertionError("five steps were disturbed")


def test_only_a_plan_that_can_be_read_moves_an_axis(servo: Bench, server: Server, browser: Browser) -> None:
    """A held Enter opens the plan and does not confirm it; an empty field is not 0, and 12,5 is not 125."""
    with opened(browser, server) as page:
        command_and_enable(page)
        azimuth = card(page, "azimuth")
        field, go = azimuth.locator(".move-angle"), page.locator("#plan-go")
        wait_for(azimuth.locator(".move").is_enabled, "the axis can be moved")
        azimuth.locator(".move").focus()
        for _ in range(HELD_KEYS):
            page.keyboard.down("Enter")
            time.sleep(0.05)
        page.keyboard.up("Enter")
        wait_for(go.is_visible, "the plan is shown")
        assert not azimuth.locator(".doing").inner_text().startswith("azimuth moves")
        page.locator("#plan-cancel").click()
        azimuth.locator(".kind").select_option("to")
        field.fill("")
        press(azimuth.locator(".move"))
        wait_for_text(page.locator("#toast"), "enter a number: the field for 'angle, °' holds none.")
        field.press_sequentially("12,5")
        wait_for_text(page.locator("#toast"), "write decimals with a point")
        # Both refusals stay in the list of events, and its tab says so until it is opened.
        wait_for_text(page.locator("#tab-events"), "Events (2 new)")
        page.locator("#tab-events").click()
        assert "holds none" in page.locator("#events li").all_text_contents()[1]
        assert page.locator("#tab-events").text_content() == "Events"
        assert go.is_hidden()
        page.keyboard.press("Escape")
        wait_for_state(page, "switch on disabled")


HELD_KEYS = 20


TWO_PLANS = """async () => {
  const { confirmPlan } = await import("./plan.js");
  const plan = (axis) => confirmPlan({ axis, text: "", forward_deg: 1, backward_deg: 0, rate_deg_s: 1, duration_s: 1 });
  const after = (time_ms, value) => new Promise((resolve) => setTimeout(() => resolve(value), time_ms));
  const [first, second] = [plan("azimuth"), plan("pitch")];
  document.getElementById("plan-go").click();
  const early = await Promise.race([second, after(100, "waits")]);
  await after(300);
  document.getElementById("plan-go").click();
  return [await first, early, await second];
}"""


def test_a_click_on_a_plan_that_has_just_replaced_another_does_not_count(servo: Bench, server: Server, browser: Browser) -> None:
    with opened(browser, server) as page:
        assert page.evaluate(TWO_PLANS) == [False, "waits", True]


@pytest.mark.image
def test_steps_before_and_after_are_shown_together(servo: Bench, server: Server, browser: Browser) -> None:
    with opened(browser, server) as page:
        take_command(page)
        rows = page.locator("#step-table tbody tr")
        for shown in ("ward", ", before"):  # forward or backward: on a busy computer one of them may be disturbed
            measure_undisturbed_step(page)
            wait_for_text(rows.last, shown)
        rise_ms = [float(row.locator("td").nth(2).inner_text()) for row in rows.all()]
        assert all(1.0 < rise < 60.0 for rise in rise_ms), rise_ms
        assert standing(servo)["state"] == "switch on disabled"
        wait_for(lambda: bool(page.evaluate("trackservo.plots.history.count > 200")), "the plots go on")


def test_a_reference_shape_is_run_and_shown(servo: Bench, server: Server, browser: Browser) -> None:
    servo.json("state", "azimuth", "enable")  # otherwise wind would turn it
    with opened(browser, server) as page:
        take_command(page)
        page.get_by_role("tab", name="Step").click()
        here = standing(servo)["position_deg"]
        for name, value in (("travel", "1"), ("period", "1"), ("periods", "1")):
            page.locator(f"#shape-{name}").fill(value)
        press(page.get_by_role("button", name="Run the shape …"))
        wait_for_text(page.locator("#plan-text"), "azimuth will move: sine over 1°, 1 × 1 s, at up to 3.14 °/s")
        press(page.get_by_role("button", name="Move", exact=True))
        wait_for_text(page.locator("#shape-note"), "done; error of the rate")
        assert float((page.locator("#shape-note").text_content() or "").split()[5]) < 0.3  # °/s rms, of 2.2
        assert abs(standing(servo)["position_deg"] - here) < 0.1 and standing(servo)["state"] == "operation enabled"
        assert page.locator("#step-plot canvas").count() == 1


@pytest.mark.parametrize(
    "how", ["button", pytest.param("Esc", marks=(pytest.mark.smoke, pytest.mark.image, pytest.mark.smoke_image)), "closed page"]
)
def test_a_jog_is_stopped(servo: Bench, server: Server, browser: Browser, listener: Listener, how: str) -> None:
    with opened(browser, server) as page:
        other = page.context.new_page()  # of the same site, so that it can read when the page went
        other.goto(server.link + "style.css")
        page.bring_to_front()
        command_and_enable(page)
        jog(page)
        if how == "button":
            remember(page, "click")
            page.evaluate("document.getElementById('stop').click()")  # the mouse holds the other button
            began = seen(page)
        elif how == "Esc":
            remember(page, "keydown")
            page.keyboard.press("Escape")
            began = seen(page)
        else:
            page.evaluate("addEventListener('pagehide', () => localStorage.setItem('left', Date.now()), true)")
            called = time.time()
            page.close()
            wait_for(lambda: other.evaluate("localStorage.getItem('left')") is not None, "the page goes")
            began = float(other.evaluate("localStorage.getItem('left')")) / 1e3
            print(f"closed page: the browser took {1e3 * (began - called):.0f} ms to begin")
        check_stopped(servo, how, listener, began)


@pytest.mark.image
def test_a_stopped_axis_brakes_by_6085_and_is_switched_off_at_rest(
    servo: Bench, server: Server, browser: Browser, listener: Listener
) -> None:
    """6084, by which a jog ends, takes three times as long."""
    brake_deg_s2, ramp_deg_s2 = (degrees(1e-6 * servo.json("get", each)[0]["value"]) for each in ("0x6085:0", "0x6084:0"))
    assert brake_deg_s2 > 2 * ramp_deg_s2
    with opened(browser, server) as page:
        command_and_enable(page)
        card(page, "azimuth").locator(".jog-rate").fill(str(FAST_JOG_DEG_S))
        jog(page)
        wait_for(lambda: abs(rate(page) - FAST_JOG_DEG_S) < 0.1 * FAST_JOG_DEG_S, "the full rate")
        page.keyboard.press("Escape")
        wait_for_state(page, "switch on disabled")
        wait_for(lambda: bool(page.evaluate(BRAKING, FAST_JOG_DEG_S)), "the whole stop is plotted")
        braked_s = page.evaluate(BRAKING, FAST_JOG_DEG_S)
    measured = 0.6 * FAST_JOG_DEG_S / braked_s
    print(f"braked by {measured:.0f} °/s² (6085: {brake_deg_s2:.0f} °/s²); at the end {listener.ends_deg_s[-1]:.2f} °/s")
    assert measured == pytest.approx(brake_deg_s2, rel=0.15)
    assert abs(listener.ends_deg_s[-1]) < END_DEG_S


FAST_JOG_DEG_S = 20.0
END_DEG_S = 0.5
BRAKING = """rate => (({ history: h, signals }) => {
  const rates = h.values[signals.findIndex((signal) => signal.name === "azimuth rate")];
  let end = h.count - 1;
  while (end > 0 && rates[end] < 0.2 * rate) end--;
  let begin = end;
  while (begin > 0 && rates[begin] < 0.8 * rate) begin--;
  return end && end < h.count - 100 ? h.time[end] - h.time[begin] : 0;
})(trackservo.plots)"""
"""Time from 80 % to 20 % of this rate, s; 0 before the axis has stood for a while."""


def test_the_plots_are_zoomed_with_the_keyboard(servo: Bench, server: Server, browser: Browser) -> None:
    with opened(browser, server) as page:
        wait_for(lambda: bool(page.evaluate("trackservo.plots.history.count > 500")), "samples")
        page.locator("#plots").focus()
        shown = [page.evaluate(SHOWN)]
        for key in ("+", "+", "ArrowLeft", "-"):
            page.keyboard.press(key)
            shown.append(page.evaluate(SHOWN))
        lengths = [end - begin for begin, end in shown]
        assert lengths[1] < lengths[0] and lengths[2] == pytest.approx(lengths[1] / 2) and lengths[3] == pytest.approx(lengths[2])
        assert shown[3][0] < shown[2][0] and lengths[4] == pytest.approx(lengths[1])
        assert "s shown" in (page.locator("#zoom-note").text_content() or "")
        page.keyboard.press("Home")
        wait_for(lambda: bool(page.evaluate("!trackservo.plots.frozen && !trackservo.plots.range")), "live again")


SHOWN = "trackservo.plots.shown()"


def test_a_viewers_page_stops_nothing_but_its_button_does(
    servo: Bench, server: Server, browser: Browser, listener: Listener
) -> None:
    with opened(browser, server) as page, opened(browser, server) as viewer:
        command_and_enable(page)
        wait_for_text(viewer.locator("#who"), "commands since")
        press(viewer.get_by_role("button", name="Take command"))
        wait_for_text(viewer.locator("#toast"), "ask there to release it")
        assert card(viewer, "azimuth").get_by_role("button", name="Disable").is_disabled()
        viewer.reload()
        wait_for_text(viewer.locator("#who"), "commands since")
        viewer.evaluate("trackservo.connection.socket.close()")
        wait_for_text(viewer.locator("#link"), "no server")
        wait_for_text(viewer.locator("#who"), "commands since")
        assert sum("connected to" in each for each in viewer.locator("#events li").all_text_contents()) == 1  # each event once
        wait_for(lambda: viewer.evaluate("trackservo.plots.frames") > 3, "the viewer's plots are drawn")
        with opened(browser, server) as third:
            assert third.locator("#stop").is_enabled()
        wait_for_text(page.locator("#who"), "1 other page")
        time.sleep(AFTERWARDS_S)
        assert not listener.stops
        wait_for_state(page, "operation enabled")
        remember(viewer, "click")
        viewer.locator("#stop").click()
        check_stopped(servo, "a viewer's button", listener, seen(viewer))


AFTERWARDS_S = 0.5


def test_a_jog_goes_on_as_long_as_the_page_says_that_it_is_held(servo: Bench, browser: Browser) -> None:
    """Longer than the page may be silent, which is 3 s here."""
    silent_s = 3.0
    with running(servo, silent_s=silent_s) as own, opened(browser, own) as page:
        command_and_enable(page)
        jog(page)
        page.wait_for_timeout(1e3 * (silent_s + 1.0))
        assert abs(rate(page)) > 1.0 and not any("silent" in each for each in page.locator("#events li").all_text_contents())
        page.mouse.up()
        wait_for(lambda: abs(rate(page)) < STANDSTILL_DEG_S, "stands after the jog")


def test_a_jog_ends_when_its_tab_is_hidden(servo: Bench, server: Server, browser: Browser) -> None:
    with opened(browser, server) as page:
        command_and_enable(page)
        jog(page)
        page.evaluate(
            "Object.defineProperty(document, 'hidden', { value: true, configurable: true });"
            "document.dispatchEvent(new Event('visibilitychange'))"
        )
        wait_for(lambda: abs(rate(page)) < STANDSTILL_DEG_S, "stands after the tab was hidden")
        wait_for_state(page, "operation enabled")


def measure_bode(page: Page) -> None:
    """A short one, by the page's controls."""
    press(page.get_by_role("tab", name="Bode"))
    for name, value in (("low", "4"), ("periods", "2")):
        page.locator(f"#bode-{name}").fill(value)
    press(page.get_by_role("button", name="Measure …"))
    wait_for_text(page.locator("#plan-text"), "azimuth will move: 1 °/s with")
    press(page.get_by_role("button", name="Move", exact=True))
    wait_for_text(page.locator("#bode-note"), "the axis moves")
    wait_for_text(page.locator("#bode-note"), "measured;")


def margins(page: Page) -> dict[str, tuple[float, float]]:
    """Phase margin (°) and sensitivity peak of each curve, as shown."""
    rows = [row.locator("td").all_text_contents() for row in page.locator("#bode-table tbody tr").all()]
    return {row[0]: (float(row[1].split()[0]), float(row[3].split()[0])) for row in rows}


def test_bode_plots_before_and_after_a_change_of_gain_are_shown_together(
    servo: Bench, server: Server, browser: Browser
) -> None:
    """Beside them the prediction with the new gain; test_analysis.py compares it with what is then measured."""
    with opened(browser, server) as page:
        take_command(page)
        measure_bode(page)
        first = margins(page)
        assert 20.0 < first["measured"][0] < 90.0, first
        before = servo.value(GAIN)
        page.get_by_role("tab", name="Gains").click()
        page.locator(f"#gains tr[data-name='{GAIN}'] input").fill(str(round(0.8 * before, 2)))
        press(page.get_by_role("button", name="Apply", exact=True))
        wait_for(lambda: "present gains" in margins(page), "the prediction")
        assert margins(page)["present gains"] != first["measured"]
        measure_bode(page)
        after = margins(page)
        assert after["before"] == first["measured"] and after["measured"] != first["measured"]
        assert page.locator("#bode-plot canvas").count() == 3
        page.get_by_role("tab", name="Gains").click()
        press(page.get_by_role("button", name="Undo last change"))
        wait_for(lambda: bool(servo.value(GAIN) == before), "undone")
        assert standing(servo)["state"] == "switch on disabled"
