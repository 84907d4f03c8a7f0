# SPDX-License-Identifier: Apache-2.0
"""python-canopen and its p402 with their own time-outs: a user's first program. Arguments: the EDS and HOST:PORT.

Prints a JSON object for each step: its name, what went wrong, and the node's time over the computer's.
"""

import json
import sys
import time

import canopen
from canopen.profiles.p402 import BaseNode402
from servoctl.link.slcan_tcp import SlcanTcpBus

EVERYTHING = 1
NODE_ID = 1
RATE = 34907
"""2 deg/s, in 1e-6 rad/s."""
SILENT_S = 1.6
"""Beyond 3041:1, 1 s of the node."""
OFF, STOP = 0, 3


def store(node):
    node.sdo[0x607F].raw = 654321
    node.store(EVERYTHING)


def restore(node):
    node.restore(EVERYTHING)


def enable(node):
    node.sdo[0x6007].raw = OFF  # the line of docs/can.md: this master is silent between its steps
    node.nmt.state = "OPERATIONAL"
    node.setup_402_state_machine()
    node.op_mode = "PROFILED VELOCITY"
    node.state = "OPERATION ENABLED"


def turn_while_silent(node):
    node.sdo[0x60FF].raw = RATE
    time.sleep(SILENT_S)
    assert node.state == "OPERATION ENABLED", node.state
    assert abs(node.sdo[0x606C].raw - RATE) < 0.2 * RATE, node.sdo[0x606C].raw


def stop_when_silent(node):
    node.sdo[0x6007].raw = STOP  # as delivered
    time.sleep(SILENT_S)
    assert node.state == "SWITCH ON DISABLED", node.state
    assert node.sdo[0x603F].raw == 0 and abs(node.sdo[0x606C].raw) < 0.1 * RATE, node.sdo[0x606C].raw
    node.sdo[0x6007].raw = OFF
    node.sdo[0x60FF].raw = 0
    node.state = "OPERATION ENABLED"


def get_a_fault(node):
    node.nmt.state = "STOPPED"
    time.sleep(0.3)
    node.nmt.state = "OPERATIONAL"
    time.sleep(0.3)


def reset_the_fault(node):
    assert node.state == "FAULT", node.state
    node.reset_from_fault()
    node.state = "OPERATION ENABLED"


def switch_off(node):
    node.state = "SWITCH ON DISABLED"


def ticks_ms(node):
    return node.sdo[0x3010][1].raw


def take(step, node):
    """What was seen; `error` is None when the step has succeeded."""
    began_s, began_ms, error, pace = time.monotonic(), ticks_ms(node), None, 0.0
    try:
        step(node)
    except (canopen.SdoAbortedError, canopen.SdoCommunicationError, RuntimeError, AssertionError) as failure:
        error = repr(failure)
    for _ in range(2):  # the first answer may be that to a request that was given up
        try:
            pace = 1e-3 * (ticks_ms(node) - began_ms) / (time.monotonic() - began_s)
            break
        except (canopen.SdoAbortedError, canopen.SdoCommunicationError):
            pass  # slower than python-canopen waits
    return {"step": step.__name__, "error": error, "pace": pace}


def main(descriptions, address):
    host, port = address.rsplit(":", 1)
    network = canopen.Network(bus=SlcanTcpBus(host, int(port)))
    network.connect()
    node = BaseNode402(NODE_ID, descriptions)
    network.add_node(node)
    try:
        for step in (store, restore, enable, turn_while_silent, stop_when_silent, get_a_fault, reset_the_fault, switch_off):
            seen = take(step, node)
            print(json.dumps(seen), flush=True)
            if seen["error"]:
                return 1
    finally:
        network.disconnect()
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
