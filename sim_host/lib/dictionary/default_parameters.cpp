// SPDX-License-Identifier: Apache-2.0
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
#define PRINT_NOTHING(...)
#define PRINT_REAL(index, sub, flags, group, member, ...) print(text, #group "." #member, p.group.member);
#define PRINT_WHOLE(index, sub, flags, group, member, ...) print(text, #group "." #member, p.group.member);
#define PRINT_DIRECTION(sub, side, title) FRICTION_DIRECTION_ROWS(PRINT_REAL, sub, side, title)
  AXIS_PARAMETERS(PRINT_NOTHING, PRINT_REAL, PRINT_REAL, PRINT_WHOLE, PRINT_DIRECTION, PRINT_NOTHING)
  return text;
}

std::string print_limits(const protection_limits& p) {
  std::string text;
#define PRINT_LIMIT(sub, member, ...) print(text, #member, p.member);
  PROTECTION_LIMITS(PRINT_LIMIT)
  return text;
}

std::string both(const std::string& azimuth, const std::string& pitch) {
  return "    {\n" + azimuth + "    },\n    {\n" + pitch + "    },\n};\n";
}

}  // namespace

axis_parameters listed_defaults() {
  axis_parameters p{};
#define SET_NOTHING(...)
#define SET_REAL(index, sub, flags, group, member, low, high, preset, ...) p.group.member = preset;
#define SET_WHOLE(index, sub, flags, group, member, low, high, preset, ...) p.group.member = preset;
#define SET_DIRECTION(sub, side, title) FRICTION_DIRECTION_ROWS(SET_REAL, sub, side, title)
  AXIS_PARAMETERS(SET_NOTHING, SET_REAL, SET_REAL, SET_WHOLE, SET_DIRECTION, SET_NOTHING)
  return p;
}

std::string print_default_parameters(const std::array<axis_parameters, SERVO_AXES>& parameters,
                                     const std::array<protection_limits, SERVO_AXES>& limits) {
  return "/* SPDX-License-Identifier: Apache-2.0 */\n"
         "/* Printed by the build from sim_host/plants/tracker.toml: do not edit it,\n"
         " * `tools/update-docs dictionary` renews it. */\n"
         "#include \"products/brushed_tracker/default_parameters.h\"\n\n"
         "const axis_parameters default_parameters[SERVO_AXES] = {\n" +
         both(print_axis(parameters[0]), print_axis(parameters[1])) +
         "\nconst protection_limits default_limits[SERVO_AXES] = {\n" +
         both(print_limits(limits[0]), print_limits(limits[1]));
}

std::string print_default_schema(std::uint32_t schema_hash) {
  return fmt::format(
      "/* SPDX-License-Identifier: Apache-2.0 */\n"
      "/* Printed by the build from the node's dictionary: do not edit it, `tools/update-docs dictionary` renews "
      "it. */\n"
      "#ifndef TRACKSERVO_PRODUCTS_BRUSHED_TRACKER_DEFAULT_SCHEMA_H\n"
      "#define TRACKSERVO_PRODUCTS_BRUSHED_TRACKER_DEFAULT_SCHEMA_H\n\n"
      "/* Object 3030:2, see node/schema_hash.h. */\n"
      "#define DEFAULT_SCHEMA_HASH 0x{:08X}u\n\n"
      "#endif\n",
      schema_hash);
}

}  // namespace trackservo::dictionary
