# SPDX-License-Identifier: Apache-2.0
"""Frequency responses, margins and steps of systems with known answers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servoctl.errors import MotionError
from servoctl.gains.frequency_response import bandwidth_hz, design_multisine, estimate, margins
from servoctl.gains.loop_model import SpeedLoopGains, open_loop
from servoctl.gains.loop_test import MeasuredLoop
from servoctl.motion.braking import Real, analyse_stop, sure_deceleration
from servoctl.motion.step_response import analyse_step
from servoctl.units import TICK_S

GAINS = SpeedLoopGains(720.0, 21600.0, 0.7, 6.0, True, 6.0, 0.0, 220.0, 0.0, 10.0, 0.1, 0.0, 0.7)
INERTIA = 6.0


def test_multisine_keeps_its_peak_and_its_lines_apart() -> None:
    sine = design_multisine(1.0, 200.0, 50)
    bins = np.round(sine.frequency_hz * sine.period_s)
    assert np.min(np.diff(bins)) >= 4
    assert np.max(np.abs(sine.at(np.arange(0, sine.period_s, 1e-4)))) == pytest.approx(1.0, abs=0.01)


def test_response_of_a_first_order_lag_is_found_in_noise() -> None:
    sine = design_multisine(1.0, 100.0, 30)
    demand = sine.at(np.arange(0, 6 * sine.period_s, TICK_S))
    pole = np.exp(-2 * np.pi * 20.0 * TICK_S)
    answer = np.zeros_like(demand)
    for k in range(1, len(demand)):
        answer[k] = pole * answer[k - 1] + (1 - pole) * demand[k - 1]
    answer += np.random.default_rng(1).normal(0, 0.002, len(answer))
    found = estimate(demand, answer, TICK_S, sine)
    z = np.exp(2j * np.pi * found.frequency_hz * TICK_S)
    exact = (1 - pole) / (z - pole)
    assert np.max(np.abs(found.value / exact - 1)) < 0.05
    assert np.min(found.coherence) > 0.95


def test_noise_alone_has_no_coherence() -> None:
    sine = design_multisine(1.0, 100.0, 30)
    demand = sine.at(np.arange(0, 8 * sine.period_s, TICK_S))
    answer = np.random.default_rng(2).normal(0, 1, len(demand))
    assert np.median(estimate(demand, answer, TICK_S, sine).coherence) < 0.5


def test_margins_of_a_double_lag_integrator_are_exact() -> None:
    frequency = np.geomspace(0.05, 50, 4000)
    s = 2j * np.pi * frequency
    loop = 20.0 / (s * (1 + s / 30) * (1 + s / 60))
    found = margins(frequency, loop)
    assert found.phase_crossover_hz == pytest.approx(np.sqrt(30 * 60) / 2 / np.pi, rel=1e-3)
    assert found.gain_margin_db == pytest.approx(20 * np.log10((30 + 60) / 20.0), abs=0.01)
    w = 2 * np.pi * (found.crossover_hz or 0)
    assert abs(20.0 / (1j * w * (1 + 1j * w / 30) * (1 + 1j * w / 60))) == pytest.approx(1.0, rel=1e-3)
    assert found.phase_margin_deg == pytest.approx(90 - np.degrees(np.arctan(w / 30) + np.arctan(w / 60)), abs=0.1)


def test_three_integrators_do_not_confuse_the_branch_of_the_phase() -> None:
    frequency = np.geomspace(0.1, 50, 2000)
    s = 2j * np.pi * frequency
    loop = 1e3 * (1 + s / 3) ** 2 / s**3 * np.exp(-0.005 * s)
    found = margins(frequency, loop)
    assert found.phase_margin_deg is not None and 0 < found.phase_margin_deg < 90


def test_bandwidth_is_where_the_gain_falls_by_3_db() -> None:
    frequency = np.geomspace(0.1, 100, 500)
    closed = 1 / (1 + 1j * frequency / 7.0)
    assert bandwidth_hz(frequency, np.asarray(closed, dtype=np.complex128)) == pytest.approx(7.0, rel=0.01)
    assert bandwidth_hz(frequency[:100], np.asarray(closed[:100], dtype=np.complex128)) is None


def simulate_firmware(reference: np.ndarray, g: SpeedLoopGains) -> tuple[np.ndarray, np.ndarray]:
    """The firmware's speed loop (PI, set-point weight, feedforward, observer) on a pure inertia, tick by tick.

    Returns measured rate and torque. Written from the C sources' difference equations, not from loop_model.
    """
    blend = 1 - np.exp(-g.observer_bandwidth * TICK_S)
    momentum = blend * g.observer_inertia / TICK_S
    rate = integral = prediction = torque = 0.0
    rates, torques = np.zeros(len(reference)), np.zeros(len(reference))
    for k in range(len(reference) - 1):
        r, following = reference[k], reference[k + 1]
        auxiliary = prediction + blend * torque
        estimate_nm = auxiliary - momentum * rate
        prediction = (1 - blend) * auxiliary + blend * (momentum - g.observer_viscous) * rate
        torque = g.proportional * (g.setpoint_weight * r - rate) + integral
        torque += g.feedforward_inertia * (following - r) / TICK_S + (estimate_nm if g.observer_on else 0.0)
        integral += TICK_S * g.integral * (r - rate)
        rates[k], torques[k] = rate, torque
        rate += TICK_S / INERTIA * torque
    return rates, torques


def measure_simulated(gains: SpeedLoopGains) -> MeasuredLoop:
    """As the axis is measured."""
    sine = design_multisine(2.0, 200.0, 40)
    reference = 0.01 * sine.at(np.arange(0, 6 * sine.period_s, TICK_S))
    closed = estimate(reference[2000:-1], simulate_firmware(reference, gains)[0][2000:-1], TICK_S, sine)
    loop = open_loop(gains, closed.frequency_hz, closed.value)
    all_lines = np.ones(len(loop), dtype=np.bool_)
    return MeasuredLoop(closed, loop, all_lines, all_lines, margins(closed.frequency_hz, loop), None, gains, 0)


def test_the_loop_with_other_gains_is_the_one_that_is_then_measured() -> None:
    """As the page and `tune` predict it."""
    softer = replace(GAINS, proportional=0.8 * GAINS.proportional)
    first, then = measure_simulated(GAINS), measure_simulated(softer)
    assert first.margins.phase_margin_deg != pytest.approx(then.margins.phase_margin_deg, abs=1.0)
    predicted = margins(first.closed.frequency_hz, first.loop_with(softer))
    assert predicted.phase_margin_deg == pytest.approx(then.margins.phase_margin_deg, abs=0.5)


@pytest.mark.parametrize("observer_on", [True, False])
def test_open_loop_from_the_closed_one_is_that_of_the_simulated_firmware(observer_on: bool) -> None:
    gains = SpeedLoopGains(**{**GAINS.__dict__, "observer_on": observer_on})
    sine = design_multisine(2.0, 200.0, 40)
    reference = 0.01 * sine.at(np.arange(0, 6 * sine.period_s, TICK_S))
    rates, torques = simulate_firmware(reference, gains)
    keep = slice(2000, -1)
    closed = estimate(reference[keep], rates[keep], TICK_S, sine)
    loop = open_loop(gains, closed.frequency_hz, closed.value)
    z = np.exp(2j * np.pi * closed.frequency_hz * TICK_S)
    plant = TICK_S / INERTIA / (z - 1)
    measured_plant = estimate(torques[keep], rates[keep], TICK_S, sine).value
    assert np.max(np.abs(measured_plant / plant - 1)) < 0.02
    found = margins(closed.frequency_hz, loop)
    assert found.phase_margin_deg is not None and found.phase_margin_deg > 30
    # Opened at the torque: u = -L u + ..., so a disturbance there shows 1 / (1 + L), independent of the path of the
    # set-point.
    sensitivity = disturbance_response(gains, closed.frequency_hz)
    assert np.max(np.abs((1 / (1 + loop)) / sensitivity - 1)) < 0.05


def disturbance_response(g: SpeedLoopGains, frequency_hz: np.ndarray) -> np.ndarray:
    """Torque at the motor per torque added there, sine by sine, from the simulated difference equations."""
    answers = []
    for frequency in frequency_hz:
        blend = 1 - np.exp(-g.observer_bandwidth * TICK_S)
        momentum = blend * g.observer_inertia / TICK_S
        rate = integral = prediction = torque = 0j
        ticks = int(max(2.0, 20 / frequency) / TICK_S)
        ticks -= ticks % max(1, int(round(1 / frequency / TICK_S)))
        added = np.exp(2j * np.pi * frequency * TICK_S * np.arange(4 * ticks))
        total = np.zeros(4 * ticks, dtype=complex)
        for k, d in enumerate(added):
            auxiliary = prediction + blend * torque
            estimate_nm = auxiliary - momentum * rate
            prediction = (1 - blend) * auxiliary + blend * (momentum - g.observer_viscous) * rate
            torque = -g.proportional * rate + integral + (estimate_nm if g.observer_on else 0.0)
            integral -= TICK_S * g.integral * rate
            total[k] = torque + d
            rate += TICK_S / INERTIA * (torque + d)
        tail = slice(3 * ticks, None)
        answers.append(np.mean(total[tail] / added[tail]))
    return np.array(answers)


def test_step_numbers_of_a_second_order_system_are_those_of_the_textbook() -> None:
    damping, w = 0.5, 2 * np.pi * 10
    time_s = np.arange(0, 1, TICK_S)
    wd = w * np.sqrt(1 - damping**2)
    answer = 1 - np.exp(-damping * w * time_s) * (
        np.cos(wd * time_s) + damping / np.sqrt(1 - damping**2) * np.sin(wd * time_s)
    )
    demand = np.concatenate([np.zeros(100), np.ones(len(time_s))])
    found = analyse_step(demand, np.concatenate([np.zeros(100), answer]), TICK_S)
    assert found.overshoot_percent == pytest.approx(16.3, abs=0.2)
    assert found.rise_s == pytest.approx(0.026, abs=0.002)
    assert found.settling_s == pytest.approx(0.084, abs=0.01)
    assert found.final_error_rad_s == pytest.approx(0, abs=1e-4)


def test_a_record_without_a_step_is_refused() -> None:
    with pytest.raises(ValueError, match="contains no step"):
        analyse_step(np.zeros(100), np.zeros(100), TICK_S)


def stop_of(rate: float, deceleration: float, full_nm: float = 40.0, noise: float = 1e-3) -> tuple[Real, Real, Real]:
    """The torque is full from 2 ms after the command on, until a tenth of the rate is left."""
    time_s = TICK_S * np.arange(-30.0, 200.0)
    slowed = np.clip(deceleration * (time_s - 0.002), 0.0, abs(rate))
    joint = np.sign(rate) * (abs(rate) - slowed) + noise * np.random.default_rng(1).standard_normal(len(time_s))
    full = (time_s >= 0.002) & (slowed < 0.9 * abs(rate))
    torque: Real = np.where(full, -np.sign(rate) * full_nm, 0.5)
    return time_s.astype(np.float64), joint.astype(np.float64), torque


@pytest.mark.parametrize("rate", [0.5, -0.5])
def test_the_deceleration_of_a_stop_is_the_slope_at_full_torque(rate: float) -> None:
    found = analyse_stop(*stop_of(rate, 6.0), full_nm=40.0)
    assert found.rate_rad_s == pytest.approx(rate, abs=1e-3)
    assert found.deceleration_rad_s2 == pytest.approx(6.0, abs=4 * found.deviation_rad_s2)
    assert 0.0 < found.deviation_rad_s2 < 0.05
    assert found.full_torque_s == pytest.approx(0.075, abs=0.002)


def test_a_stop_whose_torque_was_not_full_for_ten_samples_is_refused_with_what_it_reached() -> None:
    time_s, joint, torque = stop_of(0.5, 60.0)
    with pytest.raises(MotionError, match="it reached 40 of 40 N m"):
        analyse_stop(time_s, joint, torque, full_nm=40.0)
    with pytest.raises(MotionError, match="it reached 30 of 40 N m"):
        analyse_stop(time_s, joint, 0.75 * torque, full_nm=40.0)


def test_the_weakest_stop_counts_less_the_share_of_the_wind_and_a_fifth() -> None:
    stops = [analyse_stop(*stop_of(0.5, a, noise=1e-6), full_nm=40.0) for a in (8.0, 6.0, 7.0)]
    assert sure_deceleration(stops, 40.0, 0.0) == pytest.approx(4.8, rel=1e-3)
    assert sure_deceleration(stops, 40.0, 10.0) == pytest.approx(3.6, rel=1e-3)
