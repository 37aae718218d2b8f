#pragma once
/// Numbers through a pipe, with a time limit on reading.

#include <cstdint>
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
  int take_integer() { return static_cast<int>(take()); }
  template <class Numbers>
  void take_all(Numbers& numbers) {
    for (auto i = 0; i < static_cast<int>(numbers.size()); ++i) {
      numbers.data()[i] = take();
    }
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
