// SPDX-License-Identifier: Apache-2.0
// Runs a probe (probes/*.c) on the bare core: flash, RAM and the core's own registers.
#ifndef TRACKSERVO_TARGET_PROBE_BENCH_HPP
#define TRACKSERVO_TARGET_PROBE_BENCH_HPP

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/cortex_m4.hpp"
#include "core/system_control.hpp"

namespace bench {

namespace target = trackservo::target;

class ProbeBench {
 public:
  explicit ProbeBench(const std::string& name)
      : bus_(violations),
        core(timeline, exceptions, violations, bus_),
        control_({timeline, exceptions, violations}, core, [this] { core.request_stop(); }),
        counter_({timeline, exceptions, violations}, core, control_),
        flash_(kFlashBytes, 0xFF),
        ram_(kRamBytes, 0xA5) {
    const char *folder = std::getenv("TARGET_PROBES");
    std::ifstream file(std::string(folder != nullptr ? folder : ".") + "/" + name + ".bin", std::ios::binary);
    const std::vector<char> image((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (image.empty()) {
      throw std::runtime_error("no image of probe " + name + "; is TARGET_PROBES set?");
    }
    std::copy(image.begin(), image.end(), flash_.begin());
    core.map({0, flash_.data(), kFlashBytes, false});
    core.map({0x08000000, flash_.data(), kFlashBytes, false});
    core.map({0x20000000, ram_.data(), kRamBytes, true});
    core.map_bus(0xE0000000, 0x100000);
    bus_.attach(control_, 0xE000E000, 0x1000);
    bus_.attach(counter_, 0xE0001000, 0x1000);
    core.reset();
    core.set_clock(170'000'000);
  }

  // Records of the probe.
  std::vector<std::uint32_t> run(double seconds = 0.001) {
    core.run(target::duration_of(seconds));
    const std::uint8_t *log = core.memory_at(0x20001000, 65 * 4);
    std::uint32_t count = 0;
    std::memcpy(&count, log, 4);
    std::vector<std::uint32_t> words(std::min<std::uint32_t>(count, 64));
    std::memcpy(words.data(), log + 4, 4 * words.size());
    return words;
  }

  target::Timeline timeline;
  target::Exceptions exceptions;
  target::Violations violations;

 private:
  static constexpr std::uint32_t kFlashBytes = 512 * 1024;
  static constexpr std::uint32_t kRamBytes = 32 * 1024;

  target::Bus bus_;

 public:
  target::CortexM4 core;

 private:
  target::SystemControl control_;
  target::CycleCounter counter_;
  std::vector<std::uint8_t> flash_;
  std::vector<std::uint8_t> ram_;
};

}  // namespace bench

#endif
