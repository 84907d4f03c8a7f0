# SPDX-License-Identifier: Apache-2.0
"""The simulated machine against MuJoCo: the same duties in, the same currents, rates and angles out.

MuJoCo's `dcmotor` actuator has resistance, inductance, back-EMF, cogging and a LuGre seal of its own; the coupling of
the axes, gravity and the turning base come from its rigid bodies. None of it shares code or derivation with ours: our
plant writes the Lagrangian of two joints down. The bodies have the inertias about which ours speaks:

    stage: about z J0 - I, cabin: about the line of sight I, pitch axis J_pitch, across I + J1

so that azimuth has J0 + J1 cos^2(pitch). The stage with the cabin's I is symmetric about z, as our plant assumes.
"""

import io
import math
import os
import pathlib
import subprocess
import tomllib
from dataclasses import dataclass

import mujoco
import numpy as np
import pytest

HERE = pathlib.Path(__file__).parent
PERIOD_S = 1e-3  # of the duties
STEP_S = 20e-6  # of MuJoCo
DURATION_S = 4.0
BASE_KG_M2 = 1e9  # so heavy that the machine does not move it
ALONG_KG_M2 = 1.0  # the cabin about its line of sight
ALLOWED = 0.01  # of the range of each signal
AXES = ("azimuth", "pitch")
SIGNALS = [f"{axis} {signal}" for axis in AXES for signal in ("current", "rate", "angle")]
BASE_AXIS = {"roll": "1 0 0", "pitch": "0 -1 0", "yaw": "0 0 1"}


@dataclass
class Base:
    """A sine about one axis of the base."""

    axis: str
    amplitude_deg: float
    frequency_hz: float

    def toml(self) -> str:
        """The phase of 90 deg begins at rest, at the largest angle."""
        return (
            f'\n[[base_motion]]\naxis = "{self.axis}"\namplitude_deg = {self.amplitude_deg}\n'
            f"frequency_hz = {self.frequency_hz}\nphase_deg = 90.0\n"
        )

    def angle_rad(self, time_s: float) -> float:
        return math.radians(self.amplitude_deg) * math.cos(2.0 * math.pi * self.frequency_hz * time_s)

    def acceleration_rad_s2(self, time_s: float) -> float:
        return -self.angle_rad(time_s) * (2.0 * math.pi * self.frequency_hz) ** 2


def motor(name: str, axis: dict) -> str:
    electric, seal, cogging = axis["motor"], axis["friction"], axis["motor"]["cogging"][0]
    direction = seal["positive"]
    return f"""
      <dcmotor joint="{name}" input="voltage" motorconst="{electric["torque_constant_nm_a"]}
               {electric["back_emf_constant_v_s_rad"]}" resistance="{electric["resistance_ohm"]}"
               inductance="{1e-3 * electric["inductance_mh"]}"
               cogging="{cogging["amplitude_nm"]} {cogging["harmonic"]} {math.radians(cogging.get("phase_deg", 0.0))}"
               lugre="{seal["stiffness_nm_rad"]} {seal["damping_nm_s_rad"]} {direction["coulomb_nm"]}
                      {direction["breakaway_nm"]} {math.radians(direction["stribeck_speed_deg_s"])}"
               damping="{direction["viscous_nm_s_rad"]}"/>"""


def model_of(plant: dict, base: Base | None) -> mujoco.MjModel:
    stationary, swing = plant["azimuth"]["inertia_kg_m2"], plant["azimuth"]["inertia_swing_kg_m2"]
    about_pitch = plant["pitch"]["inertia_kg_m2"]
    # A point mass far out on the line of sight, light enough that its inertia does not count.
    imbalance_kg_m = plant["pitch"]["load"]["imbalance_nm"] / 9.81
    arm_m = 1e-6
    stage = f"{10.0} {10.0 + ALONG_KG_M2} {stationary - ALONG_KG_M2}"
    cabin = f"{ALONG_KG_M2} {about_pitch} {ALONG_KG_M2 + swing}"
    base_joint = f'<joint name="base" axis="{BASE_AXIS[base.axis]}"/>' if base else ""
    return mujoco.MjModel.from_xml_string(f"""
  <mujoco>
    <compiler inertiafromgeom="false"/>
    <option timestep="{STEP_S}" gravity="0 0 -9.81" integrator="implicitfast"/>
    <worldbody>
      <body>{base_joint}<inertial pos="0 0 0" mass="1" diaginertia="{BASE_KG_M2} {BASE_KG_M2} {BASE_KG_M2}"/>
        <body><joint name="azimuth" axis="0 0 1"/><inertial pos="0 0 0" mass="1" diaginertia="{stage}"/>
          <body><joint name="pitch" axis="0 -1 0"/>
            <inertial pos="{arm_m} 0 0" mass="{imbalance_kg_m / arm_m}" diaginertia="{cabin}"/>
          </body>
        </body>
      </body>
    </worldbody>
    <actuator>{motor("azimuth", plant["azimuth"])}{motor("pitch", plant["pitch"])}
    </actuator>
  </mujoco>""")


