#pragma once
/// What all parts of the C interface need: its structs to and from C++, and the guard.

#include <quoin/geometry_c.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <quoin/geometry/pair_batch.hpp>
#include <quoin/geometry/queries.hpp>
#include <type_traits>

struct quoin_shape {
  std::shared_ptr<quoin::geometry::Shape> solid;
  std::vector<int> input_index;
};

namespace quoin::geometry::bindings {

inline void say(const char* text, char* message, std::size_t size) {
  if (message != nullptr && size > 0) {
    std::strncpy(message, text, size - 1);
    message[size - 1] = '\0';
  }
}

/// Runs `work`, which returns a status or nothing, and turns what it throws into a status and a
/// message.
template <class Work>
quoin_status guarded(Work&& work, char* message = nullptr, std::size_t message_size = 0) noexcept {
  const auto failed = [&](const char* what, quoin_status status) {
    say(what, message, message_size);
    return status;
  };
  try {
    if constexpr (!std::is_void_v<decltype(work())>) return work();
    work();
    return QUOIN_OK;
  } catch (const std::bad_alloc&) {
    return failed("out of memory", QUOIN_NO_MEMORY);
  } catch (const InputError& error) {
    return failed(error.what(), QUOIN_BAD_INPUT);
  } catch (const std::exception& error) {
    return failed(error.what(), QUOIN_FAILED);
  } catch (...) {
    return failed("unknown exception", QUOIN_FAILED);
  }
}

/// The same on an owner, which keeps what was wrong.
template <class Owner, class Work>
quoin_status with(Owner* owner, Work&& work) {
  if (owner == nullptr) return QUOIN_BAD_INPUT;
  return guarded([&] { return work(*owner); }, owner->message, sizeof owner->message);
}

inline void require(bool condition, const char* what) {
  if (!condition) throw InputError(what);
}

/// The caller's list and how many it has room for.
inline void require_room(const void* list, const int* count) {
  require(count != nullptr && *count >= 0 && (list != nullptr || *count == 0),
          "count is null or negative, or the list is null");
}

inline void copy(const Vector3& from, double* to) { std::copy_n(from.data(), 3, to); }

inline Vector3 vector_of(const double* values) { return Eigen::Map<const Vector3>(values); }

Placement placement_of(const quoin_placement& placement);
quoin_feature to_c(const Feature& feature);
quoin_hint to_c(const FeatureHint& hint);
quoin_nearest to_c(const NearestFeatures& nearest);
quoin_contact_point to_c(const ContactPoint& point);
quoin_pair to_c(const PairResult& pair);

/// Throws InputError for a body that is none, or has no shape or no placement; `name` is for the
/// message.
void check(const quoin_body* body, int name);

/// Checked.
Body body_of(const quoin_body* body, int name);

/// None where it is null, or speaks of features that the shapes do not have.
FeatureHint from_c(const quoin_hint* hint, const Body& a, const Body& b);

/// The answer into the caller's memory, the hint (may be null) brought up to date.
quoin_status give(const NearestFeatures& found, quoin_hint* hint, quoin_nearest* nearest);

Ray ray_of(const quoin_ray* ray);
quoin_ray_hit to_c(const RayHit& hit);

inline int to_c(int value) { return value; }

template <class From, class To>
void copy(const From& from, std::vector<To>& to) {
  to.resize(from.size());
  std::transform(from.begin(), from.end(), to.begin(),
                 [](const auto& value) { return to_c(value); });
}

/// As many as there is room for in the caller's memory. `count` in: room, out: how many.
template <class From, class To>
quoin_status give(const From& found, To* to, int& count) {
  const std::size_t room = static_cast<std::size_t>(count);
  count = static_cast<int>(found.size());
  for (std::size_t k = 0; k < std::min(room, found.size()); ++k) to[k] = to_c(found[k]);
  return found.size() > room ? QUOIN_TOO_MANY : QUOIN_OK;
}

/// A list that stays with its owner, which may be null.
template <class Owner, class T>
const T* list(const Owner* owner, std::vector<T> Owner::*values, int* count) {
  if (count != nullptr) *count = owner == nullptr ? 0 : static_cast<int>((owner->*values).size());
  return owner == nullptr ? nullptr : (owner->*values).data();
}

}  // namespace quoin::geometry::bindings
