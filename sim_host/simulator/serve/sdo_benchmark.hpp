// How many SDO reads per second a client gets out of `sim_host serve` on SLCAN over TCP. A measurement, not a test.
#ifndef TRACKSERVO_SIM_SERVE_SDO_BENCHMARK_HPP
#define TRACKSERVO_SIM_SERVE_SDO_BENCHMARK_HPP

#include "config/plant_config.hpp"

namespace trackservo::sim {

// Serves in a process of its own, in real time, and reads 0x606C in sequence for this time. It uses the wall clock,
// because waiting is part of the result. Throws std::runtime_error when the node does not answer.
double sdo_reads_per_second(const PlantConfig& plant, double seconds);

}  // namespace trackservo::sim

#endif
