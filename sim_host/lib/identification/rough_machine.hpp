// SPDX-License-Identifier: Apache-2.0
// The result of a first look at a machine, good to a factor of two: it sizes the test plan that finds the rest.
#ifndef TRACKSERVO_IDENTIFICATION_ROUGH_MACHINE_HPP
#define TRACKSERVO_IDENTIFICATION_ROUGH_MACHINE_HPP

namespace trackservo::identification {

// Point values, each good to a factor of two: they size the next test plan when the parameters themselves are refused.
struct RoughMachine {
  double coulomb_nm = 0;      // mean of both directions
  double bristle_rad = 0;     // Tc / sigma0
  double stribeck_rad_s = 0;  // geometric mean of both directions
  double inertia_kg_m2 = 0;
};

}  // namespace trackservo::identification

#endif
