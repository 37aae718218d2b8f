#pragma once
/// A vector of plain values that stays on the stack until it outgrows it. Internal.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>

namespace quoin::geometry {

template <typename T, std::size_t kInline>
class SmallVector {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  SmallVector() {}  // NOLINT: the storage is left as it is
  SmallVector(const SmallVector& other) { *this = other; }
  SmallVector& operator=(const SmallVector& other) {
    assign(other);
    return *this;
  }

  void push_back(const T& value) { add() = value; }
  /// One more, to be filled.
  T& add() {
    if (size_ == capacity_) grow();
    return data_[size_++];
  }
  void assign(std::span<const T> values) {
    resize(values.size());
    std::copy(values.begin(), values.end(), data_);
  }
  void clear() { size_ = 0; }
  void resize(std::size_t size) {
    while (capacity_ < size) grow();
    size_ = size;
  }
  std::size_t size() const { return size_; }
  int count() const { return static_cast<int>(size_); }
  bool empty() const { return size_ == 0; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  T* begin() { return data_; }
  T* end() { return data_ + size_; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }
  bool contains(const T& value) const { return std::find(begin(), end(), value) != end(); }

 private:
  void grow() {
    std::unique_ptr<std::byte[]> wider(new std::byte[2 * capacity_ * sizeof(T) + alignof(T)]);
    T* const place = reinterpret_cast<T*>(wider.get());
    std::copy(begin(), end(), place);
    heap_ = std::move(wider);
    data_ = place;
    capacity_ *= 2;
  }

  alignas(T) std::byte storage_[kInline * sizeof(T)];
  std::unique_ptr<std::byte[]> heap_;
  T* data_ = reinterpret_cast<T*>(storage_);
  std::size_t size_ = 0;
  std::size_t capacity_ = kInline;
};

}  // namespace quoin::geometry
