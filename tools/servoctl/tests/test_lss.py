# SPDX-License-Identifier: Apache-2.0
"""Node ids and the bit rate over the bus, on simulators of their own whose flash outlives them."""

from __future__ import annotations

import contextlib
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from .conftest import SIM_HOST, Bench

Serve = Callable[..., contextlib.AbstractContextManager[Bench]]


@pytest.fixture
def serve(tmp_path: Path) -> Serve:
    """A simulator with these options, and servoctl at it."""

    @contextlib.contextmanager
    def start(*options: str) -> Iterator[Bench]:
        process = subprocess.Popen(
            [SIM_HOST, "serve", "--until-stdin-ends", "--bus", "slcan-tcp:0", "--flash", str(tmp_path / "flash"), *options],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert process.stdin is not None and process.stdout is not None
        address = process.stdout.readline().strip()
        while process.stdout.readline().strip() not in ("ready", ""):
            pass
        yield Bench(address, tmp_path)
        process.stdin.close()
        assert process.wait(timeout=20) == 0
        process.stdout.close()

    return start


def test_nodes_without_id_are_found_numbered_and_keep_their_ids(serve: Serve) -> None:
    options = ("--nodes", "2", "--node-id", "255", "--serial", "0x1001")
    with serve(*options) as bench:
        only_found = bench.json("lss", "scan")
        assert sorted((row["node"], row["serial"]) for row in only_found) == [(None, 0x1001), (None, 0x1002)]
        numbered = bench.json("lss", "scan", "--first", "10")
        assert [row["node"] for row in numbered] == [10, 11]
        assert sorted(row["serial"] for row in numbered) == [0x1001, 0x1002]
        assert bench("lss", "scan").code == 1
    with serve(*options) as bench:
        for row in numbered:
            assert bench.json("info", "--node", str(row["node"]))["serial"] == row["serial"]


def test_a_node_gets_another_id_at_once_and_for_good(serve: Serve) -> None:
    with serve("--serial", "77") as bench:
        reported = bench("lss", "id", "5")
        assert (reported.code, reported.out) == (0, "node 1 is now node 5.\n")
        assert bench.json("info", "--node", "5")["serial"] == 77
        changed = bench.json("lss", "id", "6", "--serial", "77", "--no-store")
        assert (changed["node"], changed["was"], changed["stored"]) == (6, 5, False)
    with serve("--serial", "77") as bench:
        assert bench.json("info", "--node", "5")["serial"] == 77


def test_the_bit_rate_changes_for_all_nodes_and_for_good(serve: Serve) -> None:
    with serve("--nodes", "2") as bench:
        changed = bench.json("lss", "rate", "250000")
        assert changed == {"bit_rate": 250000, "stored": True, "nodes": [1, 2]}
        assert bench("info").code == 3
        assert bench("info", "--bitrate", "250000").code == 0
    with serve("--nodes", "2") as bench:
        assert bench("info", "--node", "2", "--bitrate", "250000").code == 0


def test_answers_of_many_nodes_on_a_slow_bus_are_all_heard(serve: Serve) -> None:
    with serve("--nodes", "4", "--bit-rate", "125000") as bench:
        changed = bench.json("lss", "rate", "1000000", "--bitrate", "125000")
        assert changed == {"bit_rate": 1000000, "stored": True, "nodes": [1, 2, 3, 4]}


def test_one_node_with_torque_keeps_all_nodes_at_their_bit_rate(serve: Serve) -> None:
    with serve("--nodes", "2") as bench:
        assert bench("state", "azimuth", "enable", "--node", "2").code == 0
        refused = bench("lss", "rate", "250000")
        assert (refused.code, refused.err.count("\n")) == (4, 1), refused
        assert "an axis has torque" in refused.err
        assert bench("state", "azimuth", "disable", "--node", "2").code == 0
        assert bench("lss", "id", "3", "--node", "1").code == 0  # stores the bit rate along with the id
        for node in ("2", "3"):
            assert bench.json("get", "0x3050:4", "--node", node)[0]["value"] == 1000


def test_a_node_id_in_use_is_not_given_again(serve: Serve) -> None:
    with serve("--nodes", "2") as bench:
        refused = bench("lss", "id", "2", "--node", "1")
        assert (refused.code, refused.err.count("\n")) == (2, 1), refused
        assert "node id 2 is already in use" in refused.err
        assert bench.json("info", "--node", "1")["serial"] == 0
        assert bench.json("info", "--node", "2")["serial"] == 1


def test_what_cannot_be_done_is_said_in_one_sentence(serve: Serve) -> None:
    with serve() as bench:
        for code, words, reason in (
            (3, ("lss", "id", "5", "--serial", "0x99"), "no node answered"),
            (3, ("lss", "rate", "125000", "--bitrate", "500000"), "no node answers at 500000 bit/s"),
            (2, ("lss", "rate", "800000"), "800000"),
            (2, ("lss", "id", "128"), "128"),
            (2, ("lss", "id", "5", "--serial", "x"), "x"),
        ):
            result = bench(*words)
            assert (result.code, result.err.count("\n")) == (code, 1), (words, result)
            assert reason in result.err
        assert bench("state", "azimuth", "enable").code == 0
        result = bench("lss", "id", "5")
        assert (result.code, result.err.count("\n")) == (4, 1)
        assert "an axis has torque; disable both axes first" in result.err
        assert bench("info").code == 0


def test_what_needs_a_frame_in_every_tick_is_refused_on_a_slow_bus(serve: Serve) -> None:
    with serve("--bit-rate", "250000") as bench:
        result = bench("step", "azimuth", "--yes", "--bitrate", "250000")
        assert (result.code, result.err.count("\n")) == (2, 1), result
        assert "250 kbit/s" in result.err and "At least 500 kbit/s" in result.err
        assert bench.json("state", "azimuth", "--bitrate", "250000")["axes"][0]["state"] == "switch on disabled"
