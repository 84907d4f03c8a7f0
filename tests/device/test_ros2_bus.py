# SPDX-License-Identifier: Apache-2.0
"""docs/ros2/bus.yml: its values are those of the device, which accepts dcfgen's output for it and runs by it.

ROS 2 itself is not needed: its build makes the same two steps, cogen and dcfgen.
"""

import configparser
import pathlib
import shutil
import struct
import subprocess
import sys
import time

import canopen
import pytest
import yaml
from device import DESCRIPTIONS, REAL_TIME

BUS_FILE = pathlib.Path(__file__).resolve().parents[2] / "docs/ros2/bus.yml"
DCFGEN = pathlib.Path(sys.executable).parent / "dcfgen"
AXES = (0, 0x800)
PROFILE_VELOCITY = 3
# The objects that ros2_canopen's Motor402 writes and reads while it runs (canopen_402_driver: motor.hpp, motor.cpp),
# for each channel.
WRITTEN = {0x6040, 0x6060, 0x607A, 0x60FF, 0x6071}
READ = {0x6041, 0x6061, 0x6064, 0x606C, 0x6077}


@pytest.fixture(scope="module")
def bus_file():
    return yaml.safe_load(BUS_FILE.read_text())


@pytest.fixture(scope="module")
def dcf(bus_file, tmp_path_factory):
    """The folder with dcfgen's output, master.dcf and tracker.bin. Like cogen and the CMake macro cogen_dcf of
    ros2_canopen, but without -S, so that the EDS must have no errors."""
    folder = tmp_path_factory.mktemp("dcf")
    flat = {"options": bus_file["options"], "master": bus_file["master"], **bus_file["nodes"]}
    (folder / "bus.yml").write_text(yaml.dump(flat).replace("@BUS_CONFIG_PATH@", "."))
    shutil.copy(DESCRIPTIONS / "trackservo.eds", folder)
    subprocess.run([DCFGEN, "-v", "-d", ".", "-r", "bus.yml"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return folder


@pytest.fixture(scope="module")
def requests(dcf):
    """(index, subindex, bytes) of each SDO in the concise DCF (CiA 302: count, then index, subindex, size and data of each)."""
    data = (dcf / "tracker.bin").read_bytes()
    (count,), place = struct.unpack_from("<I", data), 4
    found = []
    for _ in range(count):
        index, sub, size = struct.unpack_from("<HBI", data, place)
        found.append((index, sub, data[place + 7:place + 7 + size]))
        place += 7 + size
    assert place == len(data)
    return found


@pytest.fixture
def configured(master, requests):
    for index, sub, data in requests:
        master.node.sdo.download(index, sub, data)  # raises where the device refuses
    return master


@pytest.mark.simulator
def test_the_pdos_have_all_that_the_driver_uses_of_both_axes_and_of_one_axis_each(bus_file):
    node = bus_file["nodes"]["tracker"]
    for kind, needed in (("rpdo", WRITTEN), ("tpdo", READ)):
        mapped = [[entry["index"] for entry in pdo["mapping"]] for pdo in node[kind].values()]
        assert sorted(sum(mapped, [])) == sorted(index + axis for axis in AXES for index in needed)
        assert all(len({index & 0x800 for index in pdo}) == 1 for pdo in mapped)
        assert len(mapped) == 4


@pytest.mark.simulator
def test_scales_and_times_are_those_of_the_device(bus_file):
    dictionary = canopen.import_od(str(DESCRIPTIONS / "trackservo.eds"), 1)
    node = bus_file["nodes"]["tracker"]
    assert node["scale_pos_to_dev"] * node["scale_pos_from_dev"] == pytest.approx(1.0)
    assert node["scale_vel_to_dev"] * node["scale_vel_from_dev"] == pytest.approx(1.0)
    exponents = {0x60A8: node["scale_pos_from_dev"], 0x60A9: node["scale_vel_from_dev"]}
    for index, scale in exponents.items():  # the highest byte is the power of ten
        power = dictionary[index].default >> 24
        assert scale == pytest.approx(10.0 ** (power - 256 if power > 127 else power))
    for axis in AXES:  # 6076 is in mN m, 6077 in 0.1 % of it
        assert node["scale_eff_from_dev"] == pytest.approx(dictionary[0x6076 + axis].default * 1e-6)
    times = {(sdo["index"], sdo["sub_index"]): sdo["value"] for sdo in node["sdo"]}
    for axis in AXES:
        assert (times[0x60C2 + axis, 1], times[0x60C2 + axis, 2]) == (node["period"], -3)
    assert bus_file["master"]["sync_period"] == 1000 * node["period"]


def test_each_sdo_of_the_concise_dcf_is_accepted_and_in_force(configured, requests, bus_file):
    sdo = configured.node.sdo
    assert len(requests) > 60
    last = {(index, sub): data for index, sub, data in requests}
    for (index, sub), data in last.items():
        assert sdo.upload(index, sub) == data, f"{index:04X}:{sub}"
    for kind, first in (("rpdo", 0x1600), ("tpdo", 0x1A00)):
        for number, pdo in bus_file["nodes"]["tracker"][kind].items():
            count = sdo[first + number - 1][0].raw
            mapped = [sdo[first + number - 1][n].raw >> 16 for n in range(1, count + 1)]
            assert mapped == [entry["index"] for entry in pdo["mapping"]]


def test_the_masters_idea_of_the_device_is_the_device(master, dcf):
    """A CiA 302 master refuses a device whose type, vendor or product differs from its 1F84 to 1F86."""
    sdo = master.node.sdo
    file = configparser.ConfigParser(strict=False, interpolation=None)
    file.read(dcf / "master.dcf")
    found = {0x1F84: sdo[0x1000].raw, 0x1F85: sdo[0x1018][1].raw, 0x1F86: sdo[0x1018][2].raw}
    for index, ran in found.items():
        expected = int(file.get(f"{index:04X}Value", "1", fallback="0"), 0)
        assert expected in (0, ran), f"{index:04X}"  # 0: not checked
    assert int(file.get("1F84Value", "1"), 0) == found[0x1F84]
    assert int(file.get("1F86Value", "1"), 0) == found[0x1F86]


@pytest.mark.speed(0.5 * REAL_TIME)
def test_both_axes_run_by_these_pdos_alone(configured):
    """States and targets by RPDO, answers by TPDO with each SYNC, as in the driver."""
    network = configured.network
    answers = (0x181, 0x281, 0x381, 0x481)
    configured.node.nmt.state = "OPERATIONAL"
    configured.forget()

    def newest(identifier):
        return configured.heard(identifier)[-1]

    def sync_until(condition, seconds=60.0):
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, [newest(identifier).hex() for identifier in answers]
            network.send_message(0x080, b"")
            time.sleep(0.01)

    def status(axis):
        return int.from_bytes(newest(answers[2 * axis])[:2], "little") & 0x6F

    def rate(axis):
        return int.from_bytes(newest(answers[2 * axis + 1])[:4], "little", signed=True) * 1e-6

    sync_until(lambda: all(configured.heard(identifier) for identifier in answers))
    assert [len(newest(identifier)) for identifier in answers] == [7, 6, 7, 6]
    for controlword, state in ((0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)):
        for axis in (0, 1):
            network.send_message(0x201 + 0x200 * axis, struct.pack("<Hbi", controlword, PROFILE_VELOCITY, 0))
        sync_until(lambda state=state: status(0) == state and status(1) == state)
    wanted = (0.05, -0.03)
    for axis in (0, 1):
        network.send_message(0x301 + 0x200 * axis, struct.pack("<ih", round(wanted[axis] * 1e6), 0))
    sync_until(lambda: all(abs(rate(axis) - wanted[axis]) < 0.01 for axis in (0, 1)))
    assert [newest(answers[2 * axis])[2] for axis in (0, 1)] == [PROFILE_VELOCITY] * 2
    for axis in (0, 1):
        network.send_message(0x301 + 0x200 * axis, struct.pack("<ih", 0, 0))
    sync_until(lambda: all(abs(rate(axis)) < 0.005 for axis in (0, 1)))
