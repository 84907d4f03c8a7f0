// SPDX-License-Identifier: Apache-2.0
#include "judge/fault_injection/fault_account.hpp"

#include "judge/fault_injection/fault_injection.hpp"

namespace trackservo::sim {
namespace {

std::vector<FaultTest> list_tests() {
  const std::string board = "tests/target/test_board.cpp";
  const std::string faults = "tests/target/test_board_faults.cpp";
  const std::string memory = "tests/target/test_board_memory.cpp";
  const std::string envelope = "firmware/protection/tests/test_envelope.c";
  const std::string end_stops = "tests/closed_loop/test_end_stops.cpp";
  const std::string moving = "tests/target/test_board_moving.cpp";
  const std::string tracking = "firmware/node/tests/test_node_tracking.c";
  const std::string torque = "tests/target/test_board_safe_torque.cpp";
  const std::string store = "tests/store/test_stored_set.c";
  const std::string witness = "tests/closed_loop/test_witness.cpp";
  const std::string shaking = "tests/closed_loop/test_shaking_gains.cpp";
  const std::string reset = "test_what_ends_in_a_reset_is_safe_in_every_motion";
  return {
      {FAULT_ENCODER_LOST, faults, "test_an_axis_without_its_encoder_is_switched_off"},
      {FAULT_GYRO_LOST, faults, "test_an_axis_without_its_gyro_stops_by_its_encoder"},
      {FAULT_OVER_CURRENT_TRIP, faults, "test_an_over_current_switches_its_bridge_off_within_two_periods"},
      {FAULT_POWER_STAGE, faults, "test_a_driver_fault_switches_its_bridge_off_at_once"},
      {FAULT_BUS_OFF, board, "test_it_comes_back_from_bus_off"},
      {FAULT_TICK_LATE, moving, reset},
      {FAULT_SELF_TEST, memory, "test_a_stuck_bit_of_ram_keeps_both_axes_from_being_ready"},
      {FAULT_WATCHDOG_RESET, moving, reset},
      {FAULT_EXCEPTION_RESET, moving, reset},
      {FAULT_BROWN_OUT_RESET, moving, reset},
      {FAULT_IMAGE_DAMAGED, moving, "test_a_damaged_image_stops_both_axes"},
      {FAULT_STACK_OVERFLOW, moving, reset},
      {FAULT_OSCILLATION, shaking, "test_without_gains_to_take_back_the_axis_stops_with_its_own_fault"},
      {FAULT_GAINS_TAKEN_BACK, shaking, "test_the_gains_that_shook_unnoticed_are_taken_back"},
      {FAULT_TOO_FAST, end_stops, "test_no_write_at_full_speed_near_the_end_reaches_the_end_stop"},
      {FAULT_STOP_IGNORED, envelope, "test_an_ordered_stop_must_slow_the_axis_down"},
      {FAULT_BRAKING_FAILS, envelope, "test_braking_that_does_not_slow_the_axis_down_fails_within_40_ms"},
      {FAULT_PARAMETERS_LOST, store, "test_a_damaged_set_is_skipped_and_reported_until_the_next_save"},
      {FAULT_RAM_PARITY, memory, "test_a_parity_error_switches_both_bridges_off_and_resets"},
      {FAULT_HOLDING_BRAKE, torque, "test_a_contact_that_contradicts_the_coil_is_a_fault_of_its_axis"},
      {FAULT_SAFE_TORQUE_OFF, torque, "test_each_channel_alone_removes_the_torque_of_both_axes"},
      {FAULT_SAFE_TORQUE_FAULT, torque, "test_channels_that_differ_are_a_fault_until_both_have_been_off"},
      {FAULT_CLOCK, faults, "test_a_clock_that_is_3_percent_off_stops_both_axes"},
      {FAULT_OPTION_BYTES, memory, "test_a_flipped_bit_of_the_hot_code_is_found_without_parity_as_well"},
      {FAULT_MOTOR_CONTRADICTS, witness, "test_sensors_that_are_wrong_together_are_found_by_the_motor"},
      {FAULT_MOTOR_WEAK, witness, "test_a_motor_with_half_its_torque_is_found_under_excitation"},
      {FAULT_SENSORS_DRIFT, witness, "test_a_slow_drift_of_either_sensor_is_found_at_rest"},
      {FAULT_ENCODER_ERRATIC, witness, "test_an_encoder_that_is_wrong_in_some_ticks_is_named"},
      {FAULT_STANDSTILL_LEFT, witness, "test_an_axis_that_is_pushed_out_of_its_standstill_is_found"},
      {FAULT_REDUCED_SPEED, witness, "test_reduced_speed_is_monitored_when_it_is_selected"},
      {FAULT_NO_ANSWER, witness, "test_dead_sensors_at_rest_do_not_answer_the_test_torque"},
      {FAULT_CAMERA_STALE, tracking, "test_a_frozen_picture_stops_the_axis_that_it_drives"},
      {FAULT_ACTIVE_SET, witness, "test_every_bit_that_flips_in_the_active_set_is_found_and_its_motion_bounded"},
  };
}

}  // namespace

const std::vector<FaultTest>& fault_tests() {
  static const std::vector<FaultTest> list = list_tests();
  return list;
}

std::vector<std::string> fault_injections_of(fault_id fault) {
  std::vector<std::string> names;
  for (const FaultInjection& one : fault_injections()) {
    if (one.expected == fault && one.detection == Detection::kAlways) {
      names.push_back(one.name);
    }
  }
  return names;
}

}  // namespace trackservo::sim
