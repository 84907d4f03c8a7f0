// SPDX-License-Identifier: Apache-2.0
// The pictures of the simulated camera as a stream over TCP: `sim_host serve --video pgm-tcp:PORT`.
//
// A client gets grey PGM pictures (P5, 8 bits), one after the other, as netpbm allows. Two comment lines of each say
//
//     # picture 12          its number; numbers that are missing were dropped
//     # exposure_us 240000  middle of the exposure in simulated time, which is the time of the node's clock (3010:1)
//
// A thread renders and sends. Pictures are dropped while nobody reads them, and while the thread or the client is busy
// with an earlier one: simulated time never waits for pictures.
#ifndef TRACKSERVO_SIM_SERVE_VIDEO_STREAM_HPP
#define TRACKSERVO_SIM_SERVE_VIDEO_STREAM_HPP

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "device/serve/scene.hpp"
#include "machine/sensors/picture_renderer.hpp"

namespace trackservo::sim {

class VideoStream : public SceneObserver {
 public:
  // Listens on the loopback address only; `address`: "pgm-tcp:PORT", 0: any free port. Throws std::invalid_argument for
  // another address, std::system_error for a port that cannot be opened.
  VideoStream(const std::string& address, const PictureSceneConfig& config, double frame_rate_hz, std::uint64_t seed);
  ~VideoStream() override;

  // Returns "pgm-tcp:127.0.0.1:PORT"
  std::string address() const;

  // Exposes pictures around whole multiples of the frame time.
  void observe(const Scene& scene) override;

 private:
  struct Exposure {
    std::uint64_t number = 0;
    double middle_s = 0;
    SceneState begin;
    SceneState end;
  };

  void run();
  void accept_client();
  void send(const Exposure& exposure);
  bool send_all(const char *bytes, std::size_t count);
  void close_client();

  PictureRenderer renderer_;
  double frame_s_;
  int listener_ = -1;
  int client_ = -1;
  std::uint64_t next_number_ = 1;
  double begun_s_ = 0;
  std::optional<SceneState> begin_;  // of the exposure that is going on

  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Exposure> due_;  // for the thread
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace trackservo::sim

#endif
