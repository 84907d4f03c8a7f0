# SPDX-License-Identifier: Apache-2.0
"""One axis of a servo as an object for scripts and notebooks: it moves, measures, and is commissioned. See servo.py."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Mapping
from pathlib import Path

from .drive.drive import Drive
from .errors import InputError
from .gains import loop_test, tune_run
from .gains.loop_test import LoopStimulus, MeasuredLoop
from .gains.tune_run import REQUIREMENT_KEYS, Proposal, Tried
from .identify import identification
from .identify.commissioning import check_place
from .identify.identification import Finished, Identification
from .identify.identified import read_identified
from .identify.identify_program import IdentifyProgram, find_identify
from .link.device import Device
from .motion import moves, step_test
from .motion.limits import Limits
from .motion.rate_run import send_rates
from .motion.step_test import SETPOINT_TICKS, StepRecord
from .objects.access_lock import need_unlock
from .objects.named_parameters import NamedParameters
from .objects.parameter import AXES
from .show.output_files import check_new
from .units import degrees, radians
from .wording import in_python

File = str | os.PathLike[str]

STEP_TRIES = 3


def _degrees(travel_rad: tuple[float, float] | None) -> tuple[float, float] | None:
    return None if travel_rad is None else (degrees(travel_rad[0]), degrees(travel_rad[1]))


class Axis(NamedParameters):
    """Its names of parameters need not begin with the axis. `drive`: power states, modes and targets, without checks and
    monitoring."""

    def __init__(self, device: Device, number: int) -> None:
        super().__init__(device, AXES[number])
        self.number = number
        self.name = AXES[number]
        self.drive = Drive(device, number)

    def state(self) -> str:
        """The power state: "switch on disabled", "operation enabled", "fault" and so on."""
        return self.drive.state()

    def position_rad(self) -> float:
        """The measured joint angle."""
        return self.drive.position()

    def rate_rad_s(self) -> float:
        """The measured rate."""
        return self.drive.rate()

    @in_python
    def disable(self) -> None:
        """Stops on the ramp, then removes the torque."""
        self.drive.disable()

    @in_python
    def reset(self) -> None:
        """Resets a fault; raises MotionError while its cause is still there."""
        self.drive.reset_fault()

    # --- motion -----------------------------------------------------------------------------------------------------

    @in_python
    def move(
        self, *, to_rad: float | None = None, by_rad: float | None = None, rate_rad_s: float = radians(moves.DEFAULT_RATE_DEG_S),
        limits: Limits = moves.MOST,
    ) -> float:  # fmt: skip
        """Moves to a joint angle or by an angle at up to a rate (above 0); returns the angle on arrival. The axis is enabled for
        the motion, and afterwards as it was.

        Raises InputError, before anything moves, for a motion beyond the node's limits or `limits`, and MotionError, with the axis
        at rest, for one that does not arrive.
        """
        if (to_rad is None) == (by_rad is None):
            raise InputError("move needs either to_rad or by_rad.")
        if not rate_rad_s > 0.0:
            raise InputError(f"rate_rad_s is {rate_rad_s:g}: a move needs a rate above 0.")
        here = self.drive.position()
        target = to_rad if to_rad is not None else here + (by_rad or 0.0)
        plan = moves.plan_to(self.name, here, target, rate_rad_s)
        plan.check(limits, self.drive)
        return moves.go_to(self.device, self.number, target, plan)

    @in_python
    def run(self, rate_rad_s: float, seconds: float, *, limits: Limits = moves.MOST) -> float:
        """Turns at a rate for a time, then stops on the ramp; returns the angle where it stands. Otherwise as `move`."""
        if not seconds > 0.0:
            raise InputError(f"cannot run for {seconds:g} s: expected more than 0.")
        plan = moves.plan_run(self.name, rate_rad_s, seconds)
        plan.check(limits, self.drive)
        moves.run_at_rate(self.device, self.number, rate_rad_s, seconds)
        return self.drive.position()

    @in_python
    def step(
        self, amplitude_rad_s: float, *, from_rad_s: float = 0.0, hold_s: float = 1.0, hold_other: bool = False,
        limits: Limits = step_test.MOST,
    ) -> list[StepRecord]:  # fmt: skip
        """A step of the rate and its counterpart backward, each held for `hold_s` (0.1 to 30 s), as `servoctl step`. Of each:
        direction, time since the step (s), demand and answer (rad/s, each tick), and numbers such as the rise. `hold_other` keeps
        the other axis where it is. Steps that were disturbed by a late set-point are repeated, up to twice, and then left out,
        with a Python warning. For `plots.steps_figure`. Raises InputError or MotionError."""
        planned = step_test.plan_step(self.name, amplitude_rad_s, from_rad_s, hold_s)
        for tries_left in reversed(range(STEP_TRIES)):
            planned.plan.check(limits, self.drive)
            run = send_rates(self.device, self.number, planned.rates, SETPOINT_TICKS, limits, hold_other, interpolation=1)
            records = (step_test.find_steps if tries_left else step_test.cut_steps)(run, hold_s)
            disturbed = step_test.disturbed_text(records, planned, run)
            if not disturbed:
                break
        else:
            warnings.warn(disturbed, stacklevel=3)
        return records

    @in_python
    def bode(self, stimulus: LoopStimulus | None = None, *, hold_other: bool = False, limits: Limits = loop_test.MOST) -> MeasuredLoop:
        """The speed loop in the frequency domain, as `servoctl bode`: closed and open loop, coherence, margins. `stimulus`: from
        `loop_stimulus`. For `plots.bode_figure`. Raises InputError or MotionError."""
        stimulus = stimulus or loop_test.loop_stimulus()
        stimulus.plan(self.name).check(limits, self.drive)
        return loop_test.measure_loop(self.device, self.name, stimulus, limits, hold_other)

    # --- commissioning ----------------------------------------------------------------------------------------------

    @in_python
    def identify(
        self, folder: File, *, travel_rad: tuple[float, float] | None = None, fastest_rad_s: float | None = None, quick: bool = False,
        overwrite: bool = False,
    ) -> Finished:  # fmt: skip
        """Measures friction and inertia by experiments that last about ten minutes of the node, as `servoctl identify`. Results,
        recordings and a report come into `folder`; no gain changes.

        `travel_rad`: joint angles between which the axis may move, `fastest_rad_s` its fastest rate; without them the node's
        limits. `quick`: the first look alone, accurate to a factor of two. Of what is returned, `identified` has the values with their
        intervals, `outcome` the lost ticks, and whether the other axis was held. Needs the program `identify`. Raises InputError
        or MotionError.
        """
        path = Path(folder)
        check_new(identification.result_files(path, self.number), overwrite, "identify")
        program = IdentifyProgram(find_identify(None))
        fastest_deg_s = None if fastest_rad_s is None else degrees(fastest_rad_s)
        envelope = identification.read_envelope(self.device, self.number, _degrees(travel_rad), fastest_deg_s)
        check_place(self.drive, envelope)
        run = Identification(program, self.device, self.number, envelope, identification.make_folder(path))
        return run.carry_out(run.plan(identification.FIRST_LOOK), quick)

    @in_python
    def design(self, folder: File, *, unlock: bool = False, **requirements: float) -> Proposal:
        """Gains from the identification in `folder`, beside the present ones, as `servoctl tune --dry-run`; nothing changes.

        `requirements` are those of `servoctl tune`: bandwidth_hz, damping, setpoint_weight, setpoint_model_hz, observer_hz,
        least_error, disturbance_nm, disturbance_hz, gain_margin_db, phase_margin_deg, torque_noise_nm, tracking_hz, position_hz; what is
        not given is chosen. With `unlock` the identified
        plant (2056) is part of it. Raises InputError.
        """
        with tempfile.TemporaryDirectory() as work:
            return self._propose(Path(folder), Path(work), unlock, requirements)

    @in_python
    def tune(
        self, folder: File, *, unlock: bool = False, travel_rad: tuple[float, float] | None = None,
        stimulus: LoopStimulus | None = None, overwrite: bool = False, **requirements: float,
    ) -> Tried | None:  # fmt: skip
        """Tries the gains of `design` on the live axis, and keeps them if the measured margins are not below the required or
        predicted ones (`kept`, `reasons`); otherwise, and on any error, the old gains are in force again. None: the device has
        these gains. A report and the active gains come into `folder`. Nothing is stored."""
        path = Path(folder)
        check_new(tune_run.result_files(path, self.number), overwrite, "tune", [path / identification.RESULT])
        stimulus = stimulus or loop_test.loop_stimulus()
        tune_run.check_slides(stimulus)
        plan = stimulus.plan(self.name)
        tune_run.check_reach(self.drive, plan, read_identified(path / identification.RESULT), _degrees(travel_rad))
        plan.check(tune_run.LIMITS, self.drive)
        with tempfile.TemporaryDirectory() as work:
            proposal = self._propose(path, Path(work), unlock, requirements)
            if not proposal.changed:
                return None
            need_unlock([] if unlock else proposal.locked)
            tried = tune_run.try_out(self.device, proposal, stimulus, unlock)
            tune_run.keep_design(Path(work), path)
        tune_run.write_files(path, self.device, proposal, tried)
        return tried

    def _propose(self, folder: Path, work: Path, unlock: bool, requirements: Mapping[str, float]) -> Proposal:
        for name in requirements:
            if name not in REQUIREMENT_KEYS:
                raise InputError(f"there is no requirement '{name}': expected {', '.join(REQUIREMENT_KEYS)}.")
        identified = read_identified(folder / identification.RESULT)
        identified.check_machine(self.device, self.number)
        wishes = {REQUIREMENT_KEYS[name]: value for name, value in requirements.items()}
        names = {key: name for name, key in REQUIREMENT_KEYS.items()}
        program = IdentifyProgram(find_identify(None))
        return tune_run.propose(program, self.device, identified, self.number, work, wishes, unlock, lambda key: names[key])
