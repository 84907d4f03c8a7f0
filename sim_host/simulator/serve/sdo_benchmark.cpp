#include "serve/sdo_benchmark.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>

#include "serve/server.hpp"

namespace trackservo::sim {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPatience_ms = 5000;
constexpr std::string_view kOpenChannel = "S8\rO\r";
constexpr std::string_view kReadVelocity = "t6018406C600000000000\r";  // SDO upload of 0x606C:0 from node 1
constexpr std::string_view kHeartbeat = "t7011";
constexpr std::string_view kAnswer = "t5818436C6000";  // 4 bytes follow

std::string read_some(int descriptor) {
  pollfd waiting{descriptor, POLLIN, 0};
  std::array<char, 4096> bytes{};
  const ssize_t length =
      poll(&waiting, 1, kPatience_ms) == 1 ? read(descriptor, bytes.data(), bytes.size()) : ssize_t{0};
  if (length <= 0) {
    throw std::runtime_error("the served node does not answer");
  }
  return {bytes.data(), static_cast<std::size_t>(length)};
}

void write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t length = ::write(descriptor, bytes.data(), bytes.size());
    if (length <= 0) {
      throw std::runtime_error("the served node did not open its port");
    }
    bytes.remove_prefix(static_cast<std::size_t>(length));
  }
}

// `serve` in a child process; it ends at the end of its standard input, which is here.
class ServingProcess {
 public:
  explicit ServingProcess(const PlantConfig& plant) {
    std::array<int, 2> input{};
    std::array<int, 2> output{};
    if (pipe(input.data()) != 0 || pipe(output.data()) != 0 || (child_ = fork()) < 0) {
      throw std::runtime_error("cannot start a process for the node");
    }
    if (child_ == 0) {
      dup2(input[0], STDIN_FILENO);
      close(input[0]);
      close(input[1]);
      close(output[0]);
      run_child(plant, output[1]);
    }
    close(input[0]);
    close(output[1]);
    input_ = input[1];
    output_ = output[0];
  }
  ServingProcess(const ServingProcess&) = delete;
  ServingProcess& operator=(const ServingProcess&) = delete;
  ~ServingProcess() {
    close(input_);
    close(output_);
    waitpid(child_, nullptr, 0);
  }

  // "slcan-tcp:127.0.0.1:PORT"
  std::uint16_t port() const {
    const std::string address = read_some(output_);
    std::uint16_t port = 0;
    std::from_chars(address.data() + address.rfind(':') + 1, address.data() + address.size(), port);
    return port;
  }

 private:
  [[noreturn]] static void run_child(const PlantConfig& plant, int output) {
    try {
      ServeOptions options;
      options.until_stdin_ends = true;
      const auto report = [output](const std::vector<std::string>& addresses) { write_all(output, addresses.front()); };
      serve(plant, options, {report, {}});
    } catch (const std::exception&) {
      _exit(1);  // the parent detects the end of the pipe
    }
    _exit(0);
  }

  pid_t child_ = -1;
  int input_ = -1;
  int output_ = -1;
};

// A client that sends one request.
class SdoReader {
 public:
  explicit SdoReader(std::uint16_t port) : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int at_once = 1;
    setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &at_once, sizeof at_once);
    if (connect(socket_, reinterpret_cast<const sockaddr *>(&address), sizeof address) != 0) {
      close(socket_);
      throw std::runtime_error("the served node's port cannot be reached");
    }
    write_all(socket_, kOpenChannel);
    wait_for(kHeartbeat);  // before it the node does not receive
  }
  SdoReader(const SdoReader&) = delete;
  SdoReader& operator=(const SdoReader&) = delete;
  ~SdoReader() { close(socket_); }

  void read_velocity() {
    write_all(socket_, kReadVelocity);
    wait_for(kAnswer);
  }

 private:
  // A line that begins like this; others come between.
  void wait_for(std::string_view beginning) {
    const auto give_up = Clock::now() + std::chrono::milliseconds(kPatience_ms);
    std::size_t begin = 0;
    while ((begin = heard_.find(beginning)) == std::string::npos || heard_.find('\r', begin) == std::string::npos) {
      if (Clock::now() > give_up) {
        throw std::runtime_error("the served node does not answer");
      }
      heard_ += read_some(socket_);
    }
    heard_.erase(0, heard_.find('\r', begin) + 1);
  }

  int socket_;
  std::string heard_;
};

}  // namespace

double sdo_reads_per_second(const PlantConfig& plant, double seconds) {
  const ServingProcess node(plant);
  SdoReader reader(node.port());
  reader.read_velocity();
  const auto start = Clock::now();
  std::chrono::duration<double> passed{};
  int reads = 0;
  for (; passed.count() < seconds; ++reads) {
    reader.read_velocity();
    passed = Clock::now() - start;
  }
  return reads / passed.count();
}

}  // namespace trackservo::sim
