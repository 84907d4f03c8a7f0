// SPDX-License-Identifier: Apache-2.0
// SLCAN on a pseudo terminal, for programs that need a serial device.
//
// python-can: interface="slcan", channel="/dev/pts/N"; Linux: slcand -o -s8 /dev/pts/N. One terminal serves one client;
// make one for each client.
#ifndef TRACKSERVO_SIM_BUS_SLCAN_PTY_HPP
#define TRACKSERVO_SIM_BUS_SLCAN_PTY_HPP

#include <memory>

#include "device/bus/bus_end.hpp"
#include "device/bus/slcan_line.hpp"

namespace trackservo::sim {

class SlcanPty : public BusEnd {
 public:
  // Throws std::system_error.
  explicit SlcanPty(VirtualBus& bus);
  ~SlcanPty() override;

  void pump() override;
  bool is_behind() const override;
  void add_to_poll(std::vector<pollfd>& descriptors) const override;
  std::string address() const override { return "slcan-pty:" + path_; }

  const std::string& path() const { return path_; }

 private:
  std::string path_;
  int keeper_ = -1;  // the slave side, held open so that a client may disconnect and return
  std::unique_ptr<SlcanLine> line_;
};

}  // namespace trackservo::sim

#endif
