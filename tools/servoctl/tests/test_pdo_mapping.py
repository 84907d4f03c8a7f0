# SPDX-License-Identifier: Apache-2.0
"""monitor and log decode PDOs with the mapping that the node has, or say which one they assume."""

from __future__ import annotations

import csv
import io
import json
import signal
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import can
import pytest

from servoctl.link.bus import parse_bus
from servoctl.link.device import Device
from servoctl.link.listener import Listener
from servoctl.link.pdo_loan import PdoLoan
from servoctl.link.pdo_mapping import EXTENDED, Mappings, default_mappings, read_mappings
from servoctl.objects.schema import load_schema

from .conftest import PARAMETERS, Bench, Eventually

SCHEMA = load_schema(PARAMETERS)
ROS = (
    [0x60410010, 0x60610008, 0x60640020], [0x606C0020, 0x60770010], [0x68410010, 0x68610008, 0x68640020], [0x686C0020, 0x68770010],
)  # fmt: skip
"""TPDO1 to TPDO4 of docs/ros2/bus.yml. The first has as many bytes as the default one."""


@contextmanager
def mapped(servo: Bench, *objects: list[int], identifiers: tuple[int, ...] = (0x181, 0x281, 0x381, 0x481)) -> Iterator[Device]:
    """The node operational with this mapping, sent every 20 ms."""
    with Device(parse_bus(servo.bus), 1, PARAMETERS) as device, ExitStack() as stack:
        loans = [PdoLoan(device, 0x1800 + n, 0x1A00 + n) for n in range(len(objects))]
        for loan, identifier, each in zip(loans, identifiers, objects, strict=False):
            stack.callback(loan.give_back)
            loan.take(identifier, each, 20)
        device.node.nmt.state = "OPERATIONAL"
        yield device
        device.node.nmt.state = "PRE-OPERATIONAL"


