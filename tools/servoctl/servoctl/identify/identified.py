# SPDX-License-Identifier: Apache-2.0
"""The identified parameters: result.json of `identify fit`, and the objects of an axis for them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..drive.drive import Drive
from ..errors import InputError
from ..link.device import Device
from ..objects.parameter import AXES, AXIS_SHIFT, Parameter, Value
from ..objects.schema import Schema
from ..units import degrees
from .identify_program import new_name, read_json
from .test_plan import Envelope

if TYPE_CHECKING:
    from pandas import DataFrame

FORMAT = "trackservo-identification"
NAMES = {
    "coulomb_positive": "Coulomb torque, positive", "breakaway_positive": "break-away torque, positive",
    "stribeck_speed_positive": "Stribeck speed, positive", "viscous_positive": "viscous coefficient, positive",
    "coulomb_negative": "Coulomb torque, negative", "breakaway_negative": "break-away torque, negative",
    "stribeck_speed_negative": "Stribeck speed, negative", "viscous_negative": "viscous coefficient, negative",
    "stiffness": "bristle stiffness σ0", "damping": "bristle damping σ1", "inertia": "inertia J",
}  # fmt: skip
"""Names of the parameters for people."""
OBJECTS = {
    "stiffness": [(0x2030, 5)], "damping": [(0x2030, 6)],
    "coulomb_positive": [(0x2030, 7)], "breakaway_positive": [(0x2030, 8)], "stribeck_speed_positive": [(0x2030, 9)],
    "viscous_positive": [(0x2030, 10)],
    "coulomb_negative": [(0x2030, 11)], "breakaway_negative": [(0x2030, 12)], "stribeck_speed_negative": [(0x2030, 13)],
    "viscous_negative": [(0x2030, 14)],
    "inertia": [(0x2020, 2), (0x2000, 5)],
}  # fmt: skip
"""Index of the first axis and sub-index of the object of each parameter."""


@dataclass(frozen=True)
class Estimate:
    """One parameter; `value` None when the data did not determine it, `paper` and `start` None when there is none."""

    name: str
    value: float | None
    unit: str
    low: float | None
    high: float | None
    paper: float | None

    @property
    def title(self) -> str:
        """For people."""
        return NAMES.get(self.name, self.name)

    @property
    def percent(self) -> float | None:
        """Half the width of the 95 % interval, of the value."""
        if not self.value or self.low is None or self.high is None:
            return None
        return 50.0 * (self.high - self.low) / abs(self.value)


    def row(self) -> tuple[str, str, str, str, str]:
        """For a table: parameter, value, half of the 95 % interval in %, by the paper's method, unit."""
        value = f"{self.value:.5g}" if self.value is not None else "not determined"
        percent = f"±{self.percent:.1f}" if self.percent is not None else "–"
        paper = f"{self.paper:.5g}" if self.paper is not None else "–"
        return self.title, value, percent, paper, self.unit


@dataclass(frozen=True)
class Identified:
    """A whole result; `data` is the file unchanged."""

    path: Path
    estimates: dict[str, Estimate]
    refused: list[tuple[str, str]]
    data: dict[str, Any]

    def value(self, name: str) -> float | None:
        """Of a parameter; None when it was refused."""
        return self.estimates[name].value

    def frame(self) -> DataFrame:
        """A row per parameter: value, ends of its 95 % interval, by the paper's method, unit; NaN where there is none. Needs
        pandas."""
        from ..show.frames import estimates_frame

        return estimates_frame(self)

    @property
    def warnings(self) -> list[str]:
        """Reasons to doubt the values found."""
        return [str(warning) for warning in self.data.get("warnings", [])]

    def check_machine(self, device: Device, axis: int) -> None:
        """Raises InputError when it is known to be of another axis or device."""
        machine = self.data.get("machine", {})
        name, serial = machine.get("axis", AXES[axis]), machine.get("serial", 0)
        if name != AXES[axis]:
            raise InputError(
                f"{self.path}: belongs to {name}, not to {AXES[axis]}: give the folder of {AXES[axis]} with"
                " --from."
            )
        if serial and serial != device.serial_number():
            raise InputError(
                f"{self.path}: belongs to the device with serial number {serial}, but this device has"
                f" {device.serial_number()}: identify this device first."
            )

    @property
    def travel_deg(self) -> tuple[float, float] | None:
        """The joint angles between which it was allowed to move."""
        travel = self.data.get("machine", {}).get("travel_deg")
        return (float(travel[0]), float(travel[1])) if isinstance(travel, list) and len(travel) == 2 else None

    def gains(self, schema: Schema, axis: int) -> dict[Parameter, Value]:
        """The objects of the axis that are known now, in the device's precision."""
        found: dict[Parameter, Value] = {}
        for name, places in OBJECTS.items():
            value = self.value(name)
            for index, sub in places:
                parameter = schema.by_index(index + AXIS_SHIFT * axis, sub)
                if value is not None and parameter is not None:
                    found[parameter] = parameter.check(self._consistent(name, value))
        return found | self.plant(schema, axis)

    def plant(self, schema: Schema, axis: int) -> dict[Parameter, Value]:
        """The object against which the device checks gains (2056); empty for an incomplete or older result, and for a
        device without it."""
        found: dict[Parameter, Value] = {}
        for row in self.data.get("plant", []):
            parameter = schema.by_index(int(row["index"], 0) + AXIS_SHIFT * axis, row["sub"])
            if parameter is not None:
                found[parameter] = parameter.check(row["value"])
        return found

    def _consistent(self, name: str, value: float) -> float:
        """The device accepts no break-away torque below the Coulomb torque; noise may give one."""
        coulomb = self.estimates.get(name.replace("breakaway", "coulomb"))
        if name.startswith("breakaway") and coulomb is not None and coulomb.value is not None:
            return max(value, coulomb.value)
        return value


def add_machine(path: Path, device: Device, axis: int, envelope: Envelope) -> None:
    """Adds the origin of the result to the file: axis, device, allowed travel, position of the other axis."""
    data = read_json(path, FORMAT)
    data["machine"] = {
        "axis": AXES[axis], "node": device.node_id, "serial": device.serial_number(),
        "travel_deg": [degrees(envelope.lowest_rad), degrees(envelope.highest_rad)],
        "other_axis_deg": degrees(Drive(device, 1 - axis).position()),
    }  # fmt: skip
    new = new_name(path)
    try:
        new.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
        new.replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}.") from error


def read_identified(path: Path) -> Identified:
    """Raises InputError when it is no result of `identify fit`."""
    data = read_json(path, FORMAT)
    try:
        estimates = {
            name: Estimate(
                name, row["value"], row["unit"], row["interval_95"][0], row["interval_95"][1], row["paper_method"]
            )
            for name, row in data["parameters"].items()
        }
        refused = [(row["parameter"], row["message"]) for row in data["refused"]]
        missing = [name for name in NAMES if name not in estimates]
    except (AttributeError, KeyError, TypeError, IndexError) as error:
        raise InputError(f"{path}: not a result of 'identify fit': {error!r}.") from error
    if missing:
        raise InputError(f"{path}: not a result of 'identify fit': {missing[0]} is missing.")
    return Identified(path, estimates, refused, data)
