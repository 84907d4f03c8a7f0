// SPDX-License-Identifier: Apache-2.0
// The continuous LuGre model in double, solved by Boost.Odeint's rosenbrock4: the reference for the block. It shares
// only the parameters with the block.
//
// The bristle state is a force F = s0 z, so that the solver's absolute tolerance is in Nm.
#ifndef TRACKSERVO_TESTS_SUPPORT_LUGRE_ODE_HPP
#define TRACKSERVO_TESTS_SUPPORT_LUGRE_ODE_HPP

// Without this uBLAS checks every index and the symmetry of its loops in a Debug build, which then takes minutes.
#ifndef BOOST_UBLAS_NDEBUG
#define BOOST_UBLAS_NDEBUG
#endif

#include <algorithm>
#include <boost/numeric/odeint.hpp>
#include <boost/numeric/ublas/matrix.hpp>
#include <boost/numeric/ublas/vector.hpp>
#include <cmath>
#include <utility>

#include "seals.h"

namespace lugre_ode {

using Vector = boost::numeric::ublas::vector<double>;
using Matrix = boost::numeric::ublas::matrix<double>;

constexpr double kTolerance = 1e-10;

// Whether the reference reduces s1 at high speed to stay passive, as lugre.h does, or is the model of 1995.
enum class Damping { kPassive, kOriginal };

class Friction {
 public:
  explicit Friction(const lugre_params& params, Damping damping = Damping::kPassive)
      : params_(params), damping_(damping) {}

  double stiffness() const { return static_cast<double>(params_.stiffness_nm_rad); }

  double level(double speed) const {
    const lugre_direction& d = direction(speed);
    const double coulomb = static_cast<double>(d.coulomb_nm);
    const double breakaway = static_cast<double>(d.breakaway_nm);
    const double ratio = speed / static_cast<double>(d.stribeck_speed_rad_s);
    return coulomb + (breakaway - coulomb) * std::exp(-ratio * ratio);
  }

  // dF/dt = s0 dz/dt, eq. (2)
  double force_rate(double speed, double force) const {
    return stiffness() * (speed - std::abs(speed) / level(speed) * force);
  }

  // eq. (1)
  double torque(double speed, double force) const {
    double damping = static_cast<double>(params_.damping_nm_s_rad);
    if (damping_ == Damping::kPassive && speed != 0.0) {
      damping = std::min(damping, 4.0 * level(speed) / std::abs(speed));
    }
    return force + damping * force_rate(speed, force) / stiffness() +
           static_cast<double>(direction(speed).viscous_nm_s_rad) * speed;
  }

 private:
  const lugre_direction& direction(double speed) const { return speed >= 0.0 ? params_.positive : params_.negative; }

  lugre_params params_;
  Damping damping_;
};

// Advances `state` from `start` to `end` by rosenbrock4 with dense error control. `rhs(state, slope, time)` is the
// system; its Jacobian and time derivative are taken by central differences.
template <class Rhs>
void solve(Rhs rhs, Vector& state, double start, double end, double first_step, double tolerance = kTolerance) {
  namespace odeint = boost::numeric::odeint;
  const auto jacobian = [&rhs](const Vector& x, Matrix& j, double time, Vector& time_derivative) {
    Vector low(x.size());
    Vector high(x.size());
    for (std::size_t column = 0; column < x.size(); ++column) {
      const double offset = 1e-7 * std::max(std::abs(x(column)), 1e-4);
      Vector moved = x;
      moved(column) = x(column) - offset;
      rhs(moved, low, time);
      moved(column) = x(column) + offset;
      rhs(moved, high, time);
      for (std::size_t row = 0; row < x.size(); ++row) {
        j(row, column) = (high(row) - low(row)) / (2.0 * offset);
      }
    }
    const double moment = 1e-7;
    rhs(x, low, time - moment);
    rhs(x, high, time + moment);
    time_derivative = (high - low) / (2.0 * moment);
  };
  odeint::integrate_adaptive(odeint::make_controlled<odeint::rosenbrock4<double>>(tolerance, tolerance),
                             std::make_pair(rhs, jacobian), state, start, end, first_step);
}

// Friction under a given speed(t): state (F, integral of the torque).
class Driven {
 public:
  explicit Driven(const Friction& friction) : friction_(friction), state_(2, 0.0) {}

  // The mean torque between the two times, like lugre_step's.
  template <class Speed>
  double advance(Speed speed, double start, double end) {
    state_(1) = 0.0;
    const Friction& friction = friction_;
    const auto rhs = [&friction, &speed](const Vector& x, Vector& slope, double time) {
      slope(0) = friction.force_rate(speed(time), x(0));
      slope(1) = friction.torque(speed(time), x(0));
    };
    solve(rhs, state_, start, end, (end - start) * 0.01);
    return state_(1) / (end - start);
  }

  double force() const { return state_(0); }

 private:
  Friction friction_;
  Vector state_;
};

}  // namespace lugre_ode

#endif
