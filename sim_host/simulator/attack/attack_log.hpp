// A campaign's results in a file, one line per seed: appended while it runs, and read when it is continued.
#ifndef TRACKSERVO_SIM_ATTACK_ATTACK_LOG_HPP
#define TRACKSERVO_SIM_ATTACK_ATTACK_LOG_HPP

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "attack/attack_run.hpp"
#include "base/result_log.hpp"

namespace trackservo::sim {

// The firmware and the plant of a campaign; results of another one are not mixed with them.
struct AttackLogOrigin {
  std::string commit;
  std::string plant;
};

// A CSV file. A line that a killed process has left unfinished is cut off.
class AttackLog {
 public:
  // Creates the file, or reads the results in it: `each` is called for every one. Throws std::runtime_error when the
  // file cannot be written, is of another origin or is not such a file; it then stays as it is.
  AttackLog(const std::filesystem::path& file, const AttackLogOrigin& origin,
            const std::function<void(const AttackResult&)>& each);

  // Writes the lines through to the file.
  void append(const std::vector<AttackResult>& results);

 private:
  ResultLog log_;
};

}  // namespace trackservo::sim

#endif
