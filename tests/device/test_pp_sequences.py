"""Random sequences of set-points in pp against a model of CiA 402: targets, statusword bits 10 to 13, and motion."""

import datetime
import os
import random

import pytest
from axis import ENABLE, HALT, PP, micro_rad, tenth_micro_rad

NEW, NOW, RELATIVE = 0x10, 0x20, 0x40
REACHED, LIMITED, ACKNOWLEDGED, FOLLOWING_ERROR = 0x400, 0x800, 0x1000, 0x2000
SEQUENCES = {"small": 2, "medium": 40}.get(os.environ.get("TESTS_SIZE", "medium"), 200)
DAY = datetime.date.today().toordinal()
SPEED_DEG_S = 4.0
LONG = tenth_micro_rad(1.5)  # a move that is under way when the next order comes
FROM_TARGET, FROM_DEMAND, FROM_ACTUAL = 0, 1, 2


class Model:
    """CiA 402-2 clause 7.2.3: one set-point under way and one that waits; targets within 607D."""

    def __init__(self, position):
        self.target, self.limited = position, False
        self.under_way, self.waiting = False, None

    def within(self, target):
        clamped = min(max(target, self.low), self.high)
        return clamped, clamped != target

    def base(self, how, given):
        """Of a relative set-point; 0 is given for that before it."""
        return given or (self.target if self.waiting is None or how & NOW else self.waiting[0])

    def order(self, value, how, base):
        taken = self.within(value + (self.base(how, base) if how & RELATIVE else 0))
        if how & NOW or not self.under_way:
            (self.target, self.limited), self.under_way, self.waiting = taken, True, None
        elif self.waiting is None:
            self.waiting = taken

    def limit(self, low, high):
        self.low, self.high = low, high
        target, beyond = self.within(self.target)
        self.target, self.limited = target, self.limited or beyond
        if self.waiting is not None:
            target, beyond = self.within(self.waiting[0])
            self.waiting = target, self.waiting[1] or beyond

    def go_on(self):
        """The set-point under way has been reached; the one that waits follows."""
        if self.waiting is not None:
            (self.target, self.limited), self.waiting = self.waiting, None

    def arrive(self):
        self.go_on()
        self.under_way = False


class Sequence:
    def __init__(self, axis, chance):
        self.axis, self.chance, self.log = axis, chance, []
        axis.set(micro_rad(SPEED_DEG_S), 0x6081)
        axis.enable(PP)
        self.start = axis.get(0x6062)
        self.option = chance.choice([FROM_TARGET, FROM_DEMAND, FROM_ACTUAL])
        axis.set(self.option, 0x60F2)
        self.model = Model(self.start)
        self.set_limits()

    def set_limits(self):
        low, high = (self.start + tenth_micro_rad(side * self.chance.uniform(2.0, 4.0)) for side in (-1, 1))
        self.axis.set(low, 0x607D, 1)
        self.axis.set(high, 0x607D, 2)
        self.log.append(f"607D = {low}, {high}")
        self.model.limit(low, high)

    def bits(self, mask):
        return self.axis.get(0x6041) & mask

    def order(self, fresh):
        """`fresh`: at rest, so that 6062 and 6064 are known."""
        how = self.chance.choice([0, RELATIVE]) | (0 if fresh else self.chance.choice([0, 0, NOW]))
        if self.option != FROM_TARGET and not fresh:
            how &= ~RELATIVE
        here = self.catch_up()
        base = {FROM_TARGET: 0, FROM_DEMAND: here, FROM_ACTUAL: self.axis.get(0x6064)}[self.option]
        value = self.value_far_from(here, how, base)
        self.axis.set(value, 0x607A)
        self.log.append(f"607A = {value}, bits {how:02X}")
        self.model.order(value, how, base)
        self.axis.command(ENABLE | NEW | how)
        self.axis.wait_until(lambda: self.bits(ACKNOWLEDGED))
        self.axis.command(ENABLE)

    def catch_up(self):
        """The demand, when no move ends before the next order: on a busy computer an order comes late."""
        here = self.axis.get(0x6062)
        if self.model.waiting is not None and abs(here - self.model.target) < LONG:
            self.axis.wait_until(lambda: not self.bits(ACKNOWLEDGED))
        if not self.bits(ACKNOWLEDGED):
            self.model.go_on()
            here = self.axis.get(0x6062)
        return here

    def value_far_from(self, here, how, base):
        while True:
            value = tenth_micro_rad(self.chance.uniform(-6.0, 6.0)) + (0 if how & RELATIVE else self.start)
            end, _ = self.model.within(value + (self.model.base(how, base) if how & RELATIVE else 0))
            if abs(end - here) > LONG:
                return value

    def arrive(self):
        self.model.arrive()
        self.axis.wait_until(lambda: not self.bits(ACKNOWLEDGED) and self.bits(REACHED), 8)
        expected = REACHED | (LIMITED if self.model.limited else 0)
        assert self.bits(REACHED | LIMITED | ACKNOWLEDGED | FOLLOWING_ERROR) == expected, "; ".join(self.log)
        slack = 60000 if self.option == FROM_ACTUAL else 1  # 6064 is read a little before the node does
        assert self.axis.get(0x6062) == pytest.approx(self.model.target, abs=slack), "; ".join(self.log)
        self.model.target = self.axis.get(0x6062)
        assert self.axis.get(0x6064) == pytest.approx(self.model.target, abs=tenth_micro_rad(0.05)), "; ".join(self.log)

    def halt(self):
        self.log.append("halt")
        self.axis.command(ENABLE | HALT)
        self.axis.wait_until(lambda: self.bits(REACHED))
        before = self.axis.get(0x6062)
        self.axis.master.pass_time(100)
        assert self.bits(REACHED) and self.axis.get(0x6062) == before, "; ".join(self.log)
        self.axis.command(ENABLE)

    def run(self):
        for _ in range(3):
            self.order(fresh=True)
            for _ in range(self.chance.randrange(3)):
                self.order(fresh=False)
            for action in self.chance.sample([self.halt, self.set_limits], self.chance.randrange(3)):
                action()
            self.arrive()

@pytest.mark.parametrize("number", range(SEQUENCES))
def test_pp_does_as_the_model(azimuth, number):
    Sequence(azimuth, random.Random(DAY * 1000 + number)).run()
