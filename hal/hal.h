/* SPDX-License-Identifier: Apache-2.0 */
/* The complete boundary between the firmware and a machine, on one page.
 *
 * A platform implements these functions at link time: `host` forwards them to a simulated machine, a folder of `boards`
 * with the drivers of its chip to registers. The firmware calls nothing else that accesses hardware. Axis is 0
 * (azimuth) or 1 (pitch). No function blocks; each costs at most a few microseconds on a board. */
#ifndef TRACKSERVO_HAL_H
#define TRACKSERVO_HAL_H

#include <stdbool.h>
#include <stdint.h>

/* Azimuth and pitch. A board may have fewer: an axis that it does not have is never ready. */
enum { HAL_AXES = 2 };

/* One machine. Its contents belong to the platform. */
typedef struct hal hal;

/* --- sampled once per 1 ms tick --- */

/* The sensors of one axis. A new sensor is a new member; the firmware passes the whole structure on. */
typedef struct {
  /* Absolute joint angle: the mean of the readings of the last PWM periods if the encoder is fast enough. Four readings
   * halve its noise and add 75 us of delay. Positive: counter-clockwise seen from above (azimuth), nose up (pitch). */
  uint32_t joint_angle_turn32; /* 2^-32 turn */
  bool encoder_failed;         /* no reading passed its checks: the angle is still the last good one */
  bool gyro_valid;             /* a recent sample passed its checks; otherwise gyro_rad_s has no meaning */
  float gyro_rad_s;            /* inertial rate about the axis that its mounting gives it (2056:9) */
  float mean_current_a;        /* motor current since the last tick, mean, positive for torque in positive direction */
} hal_axis_samples;

/* Writes the samples of this tick. The caller passes the samples of the last tick. */
void hal_sample(hal *machine, int axis, hal_axis_samples *samples);

/* Conditions that prevent an axis from being driven. */
typedef enum {
  HAL_GOOD = 0,
  HAL_NOT_READY,         /* a self-test failed */
  HAL_OVER_CURRENT,      /* beyond the measuring range; a broken sensor wire reads the same */
  HAL_POWER_STAGE,       /* the driver's fault input */
  HAL_TOO_HOT,           /* the heat sink */
  HAL_TIMING_LOST,       /* tick or PWM period came too late; a reset follows */
  HAL_IMAGE_DAMAGED,     /* the program memory is damaged; until it is programmed again */
  HAL_SAFE_TORQUE_OFF,   /* both channels of STO have removed the torque, without this program */
  HAL_SAFE_TORQUE_FAULT, /* the channels of STO contradict each other or the driver's enable */
  HAL_CLOCK_WRONG        /* the clock contradicts the other oscillator */
} hal_health;

/* Scales of the board's amplifiers and dividers for a current and a voltage. */
typedef struct {
  float current_full_scale_a[HAL_AXES]; /* at either end of the sensor's range, 0 A in its middle; 0.1 .. 1000 */
  float over_current_a[HAL_AXES]; /* above it, and beyond the sensor's range, the bridge is off at once; 0.05 .. 1000 */
  float voltage_full_scale_v;     /* 5 .. 1000 */
} hal_scales;

/* Sets the full scales, from the next PWM period on. Call it while both axes are off. Until the first call they are 25
 * A and 66 V. */
void hal_set_scales(hal *machine, const hal_scales *scales);

/* Returns the health of an axis. A power stage that has switched itself off because of a fault stays off until
 * hal_power_bridge(false) finds the fault gone. */
hal_health hal_axis_health(hal *machine, int axis);

/* --- time --- */

/* Returns the machine's clock in us, from the oscillator of the ticks; it wraps after 72 minutes. */
uint32_t hal_clock_us(hal *machine);

/* Returns its value when the last tick began, exactly 1000 more with each tick. Call from the deferred task only. */
uint32_t hal_tick_us(hal *machine);

enum { HAL_STROBES = 16 };

/* Rising edges of the camera's strobe since the last call, the oldest first. */
typedef struct {
  bool flooded;                /* there were more than HAL_STROBES: none of them is here */
  uint32_t count;              /* 0 .. HAL_STROBES */
  uint32_t at_us[HAL_STROBES]; /* hal_clock_us */
} hal_strobes;

/* Takes the edges of the strobe since the last call. Call at least once per ms, not from a tick. */
void hal_take_strobes(hal *machine, hal_strobes *strobes);

/* --- set once per tick --- */

/* Switches the bridge. On: it applies the duty; off: the motor's terminals are open. */
void hal_power_bridge(hal *machine, int axis, bool on);

/* Releases or engages the holding brake: current in its coil releases it, its spring engages it. STO engages it, too.
 * */
void hal_release_brake(hal *machine, int axis, bool release);

/* Returns whether the brake's contact reports it released; false without a contact. */
bool hal_brake_is_released(hal *machine, int axis);

/* What the board reads back, for a client: a sum. */
enum {
  HAL_STATUS_STO_A = 0x01, /* channel A permits torque */
  HAL_STATUS_STO_B = 0x02,
  HAL_STATUS_BRAKE_AZIMUTH = 0x04, /* contact: released */
  HAL_STATUS_BRAKE_PITCH = 0x08,
  HAL_STATUS_RAM_PARITY = 0x10,       /* option bit set */
  HAL_STATUS_WRITE_PROTECTION = 0x20, /* of the program's pages in flash */
  HAL_STATUS_READ_PROTECTION = 0x40,  /* of the flash, against a debugger */
  HAL_STATUS_FLASH_BANKS = 0x80       /* the flash has the banks that the parameter pages need */
};
uint32_t hal_status(hal *machine);

/* --- once per PWM period (20 kHz) --- */

/* Returns the motor current in A at the middle of the PWM period. */
float hal_current_a(hal *machine, int axis);

float hal_bus_voltage_v(hal *machine);

/* Sets the bridge duty in [-1, 1]: mean motor voltage = duty * bus voltage, from the next period on. */
void hal_set_duty(hal *machine, int axis, float duty);

#endif
