// SPDX-License-Identifier: Apache-2.0
// Prints the EDS of the test device, or with --json its parameters.json.
#include <cstdio>
#include <string>

#include "dictionary/device_description.hpp"

extern "C" {
#include "canopen/test_device.h"
}

int main(int argc, char **argv) {
  static test_device device;
  const can_sender nowhere{[](void *, const can_frame *) { return false; }, nullptr};
  if (!test_device_init(&device, 1, nowhere)) {
    return 1;
  }
  const trackservo::dictionary::DeviceInfo info{"test_device.eds", "trackservo", "test device", "For tests only"};
  const bool json = argc > 1 && std::string(argv[1]) == "--json";
  const std::string text = json ? trackservo::dictionary::describe_parameters(device.node.dictionary, info).dump(1)
                                : trackservo::dictionary::print_eds(device.node.dictionary, info);
  std::fputs(text.c_str(), stdout);
  return 0;
}
