// SPDX-License-Identifier: Apache-2.0
#include "device/bus/slcan_session.hpp"

#include <algorithm>
#include <array>
#include <optional>

namespace trackservo::sim {
namespace {

constexpr char kGood = '\r';
constexpr char kBad = '\a';
constexpr std::size_t kLongestLine = 64;
constexpr std::size_t kOutputLimit = 1 << 20;
constexpr unsigned kTimeStampPeriodMs = 60000;

std::optional<std::uint32_t> hex(std::string_view text) {
  std::uint32_t value = 0;
  for (const char c : text) {
    std::uint32_t digit = 0;
    if (c >= '0' && c <= '9') {
      digit = static_cast<std::uint32_t>(c - '0');
    } else if (c >= 'A' && c <= 'F') {
      digit = static_cast<std::uint32_t>(c - 'A') + 10;
    } else if (c >= 'a' && c <= 'f') {
      digit = static_cast<std::uint32_t>(c - 'a') + 10;
    } else {
      return std::nullopt;
    }
    value = value << 4 | digit;
  }
  return value;
}

void append_hex(std::string& text, std::uint32_t value, int digits) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  for (int i = digits - 1; i >= 0; --i) {
    text += kDigits[value >> (4 * i) & 0xFU];
  }
}

// "t1232AABB", "T1ABCDEF00", "r1234", with or without a time stamp of four digits after it.
std::optional<can_frame> parse_frame(std::string_view line) {
  const char kind = line[0];
  const bool extended = kind == 'T' || kind == 'R';
  const bool remote = kind == 'r' || kind == 'R';
  const std::size_t id_digits = extended ? 8 : 3;
  if (line.size() < 2 + id_digits) {
    return std::nullopt;
  }
  const auto id = hex(line.substr(1, id_digits));
  const auto length = hex(line.substr(1 + id_digits, 1));
  if (!id || !length || *length > CAN_FRAME_BYTES || *id > (extended ? 0x1FFFFFFFU : 0x7FFU)) {
    return std::nullopt;
  }
  const std::string_view data = line.substr(2 + id_digits);
  const std::size_t digits = remote ? 0 : 2 * *length;
  if (data.size() != digits && data.size() != digits + 4) {
    return std::nullopt;
  }
  can_frame frame{};
  frame.id = *id;
  frame.length = static_cast<std::uint8_t>(*length);
  frame.flags = static_cast<std::uint8_t>((extended ? CAN_FRAME_EXTENDED : 0) | (remote ? CAN_FRAME_REMOTE : 0));
  for (std::size_t i = 0; i < digits / 2; ++i) {
    const auto byte = hex(data.substr(2 * i, 2));
    if (!byte) {
      return std::nullopt;
    }
    frame.data[i] = static_cast<std::uint8_t>(*byte);
  }
  return frame;
}

}  // namespace

void SlcanSession::consume(std::string_view bytes) {
  for (const char c : bytes) {
    if (c == '\n') {
      continue;  // typed by hand in a terminal
    }
    if (c != '\r') {
      line_too_long_ = line_.size() >= kLongestLine;
      if (!line_too_long_) {
        line_ += c;
      }
      continue;
    }
    if (line_too_long_) {
      output_ += kBad;
    } else {
      execute(line_);
    }
    line_.clear();
    line_too_long_ = false;
  }
}

bool SlcanSession::open(bool listen_only) {
  open_ = true;
  listen_only_ = listen_only;
  return true;
}

bool SlcanSession::transmit(std::string_view line) {
  const auto frame = parse_frame(line);
  if (!open_ || listen_only_ || !frame) {
    return false;
  }
  to_bus_.push_back(*frame);
  return true;
}

// S9 is an addition of python-can to Lawicel's S0 to S8.
bool SlcanSession::set_bit_rate(char digit) {
  constexpr std::array<double, 10> kBitRates = {10e3, 20e3, 50e3, 100e3, 125e3, 250e3, 500e3, 800e3, 1e6, 83.3e3};
  if (open_ || digit < '0' || digit > '9') {
    return false;
  }
  bit_rate_ = kBitRates.at(static_cast<std::size_t>(digit - '0'));
  return true;
}

// Bit rate S0 to S8 and s, time stamps Z0 and Z1; filters M and m, U, W, X and Q have no effect here.
bool SlcanSession::set_up(std::string_view line) {
  switch (line[0]) {
    case 'S':
      return line.size() == 2 && set_bit_rate(line[1]);
    case 's':
      return !open_ && line.size() >= 2;
    case 'Z':
      time_stamps_ = line == "Z1";
      return line == "Z0" || line == "Z1";
    default:
      return true;
  }
}

void SlcanSession::execute(std::string_view line) {
  bool good = true;
  switch (line.empty() ? '\0' : line[0]) {
    case '\0':
      break;
    case 'O':
      good = open(false);
      break;
    case 'L':
      good = open(true);
      break;
    case 'C':
      open_ = false;
      break;
    case 't':
    case 'T':
    case 'r':
    case 'R':
      good = transmit(line);
      break;
    case 'V':
    case 'v':
      output_ += line[0] == 'V' ? "V1013" : "vtrackservo";
      break;
    case 'N':
      output_ += "NSIM1";
      break;
    case 'F':
      output_ += overrun_ ? "F01" : "F00";
      overrun_ = false;
      break;
    case 'S':
    case 's':
    case 'Z':
    case 'M':
    case 'm':
    case 'U':
    case 'W':
    case 'X':
    case 'Q':
      good = set_up(line);
      break;
    default:
      good = false;
      break;
  }
  output_ += good ? kGood : kBad;
}

void SlcanSession::show(const can_frame& frame, unsigned time_ms) {
  if (!open_) {
    return;
  }
  if (output_.size() > kOutputLimit) {
    overrun_ = true;
    return;
  }
  const bool extended = (frame.flags & CAN_FRAME_EXTENDED) != 0;
  const bool remote = (frame.flags & CAN_FRAME_REMOTE) != 0;
  output_ += extended ? (remote ? 'R' : 'T') : (remote ? 'r' : 't');
  append_hex(output_, frame.id, extended ? 8 : 3);
  append_hex(output_, frame.length, 1);
  for (int i = 0; i < frame.length && !remote; ++i) {
    append_hex(output_, frame.data[i], 2);
  }
  if (time_stamps_) {
    append_hex(output_, time_ms % kTimeStampPeriodMs, 4);
  }
  output_ += '\r';
}

}  // namespace trackservo::sim
