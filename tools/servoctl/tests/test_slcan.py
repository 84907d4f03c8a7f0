# SPDX-License-Identifier: Apache-2.0
"""What SLCAN adapters send, over TCP and at a serial port: other ends of lines, junk between, cut lines, time stamps."""

from __future__ import annotations

import contextlib
import os
import random
import select
import socket
import threading
import time
import tty
from collections.abc import Callable, Iterator

import can
import pytest

from servoctl.link.bus import open_bus, parse_bus
from servoctl.link.slcan_lines import LONGEST, LineReader, parse_line

from .conftest import Bench

FRAMES = (
    (b"t1812AABB", 0x181, False, False, b"\xaa\xbb"),
    (b"t0000", 0x000, False, False, b""),
    (b"t7FF80102030405060708", 0x7FF, False, False, bytes(range(1, 9))),
    (b"T1234567811f", 0x12345678, True, False, b"\x1f"),
    (b"r5814", 0x581, False, True, b""),
    (b"R0000000A0", 0x00A, True, True, b""),
)  # fmt: skip
WRONG = (
    b"t181", b"t1812AAB", b"t1812AABB1", b"t1812AABB12", b"t1819" + b"00" * 9, b"t8FF0", b"T200000000", b"t18X2AABB", b"t1812AAGG",
    b"81", b"2AABB", b"r581401", b"t1812AABBt1812AABB", b"t+810", b"t1_10", b"0" * 10_000, b"t1812\xc3\xa4",
)  # fmt: skip
NO_FRAMES = (b"", b"z", b"Z", b"V1013", b"NA123", b"F00", b"?")


def messages_of(text: bytes) -> list[tuple[int, bool, bool, bytes]]:
    return [(line.identifier, line.extended, line.remote, line.data) for line in LineReader().take(text)]


EXPECTED = [frame[1:] for frame in FRAMES]


@pytest.mark.parametrize("stamp", [b"", b"EA5F", b"0001E240"])
@pytest.mark.parametrize("end", [b"\r", b"\r\n", b"\n", b"\r\r", b"\r\n\r\n", b"\r\a", b"\a", b"\r\0", b"\0\r\n\0", b" \r\n"])
def test_lines_are_understood_whatever_ends_them(end: bytes, stamp: bytes) -> None:
    assert messages_of(b"".join(frame[0] + stamp + end for frame in FRAMES)) == EXPECTED


@pytest.mark.parametrize("junk", [b"\0", b"\0\0\0", b"\xff", b"\x11", b"\x80\0"])
def test_bytes_that_are_no_text_are_dropped_wherever_they_are(junk: bytes) -> None:
    text = b"\r".join(junk + frame[0][:3] + junk + frame[0][3:] + junk for frame in FRAMES)
    assert messages_of(text + b"\r") == EXPECTED


def test_only_a_stamp_of_four_digits_is_a_time() -> None:
    assert [parse_line(b"t1812AABB" + stamp).stamp_ms for stamp in (b"", b"00ff", b"12345678")] == [None, 255, None]  # type: ignore[union-attr]


@pytest.mark.parametrize("wrong", WRONG)
def test_a_wrong_line_is_skipped_and_counted(wrong: bytes) -> None:
    reader = LineReader()
    found = list(reader.take(wrong + b"\r\n" + b"t1812AABB\r\n"))
    assert [line.data for line in found] == [b"\xaa\xbb"] and reader.malformed == 1


@pytest.mark.parametrize("line", NO_FRAMES)
def test_answers_and_empty_lines_are_no_errors(line: bytes) -> None:
    reader = LineReader()
    assert len(list(reader.take(line + b"\rt1810\r"))) == 1 and reader.malformed == 0


def test_any_bytes_in_any_pieces_neither_raise_nor_fill_the_memory() -> None:
    draw = random.Random(1)
    reader = LineReader()
    for _ in range(2000):
        list(reader.take(draw.randbytes(draw.randrange(40))))
    list(reader.take(b"z" * 100_000))
    assert len(reader._rest) <= LONGEST
    found = [line for byte in b"\rt1812AABB\r" for line in reader.take(bytes([byte]))]
    assert [line.data for line in found] == [b"\xaa\xbb"]


# --- adapters ---------------------------------------------------------------------------------------------------------

Send = Callable[[bytes], None]


@contextlib.contextmanager
def tcp_adapter() -> Iterator[tuple[str, Send]]:
    """The bus that it is for servoctl, and what makes it send."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        ends: list[socket.socket] = []
        threading.Thread(target=lambda: ends.append(server.accept()[0]), daemon=True).start()

        def send(data: bytes) -> None:
            while not ends:
                time.sleep(0.01)
            ends[0].sendall(data)

        yield f"slcan-tcp:127.0.0.1:{server.getsockname()[1]}", send
        for end in ends:
            end.close()


@contextlib.contextmanager
def serial_adapter() -> Iterator[tuple[str, Send]]:
    """The same at a serial port."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    yield f"slcan:{os.ttyname(theirs)}", lambda data: (os.write(ours, data), None)[1]
    for end in (theirs, ours):
        os.close(end)


