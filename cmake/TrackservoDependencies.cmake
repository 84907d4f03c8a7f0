# The libraries of the simulator, all from the system's packages.
include_guard(GLOBAL)

find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(tomlplusplus REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(fmt REQUIRED)
find_package(Boost 1.74 REQUIRED CONFIG) # headers only
find_package(CLI11 REQUIRED)

# NLopt's C++ interface is a library of its own on Debian and part of the one library elsewhere, and both CMake
# packages are called NLopt: look for the files instead.
find_path(NLOPT_INCLUDE_DIR nlopt.hpp REQUIRED)
find_library(NLOPT_LIBRARY NAMES nlopt_cxx nlopt REQUIRED)
mark_as_advanced(NLOPT_INCLUDE_DIR NLOPT_LIBRARY)
add_library(trackservo_nlopt INTERFACE)
target_include_directories(trackservo_nlopt SYSTEM INTERFACE "${NLOPT_INCLUDE_DIR}")
target_link_libraries(trackservo_nlopt INTERFACE "${NLOPT_LIBRARY}")
