# SPDX-License-Identifier: Apache-2.0
"""Remez' exchange algorithm in long double: the polynomial whose largest weighted error is smallest."""

from collections.abc import Callable

import numpy as np

Real = np.longdouble
Curve = Callable[[np.ndarray], np.ndarray]


def solve(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Gauss' elimination: numpy's own knows no long double."""
    a, b = a.copy(), b.copy()
    for i in range(len(b)):
        pivot = i + int(np.argmax(np.abs(a[i:, i])))
        a[[i, pivot]], b[[i, pivot]] = a[[pivot, i]], b[[pivot, i]]
        for k in range(i + 1, len(b)):
            factor = a[k, i] / a[i, i]
            a[k], b[k] = a[k] - factor * a[i], b[k] - factor * b[i]
    x = np.zeros_like(b)
    for i in reversed(range(len(b))):
        x[i] = (b[i] - a[i, i + 1 :] @ x[i + 1 :]) / a[i, i]
    return x


class Remez:
    """`wanted` on [low, high] by a polynomial of `degree`; its error counts multiplied by `weight`."""

    def __init__(self, wanted: Curve, weight: Curve, low: float, high: float, degree: int) -> None:
        self.wanted, self.weight, self.degree = wanted, weight, degree
        self.x = np.linspace(Real(low), Real(high), 200001)
        middle, half = (Real(low) + Real(high)) / 2, (Real(high) - Real(low)) / 2
        points = middle + half * np.cos(np.pi * np.arange(degree + 2, dtype=Real) / (degree + 1))[::-1]
        for _ in range(20):
            exact = self._levelled(points)
            points = self._extremes(exact)
        self.coefficients = exact.astype(np.float32)
        """Rounded to single precision, the constant first."""

    def error(self, q: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Weighted, of the polynomial `q` in exact arithmetic."""
        return self.weight(x) * (np.polynomial.polynomial.polyval(x, q) - self.wanted(x))

    def largest_error(self) -> float:
        """Of the rounded coefficients."""
        return float(np.max(np.abs(self.error(self.coefficients.astype(Real), self.x))))

    def _levelled(self, points: np.ndarray) -> np.ndarray:
        """The polynomial whose error has the same size at all points, with alternating signs."""
        weight = self.weight(points)
        columns = [weight * points**k for k in range(self.degree + 1)]
        signs = Real(-1) ** np.arange(len(points))
        return solve(np.stack([*columns, signs], axis=1), weight * self.wanted(points))[:-1]

    def _extremes(self, q: np.ndarray) -> np.ndarray:
        """Where the error is largest between its changes of sign."""
        error = self.error(q, self.x)
        runs = np.split(np.arange(len(self.x)), np.flatnonzero(np.diff(np.sign(error))) + 1)
        peaks = sorted((run[np.argmax(np.abs(error[run]))] for run in runs), key=lambda i: -abs(error[i]))
        return self.x[np.sort(peaks[: self.degree + 2])]
