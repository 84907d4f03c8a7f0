// SPDX-License-Identifier: Apache-2.0
#include "machine/run/trace.hpp"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <stdexcept>

namespace trackservo::sim {
namespace {

struct Column {
  const char *name;
  double AxisRow::*value;
};

constexpr Column kColumns[] = {
    {"reference_rad_s", &AxisRow::reference_rad_s},
    {"rate_rad_s", &AxisRow::rate_rad_s},
    {"measured_rate_rad_s", &AxisRow::measured_rate_rad_s},
    {"joint_rate_rad_s", &AxisRow::joint_rate_rad_s},
    {"joint_angle_rad", &AxisRow::joint_angle_rad},
    {"torque_nm", &AxisRow::torque_nm},
    {"friction_nm", &AxisRow::friction_nm},
    {"friction_feedforward_nm", &AxisRow::friction_feedforward_nm},
    {"disturbance_estimate_nm", &AxisRow::disturbance_estimate_nm},
    {"load_nm", &AxisRow::load_nm},
    {"tracking_error_rad", &AxisRow::tracking_error_rad},
};

}  // namespace

void write_csv(const Trace& trace, const std::filesystem::path& file, const CsvForm& form) {
  fmt::memory_buffer text;
  auto out = std::back_inserter(text);
  fmt::format_to(out, "time_s");
  for (const char *axis : {"azimuth", "pitch"}) {
    for (const Column& column : kColumns) {
      fmt::format_to(out, ",{}_{}", axis, column.name);
    }
  }
  for (std::size_t i = 0; i < trace.size(); i += static_cast<std::size_t>(form.decimation)) {
    fmt::format_to(out, "\n{:.4f}", trace[i].time_s);
    for (const AxisRow& axis : trace[i].axis) {
      for (const Column& column : kColumns) {
        fmt::format_to(out, ",{:.{}g}", axis.*(column.value), form.digits);
      }
    }
  }
  fmt::format_to(out, "\n");
  std::ofstream stream(file, std::ios::binary);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  if (!stream.flush()) {
    throw std::runtime_error(fmt::format("{}: cannot be written; give an existing, writable folder", file.string()));
  }
}

}  // namespace trackservo::sim
