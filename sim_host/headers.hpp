// SPDX-License-Identifier: Apache-2.0
// Headers of other libraries that nearly every C++ file here includes. The build compiles them once (CMakeLists.txt,
// beside this file); no file includes this one.
#ifndef TRACKSERVO_SIM_HOST_HEADERS_HPP
#define TRACKSERVO_SIM_HOST_HEADERS_HPP

#include <fmt/format.h>
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iomanip>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <variant>
#include <vector>

#endif
