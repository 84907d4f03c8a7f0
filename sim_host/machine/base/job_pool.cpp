// SPDX-License-Identifier: Apache-2.0
#include "machine/base/job_pool.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace trackservo::sim {

int usable_threads() { return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 64); }

void JobPool::run(std::size_t count, const std::function<std::string(std::size_t)>& job, int cost) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        const std::string what = job(i);
        const std::lock_guard<std::mutex> lock(mutex);
        done_ += cost;
        progress_(done_, total_, what);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex);
        failure = failure ? failure : std::current_exception();
        next = count;
      }
    }
  };
  std::vector<std::thread> threads;
  for (int i = 1; i < threads_; ++i) {
    threads.emplace_back(work);
  }
  work();
  for (std::thread& thread : threads) {
    thread.join();
  }
  if (failure) {
    std::rethrow_exception(failure);
  }
}

}  // namespace trackservo::sim
