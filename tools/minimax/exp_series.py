"""Prints the coefficients of scalar_exp_minus (firmware/base/scalar.c): run it with build/venv/bin/python.

exp(r) = 1 + r + r^2 q(r) for |r| <= ln(2)/2, with the q of degree 4 whose largest relative error is smallest, found by
Remez' exchange algorithm in long double. The first two coefficients are kept at 1, so that exp(0) is 1 and small
arguments lose nothing.
"""

import numpy as np

Real = np.longdouble
DEGREE = 4
HALF_LN2 = np.log(Real(2)) / 2


def wanted(r: np.ndarray) -> np.ndarray:
    """(exp(r) - 1 - r) / r^2 by its Taylor series, which has no cancellation."""
    total, term = np.zeros_like(r), np.full_like(r, Real(1) / 2)
    for k in range(3, 24):
        total, term = total + term, term * r / k
    return total


def relative_error(q: np.ndarray, r: np.ndarray) -> np.ndarray:
    return r * r * (np.polynomial.polynomial.polyval(r, q) - wanted(r)) * np.exp(-r)


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


def levelled(points: np.ndarray) -> np.ndarray:
    """The q whose error has the same size at all points, with alternating signs."""
    weight = points * points * np.exp(-points)
    columns = [weight * points**k for k in range(DEGREE + 1)]
    signs = Real(-1) ** np.arange(len(points))
    return solve(np.stack([*columns, signs], axis=1), weight * wanted(points))[:-1]


def extremes(q: np.ndarray) -> np.ndarray:
    """Where the error is largest between its changes of sign."""
    r = np.linspace(-HALF_LN2, HALF_LN2, 200001, dtype=Real)
    error = relative_error(q, r)
    runs = np.split(np.arange(len(r)), np.flatnonzero(np.diff(np.sign(error))) + 1)
    peaks = sorted((run[np.argmax(np.abs(error[run]))] for run in runs), key=lambda i: -abs(error[i]))
    return r[np.sort(peaks[: DEGREE + 2])]


def main() -> None:
    points = HALF_LN2 * np.cos(np.pi * np.arange(DEGREE + 2, dtype=Real) / (DEGREE + 1))[::-1]
    for _ in range(20):
        q = levelled(points)
        points = extremes(q)
    rounded = q.astype(np.float32)
    r = np.linspace(-HALF_LN2, HALF_LN2, 200001, dtype=Real)
    print("q:", ", ".join(f"{c:.9g}f" for c in rounded))
    print(f"largest relative error: {np.max(np.abs(relative_error(rounded.astype(Real), r))):.2g}")


if __name__ == "__main__":
    main()
