// Random legal writes to moving axes; `sim_host attack` runs more of them and replays one.
#include <cstdio>

#include "attack/attack_campaign.hpp"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

// Whether no write can turn an axis into its end stop or let it run away. When the campaign says otherwise, change this
// line and docs/results/attack.md.
constexpr bool kWritesAreHarmless = false;

#ifdef TESTS_FEW_CASES
constexpr std::uint64_t kSeeds = 200;
#else
constexpr std::uint64_t kSeeds = 5000;
#endif

void test_random_legal_writes() {
  const sim::AttackBench bench(sim::load_plant("sim_host/plants/tracker.toml"));
  sim::AttackOptions options;
  options.seeds = kSeeds;
  const sim::AttackCampaign campaign = sim::run_attacks(bench, options, [](int, int, const std::string&) {});
  std::printf("%s", sim::print(campaign).c_str());
  const sim::ThemeSummary all = campaign.total();
  TEST_ASSERT_EQUAL(kSeeds, all.seeds);
  TEST_ASSERT_TRUE(all.writes > 100 * all.seeds && all.refusals < all.writes / 5);
  TEST_ASSERT_EQUAL(0, all.not_finite);
  TEST_ASSERT_EQUAL(0, all.silent);
  TEST_ASSERT_EQUAL_MESSAGE(kWritesAreHarmless, campaign.harmful.empty(), "see kWritesAreHarmless");
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_random_legal_writes);
  return UNITY_END();
}
