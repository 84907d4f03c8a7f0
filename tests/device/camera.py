# SPDX-License-Identifier: Apache-2.0
"""A camera of this computer: its frames reach the node by RPDO4, as in docs/can.md."""

import struct

from axis import TPDO8, tenth_micro_rad
from slip_ring import wrapped

CAMERA_ID = 0x541
TRACKING = -1
ON_TARGET, COASTING, LOST = 3, 4, 5
BY_CLOCK = 1


def map_camera(master):
    """RPDO4 takes its frames; the axes turn on while the client is silent. The node is operational."""
    sdo = master.node.sdo
    sdo[0x1403][1].raw = 0x80000000 | CAMERA_ID
    sdo[0x1603][0].raw = 0
    for sub, bits in enumerate((16, 16, 16, 8, 8), start=1):
        sdo[0x1603][sub].raw = 0x3070 << 16 | sub << 8 | bits
    sdo[0x1603][0].raw = 5
    sdo[0x1403][1].raw = CAMERA_ID
    for index in (0x6007, 0x6807):
        sdo[index].raw = 0
    master.start()


class Camera:
    """A frame every 20 ms, of a target that moves at a constant rate; the node's clock tells the exposure. The node runs in
    real time: a frame older than 127 ms does not count."""

    def __init__(self, axis, rate_deg_s=1.0):
        self.master, self.axis = axis.master, axis
        self.target = axis.get(0x6064) + 20000
        self.rate_deg_s = rate_deg_s
        self.hangs = self.frozen = False  # it sends its last frame again; its last picture with new counters
        self.step = 0  # of the counter while it hangs
        self.jitter = 0  # counts of a frozen place
        self.quality_of_20th = 90
        self.counter, self.clock, self.error = 0, None, 0
        map_camera(self.master)
        self.master.write(0x3071, 5, BY_CLOCK, 1)
        self.master.network.subscribe(self.master.sample(TPDO8, [0x60640020, 0x30720810]), self.look)

    def look(self, _identifier, data, _time):
        position, clock = struct.unpack("<lH", data)
        passed_s = 0.0 if self.clock is None else 1e-5 * (clock - self.clock & 0xFFFF)
        self.clock = clock
        self.target += passed_s * tenth_micro_rad(self.rate_deg_s)
        self.counter = self.counter + (self.step if self.hangs else 1) & 0xFF
        if not self.hangs and not self.frozen:
            self.error = round(0.1 * wrapped(self.target - position))
        quality = self.quality_of_20th if self.counter % 20 == 0 else 90
        jitter = self.jitter * (self.counter % 3 - 1)
        self.master.send(CAMERA_ID, *struct.pack("<hhHBB", self.error + jitter, 0, clock, quality, self.counter))

    @property
    def state(self):
        return self.master.number(0x3072, 5)

    def follow(self):
        self.axis.enable(TRACKING)
        self.master.wait_until(lambda: self.state == ON_TARGET, 8)
