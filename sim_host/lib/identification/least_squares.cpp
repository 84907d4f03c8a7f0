// SPDX-License-Identifier: Apache-2.0
#include "identification/least_squares.hpp"

#include <Eigen/Dense>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

namespace trackservo::identification {

namespace {

// In the form that Eigen needs.
class Residual {
 public:
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  explicit Residual(const LeastSquares& problem) : problem_(problem) {}

  int inputs() const { return static_cast<int>(problem_.parameters); }
  int values() const { return static_cast<int>(problem_.residuals); }

  int operator()(const Eigen::VectorXd& parameters, Eigen::VectorXd& residuals) const {
    residuals.resize(problem_.residuals);
    return problem_.evaluate(parameters, residuals) ? 0 : -1;
  }

 protected:
  const LeastSquares& problem_;
};

class Problem : public Residual {
 public:
  using Residual::Residual;

  // Returns the number of evaluations that it took.
  int df(const Eigen::VectorXd& parameters, Eigen::MatrixXd& jacobian) const {
    if (!problem_.differentiate) {
      return Eigen::NumericalDiff<Residual>(*this).df(parameters, jacobian);
    }
    problem_.differentiate(parameters, jacobian);
    return 0;
  }
};

}  // namespace

double minimize(const LeastSquares& problem, const LeastSquaresEnd& end, Eigen::VectorXd& parameters) {
  Problem eigen_problem(problem);
  Eigen::LevenbergMarquardt<Problem> solver(eigen_problem);
  solver.parameters.maxfev = end.max_evaluations;
  solver.parameters.ftol = end.residual_tolerance;
  solver.parameters.xtol = end.parameter_tolerance;
  solver.minimize(parameters);
  return solver.fnorm;
}

}  // namespace trackservo::identification
