# SPDX-License-Identifier: Apache-2.0
"""Why there can be no release: one sentence."""

import sys
from collections.abc import Callable


class ReleaseError(Exception):
    """What is wrong, where, and what would be right."""


def run(main: Callable[[list[str]], None]) -> None:
    """A program of this folder: an error is one sentence."""
    try:
        main(sys.argv[1:])
    except (ReleaseError, OSError) as error:
        sys.exit(f"release: {error}")
