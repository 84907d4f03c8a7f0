// SPDX-License-Identifier: Apache-2.0
// One client of the serial-line CAN protocol: text in, frames out, and back.
//
// Lawicel ASCII commands as python-can, Linux slcand and SavvyCAN speak them (O L C S s t T r R V N F Z, answers CR or
// BEL). It does not handle file descriptors: TCP and PTY ends pass bytes in and take its output.
#ifndef TRACKSERVO_SIM_BUS_SLCAN_SESSION_HPP
#define TRACKSERVO_SIM_BUS_SLCAN_SESSION_HPP

#include <cstddef>
#include <deque>
#include <string>
#include <string_view>

extern "C" {
#include "base/can_frame.h"
}

namespace trackservo::sim {

class SlcanSession {
 public:
  // Takes bytes from the client, split anywhere.
  void consume(std::string_view bytes);

  // Takes a frame from the bus; the client receives it while its channel is open. It is dropped, and the F flag set,
  // when the client has left a megabyte unread.
  void show(const can_frame& frame, unsigned time_ms);

  // Returns the frames from the client to the bus, oldest first; the owner takes them from the front.
  std::deque<can_frame>& to_bus() { return to_bus_; }
  const std::deque<can_frame>& to_bus() const { return to_bus_; }

  // Returns the bytes for the client; the owner removes what it has sent.
  std::string& output() { return output_; }
  const std::string& output() const { return output_; }

  bool is_open() const { return open_; }

  // Returns the bit rate that the client has chosen (S0 to S8), bit/s; 0: none yet, or a custom one (s).
  double bit_rate() const { return bit_rate_; }

 private:
  void execute(std::string_view line);
  bool transmit(std::string_view line);
  bool set_up(std::string_view line);
  bool set_bit_rate(char digit);
  bool open(bool listen_only);

  std::string line_;
  bool line_too_long_ = false;
  std::string output_;
  std::deque<can_frame> to_bus_;
  double bit_rate_ = 0;
  bool open_ = false;
  bool listen_only_ = false;
  bool time_stamps_ = false;
  bool overrun_ = false;
};

}  // namespace trackservo::sim

#endif
