# SPDX-License-Identifier: Apache-2.0
"""The controllers that the report compares."""

BASELINE = "pi"
COMPENSATED = "pi_vob_ftc"
DESIGNED = "least_error"
"""The compensated one with gains that the machine allows, where the others have the loop of 30 Hz."""
INGREDIENTS = ["pi", "pi_vob", "pi_ftc", "pi_vob_ftc", "pi_coulomb", "pi_best", "least_error"]
"""Order of the controllers in tables and charts."""
