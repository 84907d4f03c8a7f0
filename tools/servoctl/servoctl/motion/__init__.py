# SPDX-License-Identifier: Apache-2.0
"""Motions of a live axis: how they are planned, bounded, run and brought to rest."""
