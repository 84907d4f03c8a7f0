// SPDX-License-Identifier: Apache-2.0
#include "device/can_client.hpp"

#include <algorithm>

namespace trackservo::sim {
namespace {

constexpr std::uint16_t kPitchShift = 0x800;
constexpr std::uint16_t kControlword = 0x6040;
constexpr std::uint16_t kStatusword = 0x6041;
constexpr std::uint16_t kErrorCode = 0x603F;
constexpr std::uint16_t kMode = 0x6060;

std::uint16_t of_axis(std::uint16_t index, int axis) { return static_cast<std::uint16_t>(index + kPitchShift * axis); }

std::uint32_t word_of(const can_frame& frame, std::size_t at) {
  return frame.data[at] | static_cast<std::uint32_t>(frame.data[at + 1]) << 8 |
         static_cast<std::uint32_t>(frame.data[at + 2]) << 16 | static_cast<std::uint32_t>(frame.data[at + 3]) << 24;
}

void append(std::vector<std::uint8_t>& bytes, std::uint32_t word) {
  for (int i = 0; i < 4; ++i) {
    bytes.push_back(static_cast<std::uint8_t>(word >> (8 * i)));
  }
}

}  // namespace

CanClient::CanClient(VirtualBus& bus, std::function<void()> pass_ms)
    : bus_(bus), pass_ms_(std::move(pass_ms)), port_(bus.attach([this](const can_frame& frame) { receive(frame); })) {}

void CanClient::receive(const can_frame& frame) {
  if (frame.id == 0x580U + node_) {
    answer_ = frame;
  } else if (frame.id == 0x700U + node_) {
    ++heartbeats_;
    boots_ += frame.data[0] == 0 ? 1 : 0;
  } else if (frame.id == 0x080U + node_) {
    Emergency emergency{static_cast<std::uint16_t>(word_of(frame, 0)), {}};
    std::copy_n(frame.data, emergency.bytes.size(), emergency.bytes.begin());
    emergencies_.push_back(emergency);
  } else if (frame.id >= 0x180U && frame.id < 0x580U) {
    ++pdos_;
  }
}

void CanClient::send(std::uint32_t identifier, const std::vector<std::uint8_t>& bytes) {
  can_frame frame{};
  frame.id = identifier;
  frame.length = static_cast<std::uint8_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), frame.data);
  send(frame);
}

void CanClient::pass(int milliseconds) {
  for (int i = 0; i < milliseconds; ++i) {
    pass_ms_();
  }
}

std::optional<can_frame> CanClient::answer(int patience_ms) {
  for (int i = 0; i < patience_ms && !answer_; ++i) {
    pass(1);
  }
  return answer_;
}

void CanClient::ask(std::uint16_t index, std::uint8_t sub) {
  answer_.reset();
  send(0x600U + node_,
       {0x40, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8), sub, 0, 0, 0, 0});
}

int CanClient::read_within(std::uint16_t index, int patience_ms) {
  ask(index, 0);
  int ms = 0;
  for (; ms < patience_ms && !answer_; ++ms) {
    pass(1);
  }
  return answer_ && (answer_->data[0] & 0xE2U) == 0x42 ? ms : -1;
}

std::optional<std::uint32_t> CanClient::read(std::uint16_t index, std::uint8_t sub) {
  ask(index, sub);
  const std::optional<can_frame> frame = answer(kPatience_ms);
  if (!frame || (frame->data[0] & 0xE2U) != 0x42) {
    return std::nullopt;
  }
  return word_of(*frame, 4);
}

bool CanClient::write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes, int patience_ms) {
  answer_.reset();
  std::vector<std::uint8_t> request = {static_cast<std::uint8_t>(0x23 | (4 - bytes) << 2),
                                       static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8), sub};
  append(request, value);
  send(0x600U + node_, request);
  const std::optional<can_frame> frame = answer(patience_ms);
  constexpr std::uint8_t kAbort = 0x80;
  abort_code_ = frame && frame->data[0] == kAbort ? std::optional(word_of(*frame, 4)) : std::nullopt;
  return frame && frame->data[0] == 0x60;
}

std::uint32_t CanClient::statusword(int axis) { return read(of_axis(kStatusword, axis)).value_or(0); }

std::uint32_t CanClient::error_code(int axis) { return read(of_axis(kErrorCode, axis)).value_or(0); }

bool CanClient::is_enabled(int axis) { return (statusword(axis) & 0x6FU) == 0x27; }

bool CanClient::enable_again(int axis) {
  for (const std::uint32_t command : {0x00U, 0x80U, 0x06U, 0x07U, 0x0FU}) {
    write(of_axis(kControlword, axis), 0, command, 2);
    pass(3);
  }
  pass(20);
  return is_enabled(axis);
}

bool CanClient::enable(int mode) {
  for (const std::uint16_t shift : {std::uint16_t{0}, kPitchShift}) {
    if (!write(static_cast<std::uint16_t>(kMode + shift), 0, static_cast<std::uint32_t>(mode), 1)) {
      return false;
    }
    for (const std::uint32_t command : {0x06U, 0x07U, 0x0FU}) {
      write(static_cast<std::uint16_t>(kControlword + shift), 0, command, 2);
      pass(3);
    }
  }
  pass(20);
  return is_enabled(0) && is_enabled(1);
}

void CanClient::set_speeds(std::int32_t azimuth_urad_s, std::int32_t pitch_urad_s) {
  std::vector<std::uint8_t> bytes;
  append(bytes, static_cast<std::uint32_t>(azimuth_urad_s));
  append(bytes, static_cast<std::uint32_t>(pitch_urad_s));
  send(0x400U + node_, bytes);
}

}  // namespace trackservo::sim
