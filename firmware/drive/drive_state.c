/* SPDX-License-Identifier: Apache-2.0 */
#include "drive/drive_state.h"

typedef enum {
  COMMAND_NONE,
  COMMAND_SHUTDOWN,
  COMMAND_SWITCH_ON, /* the same bits mean Disable operation when operation is enabled */
  COMMAND_ENABLE_OPERATION,
  COMMAND_DISABLE_VOLTAGE,
  COMMAND_QUICK_STOP
} drive_command;

enum { QUICK_STOP_STAYS = 5, LAST_OPTION = 6 };

/* The standard requires bit 7 = 0 for a command. Commands that remove power are executed with either value, so a client
 * that leaves the bit set can still stop the axis. */
static drive_command command_of(uint16_t controlword) {
  if ((controlword & DRIVE_CONTROL_ENABLE_VOLTAGE) == 0) {
    return COMMAND_DISABLE_VOLTAGE;
  }
  if ((controlword & DRIVE_CONTROL_NO_QUICK_STOP) == 0) {
    return COMMAND_QUICK_STOP;
  }
  if ((controlword & DRIVE_CONTROL_FAULT_RESET) != 0) {
    return COMMAND_NONE;
  }
  if ((controlword & DRIVE_CONTROL_SWITCH_ON) == 0) {
    return COMMAND_SHUTDOWN;
  }
  return (controlword & DRIVE_CONTROL_ENABLE_OPERATION) != 0 ? COMMAND_ENABLE_OPERATION : COMMAND_SWITCH_ON;
}

static int16_t supported_or(uint16_t index, int16_t code, int16_t otherwise) {
  return drive_option_supported(index, code) ? code : otherwise;
}

/* The option codes in effect: read only when one is needed, which is rare. */
static int16_t quick_stop_of(const drive_options *options) {
  return supported_or(0x605A, options->quick_stop, drive_options_default().quick_stop);
}

static int16_t shutdown_of(const drive_options *options) {
  return supported_or(0x605B, options->shutdown, drive_options_default().shutdown);
}

static int16_t disable_of(const drive_options *options) {
  return supported_or(0x605C, options->disable, drive_options_default().disable);
}

static int16_t halt_of(const drive_options *options) {
  return supported_or(0x605D, options->halt, drive_options_default().halt);
}

static int16_t fault_reaction_of(const drive_options *options) {
  return supported_or(0x605E, options->fault_reaction, drive_options_default().fault_reaction);
}

/* Actions of an option code: the same numbers in all five objects. */
static drive_action action_of_option(int16_t code) {
  switch (code) {
    case 0:
      return DRIVE_OFF;
    case 1:
    case QUICK_STOP_STAYS:
      return DRIVE_SLOW_DOWN;
    default:
      return DRIVE_QUICK_STOP;
  }
}

/* Leaves Operation enabled for `next`, with or without a stop before. */
static drive_action leave(drive_state *state, drive_power_state next, int16_t option, bool stopped) {
  const drive_action stop = action_of_option(option);
  if (stop == DRIVE_OFF || stopped) {
    state->power = next;
    return DRIVE_OFF;
  }
  state->ends_off = true;
  return stop;
}

/* Of an axis in operation. */
static drive_action run_or_halt(const drive_options *options, const drive_state_inputs *in) {
  return (in->controlword & DRIVE_CONTROL_HALT) != 0 ? action_of_option(halt_of(options)) : DRIVE_RUN;
}

static void enter_operation(drive_state *state) {
  state->power = DRIVE_OPERATION_ENABLED;
  state->shuts_down = false;
  state->disables = false;
}

/* A word that is no command ends no stop that is under way. */
static drive_command command_in_operation(drive_state *state, uint16_t controlword) {
  const drive_command command = command_of(controlword);
  if (command == COMMAND_NONE) {
    return state->shuts_down ? COMMAND_SHUTDOWN : state->disables ? COMMAND_SWITCH_ON : COMMAND_NONE;
  }
  state->shuts_down = command == COMMAND_SHUTDOWN;
  state->disables = command == COMMAND_SWITCH_ON;
  return command;
}

