"""docs/ros2/bus.yml: every key is used, and simulator and board accept dcfgen's output for it.

SIM_HOST, EMULATE_BOARD, TARGET_IMAGE and NODE_DESCRIPTIONS name programs, image and the folder of the EDS. CTest sets
them; without them those of the build folders are used. ROS 2 itself is not needed: its build makes the same two steps,
cogen and dcfgen.
"""

import ast
import configparser
import copy
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import time

import can
import canopen
import pytest
import yaml

PROJECT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(PROJECT / "tools/ros2"))
import check_bus  # noqa: E402

BUS_FILE = PROJECT / "docs/ros2/bus.yml"
BUILD = PROJECT / "build/host"
SIM_HOST = os.environ.get("SIM_HOST", str(BUILD / "bin/sim_host"))
EMULATE_BOARD = os.environ.get("EMULATE_BOARD", str(BUILD / "bin/emulate_board"))
IMAGE = os.environ.get("TARGET_IMAGE", str(PROJECT / "build/stm32g474/bin/trackservo.bin"))
DESCRIPTIONS = pathlib.Path(os.environ.get("NODE_DESCRIPTIONS", str(BUILD / "share/trackservo")))
DCFGEN = pathlib.Path(sys.executable).parent / "dcfgen"
AXES = (0, 0x800)
# The objects that ros2_canopen's Motor402 writes and reads while it runs (canopen_402_driver: motor.hpp, motor.cpp),
# for each channel.
WRITTEN = {0x6040, 0x6060, 0x607A, 0x60FF, 0x6071}
READ = {0x6041, 0x6061, 0x6064, 0x606C, 0x6077}


@pytest.fixture(scope="module")
def bus():
    return yaml.safe_load(BUS_FILE.read_text())


@pytest.fixture(scope="module")
def dcf(bus, tmp_path_factory):
    """The folder with dcfgen's output: master.dcf and tracker.bin."""
    return generate(bus, tmp_path_factory.mktemp("dcf"))


