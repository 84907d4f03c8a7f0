// SPDX-License-Identifier: Apache-2.0
#include "device/serve/video_stream.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <csignal>
#include <limits>
#include <stdexcept>
#include <utility>

#include "device/bus/tcp_listener.hpp"

namespace trackservo::sim {
namespace {

constexpr int kStuckClient_ms = 2000;

std::uint16_t video_port_of(const std::string& address) {
  const std::string kind = "pgm-tcp:";
  std::uint16_t port = 0;
  const char *first = address.data() + std::min(kind.size(), address.size());
  const auto [end, error] = std::from_chars(first, address.data() + address.size(), port);
  if (address.rfind(kind, 0) != 0 || error != std::errc() || end != address.data() + address.size()) {
    throw std::invalid_argument(
        fmt::format("--video {}: expected pgm-tcp:PORT with a port from 0 (any free port) to 65535", address));
  }
  return port;
}

SceneState state_of(const Scene& scene) {
  constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
  return {scene.pose, scene.visible ? scene.target_m : Eigen::Vector3d::Constant(kNowhere)};
}

}  // namespace

VideoStream::VideoStream(const std::string& address, const PictureSceneConfig& config, double frame_rate_hz,
                         std::uint64_t seed)
    : renderer_(config, seed),
      frame_s_(1.0 / frame_rate_hz),
      listener_(listen_on_loopback(video_port_of(address), "--video")) {
  (void)std::signal(SIGPIPE, SIG_IGN);  // a client that disconnects causes an error of send(), not a signal
  thread_ = std::thread([this] { run(); });
}

VideoStream::~VideoStream() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  changed_.notify_one();
  thread_.join();
  close_client();
  close(listener_);
}

std::string VideoStream::address() const { return fmt::format("pgm-tcp:127.0.0.1:{}", port_of_listener(listener_)); }

void VideoStream::observe(const Scene& scene) {
  const double half_s = 0.5 * renderer_.config().exposure_s;
  const double middle_s = static_cast<double>(next_number_) * frame_s_;
  if (!begin_ && scene.time_s + kSceneTolerance_s >= middle_s - half_s) {
    begin_ = state_of(scene);
    begun_s_ = scene.time_s;
    return;
  }
  if (!begin_ || scene.time_s + kSceneTolerance_s < begun_s_ + renderer_.config().exposure_s) {
    return;
  }
  Exposure exposure{next_number_, 0.5 * (begun_s_ + scene.time_s), *begin_, state_of(scene)};
  begin_.reset();
  next_number_ = 1 + static_cast<std::uint64_t>(std::floor((scene.time_s + kSceneTolerance_s) / frame_s_));
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    due_ = std::move(exposure);  // replaces one that the thread has not taken
  }
  changed_.notify_one();
}

void VideoStream::run() {
  for (;;) {
    Exposure exposure;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [this] { return stop_ || due_; });
      if (stop_) {
        return;
      }
      exposure = *due_;
      due_.reset();
    }
    accept_client();
    if (client_ >= 0) {
      send(exposure);
    }
  }
}

// One client at a time: a newer one replaces it, because an image processor may have been restarted.
void VideoStream::accept_client() {
  const int client = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (client >= 0) {
    close_client();
    client_ = client;
    // Room for one picture: a slow client loses pictures, and does not get old ones.
    const int bytes = renderer_.config().width_px * renderer_.config().height_px / 2;  // the kernel doubles it
    setsockopt(client_, SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
  }
}

void VideoStream::send(const Exposure& exposure) {
  pollfd ready{client_, POLLOUT, 0};
  if (poll(&ready, 1, 0) == 0) {
    return;  // the client still reads an earlier picture
  }
  const RenderedPicture picture = renderer_.render(exposure.begin, exposure.end, exposure.number);
  const std::string head = fmt::format("P5\n# picture {}\n# exposure_us {}\n{} {}\n255\n", exposure.number,
                                       std::llround(exposure.middle_s * 1e6), picture.width_px, picture.height_px);
  if (!send_all(head.data(), head.size()) ||
      !send_all(reinterpret_cast<const char *>(picture.grey.data()), picture.grey.size())) {
    close_client();
  }
}

bool VideoStream::send_all(const char *bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t sent = ::send(client_, bytes, count, MSG_NOSIGNAL);
    if (sent > 0) {
      bytes += sent;
      count -= static_cast<std::size_t>(sent);
      continue;
    }
    pollfd ready{client_, POLLOUT, 0};
    if ((errno != EAGAIN && errno != EINTR) || poll(&ready, 1, kStuckClient_ms) == 0) {
      return false;
    }
  }
  return true;
}

void VideoStream::close_client() {
  if (client_ >= 0) {
    close(client_);
    client_ = -1;
  }
}

}  // namespace trackservo::sim
