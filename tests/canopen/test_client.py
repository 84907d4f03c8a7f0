# SPDX-License-Identifier: Apache-2.0
"""python-canopen, a client without knowledge of this node, uses it."""

import math
import random
import socket
import struct
import threading
import time

import can
import canopen
import pytest

NODE_ID = 5


def collect(network, cob_id, seconds):
    """Payloads with this identifier within the time."""
    seen = []
    network.subscribe(cob_id, lambda _id, data, _time: seen.append(bytes(data)))
    time.sleep(seconds)
    network.unsubscribe(cob_id)
    return seen


def abort_of(action):
    with pytest.raises(canopen.SdoAbortedError) as caught:
        action()
    return caught.value.code


# --- EDS ---------------------------------------------------------------------------------------------------------


def test_eds_loads_without_a_warning_and_knows_both_axes(eds, caplog):
    dictionary = canopen.import_od(eds, NODE_ID)
    assert caplog.records == []
    assert dictionary["Azimuth Controlword"].index == 0x6040
    assert dictionary["Pitch Controlword"].index == 0x6840
    assert dictionary[0x1800][1].default == 0x40000180 + NODE_ID
    assert dictionary[0x2F00][2].min == -100
    assert dictionary[0x2F00][2].default == -5
    assert dictionary.device_information.nr_of_RXPDO == 4


def test_every_object_of_the_eds_is_there_with_its_default(node):
    differing, checked = [], 0
    for entry in node.object_dictionary.values():
        if entry.index < 0x1000:
            continue
        subs = entry.values() if hasattr(entry, "subindices") else [entry]
        for var in subs:
            if not var.readable or var.index in (0x1001, 0x1003, 0x2F01, 0x2F02, 0x6061, 0x6861):
                continue
            sdo = node.sdo[var.index]
            value = (sdo[var.subindex] if hasattr(entry, "subindices") else sdo).raw
            checked += 1
            if var.default is not None and value != var.default and (var.index, var.subindex) != (0x1018, 4):
                differing.append((hex(var.index), var.subindex, value, var.default))
    assert differing == []
    assert checked > 150


# --- NMT and heartbeat -------------------------------------------------------------------------------------------


def test_nmt_commands_are_followed_and_heartbeats_report(node):
    for state in ("OPERATIONAL", "STOPPED", "PRE-OPERATIONAL"):
        node.nmt.state = state
        time.sleep(0.02)
        assert node.nmt.wait_for_heartbeat(timeout=1) == state


def test_reset_ends_in_a_boot_up(node):
    node.sdo[0x1015].raw = 77
    booted = threading.Event()
    node.network.subscribe(0x700 + NODE_ID, lambda _i, data, _t: booted.set() if data[0] == 0 else None)
    node.nmt.state = "RESET"
    assert booted.wait(1)
    time.sleep(0.05)
    assert node.sdo[0x1015].raw == 0


def test_heartbeat_time_is_writable(node):
    node.sdo[0x1017].raw = 20
    assert 45 <= len(collect(node.network, 0x700 + NODE_ID, 1.0)) <= 55


def test_lost_master_raises_an_emergency_that_clears_by_itself(node):
    node.sdo[0x1016][1].raw = 0x00010000 | 100
    node.network.send_message(0x701, [5])
    lost = node.emcy.wait(0x8130, timeout=1)
    assert lost is not None and lost.register == 0x11 and lost.data[0] == 1
    node.network.send_message(0x701, [5])
    time.sleep(0.05)
    assert node.emcy.active == []
    assert node.sdo[0x1003][1].raw == 0x00018130


# --- SDO ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sub, value", [
    (1, True), (2, -100), (3, 1000), (4, -99999), (5, 200), (6, 0), (7, 0xFFFFFFFF),
    (8, 0xFEDCBA9876543210), (10, "sixteen letters!"), (10, "four"), (10, ""),
])
def test_every_type_is_written_and_read_back(node, sub, value):
    node.sdo[0x2F00][sub].raw = value
    assert node.sdo[0x2F00][sub].raw == value


def test_real_is_bit_exact(node):
    for value in (0.1, -1000.0, 1e-38, 0.0):
        node.sdo[0x2F00][9].raw = value
        assert node.sdo[0x2F00][9].raw == struct.unpack("<f", struct.pack("<f", value))[0]


SIZES = [1, 4, 7, 8, 889, 890, 32768]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("block_down", [False, True])
@pytest.mark.parametrize("block_up", [False, True])
def test_domain_goes_there_and_back_bit_exact(node, size, block_down, block_up):
    if size == 32768 and not (block_down and block_up):
        size = 4096  # segmented takes one round trip every seven bytes
    data = random.Random(size).randbytes(size)
    with node.sdo[0x2F01].open("wb", size=size, block_transfer=block_down, buffering=1024) as stream:
        stream.write(data)
    with node.sdo[0x2F02].open("rb", block_transfer=block_up) as stream:
        assert stream.read() == data


