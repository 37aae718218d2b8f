#pragma once
/// Numbers through a pipe, with a time limit on reading.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace quoin::referee {

/// Numbers one after the other, written and taken in the same order.
class Message {
 public:
  void add(double number) { numbers_.push_back(number); }
  template <class Numbers>
  void add_all(const Numbers& numbers) {
    numbers_.insert(numbers_.end(), numbers.data(), numbers.data() + numbers.size());
  }
  /// 0 behind the end.
  double take() { return next_ < numbers_.size() ? numbers_[next_++] : 0.0; }
  /// 0 for what is no integer: the other end may be a process whose memory a library has spoilt.
  int take_integer() {
    const double number = take();
    return std::abs(number) <= std::numeric_limits<int>::max() ? static_cast<int>(number) : 0;
  }
  /// How many entries of so many numbers follow, at most those that there are.
  std::size_t take_count(std::size_t numbers_each = 1) {
    const auto most = static_cast<int>((numbers_.size() - next_) / numbers_each);
    return static_cast<std::size_t>(std::clamp(take_integer(), 0, most));
  }
  template <class Numbers>
  void take_all(Numbers& numbers) {
    for (auto i = 0; i < static_cast<int>(numbers.size()); ++i) numbers.data()[i] = take();
  }

  enum class Received { Whole, Closed, TimedOut };
  /// False: nobody reads.
  bool send(int pipe) const;
  /// milliseconds < 0: waits for ever.
  Received receive(int pipe, int milliseconds);

 private:
  std::vector<double> numbers_;
  std::size_t next_ = 0;
};

}  // namespace quoin::referee
