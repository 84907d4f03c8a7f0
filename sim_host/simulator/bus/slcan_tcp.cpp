#include "bus/slcan_tcp.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <system_error>

namespace trackservo::sim {
namespace {

// Small, so that a slow client is detected soon and does not first receive frames that are seconds old.
constexpr int kSendBuffer = 1 << 15;

[[noreturn]] void fail(int descriptor, const std::string& what) {
  const int error = errno;
  if (descriptor >= 0) {
    close(descriptor);
  }
  throw std::system_error(error, std::generic_category(), "slcan-tcp: " + what);
}

int listen_on(std::uint16_t port) {
  const int descriptor = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (descriptor < 0) {
    fail(descriptor, "socket");
  }
  const int yes = 1;
  setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (bind(descriptor, reinterpret_cast<const sockaddr *>(&address), sizeof address) != 0) {
    fail(descriptor, "port " + std::to_string(port));
  }
  if (listen(descriptor, 16) != 0) {
    fail(descriptor, "listen");
  }
  return descriptor;
}

std::uint16_t port_of(int descriptor) {
  sockaddr_in address{};
  socklen_t length = sizeof address;
  getsockname(descriptor, reinterpret_cast<sockaddr *>(&address), &length);
  return ntohs(address.sin_port);
}

}  // namespace

SlcanTcp::SlcanTcp(VirtualBus& bus, std::uint16_t port) : bus_(bus), listener_(listen_on(port)) {
  port_ = port_of(listener_);
  (void)std::signal(SIGPIPE, SIG_IGN);  // a client that disconnects causes an error of write(), not a signal
}

SlcanTcp::~SlcanTcp() { close(listener_); }

void SlcanTcp::accept_clients() {
  for (;;) {
    const int client = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (client < 0) {
      return;
    }
    const int yes = 1;
    setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);  // send every frame at once
    setsockopt(client, SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer);
    lines_.push_back(std::make_unique<SlcanLine>(bus_, client));
  }
}

void SlcanTcp::pump() {
  accept_clients();
  const auto gone = [](const std::unique_ptr<SlcanLine>& line) { return !line->pump(); };
  lines_.erase(std::remove_if(lines_.begin(), lines_.end(), gone), lines_.end());
}

void SlcanTcp::add_to_poll(std::vector<pollfd>& descriptors) const {
  descriptors.push_back({listener_, POLLIN, 0});
  for (const auto& line : lines_) {
    descriptors.push_back(line->wanted());
  }
}

bool SlcanTcp::is_behind() const {
  return std::any_of(lines_.begin(), lines_.end(),
                     [](const std::unique_ptr<SlcanLine>& line) { return line->is_behind(); });
}

std::string SlcanTcp::address() const { return "slcan-tcp:127.0.0.1:" + std::to_string(port_); }

}  // namespace trackservo::sim
