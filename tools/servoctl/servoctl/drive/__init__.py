# SPDX-License-Identifier: Apache-2.0
"""An axis as a CiA 402 drive: its state, its power, its limits."""
