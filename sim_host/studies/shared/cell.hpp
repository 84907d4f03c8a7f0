// SPDX-License-Identifier: Apache-2.0
// The figures of one case under one controller, over all seeds: a row of the results.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_CELL_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_CELL_HPP

#include <string>
#include <vector>

#include "studies/shared/study.hpp"

namespace trackservo::sim {

// Figures of one combination over all seeds.
struct Cell {
  std::string experiment;
  std::string case_name;
  std::string plant;
  FrictionModel friction;
  std::string controller;
  int axis;
  std::string metric;
  std::string unit;
  std::vector<double> values;  // one per seed
};

}  // namespace trackservo::sim

#endif
