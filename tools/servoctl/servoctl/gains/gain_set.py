# SPDX-License-Identifier: Apache-2.0
"""All gains of a device as one set: read, compared with a file, written from it, and stored with a backup. The commands
`save`, `diff`, `restore` and `store`, and the page, use it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import NotVerified, Refused
from ..link.device import Device
from ..objects.journal import Journal
from ..objects.parameter import AXES, Parameter, Value
from .gains_file import describe_difference, write_gains
from .tuning import Change, Tuning, staged_axes
from .tuning import store as store_on_device

Progress = Callable[[Parameter], None]


def _quiet(_parameter: Parameter) -> None:
    """Nobody looks."""


def about(device: Device) -> dict[str, Any]:
    """The table [device] of a gains file."""
    identity = device.identity()
    schema = identity["schema"]
    return {
        "name": identity["name"],
        "node": device.node_id,
        "serial": identity["serial"],
        "firmware": identity["firmware"] or identity["software"],
        "schema": None if schema is None else f"0x{schema:08X}",
    }


def of_axis(parameters: Iterable[Parameter], axis: str | None) -> list[Parameter]:
    """Those of one axis, or all."""
    return [p for p in parameters if axis is None or p.name.startswith(axis + ".")]


def read_values(device: Device, parameters: Iterable[Parameter], progress: Progress = _quiet) -> dict[Parameter, Value]:
    """Values from the device."""
    values: dict[Parameter, Value] = {}
    for parameter in parameters:
        values[parameter] = device.read(parameter)
        progress(parameter)
    return values


def read_to_save(device: Device, axis: str | None = None, progress: Progress = _quiet) -> dict[Parameter, Value]:
    """The active values; raises Refused when it is unclear which values to save."""
    pending = staged_axes(device)
    if pending:
        raise Refused(
            f"{_names(pending)}: the staged values differ from the active values, so it is unclear which to save. Run"
            " 'servoctl set --apply' or 'servoctl undo --staged' first."
        )
    return read_values(device, of_axis(device.schema.tunable, axis), progress)


def _names(axes: set[int]) -> str:
    return " and ".join(AXES[axis] for axis in sorted(axes))


@dataclass(frozen=True)
class Comparison:
    """Values of a file and of the device; `staged` are the axes whose staged values were compared."""

    wanted: dict[Parameter, Value]
    found: dict[Parameter, Value]
    absent: list[Parameter]
    staged: set[int]

    @property
    def different(self) -> dict[Parameter, Value]:
        """The file's values that the device does not have."""
        return {p: value for p, value in self.wanted.items() if self.found[p] != value}


def compare(device: Device, values: Mapping[Parameter, Value], axis: str | None = None, progress: Progress = _quiet) -> Comparison:
    """Of one axis or all."""
    wanted = {p: values[p] for p in of_axis(values, axis)}
    found = read_values(device, wanted, progress)
    absent = [p for p in of_axis(device.schema.tunable, axis) if p not in wanted]
    return Comparison(wanted, found, absent, staged_axes(device))


def restore(
    device: Device, comparison: Comparison, progress: Progress = _quiet, unlock: bool = False, override: bool = False
) -> list[Change]:
    """Stages what differs, applies once per axis, and reads all values of the file back."""
    changing = comparison.different
    changes = Tuning(device, "restore").write(changing, progress=progress, unlock=unlock, override=override) if changing else []
    for parameter, wanted in comparison.wanted.items():
        after = device.read(parameter)
        if after != wanted:
            raise NotVerified("after restoring, " + describe_difference(parameter, after, wanted) + ".")
    return changes


def store_with_backup(device: Device, on_backup: Callable[[Path, int], object] = lambda _path, _count: None) -> Path:
    """Writes a backup of all gains, calls `on_backup` with it and their number, then stores them on the device; returns the
    backup's path."""
    pending = staged_axes(device)
    if pending:
        raise Refused(
            f"{_names(pending)}: staged values are not active and would not be stored: apply or revert them first."
        )
    backup = Journal(device.node_id, device.serial_number()).backup_path()
    values = read_values(device, device.schema.tunable)
    write_gains(backup, values, about(device))
    on_backup(backup, len(values))
    store_on_device(device)
    return backup
