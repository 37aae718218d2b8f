#include <quoin/geometry_c.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <numeric>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/contact_point.hpp>

namespace geometry = quoin::geometry;

struct quoin_polyhedron {
  geometry::Polyhedron solid;
  std::vector<int> input_index;
};

namespace {

using geometry::Feature;
using geometry::FeatureKind;
using geometry::NearestFeatures;
using geometry::PairStatus;
using geometry::Points;
using geometry::Vector3;

static_assert(static_cast<int>(FeatureKind::Face) == QUOIN_FACE);
static_assert(static_cast<int>(PairStatus::Overlapping) == QUOIN_OVERLAPPING);
static_assert(static_cast<int>(geometry::ContactType::FaceFace) == QUOIN_FACE_FACE);

void say(const char* text, char* message, size_t size) {
  if (message != nullptr && size > 0) {
    std::strncpy(message, text, size - 1);
    message[size - 1] = '\0';
  }
}

/// Runs `make` and turns what it throws into a status and a message.
template <class Make>
quoin_status guarded(Make&& make, char* message, size_t message_size) {
  try {
    say("", message, message_size);
    return make();
  } catch (const std::bad_alloc&) {
    say("out of memory", message, message_size);
    return QUOIN_NO_MEMORY;
  } catch (const std::exception& error) {
    say(error.what(), message, message_size);
    return QUOIN_BAD_INPUT;
  }
}

Points points_of(const double* points, int count) {
  return Eigen::Map<const Points>(points, 3, count);
}

quoin_feature to_c(const Feature& feature) {
  return {static_cast<int>(feature.kind), feature.index};
}

void copy(const Vector3& from, double* to) { std::copy_n(from.data(), 3, to); }

geometry::FeatureHint from_c(const quoin_hint& hint) {
  geometry::FeatureHint made;
  std::copy_n(hint.vertices_a, 4, made.vertices_a.begin());
  std::copy_n(hint.vertices_b, 4, made.vertices_b.begin());
  made.normal = Eigen::Map<const Vector3>(hint.normal);
  return made;
}

quoin_hint to_c(const geometry::FeatureHint& hint) {
  quoin_hint made;
  std::copy_n(hint.vertices_a.begin(), 4, made.vertices_a);
  std::copy_n(hint.vertices_b.begin(), 4, made.vertices_b);
  copy(hint.normal, made.normal);
  return made;
}

quoin_nearest to_c(const NearestFeatures& nearest) {
  quoin_nearest made;
  made.status = static_cast<int>(nearest.status);
  made.indeterminate = nearest.indeterminate ? 1 : 0;
  made.iterations = nearest.iterations;
  made.gap = nearest.gap;
  copy(nearest.normal, made.normal);
  copy(nearest.point_a, made.point_a);
  copy(nearest.point_b, made.point_b);
  made.residual_a = nearest.residual_a;
  made.residual_b = nearest.residual_b;
  made.feature_a = to_c(nearest.feature_a);
  made.feature_b = to_c(nearest.feature_b);
  return made;
}

quoin_contact_point to_c(const geometry::ContactPoint& point) {
  quoin_contact_point made;
  made.feature_a = to_c(point.key.feature_a);
  made.feature_b = to_c(point.key.feature_b);
  made.type = static_cast<int>(point.type);
  copy(point.point_a, made.point_a);
  copy(point.point_b, made.point_b);
  copy(point.normal, made.normal);
  made.gap = point.gap;
  made.area = point.area;
  return made;
}

bool is_length(double value) { return value >= 0.0 && std::isfinite(value); }

/// The search from the hint, which is brought up to date.
NearestFeatures search(const quoin_polyhedron& a, const quoin_polyhedron& b, double tolerance,
                       quoin_hint* hint) {
  const NearestFeatures nearest =
      nearest_features(a.solid, b.solid, {.tolerance = tolerance},
                       hint == nullptr ? geometry::FeatureHint{} : from_c(*hint));
  if (hint != nullptr) {
    *hint = to_c(nearest.hint);
  }
  return nearest;
}

quoin_status status_of(const NearestFeatures& nearest) {
  return nearest.status == PairStatus::NotConverged ? QUOIN_NOT_CONVERGED : QUOIN_OK;
}

}  // namespace

