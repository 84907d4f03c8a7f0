# SPDX-License-Identifier: Apache-2.0
"""python-canopen's BaseNode402, unmodified, with the EDS that the build prints. On SLCAN and on SocketCAN."""

import pytest
from axis import Axis, micro_rad


@pytest.fixture
def motor(node):
    node.setup_402_state_machine()
    node.op_mode = "PROFILED VELOCITY"
    return node


def mean_of(variable, count=50):
    return sum(variable.raw for _ in range(count)) / count


@pytest.mark.smoke
def test_azimuth_is_enabled_turns_and_reports_its_speed(motor, master):
    assert motor.op_mode == "PROFILED VELOCITY"
    motor.state = "OPERATION ENABLED"
    assert motor.state == "OPERATION ENABLED"
    motor.sdo[0x60FF].raw = micro_rad(1.0)
    master.pass_time(1500)
    assert mean_of(motor.sdo[0x606C]) == pytest.approx(micro_rad(1.0), rel=0.03)
    assert motor.tpdo_values[0x606C] == pytest.approx(micro_rad(1.0), rel=0.10)  # one value, with its noise
    motor.sdo[0x60FF].raw = 0
    Axis(master, 0).wait_for_standstill()
    motor.state = "SWITCH ON DISABLED"
    assert motor.state == "SWITCH ON DISABLED"


def test_modes_that_the_node_has_are_taken_and_others_refused(motor):
    for mode in ("PROFILED POSITION", "CYCLIC SYNCHRONOUS POSITION", "CYCLIC SYNCHRONOUS VELOCITY",
                 "CYCLIC SYNCHRONOUS TORQUE", "HOMING", "PROFILED VELOCITY"):
        motor.op_mode = mode
        assert motor.op_mode == mode
    with pytest.raises(TypeError):
        motor.op_mode = "INTERPOLATED POSITION"


def test_a_fault_is_reset_by_its_own_method(motor, master):
    motor.state = "OPERATION ENABLED"
    motor.nmt.state = "STOPPED"
    master.wait_for_state(4)
    master.start()
    master.wait_until(lambda: motor.state == "FAULT")
    motor.reset_from_fault()
    assert motor.state == "OPERATION ENABLED"
