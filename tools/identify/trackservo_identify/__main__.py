# SPDX-License-Identifier: Apache-2.0
"""`python -m trackservo_identify`, and the command that pip installs."""

import os
import sys

from trackservo_identify import PROGRAM


def run() -> None:
    """The entry point that pip installs: becomes the program."""
    try:
        os.execv(PROGRAM, [PROGRAM.name, *sys.argv[1:]])
    except OSError as error:
        sys.exit(f"{PROGRAM}: cannot be run: {error.strerror}.")


if __name__ == "__main__":
    run()
