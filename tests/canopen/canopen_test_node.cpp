// SPDX-License-Identifier: Apache-2.0
// A test device on a virtual bus for TCP clients, in real time.
//
// Prints "slcan-tcp:127.0.0.1:PORT" on a line of its own and runs until its standard input ends. For the python-canopen
// tests in this folder.
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "device/bus/slcan_pty.hpp"
#include "device/bus/slcan_tcp.hpp"
#include "device/bus/socketcan.hpp"
#include "device/bus/virtual_bus.hpp"

extern "C" {
#include "canopen/heard_frames.h"
#include "canopen/test_device.h"
}

namespace {

using Clock = std::chrono::steady_clock;
using trackservo::sim::BusEnd;
using trackservo::sim::VirtualBus;

struct NodePort {
  VirtualBus *bus;
  VirtualBus::Port port;
};

bool send(void *context, const can_frame *frame) {
  const auto *node = static_cast<const NodePort *>(context);
  return node->bus->send(node->port, *frame);
}

// Waits for a byte or for the next tick. Returns false when standard input has ended.
bool wait(const std::vector<std::unique_ptr<BusEnd>>& ends, Clock::time_point until) {
  std::vector<pollfd> descriptors{{STDIN_FILENO, POLLIN, 0}};
  for (const auto& end : ends) {
    end->add_to_poll(descriptors);
  }
  const auto left = std::chrono::duration_cast<std::chrono::nanoseconds>(until - Clock::now()).count();
  const timespec timeout{0, left > 0 ? static_cast<long>(left) : 0};
  ppoll(descriptors.data(), descriptors.size(), &timeout, nullptr);
  char byte = 0;
  return (descriptors[0].revents & (POLLIN | POLLHUP)) == 0 || read(STDIN_FILENO, &byte, 1) > 0;
}

}  // namespace

int main(int argc, char **argv) {
  const int node_id = argc > 1 ? std::atoi(argv[1]) : 5;
  VirtualBus bus;
  static test_device device;
  const auto receive = [](const can_frame& frame) {
    if (heard_frame(&frame)) {
      canopen_node_receive(&device.node, &frame);
    }
  };
  NodePort node{&bus, bus.attach(receive, 32)};
  if (!test_device_init(&device, static_cast<std::uint8_t>(node_id), {send, &node})) {
    std::fprintf(stderr, "bad node id\n");
    return 2;
  }
  std::vector<std::unique_ptr<BusEnd>> ends;
  ends.push_back(std::make_unique<trackservo::sim::SlcanTcp>(bus, std::uint16_t{0}));
  ends.push_back(std::make_unique<trackservo::sim::SlcanPty>(bus));
  if (argc > 2) {
    try {
      ends.push_back(std::make_unique<trackservo::sim::SocketCan>(bus, argv[2]));
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
      return 3;
    }
  }
  for (const auto& end : ends) {
    std::printf("%s\n", end->address().c_str());
  }
  std::fflush(stdout);

  auto last = Clock::now();
  auto next_tick = last + std::chrono::milliseconds(1);
  while (wait(ends, next_tick)) {
    for (const auto& end : ends) {
      end->pump();
    }
    const auto now = Clock::now();
    bus.advance(std::chrono::duration<double>(now - last).count());
    last = now;
    canopen_node_answer(&device.node);
    for (int late = 0; late < 20 && next_tick <= now; ++late) {
      test_device_tick(&device);
      next_tick += std::chrono::milliseconds(1);
    }
    next_tick = next_tick <= now ? now + std::chrono::milliseconds(1) : next_tick;
    bus.advance(0);
    for (const auto& end : ends) {
      end->pump();
    }
  }
  std::printf("load %.3f frames %llu\n", bus.load(), static_cast<unsigned long long>(bus.frames()));
  return 0;
}
