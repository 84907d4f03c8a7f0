# SPDX-License-Identifier: Apache-2.0
"""Why a device refused a parameter set: objects 0x2070:6 to 9 (+0x800) as a sentence."""

from __future__ import annotations

import struct

from ..link.device import Device
from ..units import number
from .parameter import AXES, AXIS_SHIFT, Parameter, shortest

RESULT_SUB, UNSTABLE = 3, 4
OVERRIDE_ADVICE = "'servoctl set' and 'servoctl restore' apply such gains with --override-gain-check."
SET_OBJECT, OBJECT_SUB, LOW_SUB, HIGH_SUB, BOUND_SUB = 0x2070, 6, 7, 8, 9


def refusal_text(device: Device, axis: int) -> str | None:
    """ "2020:4 Observer bandwidth is 5000 rad/s; give 0.01 .. 1000."; None when the device names no value."""
    answers = [device.try_upload(SET_OBJECT + AXIS_SHIFT * axis, sub) for sub in (OBJECT_SUB, LOW_SUB, HIGH_SUB, BOUND_SUB)]
    if any(data is None for data in answers):
        return None  # firmware from before these objects
    place, low, high, bound = struct.unpack("<IffI", b"".join(data for data in answers if data is not None))
    if place == 0:
        return None
    unstable = device.try_upload(SET_OBJECT + AXIS_SHIFT * axis, RESULT_SUB) == struct.pack("<I", UNSTABLE)
    if unstable and bound != 0:
        return (
            f"a feedforward would take the motor's torque from the loop: {_value_text(device, axis, place)}; give"
            f" {number(shortest(low))} .. {number(shortest(high))}, since {_value_text(device, axis, bound)}. If the latter"
            f" is wrong, identify the axis again; {OVERRIDE_ADVICE}"
        )
    if unstable:
        return (
            f"the loops would be unstable on the identified plant (2056), mainly since {_value_text(device, axis, place)}; "
            f"the active set has {number(shortest(low))}. If 2056 is wrong, identify the axis again; {OVERRIDE_ADVICE}"
        )
    text = f"{_value_text(device, axis, place)}; give {number(shortest(low))} .. {number(shortest(high))}"
    if bound != 0:
        return f"{text}, since {_value_text(device, axis, bound)}."
    wrong = _parameter(device, place)
    if wrong is not None and wrong.low is not None and wrong.low < low:
        return f"{text}, or {number(wrong.low)}."  # switches off what has this parameter
    return f"{text}."


def _parameter(device: Device, coded: int) -> Parameter | None:
    return device.any_schema.by_index(coded >> 16, coded >> 8 & 0xFF)


def _value_text(device: Device, axis: int, coded: int) -> str:
    place = f"{coded >> 16:04X}:{coded >> 8 & 0xFF}"
    found = _parameter(device, coded)
    if found is None:
        return place
    title = found.title.removeprefix(f"{AXES[axis].capitalize()} ")
    return f"{place} {title} is {number(device.read(found))} {found.unit}".rstrip()
