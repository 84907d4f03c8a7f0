# SPDX-License-Identifier: Apache-2.0
"""One axis of the node by SDO alone; pitch is azimuth 0x800 higher."""

import math
import struct

from canopen.profiles.p402 import State402

STATES = {name: mask_value for name, mask_value in State402.SW_MASK.items()}
PP, PV, CSP, CSV, CST = 1, 3, 8, 9, 10
APPLY, REVERT, UNDO = 1, 2, 3
STAGED, DIRTY = 1, 2  # bits of 0x2070:2
ENABLE = 0x0F
HALT = 0x100
NEW_SETPOINT = 0x10
TARGET_REACHED, ACKNOWLEDGED = 0x400, 0x1000
RATED_NM = 40.0
TPDO8 = 7


def micro_rad(degrees):
    return round(math.radians(degrees) * 1e6)


def tenth_micro_rad(degrees):
    return round(math.radians(degrees) * 1e7)


def state_of(statusword):
    return next((name for name, (mask, value) in STATES.items() if statusword & mask == value), None)


class Axis:
    def __init__(self, master, shift):
        self.master = master
        self.node = master.node
        self.shift = shift

    def variable(self, index, sub=0):
        entry = self.node.sdo[index + self.shift]
        return entry[sub] if hasattr(entry, "__getitem__") and hasattr(entry, "keys") else entry

    def get(self, index, sub=0):
        return self.variable(index, sub).raw

    def set(self, value, index, sub=0):
        self.variable(index, sub).raw = value

    def wait_until(self, condition, within_s=3.0):
        return self.master.wait_until(condition, within_s)

    @property
    def state(self):
        return state_of(self.get(0x6041))

    def wait_for_state(self, state, within_s=3.0):
        return self.wait_until(lambda: self.state == state, within_s)

    def wait_for_standstill(self, within_s=3.0):
        return self.wait_until(lambda: abs(self.rate_deg_s) < 0.05, within_s)

    def command(self, controlword):
        self.set(controlword, 0x6040)

    def switch_on(self, mode):
        """Operation enabled; the supervision of the master (6007) is as it was."""
        self.set(mode, 0x6060)
        for controlword, state in ((0x06, "READY TO SWITCH ON"), (0x07, "SWITCHED ON"), (ENABLE, "OPERATION ENABLED")):
            self.command(controlword)
            self.wait_for_state(state)

    def enable(self, mode):
        self.set(0, 0x6007)  # the tests do not always speak while an axis turns
        self.switch_on(mode)
        self.wait_until(lambda: self.get(0x6061) == mode)
        self.master.pass_time(1500 * self.get(0x2060, 24))  # until its holding brake is open

    def turn(self, deg_s, settle_s=1.0):
        """At a constant rate in pv."""
        self.enable(PV)
        self.set(micro_rad(deg_s), 0x60FF)
        self.master.pass_time(1000 * settle_s)

    @property
    def rate_deg_s(self):
        return math.degrees(self.get(0x606C) * 1e-6)

    @property
    def angle_deg(self):
        return math.degrees(self.get(0x6064) * 1e-7)

    def mean_rate_deg_s(self, seconds=0.5):
        """From the angle, so that noise does not matter; TPDO8 brings it with the node's own time."""
        frames = self.master.record(TPDO8, [0x30100120, 0x60640020 + (self.shift << 16)], round(seconds / 0.02))
        (start_ms, start), *_, (end_ms, end) = (struct.unpack("<Ll", frame) for frame in frames)
        return math.degrees(1e-7 * (end - start)) / (1e-3 * (end_ms - start_ms))
