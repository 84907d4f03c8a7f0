# SPDX-License-Identifier: Apache-2.0
"""A CANopen master with the node in its network: python-canopen with longer time-outs, and the frames that it receives.

Time is the node's: object 3010:1 counts its ms. The computer's clock only ends a test whose node has died.
test_unmodified_clients.py has the client with its own time-outs.
"""

import collections
import contextlib
import gc
import struct
import threading
import time

import canopen
from canopen.profiles.p402 import BaseNode402
from device import NODE_ID, dictionary

# The test machines are shared: an answer may be late without an error.
canopen.sdo.SdoClient.RESPONSE_TIMEOUT = 10.0
canopen.lss.LssMaster.RESPONSE_TIMEOUT = 2.0
for patience in [name for name in dir(BaseNode402) if name.startswith("TIMEOUT_")]:
    setattr(BaseNode402, patience, 10.0)
BaseNode402.TIMEOUT_RESET_FAULT = 0.5  # it always waits so long: its fault reset rises only afterwards
DEAD_S = 60.0


def abort_code(sdo, index, sub, data=None):
    """Of a download (an upload without `data`) by this client; 0: not refused."""
    code = 0
    try:
        if data is None:
            sdo.upload(index, sub)
        else:
            sdo.download(index, sub, data)
    except canopen.SdoAbortedError as refusal:
        code = refusal.code
    if code != 0 and data is not None and len(data) > 4:
        # python-canopen's stream of a refused download sends when it is garbage-collected; within another transfer it
        # would wait for ever.
        gc.collect()
    return code


class Master:
    def __init__(self, bus):
        self.network = canopen.Network(bus=bus)
        self.network.connect()
        self._heard = collections.defaultdict(list)
        self._changed = threading.Condition()
        self._own = {identifier: list(callbacks) for identifier, callbacks in self.network.subscribers.items()}
        self.begin()

    def begin(self):
        """As if just connected: a new node object, and no subscriber of a former test."""
        self.network.subscribers = {identifier: list(callbacks) for identifier, callbacks in self._own.items()}
        self.node = BaseNode402(NODE_ID, dictionary())
        self.network.nodes.clear()
        self.network.add_node(self.node)
        for identifier in range(0x800):
            self.network.subscribe(identifier, self._hear)
        self.forget()

    def _hear(self, identifier, data, _time):
        with self._changed:
            self._heard[identifier].append(bytes(data))
            self._changed.notify_all()

    def forget(self):
        with self._changed:
            self._heard.clear()

    def heard(self, identifier):
        """The frames since `forget`."""
        with self._changed:
            return list(self._heard[identifier])

    def wait_for(self, identifier, count=1):
        """At least `count` frames since `forget`; sends nothing meanwhile."""
        self._wait(lambda: len(self._heard[identifier]) >= count, f"{count} frames {identifier:03X}")
        return self.heard(identifier)

    def _wait(self, condition, what):
        end = time.monotonic() + DEAD_S
        with self._changed:
            while not condition():
                self._changed.wait(0.1)
                assert time.monotonic() < end, f"not heard: {what}"

    def send(self, identifier, *data):
        self.network.send_message(identifier, bytes(data))

    def request(self, *request):
        """An SDO request byte by byte, and the next answer."""
        before = len(self.heard(0x580 + NODE_ID))
        self.send(0x600 + NODE_ID, *bytes(request).ljust(8, b"\0"))
        return self.wait_for(0x580 + NODE_ID, before + 1)[before]

    def ticks_ms(self):
        return struct.unpack("<L", self.node.sdo.upload(0x3010, 1))[0]

    def pass_time(self, ms):
        """Of the node. The master speaks meanwhile: it reads 3010:1."""
        start = self.ticks_ms()
        while (left := ms - (self.ticks_ms() - start & 0xFFFFFFFF)) > 0:
            time.sleep(min(0.02, 1e-4 * left))

    def sample(self, pdo, objects):
        """The identifier of a free TPDO that now comes every 20 ms of the node, if it is operational."""
        identifier = self.number(0x1800 + pdo, 1) & 0x7FF
        self.write(0x1A00 + pdo, 0, 0, 1)
        for sub, entry in enumerate(objects, 1):
            self.write(0x1A00 + pdo, sub, entry, 4)
        self.write(0x1A00 + pdo, 0, len(objects), 1)
        for sub, value, size in ((2, 255, 1), (3, 0, 2), (5, 20, 2), (1, 0x40000000 | identifier, 4)):
            self.write(0x1800 + pdo, sub, value, size)
        return identifier

    def record(self, pdo, objects, count):
        """So many and one more frames of it."""
        identifier = self.sample(pdo, objects)
        before = len(self.heard(identifier))
        frames = self.wait_for(identifier, before + count + 1)[before:]
        self.write(0x1800 + pdo, 1, 0xC0000000 | identifier, 4)
        return frames

    @contextlib.contextmanager
    def every(self, ms, action):
        """Calls `action` with each heartbeat of the node, which come every `ms` by its own clock."""
        self.write(0x1017, 0, ms, 2)

        def hear(_identifier, _data, _time):
            action()

        self.network.subscribe(0x700 + NODE_ID, hear)
        yield
        self.network.unsubscribe(0x700 + NODE_ID, hear)

    def be_silent(self, heartbeats):
        """For so many heartbeats of the node, 100 ms each by its own clock: nothing is sent."""
        with self._changed:
            self._heard[0x700 + NODE_ID].clear()
        self.wait_for(0x700 + NODE_ID, heartbeats)

    def wait_until(self, condition, within_s=3.0):
        """Node time in s until it holds."""
        start = self.ticks_ms()
        while not condition():
            passed_s = 1e-3 * (self.ticks_ms() - start & 0xFFFFFFFF)
            if passed_s >= within_s:
                assert condition(), f"not within {within_s} s"
                return passed_s
            time.sleep(0.001)
        return 1e-3 * (self.ticks_ms() - start & 0xFFFFFFFF)

    def sdo_abort(self, index, sub, data=None):
        return abort_code(self.node.sdo, index, sub, data)

    def number(self, index, sub=0):
        return int.from_bytes(self.node.sdo.upload(index, sub), "little")

    def write(self, index, sub, value, size):
        self.node.sdo.download(index, sub, value.to_bytes(size, "little", signed=value < 0))

    def _command(self, command):
        self.forget()
        self.node.nmt.send_command(command)
        self._wait(lambda: b"\0" in self._heard[0x700 + NODE_ID], "boot-up message")

    def reset(self):
        """All objects as after power-on; the boot-up message has come."""
        self._command(0x81)

    def reset_communication(self):
        self._command(0x82)

    def start(self):
        self.node.nmt.send_command(0x01)
        self.wait_for_state(5)

    def wait_for_state(self, state):
        """The next heartbeats show it."""
        self.forget()
        self._wait(lambda: bytes([state]) in self._heard[0x700 + NODE_ID], f"heartbeat with state {state}")

    def close(self):
        """Once; later calls do nothing."""
        if self.network.bus is not None:
            self.network.disconnect()
            self.network.bus = None
