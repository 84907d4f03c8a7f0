"""The program emulate_board itself, as a script runs it: EMULATE_BOARD and TARGET_IMAGE name it and its image."""

import os
import signal
import subprocess

import can
import pytest

PROGRAM = os.environ["EMULATE_BOARD"]
IMAGE = os.environ["TARGET_IMAGE"]
JOB = '"$@" & echo $!; wait $!'
READ_DEVICE_TYPE = [0x40, 0x00, 0x10, 0x00, 0, 0, 0, 0]


def read_device_type(address):
    with can.Bus(interface="slcan", channel=f"socket://{address}", bitrate=1000000, sleep_after_open=0) as bus:
        bus.send(can.Message(arbitration_id=0x601, data=READ_DEVICE_TYPE, is_extended_id=False))
        while (message := bus.recv(20.0)) is not None:
            if message.arbitration_id == 0x581:
                return bytes(message.data)
    raise AssertionError("no answer")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_as_a_background_job_it_runs_until_a_signal_comes(number):
    shell = subprocess.Popen(["sh", "-c", JOB, "sh", PROGRAM, IMAGE, "--bus", "slcan-tcp:0"],
                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
    job = int(shell.stdout.readline())
    address = shell.stdout.readline().strip().removeprefix("slcan-tcp:")
    assert shell.stdout.readline() == "ready\n"
    assert read_device_type(address)[:4] == b"\x43\x00\x10\x00"
    os.kill(job, number)
    assert shell.wait(timeout=60) == 0
    assert shell.stdout.read() == ""


def test_it_ends_with_standard_input_where_that_is_asked_for():
    done = subprocess.run([PROGRAM, IMAGE, "--until-stdin-ends"], stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
