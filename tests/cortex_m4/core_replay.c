/* SPDX-License-Identifier: Apache-2.0 */
#include "cortex_m4/core_replay.h"

#include <stdio.h>
#include <string.h>

#include "cortex_m4/core_trace.h"
#include "hal_host.h"

typedef struct {
  FILE *file;
  uint32_t words[16384];
  size_t count;
  size_t next;
  const char *changed; /* NULL: nothing is changed */
  long ticks;
  long compared;
  int axis;
  bool failed;
  servo_board board;
  hal machine;
  servo_samples samples; /* recorded, of this tick */
  trace_period period;   /* recorded */
  float bus_voltage_v;
  float duty[SERVO_AXES]; /* set in the last period */
} replay;

static uint32_t next_word(replay *r) {
  if (r->next == r->count) {
    r->count = fread(r->words, sizeof r->words[0], sizeof r->words / sizeof r->words[0], r->file);
    r->next = 0;
    if (r->count == 0) {
      printf("the trace ends without its end\n");
      r->failed = true;
      return TRACE_END;
    }
  }
  return r->words[r->next++];
}

static uint32_t take(void *context, const char *name, uint32_t value) {
  (void)name;
  (void)value;
  return next_word(context);
}

static uint32_t take_changed(void *context, const char *name, uint32_t value) {
  replay *r = context;
  value = next_word(r);
  if (r->changed != NULL && strcmp(name, r->changed) == 0) {
    printf("%s: %08lx is made %08lx\n", name, (unsigned long)value, (unsigned long)(value ^ 1u));
    value ^= 1u;
    r->changed = NULL;
  }
  return value;
}

static uint32_t compare(void *context, const char *name, uint32_t value) {
  replay *r = context;
  const uint32_t recorded = next_word(r);
  ++r->compared;
  if (recorded != value && !r->failed) {
    float floats[2];
    memcpy(&floats[0], &recorded, sizeof recorded);
    memcpy(&floats[1], &value, sizeof value);
    printf("tick %ld, %s, %s: recorded %08lx (%.9g), here %08lx (%.9g)\n", r->ticks,
           r->axis == SERVO_AZIMUTH ? "azimuth" : "pitch", name, (unsigned long)recorded, (double)floats[0],
           (unsigned long)value, (double)floats[1]);
    r->failed = true;
  }
  return value;
}

/* --- the machine: it gives what was recorded --- */

static void sample(void *machine, int axis, hal_axis_samples *samples) {
  *samples = ((replay *)machine)->samples.axis[axis].sensors;
}

static float current(void *machine, int axis) { return ((replay *)machine)->period.current_a[axis]; }

static float bus_voltage(void *machine) { return ((replay *)machine)->bus_voltage_v; }

static void power_bridge(void *machine, int axis, bool on) {
  (void)machine;
  (void)axis;
  (void)on;
}

static void set_duty(void *machine, int axis, float duty) { ((replay *)machine)->duty[axis] = duty; }

static hal machine_of(replay *r) { /* the node's functions, which servo_board does not call, are left out */
  return (hal){.machine = r,
               .sample = sample,
               .power_bridge = power_bridge,
               .current_a = current,
               .bus_voltage_v = bus_voltage,
               .set_duty = set_duty};
}

/* --- its events --- */

static void read_samples(replay *r) {
  const trace_visitor reader = {take, r};
  trace_visit_samples(&reader, &r->samples);
  r->bus_voltage_v = r->samples.bus_voltage_v;
}

static void configure(replay *r) {
  const trace_visitor params_reader = {take_changed, r};
  static servo_params params;
  trace_visit_params(&params_reader, &params);
  read_samples(r);
  r->machine = machine_of(r);
  if (servo_board_start(&r->board, &r->machine, &params) != CONTROL_OK) {
    printf("the parameters are refused\n");
    r->failed = true;
  }
}

static void tick(replay *r) {
  const trace_visitor reader = {take, r};
  const trace_visitor comparer = {compare, r};
  trace_visit_command(&reader, &r->board.command);
  read_samples(r);
  servo_board_tick(&r->board);
  ++r->ticks;
  for (r->axis = 0; r->axis < SERVO_AXES; ++r->axis) {
    trace_visit_tick_results(&comparer, &r->board.samples.axis[r->axis], &r->board.app.axis[r->axis]);
  }
}

static void run_period(replay *r) {
  const trace_visitor reader = {take, r};
  const trace_visitor comparer = {compare, r};
  trace_visit_period(&reader, &r->period);
  r->bus_voltage_v = r->period.bus_voltage_v;
  servo_board_pwm_period(&r->board, r->period.number);
  for (r->axis = 0; r->axis < SERVO_AXES; ++r->axis) {
    trace_visit_duty(&comparer, &r->duty[r->axis]);
  }
}

static void run(replay *r, long max_ticks) {
  const trace_visitor reader = {take, r};
  trace_event event = TRACE_END;
  do {
    trace_visit_event(&reader, &event);
    switch (event) {
      case TRACE_CONFIGURE:
        configure(r);
        break;
      case TRACE_TICK:
        tick(r);
        break;
      case TRACE_PWM:
        run_period(r);
        break;
      case TRACE_END:
      default:
        break;
    }
  } while (!r->failed && event != TRACE_END && r->ticks < max_ticks);
}

bool core_replay(const char *path, const char *changed, long max_ticks) {
  static replay r;
  memset(&r, 0, sizeof r);
  r.changed = changed;
  r.file = fopen(path, "rb");
  if (r.file == NULL) {
    printf("%s: cannot be read\n", path);
    return false;
  }
  run(&r, max_ticks);
  (void)fclose(r.file);
  if (r.changed != NULL) {
    printf("no parameter is named '%s'\n", r.changed);
    return false;
  }
  printf("%s: %ld ticks, %ld words compared: %s\n", path, r.ticks, r.compared,
         r.failed ? "DIFFERENT" : "the same bits");
  return !r.failed && r.ticks != 0;
}
