# What every target of our own is built with. Nothing here is global: third-party code never sees it.
include_guard(GLOBAL)
include(TrackservoWarnings)
include(TrackservoInstrumentation)

# The same numbers on every host: no fused multiply-add that the source does not ask for.
add_library(trackservo_reproducible_floats INTERFACE)
target_compile_options(trackservo_reproducible_floats INTERFACE -ffp-contract=off -fno-math-errno)

# For an image: tools/image/budget.py reads what every function takes of the stack, and no path of this machine is in it.
add_library(trackservo_image_options INTERFACE)
if(CMAKE_CROSSCOMPILING)
  target_compile_options(
    trackservo_image_options INTERFACE -fstack-usage "-ffile-prefix-map=${PROJECT_BINARY_DIR}=build"
                                       "-ffile-prefix-map=${PROJECT_SOURCE_DIR}=.")
endif()

# The simulator and the board's image are optimised across files, firmware included: a tenth faster with the same numbers.
# Tests are not, since each would be optimised anew when it is linked, for ten seconds; so libraries carry ordinary code,
# too ("fat objects", gcc only), and who is not optimised across files has to say so, or the linker would do it nevertheless.
if(CMAKE_CROSSCOMPILING)
  set(trackservo_ipo ON)
elseif(CMAKE_C_COMPILER_ID STREQUAL "GNU" AND NOT TRACKSERVO_SANITIZE AND NOT TRACKSERVO_COVERAGE)
  include(CheckIPOSupported)
  check_ipo_supported(RESULT trackservo_ipo LANGUAGES ${languages})
endif()

# For the libraries, for the simulator's executable, for the image, and for what counts the image's instructions.
function(trackservo_optimise_across_files target)
  if(trackservo_ipo)
    set_target_properties(
      ${target} PROPERTIES INTERPROCEDURAL_OPTIMIZATION_RELWITHDEBINFO ON INTERPROCEDURAL_OPTIMIZATION_RELEASE ON)
    target_compile_options(${target} PRIVATE -ffat-lto-objects)
  endif()
endfunction()

# Our rules for one target: C11 and C++17 as written, without compiler extensions.
function(trackservo_own_code target)
  target_compile_features(${target} PRIVATE c_std_11 "$<$<BOOL:${TRACKSERVO_SIMULATOR}>:cxx_std_17>")
  set_target_properties(${target} PROPERTIES C_STANDARD 11 C_EXTENSIONS OFF CXX_STANDARD 17 CXX_EXTENSIONS OFF)
  target_link_libraries(${target} PRIVATE trackservo_warnings trackservo_reproducible_floats trackservo_image_options
                                          trackservo_sanitizers)
  if(trackservo_ipo)
    set(across_files "$<BOOL:$<TARGET_PROPERTY:INTERPROCEDURAL_OPTIMIZATION_RELWITHDEBINFO>>")
    target_link_options(${target} PRIVATE "$<$<NOT:${across_files}>:-fno-lto>")
    if(CMAKE_CROSSCOMPILING) # cut in parts, local functions lose their file's name, which the image's budget needs
      target_link_options(${target} PRIVATE "$<${across_files}:-flto-partition=one>")
    endif()
  endif()
endfunction()

# A static library of firmware C: its includes are written from firmware/ ("control/lugre.h").
function(trackservo_add_firmware_library target)
  add_library(${target} STATIC ${ARGN})
  trackservo_own_code(${target})
  target_include_directories(${target} PUBLIC "${PROJECT_SOURCE_DIR}/firmware")
  target_link_libraries(${target} PRIVATE trackservo_coverage PUBLIC m)
  trackservo_optimise_across_files(${target})
endfunction()
