// SPDX-License-Identifier: Apache-2.0
#include "device/bus/slcan_tcp.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>

#include "device/bus/tcp_listener.hpp"

namespace trackservo::sim {
namespace {

// Small, so that a slow client is detected soon and does not first receive frames that are seconds old.
constexpr int kSendBuffer = 1 << 15;

}  // namespace

SlcanTcp::SlcanTcp(VirtualBus& bus, std::uint16_t port) : bus_(bus), listener_(listen_on_loopback(port, "slcan-tcp")) {
  port_ = port_of_listener(listener_);
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
