# SPDX-License-Identifier: Apache-2.0
# trackservo_add_image(NAME SOURCES...): an executable for the board, as bin/NAME.elf, .hex, .bin and .map, its sizes
# beside their budget (target size, part of every build), and the targets flash, erase and debug.
include_guard(GLOBAL)
include(TrackservoMissing)

find_package(Python3 3.11 QUIET COMPONENTS Interpreter)
if(NOT Python3_FOUND)
  trackservo_missing("Python 3.11 or newer" board)
endif()

set(trackservo_hot_code "${PROJECT_SOURCE_DIR}/tools/image/hot_code.py")
set(trackservo_pointers "${PROJECT_SOURCE_DIR}/tools/image/indirect_calls.toml")
set(trackservo_stamp "${PROJECT_SOURCE_DIR}/tools/image/stamp_image.py")

function(trackservo_add_image name)
  set(board trackservo_hal_${TRACKSERVO_PLATFORM})
  get_target_property(start_up ${board} TRACKSERVO_START_UP)
  get_target_property(linker_script ${board} TRACKSERVO_LINKER_SCRIPT)
  add_executable(${name} ${ARGN} "${start_up}")
  target_link_libraries(${name} PRIVATE ${board})
  # Its assembler refers to functions by name, which link-time optimisation does not see.
  set_source_files_properties("${start_up}" PROPERTIES COMPILE_OPTIONS -fno-lto)
  # For object 0x1009: the folders of the product and of the board.
  target_compile_definitions(${name} PRIVATE TRACKSERVO_PRODUCT="${TRACKSERVO_PRODUCT}" TRACKSERVO_BOARD="${TRACKSERVO_PLATFORM}")
  trackservo_own_code(${name})
  trackservo_optimise_across_files(${name})
  set(image "${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/${name}")
  set_target_properties(${name} PROPERTIES SUFFIX .elf LINK_DEPENDS "${linker_script}")
  # newlib without system calls: whatever would want a heap or a file does not link.
  target_link_options(
    ${name}
    PRIVATE
    --specs=nano.specs
    -nostartfiles
    "-T${linker_script}"
    "-L${CMAKE_CURRENT_BINARY_DIR}"
    "-Wl,-Map=${image}.map")
  # The linker script includes hot_code.ld, which tools/image/hot_code.py writes from what the image calls.
  set_target_properties(
    ${name} PROPERTIES RULE_LAUNCH_LINK "\"${Python3_EXECUTABLE}\" \"${trackservo_hot_code}\" --script \
\"${CMAKE_CURRENT_BINARY_DIR}/hot_code.ld\" --pointers \"${trackservo_pointers}\" --")
  set_property(TARGET ${name} APPEND PROPERTY LINK_DEPENDS "${trackservo_hot_code}" "${trackservo_pointers}")
  # The version block gets length and CRC of what was linked; the files are made of that.
  add_custom_command(
    TARGET ${name}
    POST_BUILD
    COMMAND ${CMAKE_OBJCOPY} -O binary $<TARGET_FILE:${name}> ${image}.bin
    COMMAND Python3::Interpreter ${trackservo_stamp} ${image}.bin ${image}.version_block
    COMMAND ${CMAKE_OBJCOPY} --update-section .version_block=${image}.version_block $<TARGET_FILE:${name}>
    COMMAND ${CMAKE_OBJCOPY} -O ihex $<TARGET_FILE:${name}> ${image}.hex
    BYPRODUCTS ${image}.bin ${image}.hex ${image}.map ${image}.version_block
    VERBATIM)
  trackservo_add_size_target(${name})
  trackservo_add_flash_targets(${name})
endfunction()

set(trackservo_budget "${PROJECT_SOURCE_DIR}/tools/image/budget.py")

function(trackservo_add_size_target name)
  add_custom_target(
    size ALL
    COMMAND Python3::Interpreter ${trackservo_budget} $<TARGET_FILE:${name}> --stack-usage "${PROJECT_BINARY_DIR}"
            --pointers ${trackservo_pointers}
    DEPENDS ${name}
    VERBATIM)
endfunction()

set(FLASH_RUNNER openocd CACHE STRING "How the image gets to the board")
set_property(CACHE FLASH_RUNNER PROPERTY STRINGS openocd stlink dfu)

function(trackservo_add_flash_targets name)
  foreach(action flash erase debug)
    add_custom_target(
      ${action}
      COMMAND "${CMAKE_COMMAND}" -E env "TRACKSERVO_PLATFORM=${TRACKSERVO_PLATFORM}" "${PROJECT_SOURCE_DIR}/tools/image/board"
              ${FLASH_RUNNER} ${action} "${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/${name}"
      USES_TERMINAL VERBATIM)
  endforeach()
  add_dependencies(flash ${name})
  add_dependencies(debug ${name})
endfunction()
