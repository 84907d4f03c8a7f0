// SPDX-License-Identifier: Apache-2.0
// Prints the modelDescription.xml of the unit that it is linked with. Run by the build.
#include <cstdio>
#include <exception>

#include "unit_description.hpp"

int main() {
  try {
    const std::string text = trackservo::fmi::model_description(*trackservo::fmi::make_unit(""));
    return std::fputs(text.c_str(), stdout) < 0 ? 1 : 0;
  } catch (const std::exception& error) {
    (void)std::fprintf(stderr, "describe_unit: %s\n", error.what());
    return 1;
  }
}
