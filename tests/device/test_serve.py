# SPDX-License-Identifier: Apache-2.0
"""The command `sim_host serve` itself: several ends on one bus, the pace of time, and its refusals."""

import contextlib
import math
import os
import signal
import struct
import subprocess
import time

import can
import pytest
from device import NODE_ID, PROJECT, SIM_HOST, Served

pytestmark = pytest.mark.simulator


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


def read(bus, index, sub, signed=False):
    request = [0x40, index & 0xFF, index >> 8, sub, 0, 0, 0, 0]
    bus.send(can.Message(arbitration_id=0x600 + NODE_ID, data=request, is_extended_id=False))
    return int.from_bytes(receive(bus, 0x580 + NODE_ID)[4:], "little", signed=signed)


def write(bus, index, sub, value, size):
    head = bytes([0x23 | (4 - size) << 2]) + index.to_bytes(2, "little") + bytes([sub])
    bus.send(can.Message(arbitration_id=0x601, data=head + value.to_bytes(4, "little"), is_extended_id=False))
    assert receive(bus, 0x581)[0] == 0x60


def ticks(bus):
    return read(bus, 0x3010, 1)


# As a script does: a background job with empty standard input.
JOB = '"$@" & echo $!; wait $!'


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_as_a_background_job_it_runs_until_a_signal_comes(number):
    shell = subprocess.Popen(["sh", "-c", JOB, "sh", SIM_HOST, "serve", "--bus", "slcan-tcp:0"],
                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
    job = int(shell.stdout.readline())
    address = shell.stdout.readline().strip().removeprefix("slcan-tcp:")
    assert shell.stdout.readline() == "ready\n"
    with can.Bus(interface="slcan", channel=f"socket://{address}", bitrate=1000000, sleep_after_open=0) as bus:
        assert ticks(bus) > 0
    os.kill(job, number)
    assert shell.wait(timeout=20) == 0
    assert shell.stdout.read() == ""


def test_it_ends_with_standard_input_where_that_is_required():
    done = subprocess.run([SIM_HOST, "serve", "--until-stdin-ends"], stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, timeout=20)
    assert (done.returncode, done.stderr) == (0, "")


def test_the_inertial_sensor_of_the_base_sends_a_hundred_rates_in_a_second():
    """On a base that stands: white noise of 1e-4 rad/s, 5 counts, in each rate."""
    with serving("slcan-tcp:0", "--base-sensor", "0x441") as served, served.open_bus() as bus:
        receive(bus, 0x441)
        begin = ticks(bus)
        messages = [struct.unpack("<hhhB", receive(bus, 0x441)) for _ in range(200)]
        assert ticks(bus) - begin == pytest.approx(2000, abs=200)
    counters = [message[3] for message in messages]
    assert all((after - before) % 256 == 1 for before, after in zip(counters, counters[1:], strict=False))
    for rate in range(3):
        counts = [message[rate] for message in messages]
        assert abs(sum(counts) / len(counts)) < 2
        assert 3 < math.sqrt(sum(count * count for count in counts) / len(counts)) < 8


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


COUNTS_PER_DEG = 1e7 * math.pi / 180


def angles_deg(bus):
    return [read(bus, index, 0, signed=True) / COUNTS_PER_DEG for index in (0x6064, 0x6864)]


def test_an_unpowered_machine_stands_for_a_minute(report):
    """In its wind; without holding brakes azimuth was at -141 degrees after 20 minutes, and pitch at its end stop."""
    with serving("slcan-tcp:0", "--speed", "max") as served, served.open_bus() as bus:
        receive(bus, 0x701)
        before = angles_deg(bus)
        while ticks(bus) < 60 * 1000:
            time.sleep(0.2)
        moved = [after - at for after, at in zip(angles_deg(bus), before, strict=True)]
        report(f"moved by {moved[0]:.5f} and {moved[1]:.5f} degrees")
        assert max(map(abs, moved)) < 0.001


def test_travel_limits_are_those_of_the_plant():
    """Stops at +-280 and at -20 and 95 degrees: the fault 1 degree before them, ramps end 1 degree before that."""
    with serving("slcan-tcp:0") as served, served.open_bus() as bus:
        receive(bus, 0x701)
        soft = [read(bus, 0x607D + axis, sub, signed=True) / COUNTS_PER_DEG for axis in (0, 0x800) for sub in (1, 2)]
        hard = [struct.unpack("<f", read(bus, 0x2060 + axis, sub).to_bytes(4, "little"))[0]
                for axis in (0, 0x800) for sub in (9, 10)]
        assert soft == pytest.approx([-278, 278, -18, 93], abs=0.01)
        assert [math.degrees(rad) for rad in hard] == pytest.approx([-279, 279, -19, 94], abs=0.01)


def brake_times_s(*options):
    with serving("slcan-tcp:0", *options) as served, served.open_bus() as bus:
        receive(bus, 0x701)
        return [struct.unpack("<f", read(bus, 0x2060 + axis, sub).to_bytes(4, "little"))[0]
                for axis in (0, 0x800) for sub in (24, 25)]


def test_brake_times_are_those_of_the_plant(tmp_path):
    assert brake_times_s() == pytest.approx([0.02, 0.03] * 2)
    plant = (PROJECT / "sim_host/plants/tracker.toml").read_text()
    changed = tmp_path / "plant.toml"
    changed.write_text(plant.replace("release_ms = 20.0", "release_ms = 45.0", 1))
    assert brake_times_s("--plant", str(changed)) == pytest.approx([0.045, 0.03, 0.02, 0.03])


def pace(bus):
    """Simulated over real time."""
    receive(bus, 0x701)
    start_s, start = time.monotonic(), ticks(bus)
    time.sleep(0.5)
    return (ticks(bus) - start) / (1000 * (time.monotonic() - start_s))


def test_time_runs_as_fast_as_it_can_on_request(report):
    with serving("slcan-tcp:0", "--speed", "max") as served, served.open_bus() as bus:
        factor = pace(bus)
        report(f"--speed max: {factor:.0f} times real time")
        assert factor > 2


def test_time_runs_at_the_pace_that_is_required(report):
    with serving("slcan-tcp:0", "--speed", "4") as served, served.open_bus() as bus:
        factor = pace(bus)
        report(f"--speed 4: {factor:.1f} times real time")
        assert 1.5 < factor < 4.2


def test_faster_than_real_time_a_client_that_reads_slowly_loses_nothing():
    """Every TPDO on every tick at full speed, read in parts with pauses: the simulator waits."""
    with serving("slcan-tcp:0", "--speed", "max") as served, served.open_bus() as bus:
        receive(bus, 0x701)
        stream = [(0x1803, 1, 0x80000481, 4), (0x1A03, 0, 0, 1), (0x1A03, 1, 0x30100120, 4), (0x1A03, 0, 1, 1),
                  (0x1803, 3, 0, 2), (0x1803, 5, 1, 2), (0x1803, 1, 0x481, 4)]
        for index, sub, value, size in stream:
            write(bus, index, sub, value, size)
        bus.send(can.Message(arbitration_id=0, data=[1, NODE_ID], is_extended_id=False))
        numbers = []
        while len(numbers) < 20000:
            numbers.append(int.from_bytes(receive(bus, 0x481), "little"))
            if len(numbers) % 4000 == 0:
                time.sleep(0.3)
        assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))


