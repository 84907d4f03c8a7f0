# SPDX-License-Identifier: Apache-2.0
"""Two python-canopen clients that use SDO at once, each on its own channel and both on the same one.

TWO_CLIENTS_TRANSFERS: transfers of each client, 300 by default; 10000 take about two minutes.
"""

import contextlib
import os
import random
import struct
import threading
import time

import canopen
import pytest
from axis import PV, micro_rad
from device import NODE_ID, REAL_TIME

pytestmark = pytest.mark.speed(REAL_TIME)  # a client that pauses for 1 s in a transfer ends it

TRANSFERS = int(os.environ.get("TWO_CLIENTS_TRANSFERS", "300"))
SDO_2_REQUEST, SDO_2_ANSWER = 0x6A0, 0x6A1

TEXTS = [(0x1008, 0), (0x1009, 0), (0x100A, 0), *((0x3002, sub) for sub in range(1, 13))]
NUMBERS = [(0x1000, 0), (0x1018, 2), (0x6502, 0), (0x6087, 0)]
OWN = [(0x6081, 0), (0x6881, 0)]
"""The profile velocity of an axis for each client; no other client writes it."""


class Client(threading.Thread):
    """Reads texts and numbers whose values are known, writes its own object and reads it back."""

    def __init__(self, sdo, own, known, max_pause_s, seed):
        super().__init__()
        self.sdo, self.own, self.known, self.max_pause_s = sdo, own, known, max_pause_s
        self.random = random.Random(seed)
        self.may_be = {known[own]}
        self.right = {"text": 0, "number": 0, "write": 0}
        self.aborted, self.wrong = 0, []

    def run(self):
        for _ in range(TRANSFERS):
            time.sleep(self.random.uniform(0, self.max_pause_s))
            try:
                self.right[self.transfer()] += 1
            except (canopen.SdoAbortedError, canopen.SdoCommunicationError):
                self.aborted += 1
        self.settle()

    def settle(self):
        """Waits until a request is answered: the requests before it are answered too, and no answer comes late into the
        next test."""
        for _ in range(100):
            with contextlib.suppress(canopen.SdoAbortedError, canopen.SdoCommunicationError):
                self.sdo.upload(*NUMBERS[0])
                return

    def transfer(self):
        kind = self.random.choice(["text", "text", "number", "write", "own"])
        if kind == "write":
            value = struct.pack("<I", self.random.randrange(100_000, 400_000))
            self.may_be.add(value)
            self.sdo.download(*self.own, value, force_segment=self.random.random() < 0.5)
            self.may_be = {value}
        elif kind == "own":
            self.expect(self.own, self.may_be, self.sdo.upload(*self.own))
            kind = "number"
        else:
            of = self.random.choice(TEXTS if kind == "text" else NUMBERS)
            self.expect(of, {self.known[of]}, self.sdo.upload(*of))
        return kind

    def expect(self, of, values, value):
        if value not in values:
            self.wrong.append((hex(of[0]), of[1], value, values))


def run_both(channels, known, max_pause_s):
    both = [Client(sdo, OWN[n], known, max_pause_s, seed=n) for n, sdo in enumerate(channels)]
    for client in both:
        client.start()
    for client in both:
        client.join()
    return both


def channel(master, request=0x600 + NODE_ID, answer=0x580 + NODE_ID):
    """Identifiers of this master's SDO client."""
    if request == 0x600 + NODE_ID:
        return master.node.sdo
    sdo = master.node.add_sdo(request, answer)
    sdo.network = master.network  # which add_sdo does not set
    return sdo


@pytest.fixture
def other(connect):
    """A second master on the bus."""
    return connect()


@pytest.fixture
def known(master):
    return {of: master.node.sdo.upload(*of) for of in TEXTS + NUMBERS + OWN}


def open_second_channel(master):
    master.write(0x1201, 1, SDO_2_REQUEST, 4)
    master.write(0x1201, 2, SDO_2_ANSWER, 4)


def show(report, what, both):
    for n, client in enumerate(both):
        report(f"{what}, client {n}: {sum(client.right.values())} of {TRANSFERS} right {client.right}, "
               f"{client.aborted} aborted, {len(client.wrong)} wrong")


