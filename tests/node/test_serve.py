"""The command `sim_host serve` itself: several ends on one bus, the pace of time, and what it refuses."""

import contextlib
import subprocess
import time

import can
import pytest

from conftest import NODE_ID, SIM_HOST, Served

TICKS_REQUEST = [0x40, 0x10, 0x30, 0x01, 0, 0, 0, 0]


@contextlib.contextmanager
def serving(*options):
    served = Served(*options)
    yield served
    served.close()


def receive(bus, cob_id, timeout=5.0):
    end = time.monotonic() + timeout
    while (left := end - time.monotonic()) > 0:
        message = bus.recv(left)
        if message is not None and message.arbitration_id == cob_id:
            return bytes(message.data)
    raise AssertionError(f"no frame {cob_id:03X}")


def ticks(bus):
    bus.send(can.Message(arbitration_id=0x600 + NODE_ID, data=TICKS_REQUEST, is_extended_id=False))
    return int.from_bytes(receive(bus, 0x580 + NODE_ID)[4:], "little")


def test_terminal_and_tcp_are_ends_of_one_bus():
    with serving("slcan-tcp:0", "--bus", "slcan-pty") as served:
        kind, terminal = served.next_end()
        assert kind == "slcan-pty"
        options = {"interface": "slcan", "bitrate": 1000000, "sleep_after_open": 0}
        with served.open_bus() as tcp, can.Bus(channel=terminal, **options) as pty:
            for bus in (pty, tcp):
                assert receive(bus, 0x701) in (b"\x00", b"\x7f")  # boot-up or heartbeat
            pty.send(can.Message(arbitration_id=0x123, data=b"\x01\x02", is_extended_id=False))
            assert receive(tcp, 0x123) == b"\x01\x02"
            assert ticks(pty) > 0


def test_time_runs_as_fast_as_it_can_when_asked(tell):
    with serving("slcan-tcp:0", "--speed", "max") as served, served.open_bus() as bus:
        receive(bus, 0x701)
        start_s, start = time.monotonic(), ticks(bus)
        time.sleep(0.5)
        factor = (ticks(bus) - start) / (1000 * (time.monotonic() - start_s))
        tell(f"--speed max: {factor:.0f} times real time")
        assert factor > 2


@pytest.mark.parametrize("options, words", [
    (["--bus", "serial:1"], ["serial:1", "slcan-tcp:PORT"]),
    (["--bus", "slcan-tcp:70000"], ["70000", "not a port"]),
    (["--bus", "socketcan:nosuchcan0"], ["socketcan:nosuchcan0"]),
    (["--node", "128"], ["--node", "128"]),
])
def test_what_cannot_be_served_is_refused_in_one_sentence(options, words):
    done = subprocess.run([SIM_HOST, "serve", *options], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=20)
    assert done.returncode != 0
    assert all(word in done.stderr for word in words), done.stderr
