# What every target of our own is built with. Nothing here is global: third-party code never sees it.
include_guard(GLOBAL)
include(TrackservoWarnings)
include(TrackservoInstrumentation)

# The same numbers on every host: no fused multiply-add that the source does not ask for.
add_library(trackservo_reproducible_floats INTERFACE)
target_compile_options(trackservo_reproducible_floats INTERFACE -ffp-contract=off)

# Our rules for one target: C11 and C++17 as written, without compiler extensions.
function(trackservo_own_code target)
  target_compile_features(${target} PRIVATE c_std_11 cxx_std_17)
  set_target_properties(${target} PROPERTIES C_STANDARD 11 C_EXTENSIONS OFF CXX_STANDARD 17 CXX_EXTENSIONS OFF)
  target_link_libraries(${target} PRIVATE trackservo_warnings trackservo_reproducible_floats trackservo_sanitizers)
endfunction()

# A static library of firmware C: its includes are written from firmware/ ("control/lugre.h").
function(trackservo_add_firmware_library target)
  add_library(${target} STATIC ${ARGN})
  trackservo_own_code(${target})
  target_include_directories(${target} PUBLIC "${PROJECT_SOURCE_DIR}/firmware")
  target_link_libraries(${target} PRIVATE trackservo_coverage PUBLIC m)
endfunction()
