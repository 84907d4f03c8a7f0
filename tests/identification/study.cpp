// How well identification does: true, found and claimed, on the simulated machine. By hand: not a test.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>

#include "commissioning_bench.hpp"
#include "identification/joint_fit.hpp"
#include "identification/start_search.hpp"

namespace id = trackservo::identification;
namespace sim = trackservo::sim;

int main(int argc, char **argv) {
  CLI::App app{"identification on the simulated machine"};
  commissioning::BenchSetup setup;
  std::string plant = "tracker";
  std::string csv;
  int seeds = 1;
  bool no_wind = false;
  double cutoff = 250;
  bool no_ripple = false;
  app.add_option("--plant", plant);
  app.add_option("--axis", setup.axis);
  app.add_option("--seed", setup.seed);
  app.add_option("--seeds", seeds);
  app.add_option("--csv", csv);
  app.add_option("--controller", setup.controller);
  app.add_flag("--no-wind", no_wind);
  app.add_option("--cutoff", cutoff);
  app.add_flag("--no-ripple", no_ripple);
  CLI11_PARSE(app, argc, argv);
  setup.plant = sim::load_plant("sim_host/plants/" + plant + ".toml");
  for (sim::AxisConfig& axis : setup.plant.axis) {
    if (no_wind) {
      axis.load.wind_gust_rms_nm = 0;
    }
    if (no_ripple) {
      axis.motor.ripple.clear();
      axis.motor.cogging.clear();
    }
  }
  const commissioning::Programme programme =
      commissioning::programme_for(commissioning::rough_machine(setup.plant, setup.axis, setup.pitch_rad));
  const auto& f = setup.plant.axis[static_cast<std::size_t>(setup.axis)].friction;
  for (int n = 0; n < seeds; ++n, ++setup.seed) {
    const auto begin = std::chrono::steady_clock::now();
    const id::Recording recording = commissioning::record(setup, programme);
    if (!csv.empty()) {
      commissioning::write_csv(recording, csv);
    }
    const auto recorded = std::chrono::steady_clock::now();
    const id::PaperEstimate paper = id::paper_estimate(recording);
    const id::Motion motion = id::analyse_motion(recording, cutoff);
    const id::PaperEstimate start = id::search_start(recording, motion, paper);
    const auto searched = std::chrono::steady_clock::now();
    id::TorqueBalance balance(recording, motion);
    const id::JointFit fit = id::fit_jointly(balance, id::starts_around(motion, id::start_parameters(balance, start)));
    const auto done = std::chrono::steady_clock::now();
    fmt::print(
        "seed {}: {:.0f} s recorded in {:.1f} s, searched {:.1f} s, fitted in {:.1f} s, {} rounds, converged {}, "
        "AR({}) {:.4g} Nm, widening {:.2f}\n",
        setup.seed, recording.time_s.back(), std::chrono::duration<double>(recorded - begin).count(),
        std::chrono::duration<double>(searched - recorded).count(),
        std::chrono::duration<double>(done - searched).count(), fit.rounds, fit.converged, fit.noise.order(),
        fit.noise.innovation_nm(), fit.widening);
    fmt::print("  gyro: scale {:.3g}, delay {:.4g} s, angle noise {:.3g} rad; torque delay {:.4g} +- {:.2g} s\n",
               motion.gyro.scale_error, motion.gyro.delay_s, motion.angle_noise_rad, fit.parameters[id::kDelay],
               fit.deviation(id::kDelay));
    const Eigen::VectorXd rho = id::autocorrelation(fit.whitened, fit.spans, 40);
    fmt::print("  whitened: largest correlation {:.3f}\n", rho.cwiseAbs().maxCoeff());
    const double truth[] = {f.positive.coulomb_nm,
                            f.positive.breakaway_nm,
                            f.positive.stribeck_speed_rad_s,
                            f.negative.coulomb_nm,
                            f.negative.breakaway_nm,
                            f.negative.stribeck_speed_rad_s,
                            f.stiffness_nm_rad,
                            f.positive.viscous_nm_s_rad,
                            f.negative.viscous_nm_s_rad,
                            f.damping_nm_s_rad,
                            sim::axis_inertia_kg_m2(setup.plant, setup.axis, setup.pitch_rad)};
    const char *names[] = {"Tc+", "Ts+", "vs+", "Tc-", "Ts-", "vs-", "s0", "s2+", "s2-", "s1", "J"};
    for (int i = 0; i < id::kLogarithms; ++i) {
      const double value = std::exp(fit.parameters[i]);
      const double error = std::log(value / truth[i]);
      fmt::print("  {:<4} true {:10.5g} start {:10.5g} found {:10.5g} error {:+6.2f} % +-{:5.2f} % ({:+.1f} sd)\n",
                 names[i], truth[i], std::exp(fit.start[i]), value, 100 * error, 196 * fit.deviation(i),
                 error / fit.deviation(i));
    }
    for (const id::MotorHarmonic& harmonic : balance.harmonics()) {
      fmt::print("  harmonic {} {}\n", harmonic.per_turn, harmonic.ripple ? "ripple" : "cogging");
    }
    for (Eigen::Index i = balance.first_map(); i < balance.parameters(); ++i) {
      fmt::print("  term {} {:.4g} +- {:.2g}\n", i, fit.parameters[i], 1.96 * fit.deviation(i));
    }
  }
}
