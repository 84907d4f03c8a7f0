# SPDX-License-Identifier: Apache-2.0
# The libraries of the simulator, all from the system's packages. Every folder may link them.
include_guard(GLOBAL)
include(TrackservoMissing)

set(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL ON)
trackservo_find_library("The library Eigen, 3.4 or newer," Eigen3 3.4 NO_MODULE)
trackservo_find_library("The library toml++" tomlplusplus)
trackservo_find_library("The library JSON for Modern C++ (nlohmann_json)" nlohmann_json)
trackservo_find_library("The library {fmt}" fmt)
trackservo_find_library("The library Boost, 1.74 or newer," Boost 1.74 CONFIG) # headers only
trackservo_find_library("The library CLI11" CLI11)
trackservo_find_library("The library pugixml" pugixml)
unset(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL)

# Those with code of their own: as the system links them, or within a program that is released.
foreach(library IN ITEMS fmt toml pugixml)
  add_library(trackservo_${library} INTERFACE)
endforeach()
if(TRACKSERVO_RELEASE)
  target_link_libraries(trackservo_fmt INTERFACE fmt::fmt-header-only)
  target_compile_definitions(trackservo_toml INTERFACE TOML_HEADER_ONLY=1)
  target_compile_features(trackservo_toml INTERFACE cxx_std_17)
  target_include_directories(
    trackservo_toml SYSTEM INTERFACE $<TARGET_PROPERTY:tomlplusplus::tomlplusplus,INTERFACE_INCLUDE_DIRECTORIES>)
  target_link_libraries(trackservo_pugixml INTERFACE pugixml::static)
else()
  target_link_libraries(trackservo_fmt INTERFACE fmt::fmt)
  target_link_libraries(trackservo_toml INTERFACE tomlplusplus::tomlplusplus)
  target_link_libraries(trackservo_pugixml INTERFACE pugixml::pugixml)
endif()

# NLopt's C++ interface is a library of its own on Debian and part of the one library elsewhere, and both CMake
# packages are called NLopt: look for the files instead. What we use is in C, so that a release brings the one that needs no
# library of C++.
find_path(NLOPT_INCLUDE_DIR nlopt.hpp)
if(TRACKSERVO_RELEASE)
  find_library(NLOPT_LIBRARY NAMES nlopt)
else()
  find_library(NLOPT_LIBRARY NAMES nlopt_cxx nlopt)
endif()
if(NOT NLOPT_INCLUDE_DIR OR NOT NLOPT_LIBRARY)
  trackservo_missing("The library NLopt, with its C++ interface," demo)
endif()
mark_as_advanced(NLOPT_INCLUDE_DIR NLOPT_LIBRARY)
add_library(trackservo_nlopt INTERFACE)
target_include_directories(trackservo_nlopt SYSTEM INTERFACE "${NLOPT_INCLUDE_DIR}")
target_link_libraries(trackservo_nlopt INTERFACE "${NLOPT_LIBRARY}")
