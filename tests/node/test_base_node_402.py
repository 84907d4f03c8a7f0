"""python-canopen's BaseNode402, unmodified, with the EDS that the build prints. On SLCAN and on SocketCAN."""

import time

import pytest

from drive import micro_rad, wait_until


@pytest.fixture
def motor(node):
    node.setup_402_state_machine()
    return node


def mean_of(variable, count=50):
    return sum(variable.raw for _ in range(count)) / count


def test_azimuth_is_enabled_turns_and_reports_its_speed(motor):
    motor.op_mode = "PROFILED VELOCITY"
    assert motor.op_mode == "PROFILED VELOCITY"
    motor.state = "OPERATION ENABLED"
    assert motor.state == "OPERATION ENABLED"
    motor.sdo[0x60FF].raw = micro_rad(1.0)
    time.sleep(1.5)
    assert mean_of(motor.sdo[0x606C]) == pytest.approx(micro_rad(1.0), rel=0.03)
    time.sleep(0.2)
    assert motor.tpdo_values[0x606C] == pytest.approx(micro_rad(1.0), rel=0.10)  # one value, with its noise
    motor.sdo[0x60FF].raw = 0
    wait_until(lambda: abs(motor.sdo[0x606C].raw) < micro_rad(0.02), 2)
    motor.state = "SWITCH ON DISABLED"
    assert motor.state == "SWITCH ON DISABLED"


def test_every_state_is_reached_by_name(motor):
    motor.op_mode = "PROFILED VELOCITY"
    for state in ("READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED", "SWITCHED ON", "READY TO SWITCH ON",
                  "SWITCH ON DISABLED", "OPERATION ENABLED", "SWITCH ON DISABLED"):
        motor.state = state
        assert motor.state == state


def test_modes_that_the_node_has_are_taken_and_others_refused(motor):
    for mode in ("PROFILED POSITION", "CYCLIC SYNCHRONOUS POSITION", "CYCLIC SYNCHRONOUS VELOCITY",
                 "CYCLIC SYNCHRONOUS TORQUE", "HOMING", "PROFILED VELOCITY"):
        motor.op_mode = mode
        assert motor.op_mode == mode
    with pytest.raises(TypeError):
        motor.op_mode = "INTERPOLATED POSITION"


def test_quick_stop_holds_the_axis_and_lets_it_go_on(motor):
    motor.sdo[0x605A].raw = 6  # stay in Quick stop active
    motor.op_mode = "PROFILED VELOCITY"
    motor.state = "OPERATION ENABLED"
    motor.sdo[0x60FF].raw = micro_rad(1.0)
    time.sleep(1.0)
    motor.state = "QUICK STOP ACTIVE"
    wait_until(lambda: abs(mean_of(motor.sdo[0x606C], 10)) < micro_rad(0.02), 0.5)
    assert motor.state == "QUICK STOP ACTIVE"
    motor.state = "OPERATION ENABLED"
    time.sleep(1.0)
    assert mean_of(motor.sdo[0x606C]) == pytest.approx(micro_rad(1.0), rel=0.03)


def test_fault_is_reset_by_a_rising_edge(motor):
    motor.op_mode = "PROFILED VELOCITY"
    motor.state = "OPERATION ENABLED"
    for _ in range(2):  # the second time the bit is still set: it must not reset by its level
        motor.nmt.state = "STOPPED"
        time.sleep(0.3)
        motor.nmt.state = "OPERATIONAL"
        wait_until(lambda: motor.state == "FAULT", 2)
        assert motor.sdo[0x603F].raw == 0x8100
        motor.controlword = 0x00
        time.sleep(0.02)  # an edge needs a tick between the two
        motor.controlword = 0x80
        wait_until(lambda: motor.state == "SWITCH ON DISABLED", 1)
        assert motor.sdo[0x603F].raw == 0
    motor.nmt.state = "STOPPED"
    time.sleep(0.3)
    motor.nmt.state = "OPERATIONAL"
    time.sleep(0.5)
    assert motor.state == "FAULT"
    motor.reset_from_fault()
    assert motor.state == "OPERATION ENABLED"
