"""LSS (CiA 305), from python-canopen's master to a node that has its id."""

import pytest
from canopen.lss import LssError, LssMaster

from conftest import NODE_ID

IDENTITY = {"vendor": (0x5A, 1), "product": (0x5B, 2), "revision": (0x5C, 3), "serial number": (0x5D, 4)}


@pytest.fixture
def lss(master):
    """The node in the configuration state, and back in the waiting state afterwards."""
    master.network.lss.send_switch_state_global(LssMaster.CONFIGURATION_STATE)
    yield master.network.lss
    master.network.lss.send_switch_state_global(LssMaster.WAITING_STATE)


def test_inquire_node_id(lss):
    assert lss.inquire_node_id() == NODE_ID


@pytest.mark.parametrize("command, sub", IDENTITY.values(), ids=IDENTITY)
def test_inquired_identity_is_that_of_1018(master, lss, command, sub):
    assert lss.inquire_lss_address(command) == master.number(0x1018, sub)


def test_switch_state_selective_finds_the_node_by_its_identity(master):
    lss = master.network.lss
    assert lss.send_switch_state_selective(*(master.number(0x1018, sub) for sub in range(1, 5)))
    assert lss.inquire_node_id() == NODE_ID
    lss.send_switch_state_global(LssMaster.WAITING_STATE)


def test_a_waiting_node_answers_no_inquiry(master):
    master.network.lss.send_switch_state_global(LssMaster.WAITING_STATE)
    with pytest.raises(LssError):
        master.network.lss.inquire_node_id()


@pytest.mark.parametrize("node_id", [0, 128, 200])
def test_configure_node_id_refuses_what_is_none(lss, node_id):
    with pytest.raises(LssError):
        lss.configure_node_id(node_id)
    assert lss.inquire_node_id() == NODE_ID


def test_configure_bit_timing_refuses_10_kbit_s(lss):
    with pytest.raises(LssError):
        lss.configure_bit_timing(8)


def test_a_node_with_an_id_takes_no_part_in_fastscan(master):
    found, _ = master.network.lss.fast_scan()
    assert not found


def test_a_new_node_id_counts_after_a_reset_of_the_communication(master):
    lss = master.network.lss
    lss.send_switch_state_global(LssMaster.CONFIGURATION_STATE)
    lss.configure_node_id(42)
    lss.send_switch_state_global(LssMaster.WAITING_STATE)
    master.forget()
    master.node.nmt.send_command(130)
    assert master.wait_for(0x700 + 42, 2)[0] == b"\x00"
    lss.send_switch_state_global(LssMaster.CONFIGURATION_STATE)
    lss.configure_node_id(NODE_ID)
    lss.send_switch_state_global(LssMaster.WAITING_STATE)
    master.forget()
    master.send(0, 130, 42)
    assert b"\x00" in master.wait_for(0x700 + NODE_ID, 1)
