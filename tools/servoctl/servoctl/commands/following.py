# SPDX-License-Identifier: Apache-2.0
"""Options of the commands that follow something over time, track and follow, and the files of their plots."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click
import numpy as np
from numpy.typing import NDArray

from ..motion.moves import SLEW_RATE_DEG_S
from ..session import Session
from ..show.output_files import overwrite_option, unused
from .motion import yes_options
from .quantity import DURATION, FASTEST_RATE

F = TypeVar("F", bound=Callable[..., Any])
Real = NDArray[np.float64]

PICTURES = (".png", ".svg", ".pdf")
TABLE = ".csv"


def following_options(slews_to: str) -> Callable[[F], F]:
    """--slew-rate, --interval, --plot, --overwrite, --dry-run and --yes; `slews_to`: where the axes slew first."""

    def add(command: F) -> F:
        command = overwrite_option(yes_options(command))
        for option in (
            click.option(
                "--plot", type=click.Path(path_type=Path, dir_okay=False), callback=_plot_file,
                help="PNG file for a plot of the error; a CSV file is saved beside it.",
            ),
            click.option(
                "--interval", type=DURATION, default="1", show_default=True, help="Time between the lines of output (s)."
            ),
            click.option(
                "--slew-rate", type=FASTEST_RATE, default=f"{SLEW_RATE_DEG_S:g}", show_default=True, help=f"Rate to the {slews_to} (°/s)."
            ),
        ):  # fmt: skip
            command = option(command)
        return command

    return add


def _plot_file(context: click.Context, parameter: click.Parameter, path: Path | None) -> Path | None:
    """Refused before anything moves, not after the flight."""
    if path is not None and path.suffix.lower() not in PICTURES:
        raise click.BadParameter(f"'{path}' must end with {', '.join(PICTURES)}.", context, parameter)
    return path


def check_plot(session: Session, plot: Path | None, overwrite: bool, *inputs: Path) -> None:
    """Raises InputError when the plot, or the CSV file beside it, must not be written."""
    if plot is not None:
        session.check_new([plot, plot.with_suffix(TABLE)], overwrite, "--plot", *inputs)


def save_errors(
    plot: Path, overwrite: bool, title: str, time_s: Real, errors_urad: Mapping[str, Real],
    states: Mapping[str, Sequence[tuple[float, float]]] | None = None,
) -> list[str]:  # fmt: skip
    """The plot and the CSV file; their names, which are others if files have come since `check_plot`."""
    from ..plots import errors_figure, save, write_csv

    plot = plot if overwrite else unused(plot, TABLE)
    save(errors_figure(title, time_s, errors_urad, states), plot)
    write_csv(plot.with_suffix(TABLE), {"time_s": time_s, **{f"{name}_error_urad": error for name, error in errors_urad.items()}})
    return [str(plot), str(plot.with_suffix(TABLE))]
