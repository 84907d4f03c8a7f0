# SPDX-License-Identifier: Apache-2.0
"""The bus load: bits of frames as ISO 11898-1 counts them, at the bit rate of the connection."""

from __future__ import annotations

import json
import os
import random
import threading
import time
from pathlib import Path
from typing import Any

import can
import pytest

from servoctl.link import bus
from servoctl.link.bus import BusAddress, bit_rate_of
from servoctl.link.can_bits import frame_bits
from servoctl.ui import engine

from .conftest import Bench
from .test_slcan import tcp_adapter

CLASSIC = [can.Message(arbitration_id=0x181, data=bytes(range(n)), is_extended_id=False) for n in range(9)]


def counted_bit_by_bit(message: can.Message) -> int:
    """Of ISO 11898-1, without tables."""
    number = message.arbitration_id
    if message.is_extended_id:
        text = f"0{number >> 18:011b}11{number & 0x3FFFF:018b}{message.is_remote_frame:b}00{message.dlc:04b}"
    else:
        text = f"0{number:011b}{message.is_remote_frame:b}00{message.dlc:04b}"
    text += "" if message.is_remote_frame else "".join(f"{byte:08b}" for byte in message.data)
    crc = 0
    for bit in text:
        crc = (crc << 1) ^ (0x4599 if (crc >> 14 & 1) ^ int(bit) else 0)
        crc &= 0x7FFF
    text += f"{crc:015b}"
    count, last, run = 0, "", 0
    for bit in text:
        count += 1
        run = run + 1 if bit == last else 1
        last = bit
        if run == 5:
            count, last, run = count + 1, "10"[int(bit)], 1
    return count + 13


def random_frame(draw: random.Random) -> can.Message:
    extended, remote = draw.random() < 0.3, draw.random() < 0.2
    length = draw.randrange(9)
    data = bytes(draw.choice((0, 0xFF, 0x1F, draw.randrange(256))) for _ in range(length))
    return can.Message(
        arbitration_id=draw.randrange(1 << (29 if extended else 11)), is_extended_id=extended, is_remote_frame=remote,
        dlc=length, data=None if remote else data,
    )  # fmt: skip


def test_every_frame_has_as_many_bits_as_counted_one_by_one() -> None:
    draw = random.Random(1)
    for message in (random_frame(draw) for _ in range(3000)):
        assert frame_bits(message) == counted_bit_by_bit(message), message


def test_a_frame_has_47_bits_and_those_of_its_data_and_at_most_a_quarter_more() -> None:
    draw = random.Random(2)
    for message in (random_frame(draw) for _ in range(300)):
        n = 0 if message.is_remote_frame else message.dlc
        fixed = (67 if message.is_extended_id else 47) + 8 * n
        assert fixed <= frame_bits(message) <= fixed + (fixed - 13 - 1) // 4


@pytest.mark.parametrize("bit_rate", [125_000, 250_000, 1_000_000])
def test_monitor_shows_the_load_at_the_bit_rate_of_the_connection(tmp_path: Path, bit_rate: int) -> None:
    bench = Bench("", tmp_path)
    text = b"".join(b"t1818" + bytes(message.data).hex().encode() + b"\r" for message in CLASSIC[8:]) * 10
    end = threading.Event()

    def talk(send: Any) -> None:
        while not end.wait(0.05):
            try:
                send(text)
            except OSError:
                return

    with tcp_adapter() as (address, send):
        threading.Thread(target=talk, args=(send,), daemon=True).start()
        shown = bench("monitor", "--passive", "--bus", address, "--bitrate", str(bit_rate), "--for", "1.5", "--json")
        end.set()
    rows = [json.loads(line) for line in shown.out.splitlines()][1:]
    assert len(rows) >= 2 and {row["bit_rate"] for row in rows} == {bit_rate}
    for row in rows:
        assert row["bits_per_s"] == pytest.approx(row["frames_per_s"] * frame_bits(CLASSIC[8]), rel=0.01)
        assert row["load"] == pytest.approx(row["bits_per_s"] / bit_rate, abs=1e-4)
        assert row["frames_per_s"] > 20


def fake_ip(folder: Path, monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    program = folder / "ip"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")


REPORTED = {
    "with a bit rate": ("""echo '[{"linkinfo":{"info_data":{"bittiming":{"bitrate":250000}}}}]'""", 250_000),
    "vcan": ("""echo '[{"linkinfo":{"info_kind":"vcan"}}]'""", None),
    "down": ("""echo '[{"linkinfo":{"info_data":{"bittiming":{"bitrate":0}}}}]'""", None),
    "no such interface": ("echo 'Device \"can0\" does not exist.' >&2; exit 1", None),
    "nonsense": ("echo nonsense", None),
    "other JSON": ("echo '{}'", None),
    "null": ("echo '[{\"linkinfo\":null}]'", None),
    "hangs": ("exec sleep 60", None),
}  # fmt: skip


@pytest.mark.parametrize("script, expected", REPORTED.values(), ids=REPORTED)
def test_the_bit_rate_of_socketcan_is_that_of_the_interface(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str, expected: int | None
) -> None:
    monkeypatch.setattr(bus, "IP_TIMEOUT_S", 0.5)
    fake_ip(tmp_path, monkeypatch, script)
    assert bit_rate_of(BusAddress("socketcan", "can0"), 1_000_000) == expected
    assert bit_rate_of(BusAddress("slcan", "/dev/ttyACM0"), 125_000) == 125_000


def test_without_a_bit_rate_there_is_a_word_instead_of_a_number(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from servoctl.link import pdo_ears

    class Silent:
        def __enter__(self) -> Silent:
            return self

        def __exit__(self, *_: object) -> None: ...

        def recv(self, timeout: float) -> None:
            time.sleep(timeout)

    monkeypatch.setattr(pdo_ears, "open_bus", lambda *_a, **_k: Silent())
    bench = Bench("socketcan:none0", tmp_path)
    rows = bench("monitor", "--passive", "--for", "0.5", "--json").out.splitlines()
    assert json.loads(rows[-1])["load"] is None and json.loads(rows[-1])["bit_rate"] is None
    given = bench("monitor", "--passive", "--for", "0.5", "--json", "--bitrate", "250000").out.splitlines()
    assert json.loads(given[-1])["bit_rate"] == 250_000 and json.loads(given[-1])["load"] == 0.0
    assert "bus load unknown: give --bitrate" in bench("monitor", "--passive", "--for", "0.5").out


def test_the_page_counts_the_same_bits() -> None:
    for bit_rate in (125_000, None):
        load = engine.BusLoad(bit_rate)
        load._since = (time.monotonic() - 1.0, 0)
        for message in CLASSIC:
            load.on_message_received(message)
        load.update()
        bits = sum(counted_bit_by_bit(message) for message in CLASSIC)
        assert load.share == (None if bit_rate is None else pytest.approx(bits / bit_rate, rel=0.02))
