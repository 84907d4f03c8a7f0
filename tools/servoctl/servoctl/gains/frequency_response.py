# SPDX-License-Identifier: Apache-2.0
"""A multisine as set-point, the frequency response from demand to response, and the margins of a loop.

Response by the H1 estimator over Hann-windowed, half overlapping periods; coherence is the share of the response that
the demand explains. Sines lie at least four bins apart, so that the window does not mix them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

LINE_SPACING_BINS = 4
KNEE_HZ = 10.0
"""Above this the sines become smaller as 1/f: there the torque is the limit, not the rate."""
GOOD_COHERENCE = 0.8
GOOD_LOOP_ERROR = 0.2
"""An open loop is trusted where its relative error, that of the closed one times |1 + L|, is below this."""


@dataclass(frozen=True)
class Multisine:
    """Sines at `frequency_hz` with `amplitude` (of the whole's peak 1) and `phase_rad`; repeats after `period_s`."""

    frequency_hz: Real
    amplitude: Real
    phase_rad: Real
    period_s: float

    def at(self, time_s: NDArray[np.floating[Any]]) -> Real:
        """The signal; its largest magnitude is 1."""
        angle = 2 * np.pi * np.outer(time_s, self.frequency_hz) + self.phase_rad
        return np.asarray(np.cos(angle) @ self.amplitude, dtype=np.float64)


def design_multisine(low_hz: float, high_hz: float, lines: int) -> Multisine:
    """About `lines` sines, evenly spread over log frequency, with phases (Schroeder) that keep the peak low."""
    period_s = LINE_SPACING_BINS / low_hz
    wanted = np.geomspace(low_hz, high_hz, lines) * period_s
    bins: list[int] = []
    for value in wanted:
        candidate = int(round(value))
        if not bins or candidate - bins[-1] >= LINE_SPACING_BINS:
            bins.append(candidate)
    frequency = np.array(bins) / period_s
    amplitude = 1.0 / np.maximum(1.0, frequency / KNEE_HZ)
    power = np.cumsum(amplitude**2) / np.sum(amplitude**2)
    phase = -2 * np.pi * np.concatenate([[0.0], np.cumsum(power[:-1])]) * len(bins) / 2
    shape = Multisine(frequency, amplitude, phase, period_s)
    peak = float(np.max(np.abs(shape.at(np.arange(0.0, period_s, 2e-4)))))
    return Multisine(frequency, amplitude / peak, phase, period_s)


@dataclass(frozen=True)
class Response:
    """y over u at some frequencies, and the coherence (0 to 1)."""

    frequency_hz: Real
    value: Complex
    coherence: Real
    averages: int

    @property
    def relative_error(self) -> Real:
        """One standard deviation of the value, relative to it, from the coherence (Bendat and Piersol)."""
        share = np.clip(self.coherence, 1e-12, 1.0)
        return np.asarray(np.sqrt((1.0 - share) / (2.0 * self.averages * share)))


def estimate(demand: Real, answer: Real, sample_s: float, sine: Multisine) -> Response:
    """H1 at the sines' frequencies; needs at least two periods."""
    length = int(round(sine.period_s / sample_s))
    if len(demand) < 2 * length:
        raise ValueError(f"{len(demand)} samples are less than two periods of {length}")
    window = np.hanning(length + 1)[:-1]
    bins = np.round(sine.frequency_hz * length * sample_s).astype(int)
    uu, yy = np.zeros(len(bins)), np.zeros(len(bins))
    uy = np.zeros(len(bins), dtype=np.complex128)
    for start in range(0, len(demand) - length + 1, length // 2):
        u = demand[start : start + length]
        y = answer[start : start + length]
        fu = np.fft.rfft((u - u.mean()) * window)[bins]
        fy = np.fft.rfft((y - y.mean()) * window)[bins]
        uu += np.abs(fu) ** 2
        yy += np.abs(fy) ** 2
        uy += np.conj(fu) * fy
    coherence = np.abs(uy) ** 2 / np.maximum(uu * yy, 1e-300)
    return Response(sine.frequency_hz, np.asarray(uy / np.maximum(uu, 1e-300)), coherence, len(demand) // length)


def open_loop_is_sharp(closed: Response, loop: Complex) -> NDArray[np.bool_]:
    """Where the open loop computed from a closed one is known well enough."""
    error = closed.relative_error * np.abs(1 + loop)
    return np.asarray((closed.coherence >= GOOD_COHERENCE) & (error < GOOD_LOOP_ERROR))


@dataclass(frozen=True)
class Margins:
    """None: not within the measured frequencies. `sensitivity` is the largest 1 / |1 + L|, the modulus margin's inverse."""

    crossover_hz: float | None
    phase_margin_deg: float | None
    phase_crossover_hz: float | None
    gain_margin_db: float | None
    sensitivity: float | None


def margins(frequency_hz: Real, loop: Complex) -> Margins:
    """Of an open loop; the least phase margin over all crossings of 0 dB, the least gain margin over those of -180°."""
    gain_db = 20 * np.log10(np.abs(loop))
    phase = branch(np.degrees(np.unwrap(np.angle(loop))), gain_db)
    phases = [(f, 180.0 + p) for f, p in _crossings(frequency_hz, gain_db, phase, 0.0)]
    gains = [(f, -g) for f, g in _crossings(frequency_hz, phase, gain_db, -180.0) if g < 0]
    crossover, phase_margin = min(phases, key=lambda pair: pair[1]) if phases else (None, None)
    phase_crossover, gain_margin = min(gains, key=lambda pair: pair[1]) if gains else (None, None)
    return Margins(crossover, phase_margin, phase_crossover, gain_margin, float(np.max(1 / np.abs(1 + loop))))


def branch(phase_deg: Real, gain_db: Real) -> Real:
    """Moves a continuous phase by whole turns so that it lies in -360° to 0° at the last crossing of 0 dB.

    Low frequencies do not determine the branch: with two or three integrators the phase begins at -180° or -270°.
    """
    above = np.flatnonzero(gain_db >= 0)
    anchor = int(above[-1]) if above.size else 0
    return np.asarray(phase_deg - 360.0 * np.ceil(phase_deg[anchor] / 360.0), dtype=np.float64)


def _crossings(frequency_hz: Real, falling: Real, other: Real, level: float) -> list[tuple[float, float]]:
    """(frequency, other) where `falling` passes a level downwards; linear over log frequency."""
    found = []
    above = falling >= level
    for i in np.flatnonzero(above[:-1] & ~above[1:]):
        share = (falling[i] - level) / (falling[i] - falling[i + 1])
        log_f = np.log(frequency_hz[i]) + share * np.log(frequency_hz[i + 1] / frequency_hz[i])
        found.append((float(np.exp(log_f)), float(other[i] + share * (other[i + 1] - other[i]))))
    return found


def bandwidth_hz(frequency_hz: Real, closed: Complex, level_db: float = -3.0) -> float | None:
    """Where the closed loop first falls below `level_db`; None when it does not."""
    gain_db = 20 * np.log10(np.abs(closed))
    found = _crossings(frequency_hz, gain_db, gain_db, level_db)
    return found[0][0] if found else None


def peak_db(closed: Complex) -> float:
    """Largest gain of the closed loop, dB."""
    return float(20 * np.log10(np.max(np.abs(closed))))
