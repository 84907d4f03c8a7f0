// SPDX-License-Identifier: Apache-2.0
#include "device/bus/slcan_line.hpp"

#include <unistd.h>

#include <array>
#include <cerrno>

namespace trackservo::sim {
namespace {

constexpr std::size_t kBehindBytes = 1 << 14;

bool would_block() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace

SlcanLine::SlcanLine(VirtualBus& bus, int descriptor)
    : bus_(bus), descriptor_(descriptor), port_(bus.attach([this](const can_frame& frame) {
        const auto since = std::chrono::steady_clock::now() - start_;
        const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(since).count();
        session_.show(frame, static_cast<unsigned>(ms));
      })) {}

SlcanLine::~SlcanLine() {
  bus_.detach(port_);
  close(descriptor_);
}

bool SlcanLine::pump() {
  forward();
  const bool alive = receive();
  forward();
  const bool hears = flush();
  return (hears && alive) || !session_.to_bus().empty();  // what a client sent before it left goes over the bus
}

bool SlcanLine::receive() {
  if (!session_.to_bus().empty()) {
    return true;  // the bus is behind: leave the rest to the kernel's flow control
  }
  std::array<char, 4096> buffer;
  const ssize_t length = read(descriptor_, buffer.data(), buffer.size());
  if (length < 0) {
    return would_block();
  }
  session_.consume({buffer.data(), static_cast<std::size_t>(length)});
  bus_.set_bit_rate(port_, session_.bit_rate() > 0 ? session_.bit_rate() : bus_.bit_rate());
  return length > 0;
}

void SlcanLine::forward() {
  auto& frames = session_.to_bus();
  while (!frames.empty() && bus_.send(port_, frames.front())) {
    frames.pop_front();
  }
}

bool SlcanLine::flush() {
  std::string& output = session_.output();
  if (output.empty()) {
    return true;
  }
  const ssize_t length = write(descriptor_, output.data(), output.size());
  if (length < 0) {
    return would_block();
  }
  output.erase(0, static_cast<std::size_t>(length));
  return true;
}

bool SlcanLine::is_behind() const { return session_.output().size() > kBehindBytes; }

pollfd SlcanLine::wanted() const {
  int events = session_.to_bus().empty() ? POLLIN : 0;
  events |= session_.output().empty() ? 0 : POLLOUT;
  return {descriptor_, static_cast<short>(events), 0};
}

}  // namespace trackservo::sim
