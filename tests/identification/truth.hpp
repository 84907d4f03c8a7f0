// The true parameters of a simulated axis, as identification names them.
#ifndef TRACKSERVO_TESTS_IDENTIFICATION_TRUTH_HPP
#define TRACKSERVO_TESTS_IDENTIFICATION_TRUTH_HPP

#include <map>
#include <string>

#include "commissioning_bench.hpp"
#include "identification/identification.hpp"

namespace commissioning_bench {

// Friction levels are the mean over the travel that was recorded, which is all that can be known of a seal that does
// not run true; over a whole turn that is the plant file's number.
std::map<std::string, double> truth_of(const BenchSetup& setup, const identification::PositionTerms& travel);

// How far a found value may be off, as a logarithm: the limits.
double allowed_error(const std::string& parameter);

}  // namespace commissioning_bench

#endif
