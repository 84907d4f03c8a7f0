# SPDX-License-Identifier: Apache-2.0
"""Prints the coefficients of scalar_exp_minus (firmware/base/scalar.c): run it with build/venv/bin/python.

exp(r) = 1 + r + r^2 q(r) for |r| <= ln(2)/2, with the q of degree 4 whose largest relative error is smallest. The first
two coefficients are kept at 1, so that exp(0) is 1 and small arguments lose nothing.
"""

import numpy as np

from remez import Real, Remez

HALF_LN2 = np.log(Real(2)) / 2


def wanted(r: np.ndarray) -> np.ndarray:
    """(exp(r) - 1 - r) / r^2 by its Taylor series, which has no cancellation."""
    total, term = np.zeros_like(r), np.full_like(r, Real(1) / 2)
    for k in range(3, 24):
        total, term = total + term, term * r / k
    return total


def main() -> None:
    found = Remez(wanted, lambda r: r * r * np.exp(-r), -HALF_LN2, HALF_LN2, degree=4)
    print("q:", ", ".join(f"{c:.9g}f" for c in found.coefficients))
    print(f"largest relative error: {found.largest_error():.2g}")


if __name__ == "__main__":
    main()
