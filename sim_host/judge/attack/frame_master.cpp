// SPDX-License-Identifier: Apache-2.0
#include "judge/attack/frame_master.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <stdexcept>

#include "machine/sensors/camera_sender.hpp"

extern "C" {
#include "canopen/heard_frames.h"
}

namespace trackservo::sim {
namespace {

constexpr std::uint32_t kRequest = 0x601;
constexpr std::uint32_t kResponse = 0x581;
constexpr std::uint8_t kDownloaded = 0x60;
constexpr std::uint8_t kAborted = 0x80;
constexpr std::uint16_t kDeviceType = 0x1000;

std::uint32_t word(const std::uint8_t *bytes) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

std::uint16_t index_of(const can_frame& frame) {
  return static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8);
}

std::string value_text(const od_entry& entry, std::uint32_t value) {
  float real = 0.0F;
  switch (entry.type) {
    case OD_REAL32:
      std::memcpy(&real, &value, sizeof real);
      return fmt::format("{:g}", real);
    case OD_INTEGER8:
      return fmt::format("{}", static_cast<std::int8_t>(value));
    case OD_INTEGER16:
      return fmt::format("{}", static_cast<std::int16_t>(value));
    case OD_INTEGER32:
      return fmt::format("{}", static_cast<std::int32_t>(value));
    default:
      return entry.index < 0x2000 || entry.index == 0x6040 ? fmt::format("0x{:X}", value) : fmt::format("{}", value);
  }
}

}  // namespace

void EventLog::say(double time_s, const std::string& text) { text_ += fmt::format("{:8.3f} s  {}\n", time_s, text); }

SdoWrite sdo_write(const DrivenNode& node, std::uint16_t index, std::uint8_t sub, double value) {
  od_object object;
  if (od_find(servo_node_dictionary(&node.node()), index, sub, &object) != OD_OK) {
    throw std::invalid_argument(fmt::format("no object {:04X}:{}", index, sub));
  }
  SdoWrite made{index, sub, static_cast<std::uint8_t>(object.entry->bytes), 0};
  if (object.entry->type == OD_REAL32) {
    const auto real = static_cast<float>(value);
    std::memcpy(&made.value, &real, sizeof real);
  } else {
    made.value = static_cast<std::uint32_t>(std::llround(value));
  }
  return made;
}

void FrameMaster::say(const std::string& text) {
  if (log_ != nullptr) {
    log_->say(time_s_, text);
  }
}

std::string FrameMaster::describe(const SdoWrite& write) const {
  od_object object;
  if (od_find(servo_node_dictionary(&node_->node()), write.index, write.sub, &object) != OD_OK) {
    return fmt::format("{:04X}:{} = 0x{:X}", write.index, write.sub, write.value);
  }
  const od_entry& entry = *object.entry;
  const std::string unit = *entry.unit == '\0' ? "" : fmt::format(" [{}]", entry.unit);
  return fmt::format("{:04X}:{} {}{} = {}{}", write.index, write.sub, object.part->prefix, entry.name,
                     value_text(entry, write.value), unit);
}

bool FrameMaster::receive(void *context, const can_frame *frame) {
  static_cast<FrameMaster *>(context)->take(*frame);
  return true;
}

void FrameMaster::take(const can_frame& frame) {
  if (frame.id != kResponse) {
    return;
  }
  const bool upload = (frame.data[0] & 0xE0U) == 0x40U;
  device_type_read_ = device_type_read_ || (upload && index_of(frame) == kDeviceType);
  if (!waiting_ || index_of(frame) != sent_.index || frame.data[3] != sent_.sub || upload) {
    return;
  }
  waiting_ = false;
  if (frame.data[0] == kAborted) {
    refusals_++;
    if (log_ != nullptr) {
      say(fmt::format("  the node refuses {:04X}:{} with {:08X}", sent_.index, sent_.sub, word(frame.data + 4)));
    }
  } else if (frame.data[0] != kDownloaded) {
    say("  unexpected answer to an SDO request");
  }
}

bool FrameMaster::write(const SdoWrite& write) {
  if (count_ == kQueue) {
    return false;
  }
  queue_[(first_ + count_) % kQueue] = write;
  count_++;
  return true;
}

void FrameMaster::map_camera(int number, std::uint32_t cob_id) {
  for (const ObjectWrite& one : camera_mapping(number, cob_id)) {
    (void)write(sdo_write(*node_, one.index, one.sub, one.value));
  }
}

void FrameMaster::send(const can_frame& frame, const std::string& meaning) {
  if (log_ != nullptr) {
    std::string bytes;
    for (int i = 0; i < frame.length; ++i) {
      bytes += fmt::format(" {:02X}", frame.data[i]);
    }
    say(fmt::format("frame {:03X}#{}{}{}", frame.id, bytes, meaning.empty() ? "" : ": ", meaning));
  }
  if (heard_frame(&frame)) {
    node_->receive(frame);
  }
}

void FrameMaster::ask_device_type() {
  can_frame frame{kRequest, 0, 8, {0x40, kDeviceType & 0xFF, kDeviceType >> 8, 0, 0, 0, 0, 0}, 0};
  node_->receive(frame);
}

void FrameMaster::step(double time_s) {
  time_s_ = time_s;
  if (waiting_ && ++waited_ticks_ < kAnswerTicks) {
    return;
  }
  if (waiting_) {
    waiting_ = false;
    say("  no answer");
  }
  if (count_ == 0) {
    return;
  }
  sent_ = queue_[first_];
  first_ = (first_ + 1) % kQueue;
  count_--;
  waiting_ = true;
  waited_ticks_ = 0;
  writes_++;
  if (log_ != nullptr) {
    say("SDO " + describe(sent_));
  }
  can_frame frame{kRequest,
                  0,
                  8,
                  {static_cast<std::uint8_t>(0x23 | (4 - sent_.bytes) << 2), static_cast<std::uint8_t>(sent_.index),
                   static_cast<std::uint8_t>(sent_.index >> 8), sent_.sub, 0, 0, 0, 0},
                  0};
  std::memcpy(frame.data + 4, &sent_.value, sizeof sent_.value);
  node_->receive(frame);
}

}  // namespace trackservo::sim
