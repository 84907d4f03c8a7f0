# SPDX-License-Identifier: Apache-2.0
"""Errors that the page shows name its own controls."""

from __future__ import annotations

import re
from types import SimpleNamespace
from typing import Any, cast

import pytest

from servoctl.drive.drive import Drive
from servoctl.errors import ServoctlError
from servoctl.gains.loop_test import loop_stimulus
from servoctl.identify.commissioning import check_place
from servoctl.identify.test_plan import Envelope
from servoctl.motion.step_test import plan_step
from servoctl.show.capture import request
from servoctl.ui.page_words import of_page
from servoctl.units import radians


def axis_at(angle_deg: float) -> Drive:
    return cast(Drive, SimpleNamespace(name="azimuth", position=lambda: radians(angle_deg)))


TRAVEL = Envelope(radians(-20.0), radians(10.0), 10.0, 1.0)


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        (lambda: check_place(axis_at(50.0), TRAVEL), "Move it inside first with 'Move …' to -5°."),
        (lambda: plan_step("azimuth", 0.0, hold=1.0), "the rate of a step must not be 0, and its time must be 0.1 to 30 s."),
        (lambda: loop_stimulus(1.0, 200.0, 0.1, 0.2, 50, 5), "the peak must be greater than 0 and less than the mean rate"),
        (lambda: loop_stimulus(1.0, 900.0, 0.1, 0.05, 50, 5), "at most 200 Hz, because"),
        (lambda: request({}, [], 1000.0, 1.0, 0.0, "now", 0, 0.0), "expected 1 to"),
    ],
)
def test_an_error_of_the_library_names_no_command(call: Any, expected: str) -> None:
    with pytest.raises(ServoctlError) as raised:
        call()
    assert re.search(r"--[a-z]|servoctl", str(raised.value))  # as the command line says it
    shown = of_page(str(raised.value))
    assert expected in shown
    assert not re.search(r"--[a-z]|servoctl", shown)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("pitch has a fault (603F = 8130): reset it with 'servoctl state pitch reset'.", "pitch has a fault (603F = 8130): reset it with 'Reset fault'."),
        ("azimuth is in 'fault' (603F = 8130); 'servoctl faults' shows details.", "azimuth is in 'fault' (603F = 8130); the tab Faults shows details."),
        ("unknown parameter 'x'; 'servoctl explain' lists all names.", "unknown parameter 'x'."),
        ("the node does not answer: 'servoctl scan' lists the nodes.", "the node does not answer: 'servoctl scan' lists the nodes."),
    ],
)  # fmt: skip
def test_what_the_page_can_do_is_named_as_there(text: str, shown: str) -> None:
    assert of_page(text) == shown