def test_two_clients_on_channels_of_their_own_have_no_wrong_value_and_no_abort(master, other, known, report):
    open_second_channel(master)
    both = run_both([channel(master), channel(other, SDO_2_REQUEST, SDO_2_ANSWER)], known, 0.0)
    show(report, "own channels", both)
    assert [client.wrong for client in both] == [[], []]
    assert [sum(client.right.values()) for client in both] == [TRANSFERS, TRANSFERS]


def test_two_clients_on_one_channel_have_no_wrong_value(master, other, known, report):
    """A transfer of several requests comes through when the other client pauses: on a slow computer only now and then."""
    texts = 0
    for _ in range(5):
        both = run_both([channel(master), channel(other)], known, 0.04)
        show(report, "one channel", both)
        assert [client.wrong for client in both] == [[], []]
        for client in both:
            assert client.aborted > TRANSFERS / 100, "the clients did not meet: nothing was tried"
            assert sum(client.right.values()) > TRANSFERS / 20, "one client keeps the other out"
        texts += sum(client.right["text"] for client in both)
        if texts > 0:
            return
    pytest.fail("no transfer of several requests came through")


def test_a_client_that_crashes_in_a_transfer_hinders_no_other(master, other, known):
    for _ in range(5):
        master.forget()
        other.send(0x600 + NODE_ID, 0x40, 0x08, 0x10, 0, 0, 0, 0, 0)
        other.send(0x600 + NODE_ID, 0x60, 0, 0, 0, 0, 0, 0, 0)
        master.wait_for(0x580 + NODE_ID, 2)  # otherwise it takes them for answers to its own request
        assert master.node.sdo.upload(0x3002, 1) == known[0x3002, 1]


def test_1201_is_off_by_default_and_is_stored(master, other, store):
    assert [master.number(0x1201, sub) for sub in (1, 2)] == [0x80000000, 0x80000000]
    open_second_channel(master)
    master.node.sdo.download(0x1010, 2, b"save")
    master.reset()
    assert channel(other, SDO_2_REQUEST, SDO_2_ANSWER).upload(0x1008, 0) == b"trackservo"


@pytest.mark.parametrize("sub", [1, 2])
def test_1201_refuses_what_cannot_be_heard_and_changes_while_it_is_on(master, sub):
    for reserved in (0x000, 0x07F, 0x101, 0x581, 0x601, 0x6E0, 0x701, 0x7E5, 0x7FF):
        assert master.sdo_abort(0x1201, sub, reserved.to_bytes(4, "little")) == 0x06090030
    master.write(0x1201, sub, SDO_2_REQUEST, 4)
    assert master.sdo_abort(0x1201, sub, (SDO_2_REQUEST + 8).to_bytes(4, "little")) == 0x08000022
    master.write(0x1201, sub, 0x80000000, 4)
    master.write(0x1201, sub, SDO_2_REQUEST + 8, 4)


def test_one_client_speaks_and_one_only_listens(master, azimuth, connect):
    listener = connect(listen_only=True)
    azimuth.turn(1.0)
    listener.forget()
    assert all(azimuth.get(0x606C) is not None for _ in range(100))
    rates = [struct.unpack_from("<l", data)[0] for data in listener.wait_for(0x381, 40)]
    assert sum(rates) / len(rates) == pytest.approx(micro_rad(1.0), rel=0.03)
    listener.wait_for_state(5)
    listener.send(0x201, 0, 0, PV)  # does not get onto the bus
    master.pass_time(200)
    assert azimuth.state == "OPERATION ENABLED"


def test_each_client_turns_an_axis_at_the_same_time(connect, azimuth, pitch):
    """Both have one SDO channel, so the second client knows the mapping from the EDS and uses only PDOs."""
    rpdo = connect().node.rpdo
    azimuth.turn(1.0, settle_s=0)
    rpdo.read(from_od=True)
    rpdo[2]["Pitch Modes of operation"].raw = PV
    for controlword, state in ((6, "READY TO SWITCH ON"), (7, "SWITCHED ON"), (15, "OPERATION ENABLED")):
        rpdo[2]["Pitch Controlword"].raw = controlword
        rpdo[2].transmit()
        pitch.wait_for_state(state)
    rpdo[3]["Azimuth Target velocity"].raw = micro_rad(1.0)
    rpdo[3]["Pitch Target velocity"].raw = micro_rad(-1.0)
    rpdo[3].transmit()
    azimuth.master.pass_time(1000)
    assert pitch.mean_rate_deg_s() == pytest.approx(-1.0, rel=0.03)
    assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
