# SPDX-License-Identifier: Apache-2.0
"""The servo that the tests talk to: the simulator (`sim`), or the image on the emulated board (`image`).

SIM_HOST, EMULATE_BOARD and TARGET_IMAGE name the programs and the image, NODE_DESCRIPTIONS the folder of the EDS. CTest
sets them; without them those of build/host and build/stm32g474 are used. A further device is an entry of DEVICES: a
class with `kind`, `address`, `open_bus` and `close`.
"""

import functools
import os
import pathlib
import subprocess

import can
import canopen
from servoctl.link.slcan_tcp import SlcanTcpBus  # python-can's own reads byte by byte

NODE_ID = 1
PROJECT = pathlib.Path(__file__).resolve().parents[2]
SIM_HOST = os.environ.get("SIM_HOST", str(PROJECT / "build/host/bin/sim_host"))
EMULATE_BOARD = os.environ.get("EMULATE_BOARD", str(PROJECT / "build/host/bin/emulate_board"))
IMAGE = os.environ.get("TARGET_IMAGE", str(PROJECT / "build/stm32g474/bin/trackservo.bin"))
DESCRIPTIONS = pathlib.Path(os.environ.get("NODE_DESCRIPTIONS", str(PROJECT / "build/host/share/trackservo")))
REAL_TIME, FAST = 1, 4
"""Node time over the computer's. A busy computer, and the emulated board, may be slower."""


@functools.cache
def dictionary():
    return canopen.import_od(str(DESCRIPTIONS / "trackservo.eds"), NODE_ID)


class Served:
    """A servo in a process of its own, and the address of its bus."""

    def __init__(self, bus, *options, program=(SIM_HOST, "serve")):
        self.process = subprocess.Popen(
            [*program, "--until-stdin-ends", "--bus", bus, *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            text=True, cwd=PROJECT)
        self.kind, self.address = self.next_end()

    def next_end(self):
        """Kind and address of a bus end, in the order of the --bus options."""
        return self.process.stdout.readline().strip().split(":", 1)

    def wait_until_ready(self):
        assert self.process.stdout.readline() == "ready\n"
        return self

    @property
    def tcp(self):
        host, port = self.address.rsplit(":", 1)
        return host, int(port)

    def open_bus(self, bit_rate=1000000, **options):
        if self.kind == "socketcan":
            return can.Bus(interface="socketcan", channel=self.address, **options)
        return SlcanTcpBus(*self.tcp, bit_rate, **options)

    def close(self):
        self.process.stdin.close()
        assert self.process.wait(timeout=20) == 0  # otherwise the image has violated the chip's rules


PROGRAMS = {"sim": (SIM_HOST, "serve"), "image": (EMULATE_BOARD, IMAGE)}


def start(kind, bus, speed, *options):
    return Served(bus, "--speed", str(speed), *options, program=PROGRAMS[kind]).wait_until_ready()


DEVICES = {kind: functools.partial(start, kind) for kind in PROGRAMS}
