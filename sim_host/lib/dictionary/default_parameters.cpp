#include <fmt/format.h>

#include <string>

#include "device_description.hpp"

namespace trackservo::dictionary {
namespace {

void print(std::string& text, const char *member, float value) {
  const std::string number = fmt::format("{}", value);
  const bool is_whole = number.find_first_of(".e") == std::string::npos;
  text += fmt::format("        .{} = {}{}f,\n", member, number, is_whole ? ".0" : "");
}

void print(std::string& text, const char *member, std::uint32_t value) {
  text += fmt::format("        .{} = {}u,\n", member, value);
}

std::string print_axis(const axis_parameters& p) {
  std::string text;
#define PRINT(member) print(text, #member, p.member)
  PRINT(speed_loop.proportional_nm_s_rad);
  PRINT(speed_loop.integral_nm_rad);
  PRINT(speed_loop.setpoint_weight);
  PRINT(speed_loop.tracking_rate_per_s);
  PRINT(speed_loop.acceleration_inertia_kg_m2);
  PRINT(position_loop.proportional_per_s);
  PRINT(position_loop.rate_limit_rad_s);
  PRINT(position_loop.deceleration_rad_s2);
  PRINT(tracking_loop.kind);
  PRINT(tracking_loop.proportional_per_s);
  PRINT(tracking_loop.integral_per_s2);
  PRINT(tracking_loop.estimator_rad_s);
  PRINT(tracking_loop.coast_s);
  PRINT(observer.on);
  PRINT(observer.inertia_kg_m2);
  PRINT(observer.viscous_nm_s_rad);
  PRINT(observer.bandwidth_rad_s);
  PRINT(observer.limit_nm);
  PRINT(friction.model);
  PRINT(friction.gain);
  PRINT(friction.lead_limit_rad_s);
  PRINT(friction.sign_width_rad_s);
  PRINT(friction.stiffness_nm_rad);
  PRINT(friction.damping_nm_s_rad);
  PRINT(friction.positive.coulomb_nm);
  PRINT(friction.positive.breakaway_nm);
  PRINT(friction.positive.stribeck_speed_rad_s);
  PRINT(friction.positive.viscous_nm_s_rad);
  PRINT(friction.negative.coulomb_nm);
  PRINT(friction.negative.breakaway_nm);
  PRINT(friction.negative.stribeck_speed_rad_s);
  PRINT(friction.negative.viscous_nm_s_rad);
  PRINT(filters.notch_hz);
  PRINT(filters.notch_width_hz);
  PRINT(filters.notch_depth);
  PRINT(filters.lowpass_hz);
  PRINT(filters.lowpass_damping);
  PRINT(sensors.source);
  PRINT(sensors.crossover_rad_s);
  PRINT(sensors.window_ticks);
  PRINT(motor.torque_constant_nm_a);
  PRINT(motor.resistance_ohm);
  PRINT(motor.inductance_h);
  PRINT(motor.back_emf_v_s_rad);
  PRINT(motor.bandwidth_rad_s);
  PRINT(motor.current_limit_a);
#undef PRINT
  return text;
}

std::string print_limits(const protection_limits& p) {
  std::string text;
#define PRINT(member) print(text, #member, p.member)
  PRINT(overspeed_rad_s);
  PRINT(base_rate_rad_s);
  PRINT(gyro_range_rad_s);
  PRINT(encoder_jump_rad);
  PRINT(stuck_s);
  PRINT(speed_error_rad_s);
  PRINT(speed_error_s);
  PRINT(stall_s);
  PRINT(minimum_rad);
  PRINT(maximum_rad);
  PRINT(continuous_current_a);
  PRINT(thermal_time_s);
  PRINT(current_offset_a);
  PRINT(voltage_mismatch_v);
  PRINT(under_voltage_v);
  PRINT(over_voltage_v);
  PRINT(stopping_margin_rad);
#undef PRINT
  return text;
}

std::string both(const std::string& azimuth, const std::string& pitch) {
  return "    {\n" + azimuth + "    },\n    {\n" + pitch + "    },\n};\n";
}

}  // namespace

std::string print_default_parameters(const std::array<axis_parameters, SERVO_AXES>& parameters,
                                     const std::array<protection_limits, SERVO_AXES>& limits) {
  return "/* Printed by the build from sim_host/plants/tracker.toml: do not edit it,\n"
         " * `tools/update-docs dictionary` renews it. */\n"
         "#include \"app/default_parameters.h\"\n\n"
         "const axis_parameters default_parameters[SERVO_AXES] = {\n" +
         both(print_axis(parameters[0]), print_axis(parameters[1])) +
         "\nconst protection_limits default_limits[SERVO_AXES] = {\n" +
         both(print_limits(limits[0]), print_limits(limits[1]));
}

std::string print_default_schema(std::uint32_t schema_hash) {
  return fmt::format(
      "/* Printed by the build from the node's dictionary: do not edit it, `tools/update-docs dictionary` renews "
      "it. */\n"
      "#ifndef TRACKSERVO_APP_DEFAULT_SCHEMA_H\n"
      "#define TRACKSERVO_APP_DEFAULT_SCHEMA_H\n\n"
      "/* Object 3030:2, see node/schema_hash.h. */\n"
      "#define DEFAULT_SCHEMA_HASH 0x{:08X}u\n\n"
      "#endif\n",
      schema_hash);
}

}  // namespace trackservo::dictionary