static drive_action operation_enabled(drive_state *state, const drive_options *options, const drive_state_inputs *in) {
  switch (command_in_operation(state, in->controlword)) {
    case COMMAND_DISABLE_VOLTAGE: /* 9 */
      state->power = DRIVE_SWITCH_ON_DISABLED;
      return DRIVE_OFF;
    case COMMAND_QUICK_STOP: /* 11 */
      state->power = DRIVE_QUICK_STOP_ACTIVE;
      return action_of_option(quick_stop_of(options));
    case COMMAND_SHUTDOWN: /* 8 */
      return leave(state, DRIVE_READY_TO_SWITCH_ON, shutdown_of(options), in->stopped);
    case COMMAND_SWITCH_ON: /* 5 */
      return leave(state, DRIVE_SWITCHED_ON, disable_of(options), in->stopped);
    case COMMAND_ENABLE_OPERATION:
    case COMMAND_NONE:
    default:
      return run_or_halt(options, in);
  }
}

static drive_action quick_stop_active(drive_state *state, const drive_options *options, const drive_state_inputs *in) {
  const drive_command command = command_of(in->controlword);
  const drive_action stop = action_of_option(quick_stop_of(options));
  const bool stays = quick_stop_of(options) >= QUICK_STOP_STAYS;
  if (command == COMMAND_DISABLE_VOLTAGE || stop == DRIVE_OFF || (!stays && in->stopped)) { /* 12 */
    state->power = DRIVE_SWITCH_ON_DISABLED;
    return DRIVE_OFF;
  }
  if (stays && command == COMMAND_ENABLE_OPERATION) { /* 16 */
    enter_operation(state);
    return run_or_halt(options, in); /* one tick of motion would begin a ramp that the halt then has to stop */
  }
  state->ends_off = !stays;
  return stop;
}

/* The states without torque and without a fault. */
static void powerless(drive_state *state, const drive_state_inputs *in) {
  const drive_command command = command_of(in->controlword);
  const bool takes_away = command == COMMAND_DISABLE_VOLTAGE || command == COMMAND_QUICK_STOP;
  const bool gives = command == COMMAND_SWITCH_ON || command == COMMAND_ENABLE_OPERATION;
  if (state->power == DRIVE_NOT_READY) { /* 1 */
    state->power = in->ready ? DRIVE_SWITCH_ON_DISABLED : DRIVE_NOT_READY;
  } else if (state->power == DRIVE_SWITCH_ON_DISABLED) { /* 2 */
    state->power = command == COMMAND_SHUTDOWN ? DRIVE_READY_TO_SWITCH_ON : DRIVE_SWITCH_ON_DISABLED;
  } else if (takes_away) { /* 7, 10 */
    state->power = DRIVE_SWITCH_ON_DISABLED;
  } else if (command == COMMAND_SHUTDOWN) { /* 6 */
    state->power = DRIVE_READY_TO_SWITCH_ON;
  } else if (state->power == DRIVE_READY_TO_SWITCH_ON) { /* 3 */
    state->power = gives && in->voltage_present && in->may_enable ? DRIVE_SWITCHED_ON : DRIVE_READY_TO_SWITCH_ON;
  } else if (command == COMMAND_ENABLE_OPERATION && in->may_enable) { /* 4 */
    enter_operation(state);
  }
}

/* 14: the fault reaction is complete. */
static drive_action end_reaction(drive_state *state) {
  state->power = DRIVE_FAULT;
  return DRIVE_OFF;
}

static drive_action brake(drive_state *state) {
  return ++state->reaction_ticks > DRIVE_BRAKE_TICKS ? end_reaction(state) : DRIVE_BRAKE;
}

static drive_action brake_by_loop(drive_state *state, const drive_options *options, const drive_state_inputs *in) {
  const drive_action action = action_of_option(fault_reaction_of(options));
  const bool over = in->stopped || action == DRIVE_OFF || ++state->reaction_ticks > DRIVE_LONGEST_REACTION_TICKS;
  state->ends_off = true;
  return over ? end_reaction(state) : action;
}

static drive_action brake_protectively(drive_state *state, const drive_state_inputs *in) {
  const bool stopped = in->stopped && state->action == DRIVE_PROTECTIVE_STOP; /* not the end of a stop before it */
  const bool over = stopped || ++state->reaction_ticks > DRIVE_LONGEST_PROTECTIVE_STOP_TICKS;
  state->ends_off = true;
  return over ? end_reaction(state) : DRIVE_PROTECTIVE_STOP;
}

/* An axis without torque gets none. Only one that has turned ever since it had torque is still braked protectively. */
static bool stays_off(const drive_state *state, const drive_state_inputs *in) {
  return state->action == DRIVE_OFF && !(state->reaction == DRIVE_FAULT_PROTECTS && in->turns);
}

