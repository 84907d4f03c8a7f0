// SPDX-License-Identifier: Apache-2.0
// Runs independent jobs on a few threads and reports progress; the first exception ends the batch and is rethrown.
#ifndef TRACKSERVO_SIM_BASE_JOB_POOL_HPP
#define TRACKSERVO_SIM_BASE_JOB_POOL_HPP

#include <functional>
#include <string>

namespace trackservo::sim {

// Returns the default number of threads for independent runs: one per processor that this process may use, 64 at most.
int usable_threads();

class JobPool {
 public:
  // Takes `total`, the expected cost of all jobs over all calls of run(); `progress` is called under a lock after each
  // job.
  JobPool(int threads, int total, std::function<void(int, int, const std::string&)> progress)
      : threads_(threads), total_(total), progress_(std::move(progress)) {}

  // Calls job(0) ... job(count - 1), each exactly once, and waits for all. The job returns the text of the progress
  // report. `cost` is the relative cost of one job of this pool, for the estimate of the time left.
  void run(std::size_t count, const std::function<std::string(std::size_t)>& job, int cost = 1);

 private:
  int threads_;
  int total_;
  int done_ = 0;
  std::function<void(int, int, const std::string&)> progress_;
};

}  // namespace trackservo::sim

#endif
