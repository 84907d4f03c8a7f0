// SPDX-License-Identifier: Apache-2.0
// Statistics of one figure over its seeds.
//
// Every function takes at least one value; the input is not sorted or changed.
#ifndef TRACKSERVO_SIM_ANALYSIS_STATISTICS_HPP
#define TRACKSERVO_SIM_ANALYSIS_STATISTICS_HPP

#include <vector>

namespace trackservo::sim {

double mean(const std::vector<double>& values);

// Returns the standard deviation with n - 1 in the denominator; 0 for a single value.
double standard_deviation(const std::vector<double>& values);

// Returns the middle value; between the middle two when their number is even.
double median(std::vector<double> values);

// Returns the quantile for `share` (0 .. 1), linear between neighbours: 0 gives the smallest value, 1 the largest.
double quantile(std::vector<double> values, double share);

// Returns Pearson's coefficient of two lists of equal length, at least two values; 0 when one of them does not vary.
double correlation(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace trackservo::sim

#endif
