# SPDX-License-Identifier: Apache-2.0
# What a host gets, for example with: cmake --install build/host-release --prefix FOLDER --component programs
#
#   programs  sim_host and identify, the shipped plants, scenarios, studies and limits, the node's descriptions
#   emulator  emulate_board, which belongs beside sim_host. Alone, because Unicorn in it has another licence (GPL)
#
# A program finds its libraries and its data from its own folder (preset host-release), so FOLDER can be moved.
include_guard(GLOBAL)

# What every Linux has. All else comes along.
set(trackservo_of_the_system "^libc\\.so" "^libm\\.so" "^ld-linux")

# trackservo_install(COMPONENT TARGETS...): programs, with their libraries.
function(trackservo_install component)
  install(TARGETS ${ARGN} RUNTIME_DEPENDENCY_SET trackservo_${component} RUNTIME DESTINATION bin COMPONENT ${component})
  install(
    RUNTIME_DEPENDENCY_SET trackservo_${component}
    PRE_EXCLUDE_REGEXES ${trackservo_of_the_system}
    DIRECTORIES ${trackservo_library_folders}
    LIBRARY DESTINATION lib COMPONENT ${component})
endfunction()

trackservo_install(programs sim_host identify)
if(TARGET emulate_board)
  cmake_path(GET UNICORN_LIBRARY PARENT_PATH trackservo_library_folders)
  trackservo_install(emulator emulate_board)
endif()

set(trackservo_data "${PROJECT_SOURCE_DIR}/sim_host")
foreach(folder IN ITEMS plants scenarios studies limits)
  file(GLOB_RECURSE shipped RELATIVE "${trackservo_data}" CONFIGURE_DEPENDS "${trackservo_data}/${folder}/*.toml")
  foreach(file IN LISTS shipped)
    cmake_path(GET file PARENT_PATH place)
    install(FILES "${trackservo_data}/${file}" DESTINATION share/trackservo/sim_host/${place} COMPONENT programs)
  endforeach()
endforeach()

foreach(file IN ITEMS trackservo.eds trackservo.dbc parameters.json faults.json can-objects.md faults.md version.txt)
  install(FILES "${PROJECT_BINARY_DIR}/share/trackservo/${file}" DESTINATION share/trackservo COMPONENT programs)
endforeach()
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION share/doc/trackservo COMPONENT programs)
