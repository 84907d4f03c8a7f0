// SPDX-License-Identifier: Apache-2.0
// A TCP port of this computer on which clients are accepted.
#ifndef TRACKSERVO_SIM_BUS_TCP_LISTENER_HPP
#define TRACKSERVO_SIM_BUS_TCP_LISTENER_HPP

#include <cstdint>
#include <string>

namespace trackservo::sim {

// Listens on the loopback address only, without blocking; 0: any free port. The caller closes the descriptor. Throws
// std::system_error, whose text begins with `what`.
int listen_on_loopback(std::uint16_t port, const std::string& what);

std::uint16_t port_of_listener(int descriptor);

}  // namespace trackservo::sim

#endif
