// SPDX-License-Identifier: Apache-2.0
#include "device/bus/tcp_listener.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace trackservo::sim {
namespace {

[[noreturn]] void fail(int descriptor, const std::string& what) {
  const int error = errno;
  if (descriptor >= 0) {
    close(descriptor);
  }
  throw std::system_error(error, std::generic_category(), what);
}

}  // namespace

int listen_on_loopback(std::uint16_t port, const std::string& what) {
  const int descriptor = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (descriptor < 0) {
    fail(descriptor, what + ": socket");
  }
  const int yes = 1;
  setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (bind(descriptor, reinterpret_cast<const sockaddr *>(&address), sizeof address) != 0) {
    fail(descriptor, what + ": port " + std::to_string(port));
  }
  if (listen(descriptor, 16) != 0) {
    fail(descriptor, what + ": listen");
  }
  return descriptor;
}

std::uint16_t port_of_listener(int descriptor) {
  sockaddr_in address{};
  socklen_t length = sizeof address;
  getsockname(descriptor, reinterpret_cast<sockaddr *>(&address), &length);
  return ntohs(address.sin_port);
}

}  // namespace trackservo::sim