def by_mujoco(plant: dict, duties: np.ndarray, pitch_rad: float, base: Base | None) -> np.ndarray:
    model = model_of(plant, base)
    data = mujoco.MjData(model)
    joint = [model.joint(name).id for name in AXES]
    data.qpos[joint[1]] = pitch_rad
    if base:
        data.qpos[0] = base.angle_rad(0.0)
    current = [int(model.actuator_actadr[i] + model.actuator_actnum[i] - 1) for i in range(2)]
    rows = []
    for duty in duties:
        data.ctrl[:] = duty * plant["supply"]["voltage_v"]
        for _ in range(round(PERIOD_S / STEP_S)):
            if base:
                data.qfrc_applied[0] = BASE_KG_M2 * base.acceleration_rad_s2(data.time)
            mujoco.mj_step(model, data)
        rows.append([x for i in range(2) for x in (data.act[current[i]], data.qvel[joint[i]], data.qpos[joint[i]])])
    return np.array(rows)


def by_us(path: pathlib.Path, duties: np.ndarray, pitch_rad: float) -> np.ndarray:
    text = io.StringIO()
    np.savetxt(text, duties, fmt="%.17g")
    done = subprocess.run(
        [os.environ["PLANT_TRACE"], path, str(pitch_rad)], input=text.getvalue(), capture_output=True, text=True, check=True
    )
    return np.loadtxt(io.StringIO(done.stdout))


def whole_counts(duty: np.ndarray, plant: dict) -> np.ndarray:
    """As the timer can make it: the bridge of the plant has whole counts."""
    counts = plant["supply"]["pwm_counts"]
    return np.round(duty * counts) / counts


def slow_reversals(time_s: np.ndarray) -> np.ndarray:
    """Through break-away, slow sliding and standstill, in both directions."""
    return np.stack([0.16 * np.sin(2.0 * np.pi * 0.4 * time_s), 0.14 * np.sin(2.0 * np.pi * 0.6 * time_s + 1.0)], axis=1)


def fast_and_coupled(time_s: np.ndarray) -> np.ndarray:
    """At up to 2 rad/s on both axes at once: each feels the other's motion."""
    return np.stack([np.where(time_s % 2.0 < 1.4, 0.30, -0.22), 0.20 * np.sin(2.0 * np.pi * 0.5 * time_s)], axis=1)


def steps_of_voltage(time_s: np.ndarray) -> np.ndarray:
    """The windings' own time constant, with a new voltage every 20 ms."""
    levels = np.random.default_rng(1).uniform(-0.4, 0.4, (int(time_s[-1] / 0.02) + 1, 2))
    return levels[(time_s / 0.02).astype(int)]


CASES = {
    "slow reversals": (slow_reversals, 0.0, None),
    "fast and coupled": (fast_and_coupled, 0.9, None),
    "steps of voltage": (steps_of_voltage, 0.3, None),
    "base rolls": (slow_reversals, 0.7, Base("roll", 10.0, 0.7)),
    "base pitches": (slow_reversals, 0.7, Base("pitch", 10.0, 0.7)),
    "base yaws": (slow_reversals, 0.7, Base("yaw", 10.0, 0.7)),
    "base rolls, no voltage": (lambda t: np.zeros((len(t), 2)), 0.7, Base("roll", 20.0, 1.5)),
}


def largest_differences(case: str, folder: pathlib.Path, changed: dict[str, float] | None = None) -> np.ndarray:
    """Shares of the range of each signal; `changed`: what MuJoCo's azimuth has otherwise."""
    shape, pitch_rad, base = CASES[case]
    text = (HERE / "plant.toml").read_text() + (base.toml() if base else "")
    path = folder / "plant.toml"
    path.write_text(text)
    plant = tomllib.loads(text)
    duties = whole_counts(shape(np.arange(0.0, DURATION_S, PERIOD_S)), plant)
    ours = by_us(path, duties, pitch_rad)
    plant["azimuth"].update(changed or {})
    theirs = by_mujoco(plant, duties, pitch_rad, base)
    assert np.ptp(theirs, axis=0).min() > 1e-3, "every signal moves"
    return np.abs(ours - theirs).max(axis=0) / np.ptp(theirs, axis=0)


@pytest.mark.parametrize("case", CASES)
def test_the_machine_moves_as_mujoco_says(case: str, tmp_path: pathlib.Path, capsys: pytest.CaptureFixture) -> None:
    worst = largest_differences(case, tmp_path)
    with capsys.disabled():
        print(f"\n{case}, largest difference in % of the range: " + ", ".join(map("{} {:.3f}".format, SIGNALS, 100 * worst)))
    assert worst.max() <= ALLOWED


@pytest.mark.parametrize("changed", [{"inertia_swing_kg_m2": 1.8}, {"inertia_kg_m2": 4.2}])
def test_an_inertia_that_is_wrong_by_some_percent_is_seen(changed: dict[str, float], tmp_path: pathlib.Path) -> None:
    assert largest_differences("base rolls", tmp_path, changed).max() > ALLOWED
