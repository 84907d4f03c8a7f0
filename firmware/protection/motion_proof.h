/* SPDX-License-Identifier: Apache-2.0 */
/* Proves that the sensors of a standing axis still show its motion: a small torque swings it, and its rate must swing
 * with it. Encoder and gyro that are dead together look at rest like good ones, and the loop's torque grows until the
 * axis breaks away; no other monitor sees that before.
 *
 *     torque = +-2 r Z sin(w t),   w = 2 pi / (MOTION_PROOF_PERIOD_TICKS dt)
 *     a + j b = 2 / N sum of rate exp(-j w t) over a window of N = MOTION_PROOF_TICKS ticks
 *
 * The sign changes from window to window. Z is the largest impedance that axis and loop can have together, so a rate
 * that swings by less than r is half of the least answer, and two such windows in a row are a fault:
 *
 *     Z = J w + s0 / w + s1 + s2 + (F + wp / w) (Kp + Ki / w) sqrt(1 + (wo / w)^2) + F wo (Jo + Bo / w)
 *
 * wo, Jo, Bo: bandwidth, inertia and viscous coefficient of the observer; F: gain of the filters at w; wp: gain of the
 * position loop.
 *
 * Most axes answer more than that, so the next window takes as much torque as gave 2 r in this one, and the whole
 * torque again after a window without an answer: a standing axis swings no more than it must.
 *
 * With an axis that answers, no vibration of one frequency can cause the fault: what cancels the answer in one window
 * adds to it in the next. Noise of a density S (1/sqrt(Hz)) gives a and b a standard deviation of S / sqrt(N dt): dead
 * sensors are found if r is three times as much. Cost: about 25 instructions, 60 more at the start of a window. */
#ifndef TRACKSERVO_PROTECTION_MOTION_PROOF_H
#define TRACKSERVO_PROTECTION_MOTION_PROOF_H

#include <stdbool.h>

/* 42 Hz at 1 ms: above what the loop holds best, and far from the mains. A quarter of a period is a whole number of
 * ticks. */
enum { MOTION_PROOF_PERIOD_TICKS = 24, MOTION_PROOF_TICKS = 8 * MOTION_PROOF_PERIOD_TICKS };

#define MOTION_PROOF_MOST_SPARED 0.8f

/* What opposes the swing; none negative. Axis: as it surely is, not as the feedforward has it. */
typedef struct {
  float inertia_kg_m2;     /* the largest */
  float stiffness_nm_rad;  /* of the bristles, s0 */
  float damping_nm_s_rad;  /* s1 + s2 */
  float proportional_gain; /* Nm s/rad */
  float integral_gain;     /* Nm/rad */
  float filter_gain;       /* of the feedback, at 1 / (MOTION_PROOF_PERIOD_TICKS dt) */
  float position_per_s;    /* of the position loop; 0: none */
  float observer_rad_s;    /* 0: no observer */
  float observer_inertia_kg_m2;
  float observer_viscous_nm_s_rad;
} motion_proof_axis;

/* All zero: nothing proven yet, no torque. */
typedef struct {
  int tick;             /* of this window */
  float amplitude_nm;   /* of its torque */
  float spared;         /* share of the torque that a good answer has spared, 0 .. MOTION_PROOF_MOST_SPARED */
  bool backwards;       /* the sign of its torque */
  bool spoiled;         /* it counts for nothing */
  bool silent;          /* the last window had no answer */
  bool unanswered;      /* the last two had none */
  float in_phase_rad_s; /* sums */
  float quadrature_rad_s;
  float torque_nm; /* for the next tick; 0 at the start of a window */
} motion_proof;

typedef struct {
  float answer_rad_s; /* r */
  float most_nm;      /* where the torque would need more, nothing is tested */
} motion_proof_limits;

/* Returns Z, the torque that swings the rate by 1 rad/s at most, Nm s/rad. */
float motion_proof_impedance(const motion_proof_axis *axis, float dt_s);

/* Takes the rate of a tick in which `torque_nm` acted, and computes the torque for the next one. `limited`: the torque
 * could not act in full. `axis` is read at the start of a window only: `proof->tick` is 0. */
void motion_proof_step(motion_proof *proof, const motion_proof_limits *limits, const motion_proof_axis *axis,
                       float rate_rad_s, bool limited, float dt_s);

#endif
