# SPDX-License-Identifier: Apache-2.0
"""Gain files, the store and the access lock on the page; and the spectrum of the live view."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page

from .conftest import Bench
from .page_bench import (
    Server,
    bench,
    browser,
    opened,
    press,
    running,
    server,
    servo,
    take_command,
    wait_for,
    wait_for_text,
)

__all__ = ["bench", "browser", "server", "servo"]
GAIN = "azimuth.speed_loop.proportional_gain"
GUARDED = "azimuth.protection.over_speed_limit"


def saved(page: Page, folder: Path) -> Path:
    """The file of the button 'Save to file'."""
    with page.expect_download() as found:
        press(page.locator("#gain-save"))
    path = folder / found.value.suggested_filename
    found.value.save_as(path)
    return path


def test_a_gain_file_is_saved_compared_written_and_undone(servo: Bench, server: Server, browser: Browser, tmp_path: Path) -> None:
    """One of another machine, or with an error, is said so."""
    with opened(browser, server) as page:
        path = saved(page, tmp_path)
        assert servo("diff", str(path)).code == 0  # the command line reads it
        before = servo.value(GAIN)
        text = path.read_text(encoding="utf-8")
        old = f"proportional_gain = {before}"
        assert old in text
        path.write_text(text.replace(old, f"proportional_gain = {1.1 * before}", 1), encoding="utf-8")

        take_command(page)
        page.locator("#gain-file").set_input_files(path)
        wait_for_text(page.locator("#compare-title"), f"1 of {servo.json('save', 'all.toml')['saved']} gains differ")
        wait_for_text(page.locator("#compare-table tbody"), GAIN)
        assert page.locator("#compare-warning").is_hidden()
        assert servo.value(GAIN) == before
        press(page.locator("#compare-write"))
        wait_for_text(page.locator("#gain-file-note"), "1 gains written")
        wait_for_text(page.locator("#compare-title"), "0 of")
        assert servo.value(GAIN) == pytest.approx(1.1 * before)
        press(page.get_by_role("button", name="Undo last change"))
        wait_for(lambda: bool(servo.value(GAIN) == before), "undone")

        servo.json("set", GAIN, str(1.05 * before))  # by another tool: the table follows
        active = page.locator(f"#gains tr[data-name='{GAIN}'] td").nth(3)
        wait_for(lambda: float(active.text_content() or "nan") == pytest.approx(1.05 * before), "the value in force")
        servo.json("undo")

        serial = next(line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("serial"))
        changed = path.read_text(encoding="utf-8").replace(serial, "serial = 123456789")
        path.write_text(changed, encoding="utf-16", newline="\r\n")  # as an editor of Windows may save it
        page.locator("#gain-file").set_input_files(path)
        wait_for_text(page.locator("#compare-warning"), "another machine (serial number 123456789")
        wrong = tmp_path / "wrong.toml"
        wrong.write_text("[azimuth.speed_loop]\nproportional_gian = 3\n")
        page.locator("#gain-file").set_input_files(wrong)
        wait_for_text(page.locator("#toast"), "wrong.toml:2:")
        assert page.locator("#gain-compare").is_hidden()


def columns(page: Page) -> list[str]:
    """Staged, active and stored value, unit and range of GAIN, as shown."""
    return page.locator(f"#gains tr[data-name='{GAIN}'] td").all_text_contents()[2:]


def test_staged_active_and_stored_values_stand_beside_each_other(servo: Bench, server: Server, browser: Browser) -> None:
    with opened(browser, server) as page:
        take_command(page)
        press(page.locator("#gain-store"))
        wait_for_text(page.locator("#gain-file-note"), "stored in the device")
        press(page.locator("#gain-read"))
        wait_for(lambda: columns(page)[0] == "–" and columns(page)[1] == columns(page)[2] != "not known", "as stored")
        old = columns(page)[1]
        assert columns(page)[3:] == ["N m s/rad", "0.0 … 1000000.0"]
        field = page.locator(f"#gains tr[data-name='{GAIN}'] input")
        field.focus()
        wait_for_text(page.locator("#gain-help"), f"{GAIN} (0x2000:01): 2 zeta w J for damping ratio zeta")
        new = f"{1.1 * float(old):.2f}"
        field.fill(new)
        press(page.locator("#gain-apply"))
        wait_for(lambda: columns(page)[:3] == ["–", new, old], "active and not stored")
        wait_for_text(page.locator("#gain-note"), "applied in one piece")

        assert servo("set", "--stage", f"{GAIN}={old}").code == 0
        press(page.locator("#gain-read"))
        wait_for(lambda: columns(page)[:3] == [old, new, old], "staged by another tool")
        assert page.locator("#gain-staged").is_visible()
        press(page.locator("#gain-discard"))
        wait_for(page.locator("#gain-staged").is_hidden, "discarded")
        wait_for(lambda: columns(page)[:3] == ["–", new, old], "nothing staged")
        field.fill(old)
        press(page.locator("#gain-apply"))
        wait_for(lambda: columns(page)[:3] == ["–", old, old], "as before")

        assert servo("set", f"{GAIN}={new}").code == 0 and servo("set", "--stage", f"{GAIN}={old}").code == 0
        press(page.locator("#gain-read"))
        wait_for(lambda: columns(page)[:3] == [old, "not known", old], "applied by another tool, and never seen")
        press(page.locator("#gain-discard"))
        wait_for(lambda: columns(page)[:3] == ["–", new, old], "seen")
        field.fill(old)
        press(page.locator("#gain-apply"))
        wait_for(lambda: columns(page)[:3] == ["–", old, old], "as before")


def test_new_values_of_one_axis_stay_when_the_other_is_shown(servo: Bench, server: Server, browser: Browser) -> None:
    with opened(browser, server) as page:
        take_command(page)
        field, other = (page.locator(f"#gains tr[data-name='{name}'] input") for name in (GAIN, GAIN.replace("azimuth", "pitch")))
        azimuth, pitch = (page.locator(f"[data-gains='{n}']") for n in (0, 1))
        before = {name: servo.value(name) for name in (GAIN, GAIN.replace("azimuth", "pitch"))}
        field.fill("800")
        pitch.click()
        wait_for_text(azimuth, "azimuth (1 new)")
        assert float(other.input_value()) == pytest.approx(before[GAIN.replace("azimuth", "pitch")], rel=1e-4)
        assert page.locator("#gain-apply").is_disabled()  # it would apply those that are shown
        azimuth.click()
        wait_for(lambda: field.count() == 1 and field.input_value() == "800", "the new value is there")
        press(page.locator("#gain-clear"))
        wait_for(lambda: azimuth.text_content() == "azimuth", "no new values")
        assert {name: servo.value(name) for name in before} == before


def test_a_guarded_gain_needs_the_lock_and_the_values_are_stored(servo: Bench, server: Server, browser: Browser) -> None:
    with opened(browser, server) as page:
        take_command(page)
        page.locator("#gain-filter").fill("protection")
        field = page.locator(f"#gains tr[data-name='{GUARDED}'] input")
        before = servo.value(GUARDED)
        assert not field.is_editable()
        page.locator("#gain-unlock").check()
        field.fill(str(round(0.99 * before, 3)))
        press(page.get_by_role("button", name="Apply", exact=True))
        wait_for_text(page.locator("#gain-note"), "applied")
        assert servo.value(GUARDED) == pytest.approx(0.99 * before, rel=1e-3)
        assert servo.json("lock", "status")["open_s"] == 0
        press(page.get_by_role("button", name="Undo last change"))
        wait_for_text(page.locator("#gain-note"), "undone")
        assert servo.value(GUARDED) == before
        press(page.locator("#gain-store"))
        wait_for_text(page.locator("#gain-file-note"), "stored in the device; backup:")
        backup = (page.locator("#gain-file-note").text_content() or "").split("backup: ")[1]
        assert servo("diff", backup).code == 0


def apply_guarded(page: Page, before: float) -> None:
    """Unlocks for a new value, and enters no word."""
    take_command(page)
    page.locator("#gain-filter").fill("protection over speed")
    page.locator("#gain-unlock").check()
    page.locator(f"#gains tr[data-name='{GUARDED}'] input").fill(str(round(0.98 * before, 3)))
    press(page.get_by_role("button", name="Apply", exact=True))


def test_a_lock_with_a_word_asks_for_it(servo: Bench, server: Server, browser: Browser) -> None:
    assert servo("lock", "set-word", "--new", "secret").code == 0
    try:
        before = servo.value(GUARDED)
        with opened(browser, server) as page:
            apply_guarded(page, before)
            wait_for_text(page.locator("#toast"), "has set an access word")
            assert servo.value(GUARDED) == before
            page.locator("#gain-word").fill("secret")
            press(page.get_by_role("button", name="Apply", exact=True))
            wait_for_text(page.locator("#gain-note"), "applied")
            press(page.get_by_role("button", name="Undo last change"))
            wait_for(lambda: bool(servo.value(GUARDED) == before), "undone")
        with running(servo, "--word", "secret") as knowing, opened(browser, knowing) as page:
            apply_guarded(page, before)
            wait_for_text(page.locator("#gain-note"), "applied")
            press(page.get_by_role("button", name="Undo last change"))
            wait_for(lambda: bool(servo.value(GUARDED) == before), "undone")
    finally:
        assert servo("lock", "set-word", "--remove", "--word", "secret").code == 0


def test_the_spectrum_shows_the_amplitude_of_a_sine_and_stops_at_a_gap(servo: Bench, server: Server, browser: Browser) -> None:
    with opened(browser, server) as page:
        found = page.evaluate(
            """async () => {
                 const { amplitudes, stretch } = await import("./spectrum.js");
                 const sine = Float32Array.from({ length: 1024 }, (_, i) => 5 + 0.25 * Math.sin(2 * Math.PI * 37 * i / 1024));
                 const lines = amplitudes(sine);
                 const time = Float64Array.from({ length: 900 }, (_, i) => i * 0.001 + (i >= 300 ? 1 : 0));
                 const source = { count: 900, time, period: 0.001, find: (t) => { const n = time.findIndex((x) => x >= t); return n < 0 ? 900 : n; } };
                 return [lines.indexOf(Math.max(...lines)), Math.max(...lines), lines[0], ...stretch(source, 0, 10)];
               }"""
        )
        assert found[0] == 37 and found[1] == pytest.approx(0.25, rel=1e-3) and abs(found[2]) < 1e-3
        assert found[3:] == [900 - 512, 512]
        wait_for(lambda: bool(page.evaluate("trackservo.plots.history.count > 200")), "samples")
        page.get_by_role("button", name="Spectrum").click()
        wait_for_text(page.locator("#spectrum-note"), "Hann window")
        assert page.locator("#spectrum-plot canvas").count() == 1


def test_cursors_show_differences_and_a_pause_holds_the_picture(servo: Bench, server: Server, browser: Browser) -> None:
    with opened(browser, server) as page:
        wait_for(lambda: bool(page.evaluate("trackservo.plots.history.count > 1500")), "samples")
        page.locator("[data-window='1']").click()
        page.locator("#pause").click()
        shown = page.evaluate("trackservo.plots.shown()")
        page.locator("#cursors").click()
        rows = page.locator("#cursor-table tbody tr")
        wait_for(lambda: rows.count() == 1 + len(page.evaluate("trackservo.plots.signals")), "a row per signal")
        assert rows.first.locator("td").last.text_content() == "0.300 s"
        box = page.locator(".plot .u-over").first.bounding_box()
        assert box is not None
        page.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + 40)
        page.mouse.down()
        page.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 40)
        page.mouse.up()
        wait_for_text(page.locator("#zoom-note"), "s shown")
        zoomed = page.evaluate("trackservo.plots.shown()")
        assert shown[0] < zoomed[0] < zoomed[1] < shown[1]
        assert zoomed[1] - zoomed[0] == pytest.approx(0.5, abs=0.05)

        take_command(page)
        page.locator("#choice").select_option("azimuth")  # other signals wait behind the picture
        wait_for(lambda: page.evaluate("trackservo.state().stream.choice") == "azimuth", "other signals come")
        live = page.evaluate("trackservo.plots.seen")
        wait_for(lambda: page.evaluate("trackservo.plots.seen") > live + 100, "their samples")
        assert page.evaluate("trackservo.plots.shown()") == zoomed
        assert [cell for cell in rows.locator("td:first-child").all_text_contents() if cell.startswith("pitch")]
        page.locator("#pause").click()
        wait_for(lambda: not [cell for cell in rows.locator("td:first-child").all_text_contents() if cell.startswith("pitch")], "are shown")
        page.locator("#choice").select_option("both")


def test_a_file_that_is_too_large_is_not_sent(servo: Bench, server: Server, browser: Browser, tmp_path: Path) -> None:
    """Its message would close the socket of the page that commands, and stop the axes."""
    with opened(browser, server) as page:
        take_command(page)
        large = tmp_path / "large.toml"
        large.write_bytes(b"# x\n" * 500_000)
        page.locator("#gain-file").set_input_files(large)
        wait_for_text(page.locator("#gain-file-note"), "large.toml is no gains file: it has 2000 kB")
        wait_for_text(page.locator("#who"), "this page commands")
