#pragma once
/// Room for one large value that is made only when it is needed. Unlike std::optional it never
/// writes the room before. Internal.

#include <cstddef>
#include <new>

namespace quoin::geometry {

template <typename T>
class LateInit {
 public:
  LateInit() {}  // NOLINT: the storage is left as it is
  LateInit(const LateInit&) = delete;
  LateInit& operator=(const LateInit&) = delete;
  ~LateInit() { reset(); }

  template <typename... Arguments>
  T& emplace(const Arguments&... arguments) {
    reset();
    value_ = new (storage_) T(arguments...);
    return *value_;
  }
  void reset() {
    if (value_ != nullptr) value_->~T();
    value_ = nullptr;
  }
  T* get() const { return value_; }  ///< null: none
  explicit operator bool() const { return value_ != nullptr; }
  T& operator*() const { return *value_; }
  T* operator->() const { return value_; }

 private:
  alignas(T) std::byte storage_[sizeof(T)];
  T* value_ = nullptr;
};

}  // namespace quoin::geometry
