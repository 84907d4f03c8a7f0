# SPDX-License-Identifier: Apache-2.0
"""How the commands servoctl and imager start."""

import importlib
import sys


def start(module: str) -> None:
    """Runs `run` of this module. Ctrl-C while its libraries are still being read ends it as quietly as later."""
    try:
        command = importlib.import_module(module)
    except KeyboardInterrupt:
        sys.exit(130)
    command.run()
