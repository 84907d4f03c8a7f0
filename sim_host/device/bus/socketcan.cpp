// SPDX-License-Identifier: Apache-2.0
#include "device/bus/socketcan.hpp"

// The kernel's header has its own `struct can_frame`; here it gets another name.
#define can_frame kernel_can_frame
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#undef can_frame

#include <fcntl.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace trackservo::sim {
namespace {

constexpr std::size_t kQueueLimit = 256;
constexpr std::chrono::milliseconds kRetry{200};
constexpr int kFramesPerPump = 256;

// Empty when it worked, otherwise the error and its remedy.
std::string open_interface(const std::string& interface, int& descriptor) {
  descriptor = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (descriptor < 0) {
    return std::string("this kernel does not support CAN (") + std::strerror(errno) +
           "): load the modules can, can_raw and vcan, or use slcan-tcp instead";
  }
  ifreq request{};
  interface.copy(request.ifr_name, sizeof request.ifr_name - 1);
  if (interface.size() >= sizeof request.ifr_name || ioctl(descriptor, SIOCGIFINDEX, &request) != 0) {
    return "no such interface: create it with 'ip link add dev " + interface + " type vcan'";
  }
  const int index = request.ifr_ifindex;
  if (ioctl(descriptor, SIOCGIFFLAGS, &request) != 0 || (request.ifr_flags & IFF_UP) == 0) {
    return "the interface is down: 'ip link set " + interface + " up'";
  }
  const can_err_mask_t errors = CAN_ERR_MASK;
  setsockopt(descriptor, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = index;
  if (bind(descriptor, reinterpret_cast<const sockaddr *>(&address), sizeof address) != 0) {
    return std::string("cannot bind: ") + std::strerror(errno);
  }
  return {};
}

can_frame from_kernel(const kernel_can_frame& kernel) {
  can_frame frame{};
  const bool extended = (kernel.can_id & CAN_EFF_FLAG) != 0;
  const bool remote = (kernel.can_id & CAN_RTR_FLAG) != 0;
  frame.id = kernel.can_id & (extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.flags = static_cast<std::uint8_t>((extended ? CAN_FRAME_EXTENDED : 0) | (remote ? CAN_FRAME_REMOTE : 0));
  frame.length = std::min<std::uint8_t>(kernel.can_dlc, CAN_FRAME_BYTES);
  std::memcpy(frame.data, kernel.data, CAN_FRAME_BYTES);
  return frame;
}

kernel_can_frame to_kernel(const can_frame& frame) {
  kernel_can_frame kernel{};
  kernel.can_id = frame.id;
  kernel.can_id |= (frame.flags & CAN_FRAME_EXTENDED) != 0 ? CAN_EFF_FLAG : 0;
  kernel.can_id |= (frame.flags & CAN_FRAME_REMOTE) != 0 ? CAN_RTR_FLAG : 0;
  kernel.can_dlc = frame.length;
  std::memcpy(kernel.data, frame.data, CAN_FRAME_BYTES);
  return kernel;
}

}  // namespace

SocketCan::SocketCan(VirtualBus& bus, std::string interface, HealthChanged health_changed)
    : bus_(bus), interface_(std::move(interface)), health_changed_(std::move(health_changed)) {
  const std::string trouble = open_interface(interface_, descriptor_);
  if (!trouble.empty()) {
    if (descriptor_ >= 0) {
      close(descriptor_);
    }
    throw std::runtime_error("socketcan:" + interface_ + ": " + trouble);
  }
  port_ = bus_.attach([this](const can_frame& frame) {
    if (from_bus_.size() < kQueueLimit) {
      from_bus_.push_back(frame);
    } else {
      ++dropped_;
    }
  });
}

SocketCan::~SocketCan() {
  bus_.detach(port_);
  if (descriptor_ >= 0) {
    close(descriptor_);
  }
}

void SocketCan::become(CanHealth health) {
  if (health == health_) {
    return;
  }
  health_ = health;
  if (health_changed_) {
    health_changed_(health);
  }
}

void SocketCan::take_error_frame(std::uint32_t error_class, const std::uint8_t *data) {
  if ((error_class & CAN_ERR_BUSOFF) != 0) {
    from_bus_.clear();  // waiting frames are outdated when the bus is back
    become(CanHealth::kBusOff);
  } else if ((error_class & CAN_ERR_RESTARTED) != 0) {
    become(CanHealth::kRecovered);
    become(CanHealth::kGood);
  } else if ((error_class & CAN_ERR_CRTL) != 0 && health_ != CanHealth::kBusOff) {
    const bool passive = (data[1] & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0;
    become(passive ? CanHealth::kErrorPassive : CanHealth::kGood);
  }
}

void SocketCan::receive() {
  for (int i = 0; i < kFramesPerPump && bus_.has_room(port_); ++i) {
    kernel_can_frame kernel{};
    const ssize_t length = read(descriptor_, &kernel, sizeof kernel);
    if (length != static_cast<ssize_t>(sizeof kernel)) {
      if (length < 0 && (errno == ENETDOWN || errno == ENODEV)) {
        interface_failed();
      }
      return;
    }
    if ((kernel.can_id & CAN_ERR_FLAG) != 0) {
      take_error_frame(kernel.can_id & CAN_ERR_MASK, kernel.data);
    } else {
      bus_.send(port_, from_kernel(kernel));
      if (health_ == CanHealth::kBusOff) {  // for a driver that does not report it: traffic proves the recovery
        become(CanHealth::kRecovered);
        become(CanHealth::kGood);
      }
    }
  }
}

void SocketCan::transmit() {
  while (!from_bus_.empty() && descriptor_ >= 0) {
    const kernel_can_frame kernel = to_kernel(from_bus_.front());
    if (write(descriptor_, &kernel, sizeof kernel) != static_cast<ssize_t>(sizeof kernel)) {
      if (errno == ENETDOWN || errno == ENODEV || errno == ENXIO) {
        interface_failed();
      }
      return;  // ENOBUFS and EAGAIN: the driver's queue is full; try again next time
    }
    from_bus_.pop_front();
  }
}

void SocketCan::interface_failed() {
  close(descriptor_);
  descriptor_ = -1;
  from_bus_.clear();
  next_try_ = std::chrono::steady_clock::now() + kRetry;
  become(CanHealth::kInterfaceDown);
}

void SocketCan::try_again() {
  from_bus_.clear();
  if (std::chrono::steady_clock::now() < next_try_) {
    return;
  }
  next_try_ = std::chrono::steady_clock::now() + kRetry;
  int descriptor = -1;
  if (open_interface(interface_, descriptor).empty()) {
    descriptor_ = descriptor;
    become(CanHealth::kRecovered);
    become(CanHealth::kGood);
  } else if (descriptor >= 0) {
    close(descriptor);
  }
}

void SocketCan::pump() {
  if (descriptor_ < 0) {
    try_again();
  }
  if (descriptor_ >= 0) {
    receive();
  }
  transmit();
}

void SocketCan::add_to_poll(std::vector<pollfd>& descriptors) const {
  if (descriptor_ >= 0) {
    const int events = POLLIN | (from_bus_.empty() ? 0 : POLLOUT);
    descriptors.push_back({descriptor_, static_cast<short>(events), 0});
  }
}

}  // namespace trackservo::sim
