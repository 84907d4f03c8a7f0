# SPDX-License-Identifier: Apache-2.0
"""`python -m servoctl`, and the command that pip installs."""

from servoctl.start import start


def run() -> None:
    """The entry point that pip installs."""
    start("servoctl.cli")


if __name__ == "__main__":
    run()
