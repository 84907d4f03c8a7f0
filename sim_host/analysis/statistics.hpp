// Statistics of one figure over its seeds.
//
// Every function takes at least one value; none is sorted or changed.
#ifndef TRACKSERVO_SIM_ANALYSIS_STATISTICS_HPP
#define TRACKSERVO_SIM_ANALYSIS_STATISTICS_HPP

#include <vector>

namespace trackservo::sim {

double mean(const std::vector<double>& values);

// With n - 1 in the denominator; 0 for a single value.
double standard_deviation(const std::vector<double>& values);

// The middle value; between the middle two when their number is even.
double median(std::vector<double> values);

}  // namespace trackservo::sim

#endif
