# SPDX-License-Identifier: Apache-2.0
"""The served board, as a script runs it: SIM_HOST, EMULATE_BOARD and TARGET_IMAGE name the programs and the image."""

import math
import os
import pathlib
import signal
import subprocess

import can
import pytest

PROGRAM = os.environ["EMULATE_BOARD"]
SIM_HOST = os.environ["SIM_HOST"]
IMAGE = os.environ["TARGET_IMAGE"]
JOB = '"$@" & echo $!; wait $!'
COUNTS_PER_DEG = 1e7 * math.pi / 180


def open_bus(address):
    return can.Bus(interface="slcan", channel=f"socket://{address}", bitrate=1000000, sleep_after_open=0)


def ask(bus, request):
    bus.send(can.Message(arbitration_id=0x601, data=request, is_extended_id=False))
    while (message := bus.recv(20.0)) is not None:
        if message.arbitration_id == 0x581:
            return message.data
    raise AssertionError("no answer")


def read(bus, index, sub):
    answer = ask(bus, [0x40, index & 0xFF, index >> 8, sub, 0, 0, 0, 0])
    assert answer[0] & 0xE3 == 0x43, answer
    unused_bytes = answer[0] >> 2 & 3
    return int.from_bytes(answer[4:8 - unused_bytes], "little", signed=True)


def write(bus, index, sub, value, size):
    """The abort code; 0: accepted."""
    data = value.to_bytes(size, "little").ljust(4, b"\0")
    answer = ask(bus, [0x23 | (4 - size) << 2, index & 0xFF, index >> 8, sub, *data])
    return 0 if answer[0] == 0x60 else int.from_bytes(answer[4:8], "little")


@pytest.mark.parametrize("number, command", [
    (signal.SIGTERM, [PROGRAM, IMAGE]), (signal.SIGINT, [SIM_HOST, "serve", "--image", IMAGE]),
])
def test_as_a_background_job_it_runs_until_a_signal_comes(number, command):
    shell = subprocess.Popen(["sh", "-c", JOB, "sh", *command, "--bus", "slcan-tcp:0"],
                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
    job = int(shell.stdout.readline())
    address = shell.stdout.readline().strip().removeprefix("slcan-tcp:")
    assert shell.stdout.readline() == "ready\n"
    with open_bus(address) as bus:
        assert read(bus, 0x1018, 1) >= 0
    os.kill(job, number)
    assert shell.wait(timeout=60) == 0
    assert shell.stdout.read() == ""


def test_it_ends_with_standard_input_where_that_is_required():
    done = subprocess.run([PROGRAM, IMAGE, "--until-stdin-ends"], stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("options, says", [
    (["--image", __file__], "is no image of this board"),
    (["--image", IMAGE, "--node-id", "3"], "--image excludes --node-id"),
    (["--without", "pitch-gyro"], "--without requires --image"),
    (["--image", IMAGE, "--without", "pitch-motor"], "--without: "),
])
def test_what_cannot_be_served_is_refused_in_one_sentence(options, says):
    done = subprocess.run([SIM_HOST, "serve", *options], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (2, "")
    assert says in done.stderr and len(done.stderr.splitlines()) <= 2, done.stderr


def test_an_image_of_another_board_is_refused(tmp_path):
    image = bytearray(pathlib.Path(IMAGE).read_bytes())
    image[0x254:0x260] = b"motor_shield"
    other = tmp_path / "other.bin"
    other.write_bytes(image)
    done = subprocess.run([SIM_HOST, "serve", "--image", other], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (2, "")
    assert "is an image of the board motor_shield; the emulated one is nucleo_g474" in done.stderr, done.stderr


def test_an_unpowered_machine_stands_in_a_storm(tmp_path):
    """20 Nm of steady wind, which would turn azimuth by a turn in that time: its seal holds 9 Nm, its brake 30 Nm."""
    shipped = (pathlib.Path(__file__).parents[2] / "sim_host/plants/tracker.toml").read_text()
    assert shipped.count("wind_mean_nm = 0.5\n") == 1
    plant = tmp_path / "storm.toml"
    plant.write_text(shipped.replace("wind_mean_nm = 0.5\n", "wind_mean_nm = 20.0\n"))
    with subprocess.Popen([PROGRAM, IMAGE, "--plant", plant, "--until-stdin-ends", "--speed", "0"],
                          stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as board:
        address = board.stdout.readline().strip().removeprefix("slcan-tcp:")
        assert board.stdout.readline() == "ready\n"
        with open_bus(address) as bus:
            before, start = read(bus, 0x6064, 0), read(bus, 0x3010, 1)
            while read(bus, 0x3010, 1) - start < 5000:
                pass
            moved_deg = (read(bus, 0x6064, 0) - before) / COUNTS_PER_DEG
        board.stdin.close()
        assert board.wait(timeout=60) == 0
    assert abs(moved_deg) < 0.001