ADAPTERS = {"TCP": tcp_adapter, "serial": serial_adapter}


@pytest.fixture(params=ADAPTERS)
def adapter(request: pytest.FixtureRequest) -> Iterator[tuple[can.BusABC, Send]]:
    """An open bus, and what makes the adapter send."""
    with ADAPTERS[request.param]() as (address, send), open_bus(parse_bus(address)) as bus:
        yield bus, send


@pytest.mark.parametrize("stamp", [b"", b"03E8"])
def test_an_adapter_that_is_different_is_heard(adapter: tuple[can.BusABC, Send], stamp: bytes) -> None:
    bus, send = adapter
    send(b"3344\r\n\0\a\r\r\nz\r\nt18\r\n" + b"".join(b"\0" + frame[0] + stamp + b"\r\n" for frame in FRAMES))
    heard = [bus.recv(5.0) for _ in FRAMES]
    assert [(m.arbitration_id, m.is_extended_id, m.is_remote_frame, bytes(m.data)) for m in heard if m] == EXPECTED
    assert bus.malformed == 2  # type: ignore[attr-defined]


def test_junk_alone_does_not_hang(adapter: tuple[can.BusABC, Send]) -> None:
    bus, send = adapter
    send(b"\0\r\n\a" * 500)
    begun = time.monotonic()
    assert bus.recv(0.2) is None and time.monotonic() - begun < 2.0
    assert bus.recv(0.0) is None


def test_a_frame_in_two_pieces_is_one(adapter: tuple[can.BusABC, Send]) -> None:
    bus, send = adapter
    send(b"t1812A")
    assert bus.recv(0.1) is None
    send(b"ABB\r")
    message = bus.recv(5.0)
    assert message is not None and bytes(message.data) == b"\xaa\xbb"


def test_an_adapter_that_is_unplugged_is_an_error_of_the_bus() -> None:
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    bus = open_bus(parse_bus(f"slcan:{os.ttyname(theirs)}"))
    os.close(theirs)
    os.close(ours)
    with pytest.raises(can.CanError, match="SLCAN at /dev/pts/"):
        bus.recv(1.0)
    bus.shutdown()


# --- servoctl through such an adapter ---------------------------------------------------------------------------------


class Translator:
    """Between a servo and servoctl: the lines of the servo end with CR LF, with NUL and empty lines between."""

    def __init__(self, servo: str, there: int) -> None:
        _, host, port = servo.split(":")
        self._servo = socket.create_connection((host, int(port)))
        self._there = there
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        os.write(self._there, b"55\r\n")
        with contextlib.suppress(OSError):  # servoctl has left
            while not self._end.is_set():
                self._pass_on()

    def _pass_on(self) -> None:
        ready, _, _ = select.select([self._servo.fileno(), self._there], [], [], 0.05)
        if self._servo.fileno() in ready:
            os.write(self._there, self._servo.recv(1024).replace(b"\r", b"\0\r\n\r\n\0"))
        if self._there in ready:
            self._servo.sendall(os.read(self._there, 1024))

    def close(self) -> None:
        self._end.set()
        self._thread.join()
        self._servo.close()


def test_servoctl_works_at_a_serial_adapter_that_ends_its_lines_with_cr_lf(servo: Bench) -> None:
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    translator = Translator(servo.bus, ours)
    try:
        assert servo.json("info", "--bus", f"slcan:{os.ttyname(theirs)}")["node"] == 1
    finally:
        translator.close()
        os.close(theirs)
        os.close(ours)


def test_servoctl_works_over_tcp_with_cr_lf(servo: Bench) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        translators: list[Translator] = []
        threading.Thread(target=lambda: translators.append(Translator(servo.bus, server.accept()[0].detach())), daemon=True).start()
        assert servo.json("info", "--bus", f"slcan-tcp:127.0.0.1:{server.getsockname()[1]}")["node"] == 1
        translators[0].close()


def test_lines_that_were_skipped_are_reported_with_a_silent_node(servo: Bench) -> None:
    with tcp_adapter() as (address, send):
        threading.Thread(target=send, args=(b"garbage\r\n" * 2 + b"t1\r\n" * 5,), daemon=True).start()
        refused = servo("info", "--bus", address)
    assert refused.code == 3 and "5 lines of the adapter were cut or wrong" in refused.err and refused.err.count("\n") == 1
