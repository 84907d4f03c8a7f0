# SPDX-License-Identifier: Apache-2.0
"""Reference shapes as rates: they come back, stay within their travel, and reverse without a jump."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from servoctl.errors import InputError
from servoctl.motion.shapes import SHAPES, plan_shape
from servoctl.units import TICK_S


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("travel_deg", [3.0, -3.0])
def test_a_shape_goes_its_travel_and_comes_back(shape: str, travel_deg: float) -> None:
    planned = plan_shape("azimuth", shape, radians(travel_deg), 2.0, 3)
    angle = np.cumsum(planned.rates) * TICK_S
    far = np.max(np.sign(travel_deg) * angle)
    assert far == pytest.approx(radians(3.0), rel=2e-3) and np.min(np.sign(travel_deg) * angle) > -radians(0.02)
    assert abs(angle[-1]) < radians(0.02)
    assert np.max(np.abs(np.diff(planned.rates))) < 0.02 * planned.plan.rate_rad_s
    assert planned.plan.forward_rad + planned.plan.backward_rad == pytest.approx(radians(3.0), rel=1e-2)
    assert planned.plan.duration_s == pytest.approx(6.6)


@pytest.mark.parametrize("wrong", [("square", 1.0, 2.0, 1), ("sine", 0.0, 2.0, 1), ("sine", 1.0, 0.1, 1), ("sine", 1.0, 2.0, 61)])
def test_a_shape_that_is_none_is_refused(wrong: tuple[str, float, float, int]) -> None:
    with pytest.raises(InputError):
        plan_shape("azimuth", *wrong)
