# SPDX-License-Identifier: Apache-2.0
"""Gains: files of them, the speed loop that they make, and tuning on the live axis."""
