# SPDX-License-Identifier: Apache-2.0
"""The node's printed descriptions match its behaviour."""

import json
import math
import re

import canopen
import cantools
import pytest

from axis import RATED_NM
from device import NODE_ID, PROJECT

SOURCES = {".c", ".cmake", ".cpp", ".h", ".hpp", ".in", ".md", ".py", ".sh", ".toml", ".txt"}


@pytest.fixture
def dbc(descriptions):
    return cantools.database.load_file(str(descriptions / "trackservo.dbc"), strict=True)


def test_eds_loads_without_a_warning(descriptions, caplog):
    dictionary = canopen.import_od(str(descriptions / "trackservo.eds"), NODE_ID)
    assert caplog.records == []
    assert dictionary["Pitch Controlword"].index == 0x6840


def test_the_description_that_servoctl_carries_is_the_same_for_every_commit(descriptions, node):
    text = (descriptions / "parameters.json").read_text()
    assert node.sdo[0x3030][3].raw not in text
    fixed = [row for row in json.loads(text)["objects"] if row["type"] == "VISIBLE_STRING" and row["access"] == "const"]
    assert len(fixed) > 3 and not any("default" in row for row in fixed)


def test_the_version_is_written_once(descriptions, node):
    """In CMakeLists.txt; every other one is printed from it, or belongs to the history."""
    version = (descriptions / "version.txt").read_text().strip()
    assert re.search(rf"\bVERSION {re.escape(version)}\n", (PROJECT / "CMakeLists.txt").read_text())
    assert node.sdo[0x100A].raw == node.sdo[0x3030][1].raw == version
    pattern = re.compile(rf"(?<![0-9.]){re.escape(version)}(?![0-9.])")
    folders = [PROJECT / folder for folder in ("cmake", "docs", "firmware", "hal", "sim_host", "tests", "tools")]
    files = [file for folder in folders for file in folder.rglob("*") if file.is_file() and ".egg-info" not in str(file)]
    named = {str(file.relative_to(PROJECT)) for file in files if file.suffix in SOURCES
             and pattern.search(file.read_text(errors="replace"))}
    others = {"docs/can-objects.md", "tools/servoctl/servoctl/descriptions/version.txt",
              "tools/lib/stm32g4.sh", "tools/requirements-checks.txt"}  # the last two name versions of other projects
    assert named <= others


def test_every_fault_has_all_its_texts_and_names_limits_that_exist(descriptions):
    faults = json.loads((descriptions / "faults.json").read_text())["faults"]
    assert [fault["number"] for fault in faults] == list(range(1, len(faults) + 1))
    assert len({fault["name"] for fault in faults}) == len(faults)
    limits = canopen.import_od(str(descriptions / "trackservo.eds"), NODE_ID)[0x2060].subindices
    for fault in faults:
        for key in ("name", "detection", "when", "cause", "check", "cure", "clear"):
            assert fault[key], f"{fault['number']}: {key}"
        assert set(fault["limits"]) <= set(limits) - {0}, fault["name"]


def test_the_words_of_a_fault_name_the_limits_that_its_row_lists(descriptions):
    faults = json.loads((descriptions / "faults.json").read_text())["faults"]
    for fault in faults:
        texts = fault["detection"] + fault["when"] + fault["timer"]
        reported = {int(sub) for sub in re.findall(r"2060:([0-9]+)", texts)}
        assert reported == set(fault["limits"]), fault["name"]


def test_reference_page_has_every_object(descriptions):
    rows = [line.split("|") for line in (descriptions / "can-objects.md").read_text().splitlines()
            if line.startswith("| ") and not line.startswith("| index")]
    listed = {(int(row[1], 16), int(row[2])) for row in rows}
    dictionary = canopen.import_od(str(descriptions / "trackservo.eds"), NODE_ID)
    for entry in dictionary.values():
        if entry.index < 0x1000:
            continue
        pitch = entry.name.startswith("Pitch ")
        for sub in entry.subindices if hasattr(entry, "subindices") else [0]:
            assert (entry.index - 0x800 * pitch, sub) in listed, f"{entry.index:04X}:{sub}"


def test_node_reports_the_commit_that_it_was_built_from(node):
    assert re.fullmatch(r"[0-9a-f]{7,}(-dirty)?|.*-g[0-9a-f]{7,}(-dirty)?|unknown", node.sdo[0x3030][3].raw)


