// SPDX-License-Identifier: Apache-2.0
#include "judge/attack/attack_campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <nlohmann/json.hpp>

#include "machine/base/json_file.hpp"

namespace trackservo::sim {
namespace {

constexpr std::size_t kSeedsPerJob = 50;
constexpr std::size_t kPrintedSeeds = 20;

double rounded(double value) { return std::round(value * 1000.0) / 1000.0; }

void add(ThemeSummary& sum, const AttackResult& result) {
  sum.seeds++;
  sum.writes += result.writes;
  sum.refusals += result.refusals;
  bool touched = false;
  for (const AxisHarm& axis : result.harm.axis) {
    touched = touched || axis.contacts.count > 0;
    sum.max_contact_rad_s = std::max(sum.max_contact_rad_s, axis.contacts.speed_rad_s);
    sum.max_contact_nm = std::max(sum.max_contact_nm, axis.contacts.torque_nm);
    sum.max_contact_j = std::max(sum.max_contact_j, axis.contacts.energy_j);
    sum.max_rate_rad_s = std::max(sum.max_rate_rad_s, axis.max_rate_rad_s);
  }
  sum.contacts += touched ? 1 : 0;
  sum.hard_contacts += result.harm.hits_hard() ? 1 : 0;
  sum.runaways += result.harm.runs_away() ? 1 : 0;
  sum.not_finite += result.harm.not_finite ? 1 : 0;
  sum.silent += result.answers ? 0 : 1;
}

void add(ThemeSummary& sum, const ThemeSummary& other) {
  sum.seeds += other.seeds;
  sum.writes += other.writes;
  sum.refusals += other.refusals;
  sum.contacts += other.contacts;
  sum.hard_contacts += other.hard_contacts;
  sum.runaways += other.runaways;
  sum.not_finite += other.not_finite;
  sum.silent += other.silent;
  sum.max_contact_rad_s = std::max(sum.max_contact_rad_s, other.max_contact_rad_s);
  sum.max_contact_nm = std::max(sum.max_contact_nm, other.max_contact_nm);
  sum.max_contact_j = std::max(sum.max_contact_j, other.max_contact_j);
  sum.max_rate_rad_s = std::max(sum.max_rate_rad_s, other.max_rate_rad_s);
}

std::string row(const std::string& name, const ThemeSummary& sum) {
  return fmt::format("{:<20} {:>7} {:>9} {:>8} {:>8} {:>7} {:>8} {:>6} {:>7} {:>8.1f} {:>7.0f} {:>6.1f} {:>7.1f}\n",
                     name, sum.seeds, sum.writes, sum.refusals, sum.contacts, sum.hard_contacts, sum.runaways,
                     sum.not_finite, sum.silent, sum.max_contact_rad_s * kDegPerRad, sum.max_contact_nm,
                     sum.max_contact_j, sum.max_rate_rad_s * kDegPerRad);
}

nlohmann::ordered_json json_of(const ThemeSummary& sum) {
  return {{"seeds", sum.seeds},
          {"writes", sum.writes},
          {"refused_writes", sum.refusals},
          {"seeds_with_contact", sum.contacts},
          {"seeds_with_hard_contact", sum.hard_contacts},
          {"seeds_with_runaway", sum.runaways},
          {"seeds_with_not_a_number", sum.not_finite},
          {"seeds_without_answer", sum.silent},
          {"max_contact_deg_s", rounded(sum.max_contact_rad_s * kDegPerRad)},
          {"max_contact_nm", rounded(sum.max_contact_nm)},
          {"max_contact_j", rounded(sum.max_contact_j)},
          {"max_rate_deg_s", rounded(sum.max_rate_rad_s * kDegPerRad)}};
}

const char *runaway_word(Runaway runaway) {
  return runaway == Runaway::kTooFast ? "too_fast" : runaway == Runaway::kNotStopped ? "not_stopped" : "none";
}

nlohmann::ordered_json json_of(const AttackResult& result) {
  nlohmann::ordered_json axes;
  for (int axis = 0; axis < kAxes; ++axis) {
    const AxisHarm& one = result.harm.axis[static_cast<std::size_t>(axis)];
    axes[axis_name(axis)] = {{"contacts", one.contacts.count},
                             {"contact_deg_s", rounded(one.contacts.speed_rad_s * kDegPerRad)},
                             {"contact_nm", rounded(one.contacts.torque_nm)},
                             {"contact_j", rounded(one.contacts.energy_j)},
                             {"max_rate_deg_s", rounded(one.max_rate_rad_s * kDegPerRad)},
                             {"runaway", runaway_word(one.runaway)}};
  }
  return {{"seed", result.seed},
          {"theme", theme_name(result.theme)},
          {"what", describe(result.harm, result.answers)},
          {"axes", axes}};
}

}  // namespace

ThemeSummary AttackCampaign::total() const {
  ThemeSummary all;
  for (const ThemeSummary& one : themes) {
    add(all, one);
  }
  return all;
}

AttackCampaign run_attacks(const AttackBench& bench, const AttackOptions& options,
                           const std::function<void(int, int, const std::string&)>& progress) {
  AttackCampaign campaign{options, {}, {}};
  for (const Theme theme : kThemes) {
    campaign.themes.push_back({});
    campaign.themes.back().theme = theme;
  }
  const auto count = [&](const AttackResult& result) {
    add(campaign.themes[static_cast<std::size_t>(result.theme)], result);
    if (!result.harmless()) {
      campaign.harmful.push_back(result);
    }
  };
  std::mutex mutex;
  const std::size_t jobs = (options.seeds + kSeedsPerJob - 1) / kSeedsPerJob;
  JobPool pool(options.threads, static_cast<int>(jobs), progress);
  pool.run(jobs, [&](std::size_t job) {
    const std::uint64_t end = std::min<std::uint64_t>((job + 1) * kSeedsPerJob, options.seeds);
    std::vector<AttackResult> results;
    for (std::uint64_t i = job * kSeedsPerJob; i < end; ++i) {
      results.push_back(run_attack(bench, options.first_seed + i));
    }
    const std::lock_guard<std::mutex> lock(mutex);
    std::for_each(results.begin(), results.end(), count);
    return std::string("attacks");
  });
  std::sort(campaign.harmful.begin(), campaign.harmful.end(),
            [](const AttackResult& a, const AttackResult& b) { return a.seed < b.seed; });
  return campaign;
}

std::string print(const AttackCampaign& campaign) {
  std::string text =
      fmt::format("{:<20} {:>7} {:>9} {:>8} {:>8} {:>7} {:>8} {:>6} {:>7} {:>8} {:>7} {:>6} {:>7}\n", "writes", "seeds",
                  "writes", "refused", "contact", "hard", "runaway", "NaN", "silent", "deg/s", "Nm", "J", "fastest");
  for (const ThemeSummary& one : campaign.themes) {
    text += row(theme_name(one.theme), one);
  }
  text += row("all", campaign.total());
  std::vector<AttackResult> worst = campaign.harmful;
  const auto speed = [](const AttackResult& one) {
    return std::max(one.harm.axis[kAzimuth].contacts.speed_rad_s, one.harm.axis[kPitch].contacts.speed_rad_s);
  };
  std::stable_sort(worst.begin(), worst.end(),
                   [&](const AttackResult& a, const AttackResult& b) { return speed(a) > speed(b); });
  text += fmt::format("{} of {} seeds do harm{}\n", worst.size(), campaign.options.seeds,
                      worst.size() > kPrintedSeeds ? fmt::format("; the worst {}:", kPrintedSeeds) : "");
  for (std::size_t i = 0; i < std::min(worst.size(), kPrintedSeeds); ++i) {
    text += fmt::format("seed {} ({}): {}\n", worst[i].seed, theme_name(worst[i].theme),
                        describe(worst[i].harm, worst[i].answers));
  }
  return text;
}

void write_attacks(const AttackCampaign& campaign, const std::string& commit, const std::filesystem::path& file) {
  nlohmann::ordered_json themes;
  for (const ThemeSummary& one : campaign.themes) {
    themes[theme_name(one.theme)] = json_of(one);
  }
  nlohmann::ordered_json harmful = nlohmann::ordered_json::array();
  for (const AttackResult& one : campaign.harmful) {
    harmful.push_back(json_of(one));
  }
  write_json({{"generator",
               {{"program", "sim_host attack"},
                {"commit", commit},
                {"first_seed", campaign.options.first_seed},
                {"seeds", campaign.options.seeds}}},
              {"limits",
               {{"contact_deg_s", rounded(kContactLimit_rad_s * kDegPerRad)},
                {"overspeed_margin_deg_s", rounded(kOverspeedMargin_rad_s * kDegPerRad)},
                {"stop_time_s", kStopTime_s}}},
              {"all", json_of(campaign.total())},
              {"themes", themes},
              {"harmful_seeds", harmful}},
             file);
}

}  // namespace trackservo::sim
