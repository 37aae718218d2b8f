#include "message.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>

namespace quoin::referee {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kMostNumbers = 1 << 22;  // far more than a solid of 1e5 points takes

bool write_all(int pipe, const void* data, std::size_t size) {
  const char* next = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = ::write(pipe, next, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    next += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

int milliseconds_left(Clock::time_point end) {
  using std::chrono::milliseconds;
  const auto left = std::chrono::duration_cast<milliseconds>(end - Clock::now());
  return static_cast<int>(std::max<milliseconds::rep>(left.count(), 0));
}

Message::Received read_all(int pipe, void* data, std::size_t size, bool limited,
                           Clock::time_point end) {
  char* next = static_cast<char*>(data);
  while (size > 0) {
    pollfd waiting{pipe, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, limited ? milliseconds_left(end) : -1);
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0) return Message::Received::TimedOut;
    const ssize_t got = ::read(pipe, next, size);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return Message::Received::Closed;
    next += got;
    size -= static_cast<std::size_t>(got);
  }
  return Message::Received::Whole;
}

}  // namespace

bool Message::send(int pipe) const {
  const std::uint64_t count = numbers_.size();
  return write_all(pipe, &count, sizeof count) &&
         write_all(pipe, numbers_.data(), count * sizeof(double));
}

Message::Received Message::receive(int pipe, int milliseconds) {
  const bool limited = milliseconds >= 0;
  const Clock::time_point end = Clock::now() + std::chrono::milliseconds(milliseconds);
  std::uint64_t count = 0;
  const Received received = read_all(pipe, &count, sizeof count, limited, end);
  if (received != Received::Whole) return received;
  if (count > kMostNumbers) return Received::Closed;  // not a message of ours
  numbers_.resize(count);
  next_ = 0;
  return read_all(pipe, numbers_.data(), count * sizeof(double), limited, end);
}

}  // namespace quoin::referee