def last(text: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(text.splitlines()[-1])
    return found


def test_monitor_decodes_the_mapping_of_ros(servo: Bench) -> None:
    with mapped(servo, *ROS):
        shown = last(servo("monitor", "--for", "1.5", "--json").out)
        state = servo.json("state")["axes"]
    assert shown["mapping"] == "read" and shown["not_decoded"] == []
    for axis, expected in zip(shown["axes"], state, strict=True):
        assert axis["state"] == "switch on disabled" and axis["error"] is None
        assert axis["position_deg"] == pytest.approx(expected["position_deg"], abs=0.5)
        assert abs(axis["rate_deg_s"]) < 5 and abs(axis["torque_percent"]) < 1


def test_without_reading_it_says_what_it_assumes_and_marks_what_does_not_fit(servo: Bench) -> None:
    with mapped(servo, *ROS):
        result = servo("monitor", "--passive", "--for", "1.5", "--json")
        text = servo("monitor", "--passive", "--for", "1").out
    shown = last(result.out)
    assert "181: 6041, 6061, 603F, 6077" in json.loads(result.err)["note"] and "--passive" in result.err
    assert shown["mapping"] == "assumed"
    misfits = {row["cob_id"]: (row["length"], row["expected"]) for row in shown["not_decoded"]}
    assert misfits == {"281": (6, 7), "381": (7, 8), "481": (6, 8)}
    assert [axis["rate_deg_s"] for axis in shown["axes"]] == [axis["position_deg"] for axis in shown["axes"]] == [None, None]
    for words in ("PDO 281 is not decoded: it has 6 bytes", "is assumed: 181: 6041"):
        assert words in " ".join(text.split())


def test_a_mapping_that_changes_is_read_again(servo: Bench, eventually: Eventually) -> None:
    monitor = servo.start("monitor", "--json")
    lines: list[dict[str, Any]] = []
    assert monitor.stdout is not None
    lines.append(json.loads(monitor.stdout.readline()))
    with mapped(servo, *ROS):
        for text in monitor.stdout:
            lines.append(json.loads(text))
            axis = lines[-1]["axes"][0]
            if axis["rate_deg_s"] is not None and axis["position_deg"] is not None:
                break
            assert len(lines) < 100
    monitor.send_signal(signal.SIGINT)
    assert monitor.wait(timeout=10) == 0
    shown = [axis for line in lines for axis in line["axes"]]
    assert all(abs(axis["rate_deg_s"]) < 50 for axis in shown if axis["rate_deg_s"] is not None)
    assert all(not axis["error"] for axis in shown)


def test_log_has_the_objects_of_the_present_mapping(servo: Bench) -> None:
    with mapped(servo, [0x606C0020, 0x60640020], identifiers=(0x6A1,)):
        rows = list(csv.DictReader(io.StringIO(servo("log", "--for", "1").out)))
        position = servo.json("state", "azimuth")["axes"][0]["position_deg"]
    assert list(rows[0])[:3] == ["time_s", "azimuth.velocity_actual_value (1e-6 rad/s)", "azimuth.position_actual_value (1e-7 rad)"]
    assert float(rows[-1]["azimuth.position_actual_value (1e-7 rad)"]) * 1e-7 * 57.29578 == pytest.approx(position, abs=0.5)
    assert {row["not decoded"] for row in rows} == {""}


def test_a_passive_log_marks_the_frames_that_it_does_not_decode(servo: Bench) -> None:
    with mapped(servo, *ROS):
        result = servo("log", "--passive", "--for", "1", "--out", "x.csv")
    with (servo.folder / "x.csv").open() as file:
        rows = list(csv.DictReader(file))
    marked = {row["not decoded"].partition(":")[0] for row in rows}
    assert marked == {"", "281", "381", "481"}
    frame = next(row["not decoded"] for row in rows if row["not decoded"].startswith("281"))
    assert len(bytes.fromhex(frame.partition(":")[2])) == 6
    assert {row["azimuth.velocity_actual_value (1e-6 rad/s)"] for row in rows} == {""}
    assert result.err.count("PDO 281 is not decoded") == 1 and "--passive" in result.err


def test_a_silent_node_is_heard_with_the_mapping_as_delivered(servo: Bench) -> None:
    result = servo("monitor", "--node", "77", "--for", "0.5", "--json")
    note = json.loads(result.err.splitlines()[0])["note"]
    assert result.code == 0 and "could not be read" in note and "does not answer" in note and "1CD: 6041" in note
    assert last(result.out)["mapping"] == "assumed"


def test_names_and_passive_contradict_each_other(servo: Bench) -> None:
    refused = servo("log", "azimuth.statusword", "--passive")
    assert refused.code == 2 and "--passive sends nothing" in refused.err and refused.err.count("\n") == 1


def test_what_is_read_is_what_is_described_as_delivered(servo: Bench) -> None:
    with Device(parse_bus(servo.bus), 1, PARAMETERS) as device:
        assert read_mappings(device, SCHEMA) == default_mappings(SCHEMA, 1)


# --- the listener -----------------------------------------------------------------------------------------------------


def frame(identifier: int, data: bytes, extended: bool = False) -> can.Message:
    return can.Message(arbitration_id=identifier, data=data, is_extended_id=extended)


def listener(can_read: bool = True, mappings: Mappings | None = None) -> Listener:
    return Listener(1, default_mappings(SCHEMA, 1) if mappings is None else mappings, can_read)


@pytest.mark.parametrize("length", [0, 1, 6, 8])
def test_a_frame_of_another_length_is_never_decoded_and_its_old_values_are_forgotten(length: int) -> None:
    heard = listener(can_read=False)
    assert heard.take(frame(0x181, bytes(7))) and heard.values
    assert heard.take(frame(0x181, bytes(length))) == {} and not heard.values
    assert heard.misfits[0x181].length == length and heard.misfits[0x181].frames == 1


def test_after_a_restart_nothing_is_decoded_until_the_mapping_was_read() -> None:
    for change in (frame(0x701, b"\0"), frame(0x701, b"\x7f"), frame(0x601, bytes.fromhex("2300180181010080"))):
        heard = listener()
        assert heard.take(frame(0x181, bytes(7))) and not heard.to_read
        heard.take(change)
        assert heard.take(frame(0x181, bytes(7))) == {} and heard.to_read and heard.withheld == 1
        heard.use(default_mappings(SCHEMA, 1))
        assert heard.take(frame(0x181, bytes(7)))
    passive = listener(can_read=False)
    passive.take(frame(0x701, b"\0"))
    assert passive.take(frame(0x181, bytes(7)))


def test_reading_and_other_writing_changes_nothing() -> None:
    heard = listener()
    for request in ("4000180100000000", "2300200101000000", "2b17100064000000"):
        heard.take(frame(0x601, bytes.fromhex(request)))
    assert not heard.to_read


def test_identifiers_of_29_bits_are_others() -> None:
    mapping = default_mappings(SCHEMA, 1)[0x181]
    heard = listener(mappings={0x181 | EXTENDED: mapping})
    assert heard.take(frame(0x181, bytes(7))) == {}
    assert heard.take(frame(0x181, bytes(7), extended=True))
