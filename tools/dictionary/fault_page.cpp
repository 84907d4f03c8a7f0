#include <fmt/format.h>

#include <vector>

#include "fault_description.hpp"
#include "faults/fault_account.hpp"

extern "C" {
#include "canopen/object_dictionary.h"
#include "node/protection_objects.h"
#include "protection/fault_texts.h"
}

namespace trackservo::dictionary {
namespace {

constexpr const char *kHead = R"page(# Faults

What the servo notices by itself, what it does then, and what to do about it. The build prints this page from
`firmware/protection/fault_table.c` and `fault_texts.c`: do not edit it, `tools/update-docs dictionary` renews it.

`servoctl faults` shows what is wrong now and what was before, with cause, check and cure; `servoctl explain 0x7320`
tells what a code means. On the bus a fault is an EMCY with its code, its number in byte 3 and the axis + 1 in
byte 4; the code is in 603F (pitch: 683F) until the axis is reset. For faults of board and store byte 3 has
the detail that their text tells. Codes of the CANopen stack alone: [can.md](can.md#emergencies). Objects that are
named here: [can-objects.md](can-objects.md).

## Table

Latency: at most, from when the fault can be seen to the tick that reacts; a timer is an object that comes on top.
Latched: the axis stays in fault until it is cleared.

| number | fault | code | detection | latency | reaction | latched | cleared by |
|---|---|---|---|---|---|---|---|
)page";

constexpr const char *kBetween = R"page(
## Reactions

- tell: EMCY, and all goes on.
- stop: the speed loop brakes the axis as 605E says, then the bridge is off. For faults that leave the loops whole.
- brake: the bridge shorts the motor, which brakes without sensors and loops. After 2 s of it the bridge is off.
- off: the bridge is off at once. For faults in which it cannot be trusted.

An axis without torque gets none, whatever the reaction. A worse fault that comes meanwhile has its reaction, never a
milder one. What comes while an axis is in a fault is told and logged, too, once until the axis is reset; 603F stays. An
axis that is off is held by its friction alone: a gust or an unbalance can turn it. Where that is dangerous the
machine needs a brake or a lock of its own.

To clear an axis' fault: controlword (6040) 00, then 80 at least 1 ms later; or `servoctl state azimuth reset`.
While the reaction lasts (statusword 0F) the axis is deaf to it, and while the fault can still be seen it stays.

## Fault log

3020 keeps the last eight faults, each with the last 16 ticks of its axis, the tick that saw it included: angle,
rates, torque, current and bus voltage; one of the board itself has none. `servoctl faults` shows them, `--csv FOLDER` writes them as files,
`--clear` forgets them. The log is in RAM: an NMT reset keeps it, a restart of the board does not.

## Access lock

Motor (2055) and protection limits (2060) can hurt when they are wrong: they are written only while the lock is
open, else abort 0800 0022. Writing 6E65706F ("open") to 3040:1 opens it for 60 s, anything else locks it,
and so does a reset of the node. 3040:2 tells the seconds left. `servoctl set`, `restore` and `undo` open it with
`--unlock`, and lock it again. It is no password: it keeps out slips, not people.

## Try it in the simulator

`sim_host faults` breaks every part in simulated motions at random moments and tells whether each was seen in
time (`--list` names the parts, `--scenario FILE` breaks one and tells it line by line). `sim_host soak` turns for
simulated hours with all noise and wind and nothing broken: any fault then is a false one. Below, "tried" names the
parts that are broken for a fault, and the tests that bring it about on the emulated board or in the store.

## Each fault
)page";

std::string reaction_text(const fault_row& row) { return row.reaction == REACTION_CUT ? "off" : reaction_name(row); }

std::string latency_of(int fault) {
  const std::string timer = fault_texts[fault].timer;
  return fmt::format("{} ms{}", fault_table[fault].latency_ms, timer.empty() ? "" : " + " + timer);
}

std::string print_row(int fault) {
  const fault_row& row = fault_table[fault];
  const fault_text& text = fault_texts[fault];
  return fmt::format("| {} | {} | {:04X} | {} | {} | {} | {} | {} |\n", fault, text.name, row.code, text.detection,
                     latency_of(fault), reaction_text(row),
                     row.reaction == REACTION_TELL || text.told_once ? "no" : "yes", text.clear);
}

// "2060:5 Stuck sensor time"
std::vector<std::string> limits_of(const fault_text& text) {
  std::vector<std::string> names;
  for (std::uint32_t i = 0; i < protection_objects_table.count; ++i) {
    const od_entry& entry = protection_objects_table.entries[i];
    if ((text.limits >> entry.sub & 1U) != 0) {
      names.push_back(fmt::format("{:04X}:{} {}", entry.index, static_cast<unsigned>(entry.sub), entry.name));
    }
  }
  return names;
}

// The parts that the simulator breaks for it, and the tests elsewhere.
std::string tried(fault_id fault) {
  std::string text;
  for (const std::string& name : sim::breakages_of(fault)) {
    text += (text.empty() ? "`sim_host faults`: " : ", ") + name;
  }
  for (const sim::FaultTest& one : sim::fault_tests()) {
    if (one.fault == fault) {
      text += fmt::format("{}[{}](../{})", text.empty() ? "" : "; ", one.test, one.file);
    }
  }
  return text;
}

std::string print_section(int fault) {
  const fault_text& text = fault_texts[fault];
  std::string limits;
  for (const std::string& limit : limits_of(text)) {
    limits += (limits.empty() ? "- Limits: " : ", ") + limit;
  }
  return fmt::format("\n### {} {} ({:04X})\n\n- Can be seen: {}\n{}- Cause: {}\n- Check: {}\n- Cure: {}\n- Tried: {}\n",
                     fault, text.name, fault_table[fault].code, text.when, limits.empty() ? "" : limits + "\n",
                     text.cause, text.check, text.cure, tried(static_cast<fault_id>(fault)));
}

}  // namespace

std::string print_fault_page() {
  std::string page = kHead;
  for (int fault = FAULT_NONE + 1; fault < FAULT_COUNT; ++fault) {
    page += print_row(fault);
  }
  page += kBetween;
  for (int fault = FAULT_NONE + 1; fault < FAULT_COUNT; ++fault) {
    page += print_section(fault);
  }
  return page;
}

}  // namespace trackservo::dictionary
