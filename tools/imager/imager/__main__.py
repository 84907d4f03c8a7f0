"""`python -m imager`, and the command that pip installs."""

import sys


def run() -> None:
    """Ctrl-C while the libraries are still being read ends it as quietly as later."""
    try:
        from .cli import run as run_command
    except KeyboardInterrupt:
        sys.exit(130)
    run_command()


if __name__ == "__main__":
    run()