def generate(bus, folder):
    """Like cogen and the CMake macro cogen_dcf of ros2_canopen; without -S, so that the EDS must have no errors."""
    flat = {"options": bus["options"], "master": bus["master"]}
    flat |= {name: {**node, **bus.get("defaults", {})} for name, node in bus["nodes"].items()}
    (folder / "bus.yml").write_text(yaml.dump(flat).replace("@BUS_CONFIG_PATH@", "."))
    shutil.copy(DESCRIPTIONS / "trackservo.eds", folder)
    subprocess.run([DCFGEN, "-v", "-d", ".", "-r", "bus.yml"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return folder


def requests_of(dcf):
    """(index, sub-index, bytes) of each SDO in the concise DCF (CiA 302: count, then index, sub-index, size and data of each)."""
    data = (dcf / "tracker.bin").read_bytes()
    (count,), place = struct.unpack_from("<I", data), 4
    found = []
    for _ in range(count):
        index, sub, size = struct.unpack_from("<HBI", data, place)
        found.append((index, sub, data[place + 7:place + 7 + size]))
        place += 7 + size
    assert place == len(data)
    return found


@pytest.fixture(params=["simulator", "board"])
def network(request):
    """python-canopen on the bus of a device that has just booted; answers may be slow when the computer is busy."""
    program = [SIM_HOST, "serve"] if request.param == "simulator" else [EMULATE_BOARD, IMAGE]
    process = subprocess.Popen([*program, "--until-stdin-ends", "--bus", "slcan-tcp:0"], stdin=subprocess.PIPE,
                               stdout=subprocess.PIPE, text=True)
    address = process.stdout.readline().strip().removeprefix("slcan-tcp:")
    assert process.stdout.readline() == "ready\n"
    network = canopen.Network(bus=can.Bus(interface="slcan", channel=f"socket://{address}", bitrate=1000000,
                                          sleep_after_open=0))
    network.connect()
    yield network
    network.disconnect()
    process.stdin.close()
    assert process.wait(timeout=60) == 0


@pytest.fixture
def node(network):
    node = canopen.RemoteNode(1, canopen.import_od(str(DESCRIPTIONS / "trackservo.eds"), 1))
    network.add_node(node)
    node.sdo.RESPONSE_TIMEOUT = 20.0
    return node


def configure(node, dcf):
    for index, sub, data in requests_of(dcf):
        node.sdo.download(index, sub, data)  # raises where the device refuses


# --- the file alone -------------------------------------------------------------------------------------------------


def test_every_key_of_the_shipped_file_is_known(bus):
    assert check_bus.errors(bus) == []


def test_the_list_of_dcfgens_keys_is_what_its_source_reads():
    """Keys are those read from `cfg` and its parts in dcfgen/cli.py: "key" in cfg, cfg["key"],
    pdo_mapping.get("key")."""
    import dcfgen.cli

    tree = ast.parse(pathlib.Path(dcfgen.cli.__file__).read_text())
    functions = {f"{of.name}.{f.name}": f for of in tree.body if isinstance(of, ast.ClassDef)
                 for f in of.body if isinstance(f, ast.FunctionDef)}
    functions["main"] = next(f for f in tree.body if isinstance(f, ast.FunctionDef) and f.name == "main")

    def read(function, *tables):
        keys = set()
        for each in ast.walk(functions[function]):
            if isinstance(each, ast.Compare) and isinstance(each.ops[0], ast.In) and isinstance(each.left, ast.Constant):
                place, key = each.comparators[0], each.left.value
            elif isinstance(each, ast.Subscript) and isinstance(each.slice, ast.Constant):
                place, key = each.value, each.slice.value
            elif isinstance(each, ast.Call) and isinstance(each.func, ast.Attribute) and each.func.attr == "get":
                place, key = each.func.value, each.args[0].value
            else:
                continue
            if ast.unparse(place) in tables and isinstance(key, str):
                keys.add(key)
        return keys

    assert read("Slave.from_config", "cfg") == check_bus.DCFGEN_NODE
    assert read("Master.from_config", "cfg") == check_bus.DCFGEN_MASTER
    assert read("Slave.__parse_pdo_config", "cfg") == check_bus.DCFGEN_PDO
    assert read("Slave.__parse_pdo_config", "pdo_mapping") == check_bus.DCFGEN_MAPPING
    assert read("Slave.from_config", "sdo") == check_bus.DCFGEN_SDO
    assert read("main", "cfg['options']") == check_bus.DCFGEN_OPTIONS


@pytest.mark.parametrize("path, wrong, meant", [
    ("options", "dcf_paths", "dcf_path"), ("master", "sync_periode", "sync_period"),
    ("nodes.tracker", "chanel_names", "channel_names"), ("nodes.tracker", "heartbeat_consumers", "heartbeat_consumer"),
    ("nodes.tracker.rpdo.1", "transmision", "transmission"), ("nodes.tracker.tpdo.3.mapping.0", "subindex", "sub_index"),
    ("nodes.tracker.sdo.0", "values", "value"), ("", "node", "nodes"),
])
def test_a_key_that_nobody_reads_is_refused_although_dcfgen_takes_it(bus, tmp_path, path, wrong, meant):
    changed = copy.deepcopy(bus)
    table = changed
    for step in path.split(".") if path else []:
        table = table[int(step) if step.isdigit() else step]
    table[wrong] = 1
    (error,) = check_bus.errors(changed)
    assert f"neither dcfgen nor ros2_canopen reads '{wrong}'; did you mean '{meant}'?" in error
    generate(changed, tmp_path)
    file = tmp_path / "changed.yml"
    file.write_text(yaml.dump(changed))
    ran = subprocess.run([sys.executable, PROJECT / "tools/ros2/check_bus.py", file], capture_output=True, text=True)
    assert ran.returncode == 1 and error in ran.stderr


def test_a_file_that_cannot_be_read_or_is_no_bus_is_reported(tmp_path):
    (tmp_path / "broken.yml").write_text("nodes: {")
    (tmp_path / "text.yml").write_text("hello")
    for name, code in (("broken.yml", 2), ("text.yml", 1), ("missing.yml", 2)):
        command = [sys.executable, PROJECT / "tools/ros2/check_bus.py", tmp_path / name]
        ran = subprocess.run(command, capture_output=True, text=True)
        assert ran.returncode == code and name in ran.stderr and "Traceback" not in ran.stderr


def test_the_pdos_have_all_that_the_driver_uses_of_both_axes_and_of_one_axis_each(bus):
    node = bus["nodes"]["tracker"]
    for kind, needed in (("rpdo", WRITTEN), ("tpdo", READ)):
        mapped = [[entry["index"] for entry in pdo["mapping"]] for pdo in node[kind].values()]
        assert sorted(sum(mapped, [])) == sorted(index + axis for axis in AXES for index in needed)
        assert all(len({index & 0x800 for index in pdo}) == 1 for pdo in mapped)
        assert len(mapped) == 4


def test_scales_and_times_are_those_of_the_device(bus):
    dictionary = canopen.import_od(str(DESCRIPTIONS / "trackservo.eds"), 1)
    node = bus["nodes"]["tracker"]
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
    assert bus["master"]["sync_period"] == 1000 * node["period"]


# --- on a device ----------------------------------------------------------------------------------------------------


def test_each_sdo_of_the_concise_dcf_is_accepted_and_in_force(node, dcf, bus):
    requests = requests_of(dcf)
    assert len(requests) > 60
    configure(node, dcf)
    last = {(index, sub): data for index, sub, data in requests}
    for (index, sub), data in last.items():
        assert node.sdo.upload(index, sub) == data, f"{index:04X}:{sub}"
    for kind, first in (("rpdo", 0x1600), ("tpdo", 0x1A00)):
        for number, pdo in bus["nodes"]["tracker"][kind].items():
            count = node.sdo[first + number - 1][0].raw
            mapped = [node.sdo[first + number - 1][n].raw >> 16 for n in range(1, count + 1)]
            assert mapped == [entry["index"] for entry in pdo["mapping"]]


def test_the_masters_idea_of_the_device_is_the_device(node, dcf):
    """A CiA 302 master refuses a device whose type, vendor or product differs from its 1F84 to 1F86."""
    master = configparser.ConfigParser(strict=False, interpolation=None)
    master.read(dcf / "master.dcf")
    found = {0x1F84: node.sdo[0x1000].raw, 0x1F85: node.sdo[0x1018][1].raw, 0x1F86: node.sdo[0x1018][2].raw}
    for index, ran in found.items():
        expected = int(master.get(f"{index:04X}Value", "1", fallback="0"), 0)
        assert expected in (0, ran), f"{index:04X}"  # 0: not checked
    assert int(master.get("1F84Value", "1"), 0) == found[0x1F84]
    assert int(master.get("1F86Value", "1"), 0) == found[0x1F86]


def test_both_axes_run_by_these_pdos_alone(network, node, dcf):
    """States and targets by RPDO, answers by TPDO with each SYNC, as in the driver."""
    configure(node, dcf)
    seen = {}
    for identifier in (0x181, 0x281, 0x381, 0x481):
        network.subscribe(identifier, lambda cob_id, data, _t: seen.update({cob_id: bytes(data)}))
    node.nmt.state = "OPERATIONAL"

    def sync_until(condition, seconds=60.0):
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, seen
            network.send_message(0x080, b"")
            time.sleep(0.01)

    def status(axis):
        return int.from_bytes(seen[0x181 + 0x200 * axis][:2], "little") & 0x6F

    def rate(axis):
        return int.from_bytes(seen[0x281 + 0x200 * axis][:4], "little", signed=True) * 1e-6

    sync_until(lambda: len(seen) == 4)
    assert [len(seen[identifier]) for identifier in sorted(seen)] == [7, 6, 7, 6]
    profile_velocity = 3
    for controlword, state in ((0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)):
        for axis in (0, 1):
            network.send_message(0x201 + 0x200 * axis, struct.pack("<Hbi", controlword, profile_velocity, 0))
        sync_until(lambda state=state: status(0) == state and status(1) == state)
    wanted = (0.05, -0.03)
    for axis in (0, 1):
        network.send_message(0x301 + 0x200 * axis, struct.pack("<ih", round(wanted[axis] * 1e6), 0))
    sync_until(lambda: all(abs(rate(axis) - wanted[axis]) < 0.01 for axis in (0, 1)))
    assert [seen[0x181 + 0x200 * axis][2] for axis in (0, 1)] == [profile_velocity] * 2
    for axis in (0, 1):
        network.send_message(0x301 + 0x200 * axis, struct.pack("<ih", 0, 0))
    sync_until(lambda: all(abs(rate(axis)) < 0.005 for axis in (0, 1)))
