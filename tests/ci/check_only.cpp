// sim_host with only its check command: for builds of a faulty firmware.
#include <cstdio>
#include <exception>

#include "commands/check_command.hpp"

int main(int argc, char **argv) {
  const std::vector<std::string> arguments(argv, argv + argc);
  const trackservo::sim::ImageDevices no_images;
  int code = 0;
  CLI::App app{"The check of sim_host."};
  trackservo::sim::add_check(app, code, arguments, no_images);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    (void)std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  return code;
}
