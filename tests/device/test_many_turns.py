# SPDX-License-Identifier: Apache-2.0
"""An axis without end stops beyond the range of its position: the encoder says where it is, 6064 by whole turns."""

import struct

import pytest
from axis import ACKNOWLEDGED, CSP, ENABLE, NEW_SETPOINT, PP, PV, TARGET_REACHED, TPDO8, micro_rad, tenth_micro_rad
from camera import ON_TARGET, Camera
from device import FAST, REAL_TIME
from slip_ring import DEG_S, RANGE_TURNS, TURN, be_seen_31_turns_away, endless_axis, remove_the_travel, wrapped

RELATIVE = 0x40
WRAPPED = 0x4000
AS_FAST_AS_IT_CAN = 100
TPDO7 = 6

up_and_down = pytest.mark.parametrize("side", [1, -1], ids=["up", "down"])


@pytest.fixture
def endless(tmp_path, pytestconfig, request):
    chosen = request.node.get_closest_marker("speed")
    with endless_axis(pytestconfig.getoption("--device"), chosen.args[0] if chosen else FAST, tmp_path) as axis:
        yield axis


class Encoder:
    """The turns that it has made are counted from its 2^-32 turn, every 20 ms, beside 6064."""

    def __init__(self, axis, pdo=TPDO8):
        self.seen = []
        axis.master.network.subscribe(axis.master.sample(pdo, [0x21010420, 0x60640020]), self.hear)
        axis.wait_until(lambda: self.seen)

    def hear(self, _identifier, data, _time):
        angle, position = struct.unpack("<Ll", data)
        last = self.turns if self.seen else position / TURN
        self.seen.append((last + ((angle / 2**32 - last + 0.5) % 1.0 - 0.5), position))

    @property
    def turns(self):
        return self.seen[-1][0]

    def check_position(self):
        """6064 was the true angle modulo 64 turns, to 1 count, in every sample."""
        assert max(abs(wrapped(position - turns * TURN)) for turns, position in self.seen) < 2


def turn_until(axis, encoder, side, turns):
    axis.enable(PV)
    axis.set(side * micro_rad(DEG_S), 0x60FF)
    axis.wait_until(lambda: side * encoder.turns > turns, 400)
    axis.set(0, 0x60FF)
    axis.wait_for_standstill(5)


def select(axis, mode):
    axis.set(mode, 0x6060)
    axis.wait_until(lambda: axis.get(0x6061) == mode)


def move_by(axis, encoder, degrees):
    """Relative, in pp; where the encoder has seen it end."""
    before = encoder.turns
    axis.set(tenth_micro_rad(degrees), 0x607A)
    axis.command(ENABLE | NEW_SETPOINT | RELATIVE)
    axis.wait_until(lambda: axis.get(0x6041) & ACKNOWLEDGED)
    axis.command(ENABLE)
    axis.wait_until(lambda: axis.get(0x6041) & TARGET_REACHED and not axis.get(0x6041) & ACKNOWLEDGED, 10)
    axis.master.pass_time(200)
    assert 360 * (encoder.turns - before) == pytest.approx(degrees, abs=0.05)


def stream_by(axis, encoder, degrees):
    """In csp at 20 deg/s: a set-point every 100 ms, modulo 64 turns, and the last one for half a second more."""
    before, start = encoder.turns, axis.get(0x6062)
    axis.set(100, 0x60C2, 1)
    steps = round(abs(degrees) / 2.0)
    for step in range(1, steps + 6):
        axis.set(round(wrapped(start + tenth_micro_rad(degrees * min(step / steps, 1.0)))), 0x607A)
        sent = len(encoder.seen)
        axis.wait_until(lambda sent=sent: len(encoder.seen) >= sent + 5)
    assert 360 * (encoder.turns - before) == pytest.approx(degrees, abs=0.05)


@pytest.mark.variants_on_image(1)
@up_and_down
def test_moves_across_the_wrap_are_as_ordered(endless, side):
    be_seen_31_turns_away(endless, side)
    remove_the_travel(endless)
    assert endless.get(0x6064) / TURN == pytest.approx(side * 31, abs=0.01)
    encoder = Encoder(endless)
    turn_until(endless, encoder, side, 31.87)  # it stops at 31.96
    assert not endless.get(0x6041) & WRAPPED
    select(endless, PP)
    for degrees in (40, -40, 40):
        move_by(endless, encoder, side * degrees)
    assert endless.get(0x6064) / TURN == pytest.approx(encoder.turns - side * RANGE_TURNS, abs=1e-4)  # beyond the wrap
    assert endless.get(0x6041) & WRAPPED
    select(endless, CSP)
    for degrees in (-40, 40):
        stream_by(endless, encoder, side * degrees)
    encoder.check_position()
    assert min(abs(turns) for turns, _ in encoder.seen[-300:]) < RANGE_TURNS / 2 < abs(encoder.turns)
    assert endless.get(0x603F) == 0


@pytest.mark.speed(REAL_TIME)
def test_a_target_is_followed_across_the_wrap(endless):
    be_seen_31_turns_away(endless, 1)
    remove_the_travel(endless)
    encoder = Encoder(endless, TPDO7)
    turn_until(endless, encoder, 1, 31.87)  # it stops at 31.96
    camera = Camera(endless, rate_deg_s=0.0)
    camera.follow()
    camera.rate_deg_s = 5.0
    endless.wait_until(lambda: encoder.turns > RANGE_TURNS / 2 + 0.01, 30)
    assert endless.rate_deg_s == pytest.approx(5.0, abs=0.3) and camera.state == ON_TARGET
    encoder.check_position()
    assert endless.get(0x603F) == 0


@pytest.mark.simulator
@pytest.mark.speed(AS_FAST_AS_IT_CAN)
@up_and_down
def test_6064_is_the_true_angle_modulo_64_turns_after_34_turns(endless, side):
    remove_the_travel(endless)
    encoder = Encoder(endless)
    turn_until(endless, encoder, side, 34.5)
    encoder.check_position()
    select(endless, PP)
    move_by(endless, encoder, -10 * side)
