# SPDX-License-Identifier: Apache-2.0
"""Changes gains as a whole: stage, apply once per axis, read back; all of it in the journal.

Object 0x2070 (+0x800): 1 command, 2 flags, 3 result, 4 and 5 CRC of the active and the persisted set, 6 to 9 refused value.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

from ..errors import InputError, NotVerified, Refused
from ..link.device import DEVICE_STATE, STORE_TIMEOUT_S, Device
from ..objects.access_lock import need_unlock, unlocked, without_equal_guarded
from ..objects.journal import Entry, Journal, now
from ..objects.parameter import AXES, AXIS_SHIFT, Parameter, Value
from ..objects.refusal import refusal_text
from ..objects.waiting_limits import refuse_waiting
from ..units import number

SET_OBJECT = 0x2070
APPLY, REVERT, UNDO, OVERRIDE = 1, 2, 3, 4
APPLY_TIMEOUT_S = 1.0
TURN_S = 3.0
"""That a write waits for that of another servoctl."""
INCOMPATIBLE = 0x06040043
RESULTS = {
    0: "taken", 1: "a value is not finite", 2: "a value is out of range", 3: "the values contradict each other",
    4: "the loops would be unstable on the identified plant, or a feedforward is beyond plant or motor",
}  # fmt: skip


@dataclass(frozen=True)
class SetState:
    """Object 0x2070 of one axis."""

    staged_differs: bool
    active_differs_from_stored: bool
    result: int
    active_crc: int
    stored_crc: int


@dataclass(frozen=True)
class Change:
    """Result of one write."""

    parameter: Parameter
    old: Value | None
    new: Value


def set_state(device: Device, axis: int) -> SetState | None:
    """None for a device that has no staged set."""
    if device.try_upload(SET_OBJECT + AXIS_SHIFT * axis, 2) is None:
        return None
    flags, result, active, stored = (device.axis_int(axis, SET_OBJECT, sub) for sub in (2, 3, 4, 5))
    return SetState(bool(flags & 1), bool(flags & 2), result, active, stored)


def command_set(device: Device, axis: int, command: int) -> None:
    """Apply, revert, undo, or apply without the check of stability; returns when the device has done it, raises Refused when it did not accept the set."""
    name = AXES[axis]
    try:
        device.axis_write(axis, SET_OBJECT, command, 1, sub=1)
    except Refused as error:
        reason = (refusal_text(device, axis) if error.abort == INCOMPATIBLE else None) or str(error)
        raise Refused(
            f"{name}: the parameter set was refused, the old set stays active: {reason}", error.abort
        ) from error
    deadline = device.clock.now() + APPLY_TIMEOUT_S
    while True:
        state = set_state(device, axis)
        applies = command in (APPLY, OVERRIDE)
        if state is None or (not state.staged_differs and (not applies or state.result == 0)):
            return
        if applies and state.result != 0:
            reason = RESULTS.get(state.result, f"result {state.result}")
            raise Refused(f"{name}: the parameter set was refused, the old set stays active: {reason}.")
        if device.clock.now() > deadline:
            raise NotVerified(f"{name}: the parameter set is not active {APPLY_TIMEOUT_S:g} s after the command.")
        time.sleep(0.005)


class Tuning:
    """Writes of one command, undone together."""

    def __init__(self, device: Device, command: str, undoes: str = "") -> None:
        self.device = device
        self.command = command
        self.journal = Journal(device.node_id, device.serial_number())
        self.undoes = undoes
        self.transaction = self.journal.new_transaction()

    def note(self, parameter: Parameter, old: Value | None, new: Value | None) -> None:
        """A line in the journal."""
        self.journal.add(
            Entry(
                now(),
                self.transaction,
                self.command,
                self.device.node_id,
                self.journal.serial,
                parameter.name,
                parameter.index,
                parameter.sub,
                old,
                new,
                parameter.unit,
                self.undoes,
            )  # fmt: skip
        )

    def refuse_foreign_stage(self, axes: set[int]) -> None:
        """Raises Refused when another client has staged values there: applying would put them into effect too."""
        for axis in sorted(axes):
            state = set_state(self.device, axis)
            if state is not None and state.staged_differs:
                raise Refused(
                    f"{AXES[axis]} has staged values that are not active, from this or another tool. 'servoctl set"
                    f" --apply --axis {AXES[axis]}' activates them, 'servoctl undo --staged --axis {AXES[axis]}'"
                    " discards them."
                )

    def write(
        self,
        values: Mapping[Parameter, Value],
        apply: bool = True,
        progress: Callable[[Parameter], None] | None = None,
        on_top: bool = False,
        unlock: bool = False,
        override: bool = False,
    ) -> list[Change]:
        """Stages all, applies once per axis, reads everything back.

        On the first refusal the staged values are withdrawn, and objects without staging get their old values, so that
        no part of it is in effect. `on_top` allows staging on values that are staged already. `unlock` opens the
        access lock, without which guarded values that differ are refused. `override` applies gains without the device's
        check of stability, which needs the lock, too.
        """
        self.journal.need()
        with self._turn():
            return self._write(values, apply, progress, on_top, unlock, override)

    @contextlib.contextmanager
    def _turn(self) -> Iterator[None]:
        """Between the check for staged values and the end no other servoctl stages any; raises Refused."""
        deadline = time.monotonic() + TURN_S
        with contextlib.closing(self.device.turns.lock("gains")) as lock:
            while not lock.try_alone():
                if time.monotonic() > deadline:
                    raise Refused("another servoctl is writing gains: write yours when it has finished.")
                time.sleep(0.02)
            yield

    def _write(
        self,
        values: Mapping[Parameter, Value],
        apply: bool,
        progress: Callable[[Parameter], None] | None,
        on_top: bool,
        unlock: bool,
        override: bool,
    ) -> list[Change]:
        axes = {p.axis for p in values if p.staged and p.axis is not None}
        if not on_top:
            self.refuse_foreign_stage(axes)
        old: dict[Parameter, Value | None] = {
            p: self.device.read(p) if p.readable and p.type != "DOMAIN" else None for p in values
        }
        differing = without_equal_guarded(values, old)
        if not unlock:
            need_unlock([p for p in differing if p.guarded])
        guarded = unlock and any(p.guarded for p in differing)
        applied = axes if apply else set()
        with unlocked(self.device, guarded or (override and bool(applied)), with_torque=not guarded):
            self._write_or_take_back(differing, old, applied, progress, OVERRIDE if override else APPLY)
        changes = [Change(p, old[p], self._read_back(p, values[p])) for p in values]
        for change in changes:
            self.note(change.parameter, change.old, change.new)
        return changes

    def _write_or_take_back(
        self,
        values: Mapping[Parameter, Value],
        old: Mapping[Parameter, Value | None],
        applied: set[int],
        progress: Callable[[Parameter], None] | None,
        command: int,
    ) -> None:
        staged = {p.axis for p in values if p.staged and p.axis is not None}
        done: list[Parameter] = []
        active: list[int] = []
        try:
            for parameter in sorted(values, key=lambda p: not p.staged):
                done.append(parameter)
                self.device.write(parameter, values[parameter])
                if progress:
                    progress(parameter)
            refuse_waiting(self.device, values)
            for axis in sorted(applied):
                command_set(self.device, axis, command)
                active.append(axis)
        except BaseException:
            self._take_back(active, staged | applied, [p for p in done if not p.staged], old)
            raise

    def _take_back(self, active: list[int], axes: set[int], unstaged: list[Parameter], old: Mapping[Parameter, Value | None]) -> None:
        for axis in active:
            self._quietly(lambda axis=axis: command_set(self.device, axis, UNDO))  # type: ignore[misc]
        for axis in axes:
            self._quietly(lambda axis=axis: command_set(self.device, axis, REVERT))  # type: ignore[misc]
        for parameter in unstaged:
            value = old[parameter]
            if value is not None:
                self._quietly(lambda p=parameter, v=value: self.device.write(p, v))  # type: ignore[misc]

    @staticmethod
    def _quietly(action: Callable[[], None]) -> None:
        try:
            action()
        except Exception:  # noqa: BLE001 - the first error is the one to report
            pass

    def _read_back(self, parameter: Parameter, wanted: Value) -> Value:
        if not parameter.readable or parameter.type == "DOMAIN":
            return wanted
        found = self.device.read(parameter)
        if found != parameter.decode(parameter.encode(wanted)):
            raise NotVerified(
                f"{parameter.name}: wrote {number(wanted)}, but the device has {number(found)} {parameter.unit}."
            )
        return found


def staged_axes(device: Device) -> set[int]:
    """Axes with staged values that are not in effect."""
    found = set()
    for axis in range(len(AXES)):
        state = set_state(device, axis)
        if state is not None and state.staged_differs:
            found.add(axis)
    return found


def undo_last(tuning: Tuning, unlock: bool = False) -> list[Change]:
    """Writes the values from before the newest transaction in the journal; raises Refused, and changes nothing, when
    another client has changed one of them since."""
    entries = tuning.journal.last_undoable()
    if not entries:
        raise InputError(f"{tuning.journal.path} contains nothing to undo.")
    tuning.undoes = entries[0].transaction
    schema = tuning.device.schema
    values: dict[Parameter, Value] = {}
    for entry in entries:
        parameter = schema.by_index(entry.index, entry.sub)
        if parameter is None or entry.old is None:
            raise InputError(f"{entry.name} from the journal is not an object of this device.")
        found = tuning.device.read(parameter)
        if found != entry.new:
            raise Refused(
                f"{entry.name} is now {number(found)}, but the journal's last write set it to"
                f" {number(entry.new)}: another client has changed it since. Set it with 'servoctl set' if you"
                " want the old value."
            )
        values[parameter] = entry.old
    return tuning.write(values, unlock=unlock)


def store(device: Device) -> None:
    """0x1010:1, and the CRC of the stored values read back; takes up to 5 s."""
    try:
        device.download(0x1010, 1, b"save", "store", STORE_TIMEOUT_S)
    except Refused as error:
        if error.abort != DEVICE_STATE:
            raise
        raise Refused(
            "The device does not store while an axis has torque: disable both axes first.", error.abort
        ) from error
    for axis in range(len(AXES)):
        state = set_state(device, axis)
        if state is not None and state.stored_crc != state.active_crc:
            raise NotVerified(
                f"{AXES[axis]}: the stored parameter set (CRC {state.stored_crc:08X}) differs from the active one"
                f" ({state.active_crc:08X})."
            )