extern "C" {

quoin_status quoin_make_hull(const double* points, int count, quoin_polyhedron** made,
                             char* message, size_t message_size) {
  const auto make = [&] {
    if (points == nullptr || made == nullptr || count < 0) {
      throw geometry::InputError("points or made is null, or count is negative");
    }
    geometry::Hull hull = geometry::make_hull(points_of(points, count));
    *made = new quoin_polyhedron{std::move(hull.polyhedron), std::move(hull.input_index)};
    return QUOIN_OK;
  };
  return guarded(make, message, message_size);
}

quoin_status quoin_make_polyhedron(const double* points, int count, const int* face_sizes,
                                   int face_count, const int* face_vertices,
                                   quoin_polyhedron** made, char* message, size_t message_size) {
  const auto make = [&] {
    if (points == nullptr || face_sizes == nullptr || face_vertices == nullptr || made == nullptr ||
        count < 0 || face_count < 0) {
      throw geometry::InputError("an argument is null, or a count is negative");
    }
    std::vector<std::vector<int>> faces;
    for (int f = 0; f < face_count; ++f) {
      if (face_sizes[f] < 0) {
        throw geometry::InputError("face " + std::to_string(f) + " has a negative size");
      }
      faces.emplace_back(face_vertices, face_vertices + face_sizes[f]);
      face_vertices += face_sizes[f];
    }
    std::vector<int> all(static_cast<std::size_t>(count));
    std::iota(all.begin(), all.end(), 0);
    *made = new quoin_polyhedron{geometry::make_polyhedron(points_of(points, count), faces),
                                 std::move(all)};
    return QUOIN_OK;
  };
  return guarded(make, message, message_size);
}

void quoin_free(quoin_polyhedron* polyhedron) { delete polyhedron; }

int quoin_vertex_count(const quoin_polyhedron* polyhedron) {
  return polyhedron == nullptr ? 0 : polyhedron->solid.topology().vertex_count();
}

quoin_status quoin_input_indices(const quoin_polyhedron* polyhedron, int* indices) {
  if (polyhedron == nullptr || indices == nullptr) {
    return QUOIN_BAD_INPUT;
  }
  std::copy(polyhedron->input_index.begin(), polyhedron->input_index.end(), indices);
  return QUOIN_OK;
}

quoin_status quoin_feature_vertices(const quoin_polyhedron* polyhedron, quoin_feature feature,
                                    int* vertices, int* count) {
  if (polyhedron == nullptr || vertices == nullptr || count == nullptr || feature.index < 0) {
    return QUOIN_BAD_INPUT;
  }
  const geometry::Topology& topology = polyhedron->solid.topology();
  std::span<const int> found;
  if (feature.kind == QUOIN_VERTEX && feature.index < topology.vertex_count()) {
    found = {&feature.index, 1};
  } else if (feature.kind == QUOIN_EDGE && feature.index < topology.edge_count()) {
    found = topology.edge(feature.index);
  } else if (feature.kind == QUOIN_FACE && feature.index < topology.face_count()) {
    found = topology.face(feature.index);
  } else {
    return QUOIN_BAD_INPUT;
  }
  const int room = std::max(*count, 0);
  *count = static_cast<int>(found.size());
  std::copy_n(found.begin(), std::min(room, *count), vertices);
  return *count > room ? QUOIN_TOO_MANY : QUOIN_OK;
}

quoin_status quoin_set_vertices(quoin_polyhedron* polyhedron, const double* vertices) {
  if (polyhedron == nullptr || vertices == nullptr) {
    return QUOIN_BAD_INPUT;
  }
  const Eigen::Map<const Points> points(vertices, 3, quoin_vertex_count(polyhedron));
  if (!points.allFinite()) {
    return QUOIN_BAD_INPUT;
  }
  polyhedron->solid.set_vertices(points);
  return QUOIN_OK;
}

quoin_hint quoin_no_hint(void) { return to_c(geometry::FeatureHint{}); }

quoin_status quoin_nearest_features(const quoin_polyhedron* a, const quoin_polyhedron* b,
                                    double tolerance, quoin_hint* hint, quoin_nearest* nearest) {
  if (a == nullptr || b == nullptr || nearest == nullptr || !is_length(tolerance)) {
    return QUOIN_BAD_INPUT;
  }
  const NearestFeatures found = search(*a, *b, tolerance, hint);
  *nearest = to_c(found);
  return status_of(found);
}

quoin_status quoin_contact_points(const quoin_polyhedron* a, const quoin_polyhedron* b,
                                  double tolerance, double reach, quoin_hint* hint,
                                  quoin_nearest* nearest, quoin_contact_point* points, int* count) {
  if (a == nullptr || b == nullptr || nearest == nullptr || count == nullptr ||
      (points == nullptr && *count > 0) || !is_length(tolerance) || !is_length(reach)) {
    return QUOIN_BAD_INPUT;
  }
  const auto find = [&] {
    const NearestFeatures found = search(*a, *b, tolerance, hint);
    *nearest = to_c(found);
    std::vector<geometry::ContactPoint> list;
    append_contact_points({0, 1}, a->solid, b->solid, found,
                          {.tolerance = tolerance, .reach = reach}, list);
    const int room = std::max(*count, 0);
    *count = static_cast<int>(list.size());
    for (int i = 0; i < std::min(room, *count); ++i) {
      points[i] = to_c(list[static_cast<std::size_t>(i)]);
    }
    return *count > room ? QUOIN_TOO_MANY : status_of(found);
  };
  return guarded(find, nullptr, 0);
}

}  // extern "C"
