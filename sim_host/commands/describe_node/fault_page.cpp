// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <vector>

#include "fault_description.hpp"
#include "judge/fault_injection/fault_account.hpp"
#include "markdown.hpp"

extern "C" {
#include "canopen/object_dictionary.h"
#include "node/objects/protection_objects.h"
#include "protection/fault_texts.h"
}

namespace trackservo::dictionary {
namespace {

constexpr const char *kHead = R"page(# Faults

Every fault that the drive detects: its code, what the drive does, the likely cause, and the remedy. The build prints
this page from `firmware/protection/fault_table.c` and `fault_texts_of_*.c`. Do not edit it: run
`tools/update-docs dictionary`.

`servoctl faults` shows active and past faults with cause, check and cure. `servoctl explain 0x7320` explains a code.
On the bus a fault is an EMCY with its code, its number in byte 3 and the axis + 1 in byte 4. The code stays in 603F
(pitch: 683F) until the axis is reset. For faults of the board and the store, byte 3 is the detail that the text of the
fault explains. Codes of the CANopen stack itself: [can.md](can.md#emergencies). Objects:
[can-objects.md](can-objects.md).

Contents: [Table](#table) · [Reactions](#reactions) · [Fault log](#fault-log) · [Access lock](#access-lock) ·
[Try it in the simulator](#try-it-in-the-simulator) · [Each fault](#each-fault)

## Table

The name of a fault leads to its cause, check and cure.

Latency: the longest time from when the fault can be detected to the tick that reacts. Where an object is named, its
time is added. Latched: the axis stays in fault until the fault is cleared.

| number | fault | code | detection | latency | reaction | latched | cleared by |
|---|---|---|---|---|---|---|---|
)page";

constexpr const char *kBetween = R"page(
## Reactions

- report: EMCY and fault log only; the axis continues.
- stop: the speed loop brakes the axis as 605E selects, then the bridge is switched off. For faults that leave the
  control loops intact.
- protect: the envelope brakes with the full motor current, independent of gains, ramps, torque limits and mode; at rest
  the bridge is switched off. For faults in which the speed loop cannot be trusted, but the encoder can.
- brake: the bridge shorts the motor, which brakes without sensors and loops. After 2 s the bridge is switched off.
- off: the bridge is switched off at once. For faults in which the bridge cannot be trusted.

An axis without torque stays without torque, whatever the reaction; "protect" also brakes an axis that has turned ever
since it had torque. If a second fault occurs during a reaction, the more severe reaction applies. Faults of an axis
that is already in fault are reported and logged as well, each once until the axis is reset; 603F keeps the first code.
Only friction holds an axis that is off: a gust or an unbalance can turn it. Where that is dangerous, the machine needs
its own brake or lock.

To clear the fault of an axis, run `servoctl state azimuth reset`, or write 00 and at least 1 ms later 80 to the
controlword (6040). A reset has no effect while the reaction lasts (statusword 0F) or while the fault is still present.

## Fault log

3020 keeps the last eight faults. A fault of an axis includes its signals in the last 16 ticks, up to the tick that
detected the fault: angle, rates, torque, current and bus voltage. A fault of the board has no signals.
`servoctl faults` shows the log, `--csv FOLDER` writes it into files, `--clear` clears it. The log is in RAM: it
survives an NMT reset, but not a restart of the board.

## Access lock

Wrong motor data (2055), protection limits (2060) or sensor scales (3060) can cause damage. They can be written only
while the lock 3040 is open for the SDO channel of the write and no axis has torque; otherwise the write fails with abort
0800 0022. `servoctl set`, `restore` and `undo` open the lock with `--unlock` and close it again. How to set a word of
your own, and what the lock does not protect against: [can.md](can.md#access-lock).

## Try it in the simulator

`sim_host faults` injects every fault into simulated motions at random instants and reports whether each was detected
in time (`--list` lists the fault injections, `--scenario FILE` runs one and reports it line by line). `sim_host soak`
runs simulated hours with full noise and wind and without fault injection: any fault is then a false alarm. Below,
"Tested" lists the fault injections for a fault, and the tests that provoke it on the emulated board or in the store.

## Each fault
)page";

std::string reaction_text(const fault_row& row) {
  switch (row.reaction) {
    case REACTION_REPORT:
      return "report";
    case REACTION_CUT:
      return "off";
    default:
      return reaction_name(row);
  }
}

const fault_text& text_of(int fault) { return *fault_text_of(static_cast<fault_id>(fault)); }

std::string latency_of(int fault) {
  const std::string timer = text_of(fault).timer;
  return fmt::format("{} ms{}", fault_table[fault].latency_ms, timer.empty() ? "" : " + " + timer);
}

// Of its section.
std::string heading_of(int fault) {
  return fmt::format("{} {} ({:04X})", fault, text_of(fault).name, fault_table[fault].code);
}

std::string print_row(int fault) {
  const fault_row& row = fault_table[fault];
  const fault_text& text = text_of(fault);
  return fmt::format("| {} | [{}](#{}) | {:04X} | {} | {} | {} | {} | {} |\n", fault, text.name,
                     anchor_of(heading_of(fault)), row.code, text.detection, latency_of(fault), reaction_text(row),
                     row.reaction == REACTION_REPORT || text.reported_once ? "no" : "yes", text.clear);
}

constexpr int kProtection = 0x2060;

// "2060:5 Stuck sensor time"
std::vector<std::string> limits_of(const fault_text& text) {
  std::vector<std::string> names;
  for (std::uint32_t i = 0; i < protection_objects_table.count; ++i) {
    const od_entry& entry = protection_objects_table.entries[i];
    if (entry.index == kProtection && (text.limits >> entry.sub & 1U) != 0) {
      names.push_back(fmt::format("{:04X}:{} {}", entry.index, static_cast<unsigned>(entry.sub), entry.name));
    }
  }
  return names;
}

// The fault injections of the simulator for this fault, and other tests.
std::string tests_of(fault_id fault) {
  std::string text;
  for (const std::string& name : sim::fault_injections_of(fault)) {
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
  const fault_text& text = text_of(fault);
  std::string limits;
  for (const std::string& limit : limits_of(text)) {
    limits += (limits.empty() ? "- Limits: " : ", ") + limit;
  }
  return fmt::format(
      "\n### {}\n\n- Detection: {}\n- Monitored: {}\n{}- Reaction: {}\n- Cause: {}\n- Check: {}\n- Cure: "
      "{}\n"
      "- Cleared by: {}\n- Tested: {}\n",
      heading_of(fault), text.detection, text.when, limits.empty() ? "" : limits + "\n",
      reaction_text(fault_table[fault]), text.cause, text.check, text.cure, text.clear,
      tests_of(static_cast<fault_id>(fault)));
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
