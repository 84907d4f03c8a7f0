#include "studies/shared/probe.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace trackservo::sim {
namespace probes {

Probe sine() { return {"sine", "1 deg/s, 0.1 Hz", {"peak_error"}}; }
Probe disturbed_step() { return {"step_disturbed", "1 deg/s", {"overshoot"}}; }
Probe start() { return {"low_speed_start", "0.1 deg/s", {"time_to_90_percent", "overshoot"}}; }
Probe steady(const char *case_name) { return {"steady_speed", case_name, {"peak_error", "rms_error"}}; }
Probe paper_loop() { return {"tracking", "paper loop", {"tracking_sigma"}}; }
Probe improved_loop() { return {"tracking", "improved loop", {"tracking_sigma"}}; }

}  // namespace probes

std::pair<const Study *, StudyCase> find_case(const Probe& probe, const std::vector<Study>& studies) {
  for (const Study& study : studies) {
    for (const StudyCase& study_case : cases_of(study)) {
      if (study.experiment == probe.experiment && study_case.name == probe.case_name) {
        return {&study, study_case};
      }
    }
  }
  throw std::invalid_argument(
      fmt::format("no scenario \"{}\" has the case \"{}\"; add the speed to it", probe.experiment, probe.case_name));
}

}  // namespace trackservo::sim
