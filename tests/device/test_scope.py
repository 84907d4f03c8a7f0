# SPDX-License-Identifier: Apache-2.0
"""A capture of the scope comes over the bus bit for bit, whichever method reads it. On SLCAN and on SocketCAN."""

import struct

import pytest

from axis import PV, micro_rad
from device import REAL_TIME

pytestmark = pytest.mark.speed(REAL_TIME)  # a client that pauses for 1 s in a transfer ends it
SCOPE, DATA = 0x3000, 0x3001
COMMAND, STATE, DIVIDER, PRETRIGGER, TRIGGER, TRIGGER_CHANNEL, LEVEL, FRAMES, CHANNELS, SIGNAL = range(1, 11)
ARM, STOP, FORCE = 1, 2, 3
ABOVE, STATE_CHANGE = 1, 5
WAITING, DONE = 2, 4
REFERENCE, TORQUE, PI, DISTURBANCE, FRICTION = 1, 6, 7, 8, 9  # numbers of azimuth's signals in 0x3002


def arm(node, signals, trigger=0, level=0.0, pretrigger=0):
    scope = node.sdo[SCOPE]
    scope[COMMAND].raw = STOP
    scope[CHANNELS].raw = len(signals)
    for i, signal in enumerate(signals):
        scope[SIGNAL + i].raw = signal
    scope[DIVIDER].raw = 1
    scope[PRETRIGGER].raw = pretrigger
    scope[TRIGGER].raw = trigger
    scope[TRIGGER_CHANNEL].raw = 0
    scope[LEVEL].raw = level
    scope[COMMAND].raw = ARM
    return scope


def read(node, block):
    with node.sdo[DATA].open("rb", block_transfer=block) as stream:
        return stream.read()


def parse(data):
    """(frame of the trigger, one list for each channel)."""
    magic, version, header, channels, frames, trigger, divider, tick_ns = struct.unpack_from("<4s7I", data)
    assert (magic, version, divider, tick_ns) == (b"TSSC", 1, 1, 1000000)
    assert len(data) == header + 4 * channels * frames
    return trigger, list(zip(*struct.iter_unpack(f"<{channels}f", data[header:])))


def test_capture_of_32_kib_is_the_same_by_block_and_by_segments(master, node, azimuth, report):
    azimuth.turn(1.0)
    scope = arm(node, [TORQUE, PI, DISTURBANCE, FRICTION])
    master.wait_until(lambda: scope[STATE].raw == DONE, 5)
    start_ms = master.ticks_ms()
    data = read(node, block=True)
    report(f"{len(data)} bytes by block upload in {1e-3 * (master.ticks_ms() - start_ms):.2f} s")
    assert len(data) == 32 + 4 * 8 + 32768
    assert read(node, block=True) == data
    assert read(node, block=False) == data
    _, (torque, pi, disturbance, friction) = parse(data)
    # One tick, one frame: the parts add up in each of them.
    for total, *parts in zip(torque, pi, disturbance, friction):
        assert sum(parts) == pytest.approx(total, abs=1e-4)
    assert max(torque) > min(torque) > 0


def test_state_change_triggers_with_frames_before_it(master, node, azimuth):
    azimuth.enable(PV)
    scope = arm(node, [REFERENCE], trigger=STATE_CHANGE, pretrigger=100)
    master.wait_until(lambda: scope[STATE].raw == WAITING, 1)
    azimuth.command(0x07)
    master.wait_until(lambda: scope[STATE].raw not in (WAITING, DONE), 1)
    master.pass_time(100)
    scope[COMMAND].raw = STOP
    trigger, (reference,) = parse(read(node, block=True))
    assert trigger >= 100 and len(reference) > trigger + 50  # ended early, so no frame was overwritten


def test_trigger_that_does_not_come_can_be_forced(master, node, azimuth):
    azimuth.enable(PV)
    scope = arm(node, [REFERENCE], trigger=ABOVE, level=1e6, pretrigger=4096)
    master.pass_time(100)
    assert scope[STATE].raw < WAITING  # the frames before it are not there yet
    azimuth.set(micro_rad(1.0), 0x60FF)
    scope[COMMAND].raw = FORCE
    master.wait_until(lambda: scope[STATE].raw == DONE, 10)
    trigger, (reference,) = parse(read(node, block=True))
    assert 50 < trigger < 4096
    assert len(reference) == trigger + 8192 - 4096
    assert abs(reference[0]) < 1e-3 and reference[-1] == pytest.approx(1e-6 * micro_rad(1.0), rel=1e-3)
