# SPDX-License-Identifier: Apache-2.0
"""Identification of an axis: the test plan, its execution, and the results."""
