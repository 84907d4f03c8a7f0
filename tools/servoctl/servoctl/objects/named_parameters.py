# SPDX-License-Identifier: Apache-2.0
"""Parameters of a servo or of one of its axes by name: read, and changed all or none."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from ..errors import InputError
from ..gains import gain_set
from ..gains.trial_gains import TrialGains
from ..gains.tuning import Change, Tuning
from ..link.device import Device
from ..show.frames import need_pandas, parameter_frame
from ..wording import in_python
from .parameter import Parameter, Value

if TYPE_CHECKING:
    from pandas import DataFrame


class NamedParameters:
    """Those of a device; with an axis its own, whose names then need not begin with it."""

    def __init__(self, device: Device, axis: str | None) -> None:
        self.device = device
        self._axis = axis

    @in_python
    def parameter(self, name: str) -> Parameter:
        """What is known of the object of a name, or of any ending of it that is unique: index, unit, range, meaning. Raises
        InputError with suggestions."""
        found = self.device.schema.find(name, self._axis)
        self._check_mine(found)
        return found

    def _check_mine(self, parameter: Parameter) -> None:
        if self._axis is not None and not parameter.name.startswith(f"{self._axis}."):
            raise InputError(f"{parameter.name} is not a parameter of {self._axis}.")

    def read(self, name: str) -> Value:
        """The value that the device has, in the unit of the parameter."""
        return self.device.read(self.parameter(name))

    def __getitem__(self, name: str) -> Value:
        return self.read(name)

    @in_python
    def get(self, *names: str) -> DataFrame:
        """Values of parameters or of groups such as "speed_loop", all gains without a name: a row each, with unit, range and
        default."""
        need_pandas()
        schema = self.device.schema
        chosen = schema.select(names, self._axis) if names else gain_set.of_axis(schema.tunable, self._axis)
        for parameter in chosen:
            self._check_mine(parameter)
        return parameter_frame(gain_set.read_values(self.device, [p for p in chosen if p.readable]))

    @in_python
    def set(self, values: Mapping[str, Value], *, unlock: bool = False, override: bool = False) -> list[Change]:
        """Changes parameters, all or none: each value is checked (a text may have a unit: "5 deg/s"), then all are staged, applied
        once per axis, read back and noted in the journal. `undo` of the servo takes them back.

        `unlock` opens the access lock for guarded parameters, which can cause damage; both axes must be off. `override` applies
        gains that the device refuses as unstable. Raises InputError, Refused or NotVerified.
        """
        return Tuning(self.device, "set").write(self._checked(values), unlock=unlock, override=override)

    @contextlib.contextmanager
    def trial(self, values: Mapping[str, Value], *, unlock: bool = False) -> Iterator[None]:
        """Values as with `set`, for the time of a `with` block: at its end the old ones are in force again, whatever happens."""
        with in_python, TrialGains(self.device, "trial", self._checked(values), unlock):
            yield

    def _checked(self, values: Mapping[str, Value]) -> dict[Parameter, Value]:
        found: dict[Parameter, Value] = {}
        for name, value in values.items():
            parameter = self.parameter(name)
            if parameter in found:
                raise InputError(f"{parameter.name} is given twice: give it one value.")
            found[parameter] = parameter.wanted(value)
        if not found:
            raise InputError("nothing to set: expected names with values.")
        return found
