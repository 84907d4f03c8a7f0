# SPDX-License-Identifier: Apache-2.0
"""The controllers that the report compares."""

BASELINE = "pi"
COMPENSATED = "pi_vob_ftc"
INGREDIENTS = ["pi", "pi_vob", "pi_ftc", "pi_vob_ftc", "pi_coulomb", "pi_best"]
"""Order of the controllers in tables and charts."""
