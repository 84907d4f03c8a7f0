# SPDX-License-Identifier: Apache-2.0
"""LSS (CiA 305) from python-canopen's master, unmodified: to the device, which has its id, and to simulators without."""

import pytest
from canopen.lss import LssError, LssMaster
from device import NODE_ID, dictionary
from master import Master

UNCONFIGURED = 255
PRODUCT = 0x54534456
SERIAL = 0x100
KBIT_S_125 = 4
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


def test_a_node_with_an_id_takes_no_part_in_fastscan(master):
    assert master.network.lss.fast_scan() == (False, None)


@pytest.mark.smoke
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


@pytest.mark.simulator
def test_a_node_without_node_id_is_found_numbered_and_remembered(serve, tmp_path):
    options = ("--node-id", str(UNCONFIGURED), "--serial", str(SERIAL), "--flash",
               str(tmp_path / "flash"))
    served = serve(*options).wait_until_ready()
    master = Master(served.open_bus())
    lss = master.network.lss
    lss.RESPONSE_TIMEOUT = 0.6  # for the computer; python-canopen has no other clock
    assert lss.fast_scan() == (True, [0, PRODUCT, 1, SERIAL])
    lss.configure_node_id(10)
    lss.store_configuration()
    lss.send_switch_state_global(LssMaster.WAITING_STATE)
    assert lss.fast_scan() == (False, None)
    master.close()
    served.close()
    again = Master(serve(*options).wait_until_ready().open_bus())  # the power comes back
    assert again.network.add_node(10, dictionary()).sdo[0x1018][4].raw == SERIAL
    again.close()


@pytest.mark.simulator
def test_the_bit_rate_changes_when_it_is_activated_and_stays_when_it_is_stored(serve, tmp_path):
    flash = ("--flash", str(tmp_path / "flash"))
    served = serve(*flash).wait_until_ready()
    fast = Master(served.open_bus())
    lss = fast.network.lss
    lss.send_switch_state_global(LssMaster.CONFIGURATION_STATE)
    lss.configure_bit_timing(KBIT_S_125)
    lss.store_configuration()
    lss.activate_bit_timing(100)
    slow = Master(served.open_bus(bit_rate=125000))
    slow.wait_for(0x700 + NODE_ID)
    assert (slow.number(0x3050, 2), slow.number(0x1800, 3)) == (125, 160)
    fast.forget()
    slow.forget()
    slow.wait_for(0x700 + NODE_ID, 3)
    assert fast.heard(0x700 + NODE_ID) == []
    for master in (slow, fast):
        master.close()
    served.close()
    again = Master(serve(*flash).wait_until_ready().open_bus(bit_rate=125000))
    assert again.number(0x1000) != 0
    again.close()
