/// quoin as a plug-in of the referee, through its interface for C++: shapes by their faces where
/// these are known.

#include <quoin/geometry/build.hpp>
#include <quoin/geometry/contact_point.hpp>

#include "peer_solid.hpp"

namespace {

namespace geometry = quoin::geometry;
using quoin::referee::copy;

struct PlacedShape {
  explicit PlacedShape(geometry::Shape made) : shape(std::move(made)), body(shape) {}
  PlacedShape(const PlacedShape&) = delete;  // the body refers to the shape
  PlacedShape& operator=(const PlacedShape&) = delete;
  geometry::Shape shape;
  geometry::Body body;
};

const geometry::Body& body_of(void* solid) { return static_cast<PlacedShape*>(solid)->body; }

geometry::Shape shape_of(const quoin_referee_solid& solid) {
  const Eigen::Map<const geometry::Points> points(solid.points, 3, solid.point_count);
  std::vector<std::vector<int>> faces;
  int corners = 0;
  for (int f = 0; f < solid.face_count; ++f) {
    const int* first = solid.face_vertices + corners;
    faces.emplace_back(first, first + solid.face_sizes[f]);
    corners += solid.face_sizes[f];
  }
  std::vector<bool> used(static_cast<std::size_t>(solid.point_count));
  std::for_each_n(solid.face_vertices, corners,
                  [&](int v) { used[static_cast<std::size_t>(v)] = true; });
  const bool all_used = std::find(used.begin(), used.end(), false) == used.end();
  return all_used ? geometry::make_shape(points, faces) : geometry::make_hull(points).polyhedron;
}

void* make_solid(const quoin_referee_solid* solid) {
  try {
    return new PlacedShape(shape_of(*solid));
  } catch (const geometry::InputError&) {
    return nullptr;
  }
}
void free_solid(void* solid) { delete static_cast<PlacedShape*>(solid); }

void* make_memory() { return new geometry::FeatureHint; }
void free_memory(void* memory) { delete static_cast<geometry::FeatureHint*>(memory); }

void set_placement(void* solid, const quoin_referee_placement* placement) {
  const quoin::referee::PeerPlacement place = quoin::referee::to_eigen(*placement);
  geometry::Placement to;
  to.linear = place.linear;
  to.translation = place.translation;
  static_cast<PlacedShape*>(solid)->body.move(to);
}

geometry::NearestFeatures nearest_of(void* a, void* b, void* memory) {
  if (memory == nullptr) return nearest_features(body_of(a), body_of(b));
  geometry::FeatureHint& hint = *static_cast<geometry::FeatureHint*>(memory);
  const geometry::NearestFeatures nearest = nearest_features(body_of(a), body_of(b), {}, hint);
  hint = nearest.hint;
  return nearest;
}

quoin_referee_status ask(void* a, void* b, void* memory, quoin_referee_answer* answer) {
  const geometry::NearestFeatures nearest = nearest_of(a, b, memory);
  if (nearest.status == geometry::PairStatus::NotConverged) return QUOIN_REFEREE_FAILED;
  answer->gap = nearest.gap;
  copy(nearest.normal, answer->normal);
  copy(nearest.point_a, answer->point_a);
  copy(nearest.point_b, answer->point_b);
  return QUOIN_REFEREE_ANSWERED;
}

quoin_referee_status list_points(void* a, void* b, void* memory, quoin_referee_point* points,
                                 int* count) {
  geometry::PairContact contact;
  if (memory != nullptr) contact.nearest.hint = *static_cast<geometry::FeatureHint*>(memory);
  update_pair_contact(body_of(a), body_of(b), {}, contact);
  if (memory != nullptr) *static_cast<geometry::FeatureHint*>(memory) = contact.nearest.hint;
  const std::vector<geometry::ContactPoint>& contacts = contact.points;
  const int found = static_cast<int>(contacts.size());
  for (int i = 0; i < std::min(found, *count); ++i) {
    const geometry::ContactPoint& point = contacts[static_cast<std::size_t>(i)];
    copy(point.point_a, points[i].point_a);
    copy(point.point_b, points[i].point_b);
    points[i].gap = point.gap;
    points[i].area = point.area;
  }
  *count = found;
  return QUOIN_REFEREE_ANSWERED;
}

constexpr quoin_referee_library kQuoin{
    QUOIN_REFEREE_INTERFACE,
    "quoin",
    QUOIN_VERSION,
    QUOIN_REFEREE_DISTANCE | QUOIN_REFEREE_DEPTH | QUOIN_REFEREE_NORMAL | QUOIN_REFEREE_WITNESSES |
        QUOIN_REFEREE_POINTS | QUOIN_REFEREE_APART | QUOIN_REFEREE_AREAS | QUOIN_REFEREE_MEMORY |
        QUOIN_REFEREE_DEFORMED,
    0.0,
    make_solid,
    free_solid,
    make_memory,
    free_memory,
    set_placement,
    ask,
    list_points};

}  // namespace

extern "C" const quoin_referee_library* quoin_referee_plugin(int index) {
  return index == 0 ? &kQuoin : nullptr;
}
