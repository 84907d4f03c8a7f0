#include "cortex_m4/core_replay.h"

#include <stdio.h>
#include <string.h>

#include "cortex_m4/core_trace.h"

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

static void configure(replay *r, servo_app *app) {
  const trace_visitor params_reader = {take_changed, r};
  const trace_visitor reader = {take, r};
  static servo_params params;
  servo_samples samples;
  trace_visit_params(&params_reader, &params);
  trace_visit_samples(&reader, &samples);
  if (servo_app_configure(app, &params, &samples) != CONTROL_OK) {
    printf("the parameters are refused\n");
    r->failed = true;
  }
}

static void tick(replay *r, servo_app *app) {
  const trace_visitor reader = {take, r};
  const trace_visitor comparer = {compare, r};
  servo_command command;
  servo_samples samples;
  trace_visit_command(&reader, &command);
  trace_visit_samples(&reader, &samples);
  servo_app_tick(app, &command, &samples);
  ++r->ticks;
  for (r->axis = 0; r->axis < SERVO_AXES; ++r->axis) {
    trace_visit_tick_results(&comparer, &app->axis[r->axis]);
  }
}

static void run_period(replay *r, servo_app *app) {
  const trace_visitor reader = {take, r};
  const trace_visitor comparer = {compare, r};
  trace_period period;
  trace_visit_period(&reader, &period);
  app->axis[period.axis].current_reference_a = period.reference_a;
  float duty = servo_app_pwm(app, period.axis, period.current_a, period.bus_voltage_v);
  r->axis = period.axis;
  trace_visit_duty(&comparer, &duty);
}

static void run(replay *r, long max_ticks) {
  static servo_app app;
  const trace_visitor reader = {take, r};
  trace_event event = TRACE_END;
  do {
    trace_visit_event(&reader, &event);
    switch (event) {
      case TRACE_CONFIGURE:
        configure(r, &app);
        break;
      case TRACE_TICK:
        tick(r, &app);
        break;
      case TRACE_PWM:
        run_period(r, &app);
        break;
      case TRACE_END:
      default:
        break;
    }
  } while (!r->failed && event != TRACE_END && r->ticks < max_ticks);
}

bool core_replay(const char *path, const char *changed, long max_ticks) {
  static replay r;
  r = (replay){.changed = changed, .file = fopen(path, "rb")};
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
