"""Options of the commands that follow something over time: track and follow."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from .motion import yes_options
from .quantity import DURATION, FASTEST_RATE

F = TypeVar("F", bound=Callable[..., Any])

PICTURES = (".png", ".svg", ".pdf")


def following_options(slews_to: str) -> Callable[[F], F]:
    """--slew-rate, --interval, --plot, --dry-run and --yes; `slews_to`: where the axes slew first."""

    def add(command: F) -> F:
        command = yes_options(command)
        for option in (
            click.option(
                "--plot", type=click.Path(path_type=Path, dir_okay=False), callback=_plot_file,
                help="PNG file for a plot of the error; a CSV file is saved beside it.",
            ),
            click.option(
                "--interval", type=DURATION, default="1", show_default=True, help="Time between the lines of output (s)."
            ),
            click.option(
                "--slew-rate", type=FASTEST_RATE, default="5", show_default=True, help=f"Rate to the {slews_to} (°/s)."
            ),
        ):  # fmt: skip
            command = option(command)
        return command

    return add


def _plot_file(context: click.Context, parameter: click.Parameter, path: Path | None) -> Path | None:
    """Refused before anything moves, not after the flight."""
    if path is None:
        return None
    if path.suffix.lower() not in PICTURES:
        raise click.BadParameter(f"'{path}' must end with {', '.join(PICTURES)}.", context, parameter)
    folder = next(parent for parent in path.absolute().parents if parent.exists())
    if not folder.is_dir() or not os.access(folder, os.W_OK):
        raise click.BadParameter(f"'{path}' cannot be written: {folder} is not a folder that you may write.", context, parameter)
    return path