def test_block_transfer_works_without_crc(node):
    data = random.Random(1).randbytes(1000)
    with node.sdo[0x2F01].open("wb", size=1000, block_transfer=True, request_crc_support=False) as stream:
        stream.write(data)
    with node.sdo[0x2F02].open("rb", block_transfer=True, request_crc_support=False) as stream:
        assert stream.read() == data


REFUSALS = [
    (0x2FFF, 0, b"\0", 0x06020000),
    (0x2F00, 99, b"\0", 0x06090011),
    (0x2F00, 12, b"\0\0", 0x06010002),
    (0x2F02, 0, b"\0" * 20, 0x06010002),
    (0x2F00, 7, b"\0\0", 0x06070013),
    (0x2F00, 6, b"\0\0\0\0", 0x06070012),
    (0x2F00, 8, b"\0" * 9, 0x06070012),
    (0x2F00, 10, b"seventeen letters", 0x06070012),
    (0x2F00, 10, b"a\nb", 0x06090030),
    (0x2F00, 5, b"\xC9", 0x06090031),
    (0x2F00, 5, b"\x09", 0x06090032),
    (0x2F00, 2, b"\x80", 0x06090032),
    (0x2F00, 9, struct.pack("<f", math.nan), 0x06090030),
    (0x2F00, 9, struct.pack("<f", math.inf), 0x06090031),
    (0x2F00, 9, struct.pack("<f", -math.inf), 0x06090032),
    (0x2F00, 9, struct.pack("<f", 1000.5), 0x06090031),
    (0x2F10, 0, b"\x0D", 0x08000022),
    (0x2F10, 0, b"\x42", 0x06060000),
    (0x1010, 1, b"load", 0x08000020),
    (0x1016, 1, struct.pack("<L", 0x01000001), 0x06090031),
    (0x1A00, 0, b"\0", 0x08000022),
    (0x1A02, 1, struct.pack("<L", 0x60400010), 0x06040041),
    (0x1A02, 1, struct.pack("<L", 0x2FFF0010), 0x06020000),
    (0x1402, 1, struct.pack("<L", 0x585), 0x06090030),
]


@pytest.mark.parametrize("index, sub, data, code", REFUSALS)
def test_refusal_has_the_code_of_the_standard_and_changes_nothing(node, index, sub, data, code):
    def everything():
        return [node.sdo.upload(0x2F00, s) for s in (*range(1, 11), 12)] + [
            node.sdo.upload(i, s) for i in (0x1A00, 0x1A02, 0x1402) for s in (0, 1)]

    before = everything()
    assert abort_of(lambda: node.sdo.download(index, sub, data)) == code
    assert everything() == before


def test_reading_what_must_not_be_read_is_refused(node):
    assert abort_of(lambda: node.sdo.upload(0x2F00, 11)) == 0x06010001
    assert abort_of(lambda: node.sdo.upload(0x1003, 1)) == 0x08000024
    assert abort_of(lambda: node.sdo.upload(0x5000, 0)) == 0x06020000


def test_silent_client_gets_a_time_out(node):
    answers = []
    node.network.subscribe(0x580 + NODE_ID, lambda _i, data, _t: answers.append(bytes(data)))
    node.network.send_message(0x600 + NODE_ID, [0x21, 0x01, 0x2F, 0, 100, 0, 0, 0])
    time.sleep(1.3)
    assert answers[-1][0] == 0x80 and struct.unpack_from("<L", answers[-1], 4)[0] == 0x05040000


def test_wrong_toggle_and_wrong_crc_are_refused(node):
    answers = []
    node.network.subscribe(0x580 + NODE_ID, lambda _i, data, _t: answers.append(bytes(data)))

    def exchange(*request):
        """As a client does: it waits for the answer, which may come 100 ms after an aborted transfer (0019)."""
        count = len(answers)
        node.network.send_message(0x600 + NODE_ID, bytes(request).ljust(8, b"\0"))
        end = time.monotonic() + 1
        while len(answers) == count:
            time.sleep(0.002)
            assert time.monotonic() < end, "no answer within 1 s"
        return answers[count]

    exchange(0x40, 0x00, 0x2F, 10)
    assert struct.unpack_from("<L", exchange(0x70), 4)[0] == 0x05030000
    exchange(0xC6, 0x01, 0x2F, 0, 7)
    assert exchange(0x81, 1, 2, 3, 4, 5, 6, 7)[:2] == b"\xA2\x01"
    assert struct.unpack_from("<L", exchange(0xC1, 0xFF, 0xFF), 4)[0] == 0x05040004
    assert exchange(0xE0)[0] == 0x80


def test_store_answers_when_it_is_done(node):
    node.store()
    node.restore()


