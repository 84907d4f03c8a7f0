"""One axis of the node by SDO alone; pitch is azimuth 0x800 higher."""

import math
import time

STATES = {  # statusword: mask, value
    "NOT READY TO SWITCH ON": (0x4F, 0x00), "SWITCH ON DISABLED": (0x4F, 0x40), "READY TO SWITCH ON": (0x6F, 0x21),
    "SWITCHED ON": (0x6F, 0x23), "OPERATION ENABLED": (0x6F, 0x27), "QUICK STOP ACTIVE": (0x6F, 0x07),
    "FAULT REACTION ACTIVE": (0x4F, 0x0F), "FAULT": (0x4F, 0x08),
}
PP, PV, CSP, CSV, CST = 1, 3, 8, 9, 10
APPLY, REVERT, UNDO = 1, 2, 3
STAGED, DIRTY = 1, 2  # bits of 0x2070:2
ENABLE = 0x0F
RATED_NM = 40.0


def micro_rad(degrees):
    return round(math.radians(degrees) * 1e6)


def wait_until(condition, timeout):
    """Duration in seconds."""
    start = time.monotonic()
    while not condition():
        assert time.monotonic() - start < timeout, "it did not happen in time"
        time.sleep(0.005)
    return time.monotonic() - start


class Axis:
    def __init__(self, node, shift):
        self.node = node
        self.shift = shift

    def variable(self, index, sub=0):
        entry = self.node.sdo[index + self.shift]
        return entry[sub] if hasattr(entry, "__getitem__") and hasattr(entry, "keys") else entry

    def get(self, index, sub=0):
        return self.variable(index, sub).raw

    def set(self, value, index, sub=0):
        self.variable(index, sub).raw = value

    @property
    def state(self):
        statusword = self.get(0x6041)
        return next((name for name, (mask, value) in STATES.items() if statusword & mask == value), None)

    def command(self, controlword):
        self.set(controlword, 0x6040)

    def enable(self, mode):
        self.set(0, 0x6007)  # the tests do not speak while an axis turns
        self.set(mode, 0x6060)
        for controlword, state in ((0x06, "READY TO SWITCH ON"), (0x07, "SWITCHED ON"), (ENABLE, "OPERATION ENABLED")):
            self.command(controlword)
            wait_until(lambda: self.state == state, 1)
        wait_until(lambda: self.get(0x6061) == mode, 1)
        time.sleep(1.5 * self.get(0x2060, 24))  # until its holding brake is open

    def turn(self, deg_s, settle_s=1.0):
        """At a constant rate in pv."""
        self.enable(PV)
        self.set(micro_rad(deg_s), 0x60FF)
        time.sleep(settle_s)

    @property
    def rate_deg_s(self):
        return math.degrees(self.get(0x606C) * 1e-6)

    @property
    def angle_deg(self):
        return math.degrees(self.get(0x6064) * 1e-7)

    def mean_rate_deg_s(self, seconds=0.5):
        """From the angle, so that noise does not matter, over the node's own time (3010:1)."""
        start_ms, angle_deg = self.node.sdo[0x3010][1].raw, self.angle_deg
        time.sleep(seconds)
        return (self.angle_deg - angle_deg) / (1e-3 * (self.node.sdo[0x3010][1].raw - start_ms))
