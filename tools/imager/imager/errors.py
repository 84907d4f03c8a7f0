# SPDX-License-Identifier: Apache-2.0
"""What the user can repair: one sentence, exit code 2."""

from __future__ import annotations


class ImagerError(Exception):
    """What is wrong, where, and what would be right."""
