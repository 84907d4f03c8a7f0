# Sanitizers (all of our code, and Unity) and coverage (firmware/ only), as INTERFACE targets: empty unless the
# preset asks for them.
include_guard(GLOBAL)

# Link options travel with a static library to its executable, compile options stay at home.
add_library(trackservo_sanitizers INTERFACE)
if(TRACKSERVO_SANITIZE)
  set(sanitizers -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all)
  target_compile_options(trackservo_sanitizers INTERFACE ${sanitizers} -fno-omit-frame-pointer -O1)
  target_link_options(trackservo_sanitizers INTERFACE ${sanitizers})
endif()

# Unoptimised, so that a line and a branch are those of the source; the simulator around it stays fast.
add_library(trackservo_coverage INTERFACE)
if(TRACKSERVO_COVERAGE)
  target_compile_options(trackservo_coverage INTERFACE --coverage -O0)
  target_link_options(trackservo_coverage INTERFACE --coverage)
endif()