/* Never a milder reaction than before, even when the fault is gone: it was present. */
static drive_action fault_reaction(drive_state *state, const drive_options *options, const drive_state_inputs *in) {
  if (in->fault > state->reaction) {
    state->reaction = in->fault;
    state->reaction_ticks = 0;
  }
  if (stays_off(state, in) || state->reaction == DRIVE_FAULT_CUTS) {
    return end_reaction(state);
  }
  if (state->reaction == DRIVE_FAULT_PROTECTS) {
    return brake_protectively(state, in);
  }
  return state->reaction == DRIVE_FAULT_BRAKES ? brake(state) : brake_by_loop(state, options, in);
}

/* 13, from every state. */
static drive_action enter_fault(drive_state *state, const drive_options *options, const drive_state_inputs *in) {
  state->power = DRIVE_FAULT_REACTION_ACTIVE;
  state->reaction = in->fault;
  state->reaction_ticks = 0;
  if (stays_off(state, in) || in->fault == DRIVE_FAULT_CUTS) {
    return DRIVE_OFF;
  }
  if (in->fault == DRIVE_FAULT_PROTECTS) {
    return DRIVE_PROTECTIVE_STOP;
  }
  return in->fault == DRIVE_FAULT_BRAKES ? DRIVE_BRAKE : action_of_option(fault_reaction_of(options));
}

static drive_action next_action(drive_state *state, const drive_options *options, const drive_state_inputs *in,
                                bool reset_edge) {
  const bool in_fault = state->power == DRIVE_FAULT_REACTION_ACTIVE || state->power == DRIVE_FAULT;
  const bool turns_on = state->power == DRIVE_FAULT && in->fault == DRIVE_FAULT_PROTECTS && in->turns;
  if ((in->fault != DRIVE_NO_FAULT && !in_fault) || turns_on) {
    return enter_fault(state, options, in);
  }
  switch (state->power) {
    case DRIVE_OPERATION_ENABLED:
      return operation_enabled(state, options, in);
    case DRIVE_QUICK_STOP_ACTIVE:
      return quick_stop_active(state, options, in);
    case DRIVE_FAULT_REACTION_ACTIVE:
      return fault_reaction(state, options, in);
    case DRIVE_FAULT: /* 15 */
      state->power = reset_edge && in->fault == DRIVE_NO_FAULT ? DRIVE_SWITCH_ON_DISABLED : DRIVE_FAULT;
      return DRIVE_OFF;
    case DRIVE_NOT_READY:
    case DRIVE_SWITCH_ON_DISABLED:
    case DRIVE_READY_TO_SWITCH_ON:
    case DRIVE_SWITCHED_ON:
    default:
      powerless(state, in);
      return state->power == DRIVE_OPERATION_ENABLED ? DRIVE_RUN : DRIVE_OFF;
  }
}

void drive_state_reset(drive_state *state) { *state = (drive_state){.power = DRIVE_NOT_READY}; }

drive_action drive_state_step(drive_state *state, const drive_options *options, const drive_state_inputs *in) {
  const bool reset_bit = (in->controlword & DRIVE_CONTROL_FAULT_RESET) != 0;
  const bool reset_edge = reset_bit && !state->reset_bit_before;
  state->reset_bit_before = reset_bit;
  state->ends_off = false;
  state->action = next_action(state, options, in, reset_edge);
  return state->action;
}

uint16_t drive_state_statusword(drive_power_state power) {
  static const uint16_t words[] = {
      [DRIVE_NOT_READY] = 0x0020,
      [DRIVE_SWITCH_ON_DISABLED] = 0x0060,
      [DRIVE_READY_TO_SWITCH_ON] = 0x0021,
      [DRIVE_SWITCHED_ON] = 0x0023,
      [DRIVE_OPERATION_ENABLED] = 0x0027,
      [DRIVE_QUICK_STOP_ACTIVE] = 0x0007,
      [DRIVE_FAULT_REACTION_ACTIVE] = 0x002F,
      [DRIVE_FAULT] = 0x0028,
  };
  return words[power];
}

bool drive_option_supported(uint16_t index, int16_t code) {
  /* Bit n: code n is supported. */
  static const uint8_t codes[] = {0x67, 0x03, 0x03, 0x06, 0x07};
  if (index < 0x605A || index > 0x605E || code < 0 || code > LAST_OPTION) {
    return false;
  }
  return ((codes[index - 0x605A] >> code) & 1) != 0;
}

drive_options drive_options_default(void) {
  return (drive_options){.master_silent = DRIVE_SILENT_QUICK_STOP,
                         .quick_stop = 2,
                         .shutdown = 0,
                         .disable = 1,
                         .halt = 1,
                         .fault_reaction = 2};
}