def test_dbc_has_the_default_pdos(dbc):
    assert {m.name: m.frame_id for m in dbc.messages} == {
        "RPDO1": 0x201, "RPDO2": 0x301, "RPDO3": 0x401, "RPDO4": 0x501,
        "TPDO1": 0x181, "TPDO2": 0x281, "TPDO3": 0x381, "TPDO4": 0x481}
    units = {s.name: s.unit for m in dbc.messages for s in m.signals}
    assert units["AzimuthVelocityActualValue"] == "rad/s"
    assert units["PitchTargetPosition"] == "rad"
    assert units["PitchTorqueActualValue"] == "N m"
    assert dbc.get_message_by_name("TPDO3").cycle_time == 20


def test_dbc_decodes_what_the_node_sends(master, dbc, node, azimuth):
    azimuth.turn(1.0)
    seen = {}
    for message in dbc.messages:
        if message.name.startswith("TPDO"):
            node.network.subscribe(message.frame_id, lambda cob_id, data, _t: seen.update({cob_id: bytes(data)}))
    master.pass_time(500)
    values = {}
    for cob_id, data in seen.items():
        assert len(data) == dbc.get_message_by_frame_id(cob_id).length
        values |= dbc.decode_message(cob_id, data)
    assert len(seen) == 4
    assert values["AzimuthVelocityActualValue"] == pytest.approx(math.radians(1.0), rel=0.1)
    assert values["AzimuthPositionActualValue"] == pytest.approx(math.radians(azimuth.angle_deg), abs=0.02)
    assert values["AzimuthTorqueActualValue"] == pytest.approx(1e-3 * RATED_NM * azimuth.get(0x6077), abs=4)  # the wind
    assert values["AzimuthModesOfOperationDisplay"] == "pv"
    assert values["AzimuthStatusword"] & 0x6F == 0x27
    assert values["PitchStatusword"] & 0x4F == 0x40
    assert values["AzimuthErrorCode"] == 0


def test_dbc_encodes_what_the_node_obeys(master, dbc, node, azimuth):
    for controlword, state in ((6, "READY TO SWITCH ON"), (7, "SWITCHED ON"), (15, "OPERATION ENABLED")):
        node.network.send_message(0x201, dbc.encode_message(
            "RPDO1", {"AzimuthControlword": controlword, "AzimuthModesOfOperation": "pv"}))
        azimuth.wait_for_state(state)
    node.network.send_message(0x401, dbc.encode_message(
        "RPDO3", {"AzimuthTargetVelocity": math.radians(1.0), "PitchTargetVelocity": 0.0}))
    master.pass_time(1000)
    assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)


def test_the_board_starts_with_the_parameters_of_the_example_machine(descriptions):
    """As numbers: on another machine the design's last digits may differ."""
    def assignments(file):
        return [(name, float(value)) for name, value in re.findall(r"\.([a-z0-9_.]+) = ([-+.e0-9]+)[fu],", file.read_text())]
    printed = assignments(descriptions / "default_parameters.c")
    committed = assignments(PROJECT / "firmware/products/brushed_tracker/default_parameters.c")
    objects = json.loads((descriptions / "parameters.json").read_text())["objects"]
    stored = [row for row in objects if 0x2000 <= row["index"] < 0x3000 and row.get("stored")]
    assert len(printed) == len(stored)
    assert [name for name, _ in committed] == [name for name, _ in printed]
    assert [value for _, value in committed] == pytest.approx([value for _, value in printed], rel=1e-5), \
        "the build prints another text: run tools/update-docs dictionary"


def test_the_eds_names_the_bit_rates_that_lss_can_set(node, descriptions):
    device = canopen.import_od(str(descriptions / "trackservo.eds"), NODE_ID).device_information
    assert device.LSS_supported
    lss = node.network.lss
    lss.send_switch_state_global(lss.CONFIGURATION_STATE)
    taken = set()
    for index, kbit_s in enumerate((1000, 800, 500, 250, 125, 100, 50, 20, 10)):
        try:
            lss.configure_bit_timing(index)
            taken.add(1000 * kbit_s)
        except canopen.lss.LssError as error:
            assert str(error) == "LSS Error: 1"
    assert taken == device.allowed_baudrates == {125000, 250000, 500000, 1000000}
