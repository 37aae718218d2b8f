#pragma once
/// What all parts of the C interface need: its structs to and from C++, and the guard.

#include <quoin/geometry_c.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <quoin/geometry/pair_batch.hpp>
#include <quoin/geometry/queries.hpp>

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

/// Runs `work` and turns what it throws into a status and a message.
template <class Work>
quoin_status guarded(Work&& work, char* message = nullptr, std::size_t message_size = 0) noexcept {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    say("out of memory", message, message_size);
    return QUOIN_NO_MEMORY;
  } catch (const InputError& error) {
    say(error.what(), message, message_size);
    return QUOIN_BAD_INPUT;
  } catch (const std::exception& error) {
    say(error.what(), message, message_size);
    return QUOIN_FAILED;
  } catch (...) {
    say("unknown exception", message, message_size);
    return QUOIN_FAILED;
  }
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

/// As many points as there is room for in the caller's memory. `count` in: room, out: how many.
quoin_status give(std::span<const ContactPoint> found, quoin_contact_point* points, int& count);

template <class From, class To>
void copy(const From& from, std::vector<To>& to) {
  to.resize(from.size());
  std::transform(from.begin(), from.end(), to.begin(),
                 [](const auto& value) { return to_c(value); });
}

/// A list that stays with its owner.
template <class T>
const T* list(const std::vector<T>& values, int* count) {
  if (count != nullptr) *count = static_cast<int>(values.size());
  return values.data();
}

template <class T>
const T* no_list(int* count) {
  if (count != nullptr) *count = 0;
  return nullptr;
}

}  // namespace quoin::geometry::bindings
