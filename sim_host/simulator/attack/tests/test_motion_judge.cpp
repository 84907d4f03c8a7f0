// The judge sees what it must see: contacts with end stops and axes that run away.
#include <cstdio>

#include "attack/attack_run.hpp"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

const sim::NodeSetup& setup() {
  static const sim::NodeSetup made(sim::load_plant("sim_host/plants/tracker.toml"));
  return made;
}

// An axis without torque that is pushed from outside; the upper end stop of pitch is at 95 degrees.
sim::Harm harm_of_a_push(double from_deg, double push_nm, int ticks, std::size_t axis = sim::kPitch) {
  sim::DrivenNode node(setup(), 1, {0.0, from_deg * sim::kRadPerDeg});
  sim::MotionJudge judge(setup());
  node.machine().broken().axis[axis].push_nm = push_nm;
  for (int i = 0; i < ticks; ++i) {
    node.tick();
    judge.look(node, i * sim::kTick_s);
  }
  return judge.harm();
}

void test_a_push_into_the_end_stop_is_a_hard_contact() {
  const sim::Harm harm = harm_of_a_push(85.0, 30.0, 1000);
  const sim::EndStopContacts& contacts = harm.axis[sim::kPitch].contacts;
  std::printf("%.1f deg/s, %.0f Nm, %.2f J\n", contacts.speed_rad_s / sim::kRadPerDeg, contacts.torque_nm,
              contacts.energy_j);
  TEST_ASSERT_TRUE(harm.hits_hard());
  TEST_ASSERT_EQUAL(0, harm.axis[sim::kAzimuth].contacts.count);
  TEST_ASSERT_TRUE(contacts.torque_nm > 30.0);
  // v sqrt(J k), less what the stop's damping takes; 2.5 kg m2 and 50000 Nm/rad.
  TEST_ASSERT_DOUBLE_WITHIN(0.5 * contacts.torque_nm, contacts.torque_nm, contacts.speed_rad_s * 354.0);
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.5 * 2.5 * contacts.speed_rad_s * contacts.speed_rad_s, contacts.energy_j);
}

void test_a_slow_contact_does_no_harm() {
  const sim::Harm harm = harm_of_a_push(94.99, 20.0, 300);
  TEST_ASSERT_TRUE(harm.axis[sim::kPitch].contacts.count > 0);
  TEST_ASSERT_FALSE(harm.hits_hard());
  TEST_ASSERT_FALSE(harm.runs_away());
}

void test_an_axis_beyond_its_speed_limit_runs_away() {
  const sim::Harm harm = harm_of_a_push(0.0, 200.0, 150);
  TEST_ASSERT_EQUAL(sim::Runaway::kTooFast, harm.axis[sim::kPitch].runaway);
}

void test_an_axis_that_turns_on_without_a_command_runs_away() {
  const sim::Harm harm = harm_of_a_push(0.0, 15.0, 4000, sim::kAzimuth);
  TEST_ASSERT_EQUAL(sim::Runaway::kNotStopped, harm.axis[sim::kAzimuth].runaway);
  TEST_ASSERT_TRUE(harm.axis[sim::kAzimuth].runaway_time_s >= sim::kStopTime_s);
}

void test_equal_seeds_give_equal_runs() {
  const sim::AttackBench bench(setup().plant);
  sim::EventLog one;
  sim::EventLog two;
  const sim::AttackResult first = sim::run_attack(bench, 7, &one);
  const sim::AttackResult second = sim::run_attack(bench, 7, &two);
  const sim::AttackResult without_log = sim::run_attack(bench, 7);
  TEST_ASSERT_EQUAL_STRING(one.text().c_str(), two.text().c_str());
  TEST_ASSERT_TRUE(first.writes > 20 && one.text().find("SDO 6040:0 Azimuth Controlword = 0xF") != std::string::npos);
  TEST_ASSERT_EQUAL_DOUBLE(first.harm.axis[0].max_rate_rad_s, second.harm.axis[0].max_rate_rad_s);
  TEST_ASSERT_EQUAL_DOUBLE(first.harm.axis[0].max_rate_rad_s, without_log.harm.axis[0].max_rate_rad_s);
  TEST_ASSERT_EQUAL(first.writes, without_log.writes);
}

void test_everything_that_a_master_can_write_is_attacked() {
  const sim::AttackBench bench(setup().plant);
  std::printf("%zu objects\n", bench.objects().count());
  TEST_ASSERT_TRUE(bench.objects().count() > 300);
  for (std::size_t group = 0; group < sim::kObjectGroups; ++group) {
    TEST_ASSERT_FALSE(bench.objects().group(static_cast<sim::ObjectGroup>(group)).empty());
    for (const sim::WritableObject& object : bench.objects().group(static_cast<sim::ObjectGroup>(group))) {
      TEST_ASSERT_TRUE(object.index != 0x3040);  // nothing is unlocked
    }
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_push_into_the_end_stop_is_a_hard_contact);
  RUN_TEST(test_a_slow_contact_does_no_harm);
  RUN_TEST(test_an_axis_beyond_its_speed_limit_runs_away);
  RUN_TEST(test_an_axis_that_turns_on_without_a_command_runs_away);
  RUN_TEST(test_equal_seeds_give_equal_runs);
  RUN_TEST(test_everything_that_a_master_can_write_is_attacked);
  return UNITY_END();
}
