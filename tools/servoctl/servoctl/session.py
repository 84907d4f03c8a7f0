# SPDX-License-Identifier: Apache-2.0
"""Common parts of all commands: the common options, the device that they name, and the completion of names."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

import click
from click.shell_completion import CompletionItem

from .commands.quantity import Whole
from .errors import ServoctlError
from .link.bus import BIT_RATES, ENVIRONMENT, FORMS, bit_rate_of, parse_bus
from .link.device import Device
from .objects.access_lock import bytes_of
from .objects.parameter import AXES
from .objects.schema import Schema, named_file, need_schema
from .show.output import Output
from .show.output_files import check_new

F = TypeVar("F", bound=Callable[..., Any])


class Session:
    """The common options of one call."""

    def __init__(
        self, bus: str | None, node: int, bitrate: int, parameters: Path | None, as_json: bool, word: str | None = None
    ) -> None:
        self.bus = bus
        self.node = node
        self.bitrate = bitrate
        self.parameters = parameters
        self.word = word
        self.out = Output(as_json)

    def connect(self, node: int | None = None) -> Device:
        """Opens the bus and returns the node; close it with `with`."""
        if self.word is not None:
            bytes_of(self.word)  # refused before anything is sent
        device = Device(parse_bus(self.bus), node or self.node, self.parameters, self.bitrate)
        device.access_word = self.word
        return device

    @property
    def bus_is_given(self) -> bool:
        """By option; the environment does not count."""
        return _is_given("bus")

    def bit_rate(self) -> int | None:
        """Of the connection, in bit/s; None if neither the interface nor the option --bitrate says it."""
        return bit_rate_of(parse_bus(self.bus), self.bitrate) or (self.bitrate if _is_given("bitrate") else None)

    def check_bus(self) -> None:
        """Raises InputError when no valid bus is given."""
        parse_bus(self.bus)

    def check_new(self, paths: Iterable[Path], overwrite: bool, option: str, *inputs: Path) -> None:
        """As in `output_files`; the description of the device is an input, too."""
        description = named_file(self.parameters)
        check_new(paths, overwrite, option, [*inputs, *([description] if description else [])])

    def file_schema(self) -> Schema:
        """The best known parameters.json, without reading a device."""
        return need_schema(self.parameters)


def _is_given(option: str) -> bool:
    return click.get_current_context().get_parameter_source(option) is click.core.ParameterSource.COMMANDLINE


def common(command: F) -> F:
    """Adds the common options; the command gets a Session as its first argument."""

    @click.option("--bus", envvar=ENVIRONMENT, metavar="BUS", help=f"CAN bus: {FORMS} (environment: {ENVIRONMENT}).")
    @click.option(
        "--node", type=Whole(1, 127), default=1, envvar="SERVOCTL_NODE", show_default=True, help="Node id."
    )
    @click.option(
        "--bitrate",
        type=click.Choice([str(rate) for rate in BIT_RATES]),
        default="1000000",
        show_default=True,
        help="Bit rate in bit/s, for SLCAN adapters; a SocketCAN interface has its own.",
    )
    @click.option(
        "--parameters",
        type=click.Path(path_type=Path, dir_okay=False),
        metavar="FILE",
        help=(
            "parameters.json of the firmware (default: the file with the device's schema hash, included in"
            " servoctl or found)."
        ),
    )
    @click.option(
        "--word", metavar="WORD", envvar="SERVOCTL_WORD",
        help="Access word of the device, for guarded parameters, if its owner has set one (environment: SERVOCTL_WORD).",
    )  # fmt: skip
    @click.option("--json", "as_json", is_flag=True, help="Print results and errors as JSON.")
    @functools.wraps(command)
    def wrapped(
        *args: Any, bus: str | None, node: int, bitrate: str, parameters: Path | None, word: str | None,
        as_json: bool, **kwargs: Any,
    ) -> Any:  # fmt: skip
        return command(Session(bus, node, int(bitrate), parameters, as_json, word), *args, **kwargs)

    return wrapped  # type: ignore[return-value]


def axis_choice(meaning: str) -> Callable[[F], F]:
    """Adds --axis, None when it is not given."""
    return click.option("--axis", type=click.Choice(AXES), help=meaning)


axis_option = axis_choice("Axis of the names that do not contain one; without names, only this axis.")
only_axis_option = axis_choice("Only this axis.")


def unlock_option(command: F) -> F:
    """Adds --unlock, for commands that write parameters."""
    return click.option(
        "--unlock",
        is_flag=True,
        help=(
            "Allow writing guarded parameters, which can cause damage: motor (2055), identified"
            " plant (2056), protection limits (2060), board (3060)."
        ),
    )(command)


def override_option(command: F) -> F:
    """Adds --override-gain-check, for commands that apply gains."""
    return click.option(
        "--override-gain-check",
        "override",
        is_flag=True,
        help=(
            "Apply gains that the device refuses as unstable on its identified plant (2056). You then answer for the"
            " motion: the axis may shake with full torque until the oscillation monitor stops it."
        ),
    )(command)


def axis_number(axis: str | None) -> int:
    """0 azimuth (also when none is given), 1 pitch."""
    return AXES.index(axis) if axis else 0


class NameType(click.ParamType):  # type: ignore[type-arg] # not generic in click 8.1
    """The name of a parameter, completed from the known parameters.json."""

    name = "name"

    def __init__(self, assignment: bool = False) -> None:
        self.assignment = assignment

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        """Names that begin with, or otherwise contain, the typed text; groups first."""
        named = ctx.params.get("parameters")
        try:
            schema = need_schema(Path(named) if named else None)
        except ServoctlError:
            return []
        ending = "=" if self.assignment else ""
        usable = [p for p in schema if p.writable or not self.assignment]
        chosen = [p for p in usable if p.name.startswith(incomplete)] or [p for p in usable if incomplete in p.name]
        return [CompletionItem(p.name + ending, help=p.help) for p in chosen]
