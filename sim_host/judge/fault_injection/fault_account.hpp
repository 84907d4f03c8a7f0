// SPDX-License-Identifier: Apache-2.0
// Where each fault of the firmware's table is tested: its injections in `sim_host faults`, and the other tests.
#ifndef TRACKSERVO_SIM_FAULT_INJECTION_FAULT_ACCOUNT_HPP
#define TRACKSERVO_SIM_FAULT_INJECTION_FAULT_ACCOUNT_HPP

#include <string>
#include <vector>

extern "C" {
#include "protection/fault_table.h"
}

namespace trackservo::sim {

// A test that causes a fault outside the simulator's matrix: on the emulated board, in the store.
struct FaultTest {
  fault_id fault;
  std::string file;  // within the project
  std::string test;  // its function
};

const std::vector<FaultTest>& fault_tests();

// Names of the injections that must be detected as this fault.
std::vector<std::string> fault_injections_of(fault_id fault);

}  // namespace trackservo::sim

#endif
