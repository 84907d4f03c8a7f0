// SPDX-License-Identifier: Apache-2.0
// Random legal writes to moving axes do no harm. `tools/test attack` runs 5,000 seeds, `sim_host attack` any, and
// replays one.
#include <cstdio>

#include "judge/attack/attack_campaign.hpp"
#include "judge/attack/named_sequences.hpp"
#include "support/test_size.h"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

void test_random_legal_writes() {
  const sim::AttackBench bench(sim::load_plant("sim_host/plants/tracker.toml"));
  sim::AttackOptions options;
  options.seeds = static_cast<std::uint64_t>(by_size(60, 500, 5000));
  const sim::AttackCampaign campaign = sim::run_attacks(bench, options, [](int, int, const std::string&) {});
  std::printf("%s", sim::print(campaign).c_str());
  const sim::ThemeSummary all = campaign.total();
  TEST_ASSERT_EQUAL(options.seeds, all.seeds);
  TEST_ASSERT_TRUE(all.writes > 100 * all.seeds && all.refusals < all.writes / 5);
  TEST_ASSERT_EQUAL(0, all.not_finite);
  TEST_ASSERT_EQUAL(0, all.silent);
  TEST_ASSERT_TRUE_MESSAGE(campaign.harmful.empty(), "see the list above; sim_host attack --replay SEED shows each");
}

// Each must do what its row says; a row whose state changes needs `harmless` changed, and docs/results/attack.md.
void test_known_sequences() {
  const sim::AttackBench bench(sim::load_plant("sim_host/plants/tracker.toml"));
  const std::vector<sim::SequenceResult> results = sim::run_named_sequences(bench, 2);
  std::printf("%s", sim::print(results).c_str());
  TEST_ASSERT_EQUAL(sim::named_sequences().size(), results.size());
  for (const sim::SequenceResult& one : results) {
    TEST_ASSERT_FALSE_MESSAGE(one.harm.not_finite, one.sequence->name.c_str());
    TEST_ASSERT_EQUAL_MESSAGE(one.sequence->harmless, one.harmless, one.sequence->name.c_str());
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_known_sequences);
  RUN_TEST(test_random_legal_writes);
  return UNITY_END();
}
