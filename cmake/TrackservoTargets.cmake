# SPDX-License-Identifier: Apache-2.0
# What every target of our own is built with. Nothing here is global: third-party code never sees it.
include_guard(GLOBAL)
include(TrackservoWarnings)
include(TrackservoInstrumentation)

# The same numbers on every host: no fused multiply-add that the source does not ask for.
add_library(trackservo_reproducible_floats INTERFACE)
target_compile_options(trackservo_reproducible_floats INTERFACE -ffp-contract=off -fno-math-errno)

# For an image: tools/image/budget.py reads what every function takes of the stack.
add_library(trackservo_image_options INTERFACE)
if(CMAKE_CROSSCOMPILING)
  target_compile_options(trackservo_image_options INTERFACE -fstack-usage)
endif()

# What is released is the same from every folder: no path of this machine is in it. A program brings the libraries that it
# needs in the folder lib beside its own, and C++'s within itself.
add_library(trackservo_release_options INTERFACE)
if(CMAKE_CROSSCOMPILING OR TRACKSERVO_RELEASE)
  set(without_paths "-ffile-prefix-map=${PROJECT_BINARY_DIR}=build" "-ffile-prefix-map=${PROJECT_SOURCE_DIR}=.")
  target_compile_options(trackservo_release_options INTERFACE ${without_paths})
  target_link_options(trackservo_release_options INTERFACE ${without_paths}) # which optimises across files
endif()
if(TRACKSERVO_RELEASE AND NOT CMAKE_CROSSCOMPILING)
  target_link_options(trackservo_release_options INTERFACE -static-libgcc "$<$<LINK_LANGUAGE:CXX>:-static-libstdc++>")
  set(CMAKE_BUILD_WITH_INSTALL_RPATH ON) # a path of this machine would leave its length in the program
  set(CMAKE_INSTALL_RPATH "$ORIGIN/../lib")
endif()

# The board's image is optimised across files, and so is what counts the image's instructions. On a host nothing is: a run
# of the simulator would take a seventh less time, and its build a third more.
function(trackservo_optimise_across_files target)
  if(CMAKE_CROSSCOMPILING)
    set_target_properties(
      ${target} PROPERTIES INTERPROCEDURAL_OPTIMIZATION_RELWITHDEBINFO ON INTERPROCEDURAL_OPTIMIZATION_RELEASE ON)
    target_compile_options(${target} PRIVATE -ffat-lto-objects)
  endif()
endfunction()

# The 180 programs of a host's build are linked in a fifth of the time by mold, where it is there.
if(NOT CMAKE_CROSSCOMPILING)
  include(CheckLinkerFlag)
  check_linker_flag(C -fuse-ld=mold trackservo_mold)
endif()

# Our rules for one target: C11 and C++17 as written, without compiler extensions.
function(trackservo_own_code target)
  target_compile_features(${target} PRIVATE c_std_11 "$<$<BOOL:${TRACKSERVO_SIMULATOR}>:cxx_std_17>")
  set_target_properties(${target} PROPERTIES C_STANDARD 11 C_EXTENSIONS OFF CXX_STANDARD 17 CXX_EXTENSIONS OFF)
  if(TRACKSERVO_SIMULATOR) # whose libraries are in the units of sim_host/fmi, too; the programs share its precompiled headers
    target_compile_options(${target} PRIVATE -fPIC -fvisibility=hidden "$<$<COMPILE_LANGUAGE:CXX>:-fvisibility-inlines-hidden>")
  endif()
  target_link_libraries(${target} PRIVATE trackservo_warnings trackservo_reproducible_floats trackservo_image_options
                                          trackservo_release_options trackservo_sanitizers)
  if(CMAKE_CROSSCOMPILING)
    # Libraries hold ordinary code as well ("fat objects"), and who is not optimised across files has to say so, or the
    # linker would do it nevertheless. Cut in parts, local functions lose their file's name, which the image's budget needs.
    set(across_files "$<BOOL:$<TARGET_PROPERTY:INTERPROCEDURAL_OPTIMIZATION_RELWITHDEBINFO>>")
    target_link_options(${target} PRIVATE "$<$<NOT:${across_files}>:-fno-lto>" "$<${across_files}:-flto-partition=one>")
  elseif(trackservo_mold)
    target_link_options(${target} PRIVATE -fuse-ld=mold)
  endif()
endfunction()

# Our rules for C++ around the simulator, with the headers that nearly all of it reads compiled once (sim_host/headers.hpp).
# Who uses them so needs their libraries' definitions.
function(trackservo_own_cpp target)
  trackservo_own_code(${target})
  target_link_libraries(${target} PRIVATE Boost::headers Eigen3::Eigen trackservo_fmt nlohmann_json::nlohmann_json)
  target_precompile_headers(${target} REUSE_FROM trackservo_headers)
endfunction()

# A static library of firmware C: its includes are written from firmware/ ("control/lugre.h").
function(trackservo_add_firmware_library target)
  add_library(${target} STATIC ${ARGN})
  trackservo_own_code(${target})
  target_include_directories(${target} PUBLIC "${PROJECT_SOURCE_DIR}/firmware")
  target_link_libraries(${target} PRIVATE trackservo_coverage PUBLIC m)
  trackservo_optimise_across_files(${target})
endfunction()
