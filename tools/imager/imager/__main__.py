# SPDX-License-Identifier: Apache-2.0
"""`python -m imager`, and the command that pip installs."""

from servoctl.start import start


def run() -> None:
    """The entry point that pip installs."""
    start("imager.cli")


if __name__ == "__main__":
    run()
