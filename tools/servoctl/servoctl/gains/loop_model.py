# SPDX-License-Identifier: Apache-2.0
"""Small-signal model of the firmware's speed controller, from the gains of the device.

    u = [ Cr r - (C + M - Q (M - B)) F y ] / (1 - Q)

with r the set-point rate, y the measured rate, C and Cr the PI towards y and r (set-point weight, acceleration
feedforward), Q, M and B the disturbance observer, F the filters on the feedback. All at z = exp(j w T), T the 1 ms
tick, in the difference equations of firmware/control (pi_controller.c, disturbance_observer.c). The friction
feedforward is left out: sliding, its slope is a few percent of the proportional gain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..link.device import Device
from ..units import TICK_S

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]


@dataclass(frozen=True)
class SpeedLoopGains:
    """Objects 0x2000, 0x2020 and 0x2040 of an axis: N m s/rad, N m/rad, kg m^2, rad/s, Hz as on the device."""

    proportional: float
    integral: float
    setpoint_weight: float
    feedforward_inertia: float
    observer_on: bool
    observer_inertia: float
    observer_viscous: float
    observer_bandwidth: float
    notch_hz: float
    notch_width_hz: float
    notch_depth: float
    lowpass_hz: float
    lowpass_damping: float


def read_gains(device: Device, axis: int) -> SpeedLoopGains:
    """The present values of the device."""
    real = device.axis_real
    return SpeedLoopGains(
        real(axis, 0x2000, 1), real(axis, 0x2000, 2), real(axis, 0x2000, 3), real(axis, 0x2000, 5),
        device.axis_int(axis, 0x2020, 1) == 1, real(axis, 0x2020, 2), real(axis, 0x2020, 3), real(axis, 0x2020, 4),
        real(axis, 0x2040, 1), real(axis, 0x2040, 2), real(axis, 0x2040, 3), real(axis, 0x2040, 4), real(axis, 0x2040, 5),
    )  # fmt: skip


def controller(gains: SpeedLoopGains, frequency_hz: Real) -> tuple[Complex, Complex]:
    """(from y to -u, from r to u), N m s/rad, with the observer and the feedback's filters in the first."""
    z = np.exp(2j * np.pi * frequency_hz * TICK_S)
    integral = gains.integral * TICK_S / (z - 1)
    to_y = gains.proportional + integral
    to_r = gains.proportional * gains.setpoint_weight + integral + gains.feedforward_inertia * (z - 1) / TICK_S
    q = np.zeros_like(z)
    if gains.observer_on:
        blend = 1.0 - np.exp(-gains.observer_bandwidth * TICK_S)
        momentum = blend * gains.observer_inertia / TICK_S
        q = blend / z / (1.0 - (1.0 - blend) / z)
        to_y = to_y + momentum - q * (momentum - gains.observer_viscous)
    return to_y * feedback_filters(gains, frequency_hz) / (1.0 - q), to_r / (1.0 - q)


def feedback_filters(gains: SpeedLoopGains, frequency_hz: Real) -> Complex:
    """Notch and low-pass, as the continuous filters from which the firmware's biquads are made."""
    s = 2j * np.pi * frequency_hz
    answer = np.ones_like(s)
    if gains.notch_hz > 0:
        w, width = 2 * np.pi * gains.notch_hz, 2 * np.pi * gains.notch_width_hz
        answer = answer * (s**2 + gains.notch_depth * width * s + w**2) / (s**2 + width * s + w**2)
    if gains.lowpass_hz > 0:
        w = 2 * np.pi * gains.lowpass_hz
        answer = answer * w**2 / (s**2 + 2 * gains.lowpass_damping * w * s + w**2)
    return answer


def open_loop(gains: SpeedLoopGains, frequency_hz: Real, closed: Complex) -> Complex:
    """The loop, opened at the motor's torque, from the measured closed loop y / r."""
    to_y, to_r = controller(gains, frequency_hz)
    plant = closed / (to_r - closed * to_y)
    return np.asarray(plant * to_y, dtype=np.complex128)
