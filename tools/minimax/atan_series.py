# SPDX-License-Identifier: Apache-2.0
"""Prints the coefficients of scalar_atan2 (firmware/base/scalar.c): run it with build/venv/bin/python.

atan(z) = z + z s q(s) with s = z^2, for |z| <= tan(pi / 8), with the q of degree 3 whose largest relative error is
smallest. The first coefficient is kept at 1, so that small angles lose nothing.
"""

import numpy as np

from remez import Real, Remez

END = (np.sqrt(Real(2)) - 1) ** 2


def wanted(s: np.ndarray) -> np.ndarray:
    """(atan(z) / z - 1) / s by its series: sum of (-1)^k s^(k-1) / (2 k + 1)."""
    return sum((Real(-1) ** k * s ** (k - 1) / (2 * k + 1) for k in range(1, 40)), start=np.zeros_like(s))


def main() -> None:
    found = Remez(wanted, lambda s: s / (1 + s * wanted(s)), 0.0, END, degree=3)
    print("q:", ", ".join(f"{c:.9g}f" for c in found.coefficients))
    print(f"largest relative error: {found.largest_error():.2g}")


if __name__ == "__main__":
    main()
