// SPDX-License-Identifier: Apache-2.0
#include "device/bus/slcan_pty.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace trackservo::sim {
namespace {

[[noreturn]] void fail(int descriptor, const char *what) {
  const int error = errno;
  if (descriptor >= 0) {
    close(descriptor);
  }
  throw std::system_error(error, std::generic_category(), std::string("slcan-pty: ") + what);
}

int open_master(std::string& path) {
  const int master = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (master < 0 || grantpt(master) != 0 || unlockpt(master) != 0) {
    fail(master, "cannot open a pseudo terminal");
  }
  std::array<char, 128> name{};
  if (ptsname_r(master, name.data(), name.size()) != 0) {
    fail(master, "cannot get the name of the pseudo terminal");
  }
  path = name.data();
  return master;
}

// No echo, no line editing, no translation.
void make_raw(int descriptor) {
  termios settings{};
  tcgetattr(descriptor, &settings);
  cfmakeraw(&settings);
  tcsetattr(descriptor, TCSANOW, &settings);
}

}  // namespace

SlcanPty::SlcanPty(VirtualBus& bus) {
  const int master = open_master(path_);
  keeper_ = open(path_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (keeper_ < 0) {
    fail(master, "cannot open the pseudo terminal's slave");
  }
  make_raw(keeper_);
  line_ = std::make_unique<SlcanLine>(bus, master);
}

SlcanPty::~SlcanPty() { close(keeper_); }

void SlcanPty::pump() { line_->pump(); }

bool SlcanPty::is_behind() const { return line_->is_behind(); }

void SlcanPty::add_to_poll(std::vector<pollfd>& descriptors) const { descriptors.push_back(line_->wanted()); }

}  // namespace trackservo::sim
