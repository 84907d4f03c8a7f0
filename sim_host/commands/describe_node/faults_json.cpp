// SPDX-License-Identifier: Apache-2.0
#include "fault_description.hpp"

extern "C" {
#include "protection/fault_texts.h"
}

namespace trackservo::dictionary {
namespace {

std::string owner_name(fault_owner owner) {
  switch (owner) {
    case FAULT_OF_AXIS:
      return "axis";
    case FAULT_OF_BOARD:
      return "board";
    case FAULT_OF_STORE:
      break;
  }
  return "store";
}

nlohmann::ordered_json limit_subs_of(const fault_text& text) {
  nlohmann::ordered_json subs = nlohmann::ordered_json::array();
  for (unsigned sub = 0; sub < 64; ++sub) {
    if ((text.limits >> sub & 1U) != 0) {
      subs.push_back(sub);
    }
  }
  return subs;
}

nlohmann::ordered_json describe(int fault) {
  const fault_row& row = fault_table[fault];
  const fault_text& text = *fault_text_of(static_cast<fault_id>(fault));
  return {{"number", fault},
          {"name", text.name},
          {"code", row.code},
          {"of", owner_name(text.owner)},
          {"reaction", reaction_name(row)},
          {"latency_ms", row.latency_ms},
          {"timer", text.timer},
          {"limits", limit_subs_of(text)},
          {"detection", text.detection},
          {"when", text.when},
          {"cause", text.cause},
          {"check", text.check},
          {"cure", text.cure},
          {"clear", text.clear}};
}

}  // namespace

std::string reaction_name(const fault_row& row) {
  switch (static_cast<fault_reaction>(row.reaction)) {
    case REACTION_REPORT:
      return "tell";
    case REACTION_STOP:
      return "stop";
    case REACTION_PROTECT:
      return "protect";
    case REACTION_BRAKE:
      return "brake";
    case REACTION_CUT:
      break;
  }
  return "cut";
}

nlohmann::ordered_json describe_faults() {
  nlohmann::ordered_json faults = nlohmann::ordered_json::array();
  for (int fault = FAULT_NONE + 1; fault < FAULT_COUNT; ++fault) {
    faults.push_back(describe(fault));
  }
  nlohmann::ordered_json signals = nlohmann::ordered_json::array();
  for (const fault_signal& signal : fault_signals) {
    signals.push_back({{"name", signal.name}, {"unit", signal.unit}});
  }
  return {{"faults", faults}, {"signals", signals}};
}

}  // namespace trackservo::dictionary
