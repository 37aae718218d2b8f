#pragma once
/// Values as bytes of this build, for checkpoints. One list of fields serves both ways:
/// `archive(a, b, c)` writes them, or reads them into the same places.

#include <Eigen/Core>
#include <istream>
#include <optional>
#include <ostream>
#include <string>
#include <type_traits>
#include <vector>

#include "scene_file/scene_error.hpp"

namespace quoin::scene_file {

class ArchiveWriter {
 public:
  explicit ArchiveWriter(std::ostream& out) : out_(out) {}

  template <class... Values>
  void operator()(const Values&... values) {
    (put(values), ...);
  }

 private:
  void bytes(const void* from, std::size_t count) {
    out_.write(static_cast<const char*>(from), static_cast<std::streamsize>(count));
  }
  /// A plain record without pointers.
  template <class Value>
  void put(const Value& value) {
    static_assert(std::is_trivially_destructible_v<Value> && !std::is_pointer_v<Value>);
    bytes(&value, sizeof value);
  }
  void put(const std::string& text) {
    put(text.size());
    bytes(text.data(), text.size());
  }
  template <class Value>
  void put(const std::vector<Value>& list) {
    put(list.size());
    for (const Value& value : list) put(value);
  }
  void put(const Eigen::VectorXd& vector) {
    put(std::vector<double>(vector.begin(), vector.end()));
  }

  std::ostream& out_;
};

/// Throws FileError when there is less than is read.
class ArchiveReader {
 public:
  explicit ArchiveReader(std::istream& in) : in_(in) {}

  template <class... Values>
  void operator()(Values&... values) {
    (take(values), ...);
  }

 private:
  static constexpr std::size_t kMost = std::size_t{1} << 30;  // items: more is no list

  void bytes(void* to, std::size_t count) {
    if (!in_.read(static_cast<char*>(to), static_cast<std::streamsize>(count)))
      throw FileError("the checkpoint is cut short");
  }
  std::size_t count() {
    std::size_t n = 0;
    bytes(&n, sizeof n);
    if (n > kMost) throw FileError("the checkpoint is damaged");
    return n;
  }
  template <class Value>
  void take(Value& value) {
    static_assert(std::is_trivially_destructible_v<Value> && !std::is_pointer_v<Value>);
    bytes(&value, sizeof value);
  }
  void take(std::string& text) {
    text.resize(count());
    bytes(text.data(), text.size());
  }
  template <class Value>
  void take(std::vector<Value>& list) {
    const std::size_t n = count();
    list.clear();
    for (std::size_t i = 0; i < n; ++i) take(list.emplace_back());
  }
  void take(Eigen::VectorXd& vector) {
    std::vector<double> values;
    take(values);
    vector = Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values));
  }

  std::istream& in_;
};

}  // namespace quoin::scene_file