# --- PDO and SYNC ------------------------------------------------------------------------------------------------


def test_default_pdos_work(node):
    node.tpdo.read()
    node.rpdo.read()
    node.nmt.state = "OPERATIONAL"
    time.sleep(0.05)
    node.rpdo[1]["Azimuth Controlword"].raw = 0x0F
    node.rpdo[1]["Azimuth Modes of operation"].raw = 9
    node.rpdo[1].transmit()
    deadline = time.time() + 1
    while time.time() < deadline and node.tpdo[1]["Azimuth Statusword"].raw != 0x0F:
        node.tpdo[1].wait_for_reception(0.1)
    assert node.tpdo[1]["Azimuth Statusword"].raw == 0x0F
    assert node.tpdo[1]["Azimuth Modes of operation display"].raw == 9


def test_mapping_is_rewritten_by_pdo_save(node):
    node.tpdo.read()
    node.rpdo.read()
    tpdo, rpdo = node.tpdo[3], node.rpdo[3]
    tpdo.clear()
    tpdo.add_variable(0x2F00, 9)
    tpdo.add_variable(0x2F00, 5)
    tpdo.cob_id, tpdo.trans_type, tpdo.event_timer, tpdo.enabled = 0x380 + NODE_ID, 255, 20, True
    rpdo.clear()
    rpdo.add_variable(0x2F00, 5)
    rpdo.add_variable(0x2F00, 9)
    rpdo.cob_id, rpdo.trans_type, rpdo.enabled = 0x400 + NODE_ID, 255, True
    tpdo.save()
    rpdo.save()
    node.nmt.state = "OPERATIONAL"
    rpdo["Every type.An unsigned8"].raw = 123
    rpdo["Every type.A real32"].raw = 2.5
    time.sleep(0.02)
    rpdo.transmit()
    time.sleep(0.02)
    for _ in range(3):
        assert tpdo.wait_for_reception(1) is not None
    assert tpdo["Every type.An unsigned8"].raw == 123
    assert tpdo["Every type.A real32"].raw == 2.5
    assert node.sdo[0x2F00][5].raw == 123
    before = node.sdo[0x1A02][0].raw
    tpdo.enabled = False
    tpdo.save()
    assert before == 2 and node.sdo[0x1802][1].raw & 0x80000000


def test_synchronous_pdos_follow_sync(node):
    node.rpdo.read()
    node.nmt.state = "OPERATIONAL"
    time.sleep(0.05)
    node.rpdo[2]["Azimuth Target velocity"].raw = 17453
    node.rpdo[2]["Pitch Target velocity"].raw = -17453
    node.rpdo[2].transmit()
    time.sleep(0.05)
    assert node.sdo[0x60FF].raw == 0
    seen = []
    node.network.subscribe(0x280 + NODE_ID, lambda _i, data, _t: seen.append(struct.unpack("<ll", data)))
    for _ in range(20):
        node.network.sync.transmit()
        time.sleep(0.01)
    assert len(seen) == 20
    assert seen[-1] == (17453, -17453)


# --- Emergency ---------------------------------------------------------------------------------------------------


def test_emergency_is_seen_and_cleared(node):
    node.sdo[0x2F20].raw = 0xFF10
    time.sleep(0.05)
    assert [(e.code, e.register, e.data) for e in node.emcy.active] == [(0xFF10, 0x81, bytes([42, 7, 0, 0, 0]))]
    assert node.sdo[0x1001].raw == 0x81
    node.sdo[0x2F20].raw = 0
    time.sleep(0.05)
    assert node.emcy.active == []
    assert node.sdo[0x1001].raw == 0


# --- Several clients, hostile traffic ----------------------------------------------------------------------------


def listen_fast(test_node, seconds):
    """All frames of the bus, as SLCAN lines; python-can cannot keep up with a full bus."""
    text = b""
    with socket.create_connection(("127.0.0.1", test_node.port)) as connection:
        connection.sendall(b"S8\rL\r")
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            text += connection.recv(1 << 20)
    return text.split(b"\r")


def test_clients_work_at_once_without_disturbing_each_other(test_node, connect, node):
    monitor = connect()
    node.nmt.state = "OPERATIONAL"
    node.sdo[0x1017].raw = 10
    lines = []
    listener = threading.Thread(target=lambda: lines.extend(listen_fast(test_node, 2.0)))
    listener.start()
    reads = 0
    while listener.is_alive():
        assert node.sdo.upload(0x2F00, 12) == b"\x34\x12"
        monitor.sync.transmit()
        reads += 1
    print(f"{reads / 2:.0f} SDO reads per second")
    assert 190 <= sum(line.startswith(b"t7051") for line in lines) <= 210
    assert abs(sum(line.startswith(b"t0800") for line in lines) - reads) <= 5
    assert abs(sum(line.startswith(b"t2858") for line in lines) - reads) <= 5
    monitor.disconnect()
    assert node.sdo.upload(0x2F00, 12) == b"\x34\x12"