def test_after_a_stall_of_the_computer_no_frame_of_a_full_stream_is_lost():
    """Four TPDOs in every tick; the ticks that are made up for at once are 80 frames."""
    with serving("slcan-tcp:0") as served, served.open_bus() as bus:
        receive(bus, 0x701)
        for n in range(4):
            for sub in (1, 2):
                write(bus, 0x1A04 + n, sub, (0x30100120, 0x60640020)[sub - 1], 4)
            write(bus, 0x1A04 + n, 0, 2, 1)
            write(bus, 0x1804 + n, 3, 0, 2)
            write(bus, 0x1804 + n, 5, 1, 2)
            write(bus, 0x1804 + n, 1, 0x680 + 12 * n, 4)
        bus.send(can.Message(arbitration_id=0, data=[1, NODE_ID], is_extended_id=False))
        receive(bus, 0x680)
        numbers = {0x680 + 12 * n: [] for n in range(4)}
        for _ in range(5):
            os.kill(served.process.pid, signal.SIGSTOP)
            time.sleep(0.05)
            os.kill(served.process.pid, signal.SIGCONT)
            for _ in range(400):
                message = bus.recv(5.0)
                assert message is not None
                if message.arbitration_id in numbers:
                    numbers[message.arbitration_id].append(int.from_bytes(message.data[:4], "little"))
        for found in numbers.values():
            assert len(found) > 400 and found == list(range(found[0], found[0] + len(found)))


@pytest.mark.parametrize("options, words", [
    (["--bus", "serial:1"], ["serial:1", "slcan-tcp:PORT"]),
    (["--bus", "slcan-tcp:70000"], ["70000", "not a port"]),
    (["--bus", "slcan-tcp:"], ["slcan-tcp:", "not a port"]),
    (["--bus", "socketcan:nosuchcan0"], ["socketcan:nosuchcan0"]),
    (["--node", "128"], ["--node", "128"]),
    (["--node", "127", "--nodes", "2"], ["127", "last node id"]),
    (["--serial", "4294967295", "--nodes", "2"], ["4294967295", "serial number"]),
    (["--speed", "0"], ["--speed", "realtime, max or"]),
    (["--speed", "fast"], ["--speed", "realtime, max or"]),
])
def test_what_cannot_be_served_is_refused_in_one_sentence(options, words):
    done = subprocess.run([SIM_HOST, "serve", *options], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=20)
    assert done.returncode != 0
    assert all(word in done.stderr for word in words), done.stderr
