# SPDX-License-Identifier: Apache-2.0
"""What a page can ask for, run by the thread of the bus. Each job uses the library as the command of the same name does."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from ..drive import power
from ..drive.drive import Drive
from ..drive.node_limits import limits_data, read_limits
from ..errors import InputError, MotionError
from ..gains import gain_set
from ..gains.frequency_response import branch, margins, peak_db
from ..gains.gains_file import GainsFile, gains_text
from ..gains.loop_model import Complex, read_gains
from ..gains.loop_test import LoopStimulus, MeasuredLoop, loop_stimulus, measure_loop
from ..gains.tuning import REVERT, SetState, Tuning, command_set, set_state, undo_last
from ..link.device import Device
from ..motion import tracking
from ..motion.cable_wrap import AZIMUTH, lasting_cue
from ..motion.limits import Limits, Plan
from ..motion.moves import plan_data, plan_to
from ..motion.rate_run import Progress, send_rates
from ..motion.shapes import SETPOINT_TICKS as SHAPE_TICKS
from ..motion.shapes import plan_shape
from ..motion.step_test import SETPOINT_TICKS, StepRecord, cut_steps, disturbed_text, plan_step
from ..objects.access_lock import lock_state
from ..objects.fault_log import as_json, read_log
from ..objects.fault_state import read_faults
from ..objects.fault_table import find_faults
from ..objects.parameter import AXES, Parameter, Value
from ..objects.schema import Schema
from ..show import capture
from ..units import TICK_S, Shown, degrees, number, radians
from .commission import Commission
from .held_axis import ANY, HeldAxis, follow

if TYPE_CHECKING:
    from .engine import Engine

BODE_LINES = 50
ATTEMPTS = 3
"""To read a set that nobody changes meanwhile."""
PLACE_DEG = 0.5
"""By so much an axis may have left the place that a motion was planned for."""
COMMAND = "ui"
"""In the journal."""


class Jobs:
    """Angles in °, rates in °/s, as people read them."""

    def __init__(self, engine: Engine, device: Device, held: dict[int, HeldAxis]) -> None:
        self._engine = self.engine = engine
        self._device = device
        self._held = self.held = held
        self._in_force: dict[str, Value] = {}
        self._stored: dict[str, Value] = {}
        self._crcs: dict[int, tuple[int, int]] = {}
        """Of the active and the stored set, when they were read."""
        self._loops = self._engine.loops
        self._signals: dict[int, str] = {}
        self.commission = Commission(self, device)

    # --- motion ---------------------------------------------------------------------------------------------------

    def enable(self, axis: int) -> None:
        """Enables and holds the axis."""
        if axis in self._held:
            return
        if str(self._device.node.nmt.state).lower() != "operational":
            self._device.set_nmt("operational")  # stays so: the samples come while it is
        held = HeldAxis(self._device, axis)
        held.enter()
        self._held[axis] = held
        self._engine.say(f"{AXES[axis]} enabled", "good")

    def disable(self, axis: int) -> None:
        """Stops on the ramp and removes the torque."""
        if axis in self._held:
            failed = self._engine.leave(axis)
            if failed is not None:
                raise failed
        else:
            Drive(self._device, axis).disable()
        self._engine.say(f"{AXES[axis]} disabled")

    def reset(self, axis: int) -> None:
        """Resets a fault."""
        Drive(self._device, axis).reset_fault()
        self._engine.say(f"{AXES[axis]}: fault reset", "good")

    def start_node(self) -> None:
        """NMT: operational."""
        self._device.set_nmt("operational")

    def _need(self, axis: int) -> HeldAxis:
        if axis not in self._held:
            raise MotionError(f"{AXES[axis]} is not enabled here: enable it first.")
        return self._held[axis]

    def _drive(self, axis: int) -> Drive:
        """That of the axis, which counts its turns while it is held."""
        return self._held[axis].drive if axis in self._held else Drive(self._device, axis)

    def jog(self, axis: int, rate_deg_s: float) -> None:
        """Runs as long as the page says that the button is held."""
        if rate_deg_s == 0.0:
            raise InputError("the rate of a jog must not be 0.")
        self._need(axis).jog(radians(rate_deg_s))

    def release(self, axis: int) -> None:
        """Ends a jog."""
        if axis in self._held:
            self._held[axis].release()

    def plan(self, axis: int, relative: bool, angle_deg: float, rate_deg_s: float) -> dict[str, Any]:
        """What a move would do; raises InputError when the node does not allow it."""
        drive = self._drive(axis)
        here = drive.position()
        target = here + radians(angle_deg) if relative else radians(angle_deg)
        found = self._checked(drive, here, target, radians(rate_deg_s))
        return plan_data(found) | {
            "from_deg": number_of_degrees(here), "target_deg": angle_deg if not relative else number_of_degrees(target)
        }  # fmt: skip

    @staticmethod
    def _still_at(drive: Drive, from_deg: float | None) -> float:
        """The position, rad, which must be the one that a plan was made for, if any; raises MotionError."""
        here = drive.position()
        if from_deg is not None and abs(degrees(here) - from_deg) > PLACE_DEG:
            raise MotionError(
                f"{drive.name} has moved since this was planned, from {from_deg:.3f}° to {degrees(here):.3f}°: nothing moves; plan"
                " it again."
            )
        return here

    @staticmethod
    def _checked(drive: Drive, here: float, target: float, rate: float) -> Plan:
        if not rate > 0.0:
            raise InputError("the rate must be greater than 0.")
        found = plan_to(drive.name, here, target, rate)
        found.check(ANY, drive)
        return found

    def move(self, axis: int, target_deg: float, rate_deg_s: float, from_deg: float) -> None:
        """To an angle, from the one that it was planned for."""
        held = self._need(axis)
        self._checked(held.drive, self._still_at(held.drive, from_deg), radians(target_deg), radians(rate_deg_s))
        held.move([radians(target_deg)], radians(rate_deg_s))

    def swing(self, axis: int, travel_deg: float, rate_deg_s: float, from_deg: float | None = None) -> None:
        """Back and forth between here, where it was planned unless that is None, and an angle away, until it is stopped or
        another motion begins."""
        held = self._need(axis)
        here = self._still_at(held.drive, from_deg)
        target = here + radians(travel_deg)
        self._checked(held.drive, here, target, radians(rate_deg_s))
        held.move([target, here], radians(rate_deg_s), forever=True)

    def hold(self, axis: int) -> None:
        """Ends a motion on its ramp; the axis stays enabled."""
        self._need(axis).rest()

    # --- tracking -------------------------------------------------------------------------------------------------

    def _cue(self, angles_deg: list[float], target_rate_deg_s: float | None) -> tuple[list[float], str]:
        """Angles in rad; of azimuths a revolution apart the one that lasts longest, as with `servoctl track --cue`."""
        angles = [radians(angle) for angle in angles_deg]
        rate = None if target_rate_deg_s is None else radians(target_rate_deg_s)
        angles[AZIMUTH], why = lasting_cue(Drive(self._device, AZIMUTH), angles[AZIMUTH], rate)
        return angles, why

    def cue(
        self, angles_deg: list[float], rate_deg_s: float, target_rate_deg_s: float | None, from_deg: list[float]
    ) -> None:  # fmt: skip
        """Both axes to angles at once, from those that it was planned for."""
        both = [self._need(axis) for axis in range(len(AXES))]
        angles, _ = self._cue(angles_deg, target_rate_deg_s)
        for held, target, place in zip(both, angles, from_deg, strict=True):
            held.need_rest()
            self._checked(held.drive, self._still_at(held.drive, place), target, radians(rate_deg_s))
        for held, target in zip(both, angles, strict=True):
            held.move([target], radians(rate_deg_s))

    def plan_cue(self, angles_deg: list[float], rate_deg_s: float, target_rate_deg_s: float | None) -> list[dict[str, Any]]:
        """What a cue would do; raises InputError when the node does not allow it."""
        drives = [self._drive(axis) for axis in range(len(AXES))]
        angles, why = self._cue(angles_deg, target_rate_deg_s)
        rate = radians(rate_deg_s)
        places = [drive.position() for drive in drives]
        plans = [
            plan_data(self._checked(drive, here, target, rate)) | {"from_deg": number_of_degrees(here)}
            for drive, here, target in zip(drives, places, angles, strict=True)
        ]
        plans[AZIMUTH]["text"] += why
        return plans

    def follow(self, camera_id: str, places_deg: dict[int, float]) -> list[str]:
        """The enabled axes follow what the camera sees, as with `servoctl track`; their names. `places_deg` are the places of
        the axes that it was planned for. Without an identifier the node must have a mapping of its own."""
        if not self._held:
            raise MotionError("no axis is enabled here: enable those that shall follow.")
        if self._held.keys() != places_deg.keys():
            raise MotionError("other axes are enabled than when this was planned: nothing moves; plan it again.")
        identifier = tracking.parse_identifier(camera_id) if camera_id else None
        chosen = [self._held[axis] for axis in sorted(self._held)]
        for held in chosen:
            tracking.check_supported(self._device, held.drive.axis)
            held.need_rest()
            held.release()
            self._still_at(held.drive, places_deg[held.drive.axis])
        self._engine.map_camera(self._device, identifier)
        tracking.check_frames(self._device, identifier, tracking.FIRST_FRAME_S)
        follow(chosen)
        names = [held.drive.name for held in chosen]
        self._engine.say(f"{' and '.join(names)}: following the target of the camera")
        return names

    def plan_follow(self) -> list[dict[str, Any]]:
        """Where the enabled axes are, and the limits of the node within which they would follow, °."""
        drives = [self._held[axis].drive for axis in sorted(self._held)]
        return [{"axis": drive.name, "here_deg": degrees(drive.position()), **limits_data(read_limits(drive))} for drive in drives]

    def end_follow(self) -> None:
        """The axes stop on their ramps, and stay enabled."""
        for held in self._held.values():
            if held.follows:
                held.rest()

    # --- measurements -----------------------------------------------------------------------------------------------

    def progress(self, axis: int, what: str, duration_s: float) -> Progress:
        """For a measurement: the page shows how far it is, and the rate of the axis."""
        return lambda passed_s, rate_rad_s: self._engine.measured(
            axis, rate_rad_s, f"{what}: {100 * min(passed_s / duration_s, 1.0):.0f} %"
        )

    # --- step ----------------------------------------------------------------------------------------------------------

    def plan_step(self, axis: int, amplitude_deg_s: float, hold_s: float) -> dict[str, Any]:
        """What a step would do; raises InputError when the node does not allow it."""
        planned = plan_step(AXES[axis], radians(amplitude_deg_s), hold=hold_s)
        planned.plan.check(ANY, Drive(self._device, axis))
        return plan_data(planned.plan)

    def step(self, axis: int, amplitude_deg_s: float, hold_s: float) -> dict[str, Any]:
        """Measures a step of the rate, forward and backward, as `servoctl step`. The axis is off before and after it."""
        if self._held:
            raise MotionError("a step needs the stream and both axes at rest: disable the axes first.")
        planned = plan_step(AXES[axis], radians(amplitude_deg_s), hold=hold_s)
        plan, total = planned.plan, len(planned.rates) * TICK_S
        plan.check(ANY, Drive(self._device, axis))
        limits = Limits(plan.rate_rad_s, plan.forward_rad + plan.backward_rad, plan.duration_s)
        with self._engine.without_stream(self._device, {axis: power.CYCLIC_VELOCITY}):
            run = send_rates(
                self._device, axis, planned.rates, SETPOINT_TICKS, limits, interpolation=1,
                progress=self.progress(axis, "step", total),
            )  # fmt: skip
        records = cut_steps(run, hold_s)
        self._engine.say(f"{AXES[axis]}: step measured")
        return {"axis": AXES[axis], "lost": run.lost, "note": disturbed_text(records, planned, run), "steps": [_step(record) for record in records]}

    def plan_shape(self, axis: int, shape: str, travel_deg: float, period_s: float, periods: int) -> dict[str, Any]:
        """What a reference shape would do; raises InputError when the node does not allow it."""
        plan = plan_shape(AXES[axis], shape, radians(travel_deg), period_s, periods).plan
        plan.check(ANY, Drive(self._device, axis))
        return plan_data(plan)

    def shape(self, axis: int, shape: str, travel_deg: float, period_s: float, periods: int) -> dict[str, Any]:
        """Demanded and measured rate during a reference shape. The axis is off before and after it, as for a step."""
        if self._held:
            raise MotionError("a reference shape needs the stream and both axes at rest: disable the axes first.")
        planned = plan_shape(AXES[axis], shape, radians(travel_deg), period_s, periods)
        plan = planned.plan
        plan.check(ANY, Drive(self._device, axis))
        limits = Limits(plan.rate_rad_s, plan.forward_rad + plan.backward_rad, plan.duration_s)
        with self._engine.without_stream(self._device, {axis: power.CYCLIC_VELOCITY}):
            run = send_rates(
                self._device, axis, planned.rates, SHAPE_TICKS, limits,
                progress=self.progress(axis, shape, plan.duration_s),
            )  # fmt: skip
        self._engine.say(f"{AXES[axis]}: {shape} done")
        error = degrees(1) * (run.demand - run.answer)
        return {
            "axis": AXES[axis], "shape": shape, "lost": run.lost, "time_ms": (1e3 * TICK_S * np.arange(len(run.demand))).tolist(),
            "demand_deg_s": (degrees(1) * run.demand).round(6).tolist(), "rate_deg_s": (degrees(1) * run.answer).round(6).tolist(),
            "rms_deg_s": float(np.sqrt(np.mean(error**2))), "largest_deg_s": float(np.max(np.abs(error))),
        }  # fmt: skip

    # --- the speed loop in the frequency domain ---------------------------------------------------------------------

    @staticmethod
    def _stimulus(low_hz: float, high_hz: float, bias_deg_s: float, amplitude_deg_s: float, periods: int) -> LoopStimulus:
        if not 2 <= periods <= 100:
            raise InputError("expected 2 to 100 periods.")
        return loop_stimulus(low_hz, high_hz, radians(bias_deg_s), radians(amplitude_deg_s), BODE_LINES, periods)

    def plan_bode(self, axis: int, *stimulus: Any) -> dict[str, Any]:
        """What a Bode plot would move; raises InputError when the node does not allow it."""
        plan = self._stimulus(*stimulus).plan(AXES[axis])
        plan.check(ANY, Drive(self._device, axis))
        return plan_data(plan)

    def bode(self, axis: int, *stimulus: Any) -> dict[str, Any]:
        """Measures the speed loop as `servoctl bode`. The axis is off before and after it."""
        if self._held:
            raise MotionError("a Bode plot needs the stream and both axes at rest: disable the axes first.")
        wanted = self._stimulus(*stimulus)
        plan = wanted.plan(AXES[axis])
        plan.check(ANY, Drive(self._device, axis))
        limits = Limits(plan.rate_rad_s, plan.forward_rad + plan.backward_rad, plan.duration_s)
        with self._engine.without_stream(self._device, {axis: power.CYCLIC_VELOCITY}):
            measured = measure_loop(
                self._device, AXES[axis], wanted, limits,
                progress=self.progress(axis, "Bode plot", plan.duration_s),
            )  # fmt: skip
        self._loops[axis] = measured
        self._engine.say(f"{AXES[axis]}: speed loop measured")
        closed = 20 * np.log10(np.abs(measured.closed.value[measured.good]))
        return _loop(AXES[axis], measured, measured.loop) | {
            "closed_frequency_hz": measured.closed.frequency_hz[measured.good].tolist(), "closed_db": closed.round(4).tolist(),
            "closed_peak_db": peak_db(measured.closed.value[measured.good]), "bandwidth_hz": measured.bandwidth_hz,
            "lost": measured.lost, "lines": len(measured.good), "trusted": int(np.count_nonzero(measured.good)),
        }  # fmt: skip

    def predict(self, axis: int) -> dict[str, Any] | None:
        """The open loop with the present gains and the plant measured last; None before a measurement, and while values are
        staged, which are all that the node reads back."""
        measured = self._loops.get(axis)
        state = set_state(self._device, axis)
        if measured is None or (state is not None and state.staged_differs):
            return None
        return _loop(AXES[axis], measured, measured.loop_with(read_gains(self._device, axis)))

    # --- scope of the device --------------------------------------------------------------------------------------------

    def _scope_names(self) -> dict[int, str]:
        if not self._signals:
            self._signals.update(capture.signal_names(self._device))
        return self._signals

    def scope_names(self) -> dict[str, Any]:
        """Signals of the device's scope and their units, triggers, and the room for samples."""
        signals = [
            {"number": n, "name": capture.without_unit(name), "unit": Shown(capture.unit_of(name)).unit}
            for n, name in self._scope_names().items()
        ]  # fmt: skip
        return {"signals": signals, "triggers": list(capture.TRIGGERS), "words": capture.WORDS, "most": capture.MAX_CHANNELS}

    def scope_arm(
        self, signals: list[int], rate_hz: float, duration_s: float, pre_s: float, trigger: str, on: int, level: float
    ) -> None:
        """As `servoctl scope`, the level in the unit that `scope_names` gives; the capture needs no attention of ours."""
        names = self._scope_names()
        if not set(signals) <= names.keys() or on not in names:
            raise InputError("this device has no such signal.")
        threshold = level / Shown(capture.unit_of(names[on])).factor
        self._engine.scope = capture.Run(
            self._device, capture.request(names, signals, rate_hz, duration_s, pre_s, trigger, on, threshold)
        )

    def _scope(self) -> capture.Run:
        if self._engine.scope is None:
            raise InputError("nothing is captured: arm the scope first.")
        return self._engine.scope

    def scope_force(self) -> None:
        """Triggers now."""
        self._scope().force()

    def scope_stop(self) -> None:
        """Ends the capture."""
        self._scope().stop()

    def scope_read(self) -> dict[str, Any]:
        """The capture, in the units that people read; nothing moves meanwhile."""
        run = self._scope()
        if self._device.turns.anyone_moves():
            raise MotionError("the capture is complete, and is read when no axis is enabled here or moved by another servoctl.")
        found = run.read(self._scope_names())
        self._engine.scope = None
        shown = {name: Shown(capture.unit_of(name)) for name in found.traces}
        return {
            "time_s": found.time_s.tolist(), "triggered": found.triggered, "period_ms": run.wanted.divider,
            "signals": [
                {"name": capture.without_unit(name), "unit": shown[name].unit, "values": (shown[name].factor * trace).tolist()}
                for name, trace in found.traces.items()
            ],
        }  # fmt: skip

    # --- signals, faults ------------------------------------------------------------------------------------------

    def choose(self, choice: str) -> None:
        """Signals to plot."""
        self._engine.choose(self._device, choice)

    def record(self) -> str:
        """Begins a recording of the live signals; its name."""
        return self._engine.record(self._device)

    def faults(self) -> dict[str, Any]:
        """Present and past faults; the log with the ticks before each fault when nothing moves."""
        table = find_faults([self._device.any_schema.source])
        found = read_faults(self._device, table)
        if self._device.turns.anyone_moves():
            return found | {"log": None, "note": "The fault log is read when no axis is enabled here or moved by another servoctl."}
        log = read_log(self._device, table)
        return found | {"log": as_json(log) if log else None, "note": "" if log else "This node has no fault log (3020)."}

    # --- gains ----------------------------------------------------------------------------------------------------

    def gains(self, axis: int) -> dict[str, Any]:
        """All gains of an axis: the values read (staged), active and stored ones as far as they are known."""
        name = AXES[axis]
        chosen = [p for p in self._device.schema.tunable if p.axis == axis and p.type not in ("DOMAIN", "VISIBLE_STRING")]
        values, state = self._read_whole(axis, chosen)
        self._forget_changed(axis, state)
        rows = []
        for parameter, value in values.items():
            self._note(parameter, value, state is None or not state.staged_differs, state is not None and not state.active_differs_from_stored)
            rows.append(_row(parameter, value, self._in_force.get(parameter.name), self._stored.get(parameter.name)))
        return {
            "axis": name, "rows": rows, "staged": bool(state and state.staged_differs),
            "differs_from_stored": bool(state and state.active_differs_from_stored), "read": time.time(),
        }  # fmt: skip

    def _read_whole(self, axis: int, chosen: list[Parameter]) -> tuple[dict[Parameter, Value], SetState | None]:
        """Values of one set, which nobody has changed meanwhile; raises MotionError."""
        for _ in range(ATTEMPTS):
            before = set_state(self._device, axis)
            values = {parameter: self._device.read(parameter) for parameter in chosen}
            if set_state(self._device, axis) == before:
                return values, before
        raise MotionError(f"another program changes the gains of {AXES[axis]} again and again: read them when it has finished.")

    def _forget_changed(self, axis: int, state: SetState | None) -> None:
        """Values of a set that somebody else has applied or stored since they were read."""
        crcs = (state.active_crc, state.stored_crc) if state else (0, 0)
        before = self._crcs.get(axis, crcs)
        self._crcs[axis] = crcs
        for known, was, now in zip((self._in_force, self._stored), before, crcs, strict=True):
            if was != now:
                for name in [name for name in known if name.startswith(f"{AXES[axis]}.")]:
                    del known[name]

    def _note(self, parameter: Parameter, value: Value, in_force: bool, as_stored: bool) -> None:
        """The node shows staged values; the others are known from when they were the same."""
        if in_force or not parameter.staged:
            self._in_force[parameter.name] = value
        if (in_force and as_stored) and parameter.staged:
            self._stored[parameter.name] = value

    def apply(self, values: dict[str, str], unlock: bool, word: str) -> list[dict[str, Any]]:
        """All in one piece; raises the device's refusal, and then nothing of it is active."""
        wanted = {p: p.check(p.parse(text)) for p, text in ((self._device.schema.find(n), t) for n, t in values.items())}
        if not wanted:
            raise InputError("nothing to apply: change a value first.")
        with self.word(unlock, word):
            changes = Tuning(self._device, COMMAND).write(wanted, unlock=unlock)
        return self._report(changes, "set")

    def undo(self, unlock: bool, word: str) -> list[dict[str, Any]]:
        """The last change in this computer's journal."""
        with self.word(unlock, word):
            return self._report(undo_last(Tuning(self._device, COMMAND), unlock), "undone:")

    @contextlib.contextmanager
    def word(self, unlock: bool, word: str) -> Iterator[None]:
        """The owner's word for the lock, as far as one is set; the library would ask for it in the terminal."""
        started_with = self._device.access_word
        if unlock and not (word or started_with) and lock_state(self._device).has_word:
            raise InputError("the owner of this node has set an access word: enter it beside 'Unlock'.")
        self._device.access_word = word or started_with
        try:
            yield
        finally:
            self._device.access_word = started_with

    def save(self) -> dict[str, Any]:
        """A gains file of both axes."""
        values = gain_set.read_to_save(self._device)
        return {"text": gains_text(values, gain_set.about(self._device)), "count": len(values)}

    def schema(self) -> Schema:
        """The objects of the device; raises SchemaMismatch."""
        return self._device.schema

    def compare(self, file: GainsFile) -> dict[str, Any]:
        """A gains file with the device."""
        found = gain_set.compare(self._device, file.values)
        serial, mine = file.device.get("serial"), self._device.serial_number()
        other = f"this file was saved from another machine (serial number {serial}; this one is {mine})." if serial not in (None, mine) else ""
        return {
            "name": str(file.path), "compared": len(found.wanted), "not_in_file": len(found.absent), "warning": other,
            "staged": [AXES[axis] for axis in sorted(found.staged)],
            "different": [
                {"name": p.name, "device": number(found.found[p]), "file": number(value), "unit": p.unit, "guarded": p.guarded}
                for p, value in found.different.items()
            ],
        }  # fmt: skip

    def restore(self, file: GainsFile, unlock: bool, word: str) -> list[dict[str, Any]]:
        """Writes a gains file in one piece, and reads it back."""
        with self.word(unlock, word):
            changes = gain_set.restore(self._device, gain_set.compare(self._device, file.values), unlock=unlock)
        return self._report(changes, "set")

    def store(self) -> str:
        """Stores the active values in the device's flash; the place of the backup. Both axes must be off."""
        self._engine.busy("stores")
        try:
            backup = gain_set.store_with_backup(self._device)
        finally:
            self._engine.busy("")
        self._engine.say(f"stored; backup: {backup}", "good")
        return str(backup)

    def discard(self, axis: int) -> None:
        """Withdraws values that are staged and not active."""
        command_set(self._device, axis, REVERT)

    def _report(self, changes: list[Any], verb: str) -> list[dict[str, Any]]:
        for change in changes:
            text = f"{change.parameter.name} = {number(change.new)} {change.parameter.unit}".rstrip()
            self._engine.say(f"{verb} {text} (was {number(change.old)})")
        return [{"name": c.parameter.name, "old": c.old, "new": c.new, "unit": c.parameter.unit} for c in changes]