def test_client_on_the_pseudo_terminal_shares_the_bus(connect, test_node, node):
    other = connect(test_node.pty)
    assert other[NODE_ID].sdo[0x2F00][12].raw == 0x1234
    other[NODE_ID].nmt.state = "OPERATIONAL"
    time.sleep(0.02)
    assert node.nmt.wait_for_heartbeat(timeout=1) == "OPERATIONAL"


def test_flood_and_wrong_lengths_leave_heartbeats_and_values_alone(test_node, connect):
    quiet = connect()
    quiet[NODE_ID].nmt.state = "OPERATIONAL"
    quiet[NODE_ID].sdo[0x1017].raw = 10
    values = [quiet[NODE_ID].sdo.upload(0x2F00, sub) for sub in range(1, 11)]
    quiet.disconnect()
    stop = threading.Event()
    frames = b"".join(
        b"t%03X%d%s\r" % (cob_id, length, b"5A" * length)
        for cob_id in (0x605, 0x205, 0x305, 0x080, 0x123, 0x7FE, 0x000) for length in range(8)
        if not (cob_id in (0x205, 0x305) and length >= 3))
    frames += b"T1ABCDEF88" + b"00" * 8 + b"\rR000006058\r"

    def flood():
        with socket.create_connection(("127.0.0.1", test_node.port)) as connection:
            connection.sendall(b"S8\rO\r")
            connection.settimeout(0.01)
            while not stop.is_set():
                try:
                    connection.sendall(frames)
                    connection.recv(1 << 20)
                except TimeoutError:
                    connection.settimeout(0.01)

    thread = threading.Thread(target=flood)
    thread.start()
    try:
        lines = listen_fast(test_node, 2.0)
    finally:
        stop.set()
        thread.join()
    heartbeats = sum(line.startswith(b"t7051") for line in lines)
    print(f"{len(lines) / 2:.0f} frames per second, {heartbeats} heartbeats in 2 s")
    assert len(lines) > 10000  # the bus was full
    assert 190 <= heartbeats <= 210
    back = connect()
    assert [back[NODE_ID].sdo.upload(0x2F00, sub) for sub in range(1, 11)] == values
    back.disconnect()  # the last frames of the flood, which python-canopen cannot read, are not heard in the teardown


def test_garbage_on_the_line_is_answered_with_bel_and_forgotten(test_node):
    with socket.create_connection(("127.0.0.1", test_node.port)) as connection:
        connection.settimeout(1)

        def ask(command):
            """The answer; frames of the bus in between are skipped."""
            connection.sendall(command + b"\r")
            answer = b""
            while not answer.endswith((b"\r", b"\a")):
                answer += connection.recv(1)
                if answer.startswith(b"t") and answer.endswith(b"\r"):
                    answer = b""
            return answer

        assert ask(b"t1230") == b"\a"  # closed
        assert ask(b"V") == b"V1013\r"
        assert ask(b"N") == b"NSIM1\r"
        assert ask(b"") == b"\r"
        assert ask(b"S8") == b"\r"
        assert ask(b"L") == b"\r"
        assert ask(b"t1230") == b"\a"  # listen only
        assert ask(b"C") == b"\r"
        assert ask(b"S9X") == b"\a"
        assert ask(b"?") == b"\a"
        assert ask(b"x" * 500) == b"\a"
        assert ask(b"O") == b"\r"
        for bad in (b"t", b"t12", b"t1239", b"t8000", b"t1232AA", b"t1232AAB", b"t1231GG", b"T200000000", b"r123"):
            assert ask(bad) == b"\a", bad
        assert ask(b"F") == b"F00\r"


def test_client_that_leaves_in_mid_transfer_hinders_nobody(connect, node):
    leaver = connect()
    leaver.send_message(0x600 + NODE_ID, [0xC6, 0x01, 0x2F, 0, 100, 0, 0, 0])
    time.sleep(0.02)
    leaver.disconnect()
    time.sleep(1.3)  # its time-out
    assert node.sdo.upload(0x2F00, 12) == b"\x34\x12"


def test_python_can_sees_frames_in_both_directions(test_node):
    with test_node.open_bus() as left, test_node.open_bus() as right:
        time.sleep(0.05)
        sent = can.Message(arbitration_id=0x1ABCDE5F, data=[1, 2, 3], is_extended_id=True)
        left.send(sent)
        end = time.time() + 1
        seen = None
        while time.time() < end and (seen is None or seen.arbitration_id != sent.arbitration_id):
            seen = right.recv(0.1)
        assert seen is not None and seen.is_extended_id and bytes(seen.data) == bytes([1, 2, 3])
