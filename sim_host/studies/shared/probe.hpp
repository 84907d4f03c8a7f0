// A case of a shipped study, with some of its figures.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_PROBE_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_PROBE_HPP

#include <string>
#include <utility>
#include <vector>

#include "studies/shared/study.hpp"

namespace trackservo::sim {

struct Probe {
  std::string experiment;
  std::string case_name;
  std::vector<std::string> metrics;
};

// The shipped studies' cases with their deciding figures.
namespace probes {
Probe sine();
Probe disturbed_step();
Probe start();
Probe steady(const char *case_name);  // peak and rms
Probe paper_loop();
Probe improved_loop();
}  // namespace probes

// The study with the probe's case; studies of one experiment differ in their cases. Throws std::invalid_argument when
// there is none.
std::pair<const Study *, StudyCase> find_case(const Probe& probe, const std::vector<Study>& studies);

}  // namespace trackservo::sim

#endif