def _loop(axis: str, measured: MeasuredLoop, loop: Complex) -> dict[str, Any]:
    """Gain and phase of an open loop where it can be trusted, and its margins."""
    sharp = measured.sharp
    frequency = measured.closed.frequency_hz[sharp]
    gain_db = 20 * np.log10(np.abs(loop[sharp]))
    phase_deg = branch(np.degrees(np.unwrap(np.angle(loop[sharp]))), gain_db)
    return {
        "axis": axis, "open_frequency_hz": frequency.tolist(),
        "open_db": gain_db.round(4).tolist(), "open_deg": phase_deg.round(3).tolist(), "margins": asdict(margins(frequency, loop[sharp])),
    }  # fmt: skip


def _step(record: StepRecord) -> dict[str, Any]:
    """In ms, °/s and %."""
    name, time_s, demand, answer, numbers = record

    def ms(value: float | None) -> float | None:
        return None if value is None else 1e3 * value

    return {
        "direction": name, "time_ms": (1e3 * time_s).tolist(), "demand_deg_s": (degrees(1) * demand).tolist(),
        "rate_deg_s": (degrees(1) * answer).tolist(),
        "half_ms": ms(numbers.time_to_half_s), "rise_ms": ms(numbers.rise_s), "overshoot_percent": numbers.overshoot_percent,
        "settling_ms": ms(numbers.settling_s), "error_deg_s": degrees(numbers.final_error_rad_s), "noise_deg_s": degrees(numbers.noise_rad_s),
    }  # fmt: skip


def number_of_degrees(angle_rad: float) -> float:
    """To the resolution of the node's positions."""
    return round(degrees(angle_rad), 6)


def _row(parameter: Parameter, value: Value, active: Value | None, stored: Value | None) -> dict[str, Any]:
    _, group, *entry = parameter.name.split(".")
    return {
        "name": parameter.name, "group": group.replace("_", " "), "entry": ".".join(entry).replace("_", " ") or group.replace("_", " "),
        "where": parameter.where, "unit": parameter.unit, "range": parameter.limits(), "help": parameter.help,
        "default": number(parameter.default), "guarded": parameter.guarded, "value": number(value),
        "active": number(active) if active is not None else None, "stored": number(stored) if stored is not None else None,
    }  # fmt: skip
