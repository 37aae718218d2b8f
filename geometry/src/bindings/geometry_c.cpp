#include <cmath>
#include <numeric>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/queries.hpp>

#include "bindings/c_values.hpp"
#include "finder/placed_box.hpp"

namespace quoin::geometry::bindings {

static_assert(static_cast<int>(FeatureKind::Face) == QUOIN_FACE);
static_assert(static_cast<int>(PairStatus::NotConverged) == QUOIN_PAIR_NOT_CONVERGED);
static_assert(static_cast<int>(ContactType::FaceFace) == QUOIN_FACE_FACE);
static_assert(static_cast<int>(PairEvent::End) == QUOIN_END);

Placement placement_of(const quoin_placement& placement) {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  return {Eigen::Map<const RowMajor>(placement.linear), vector_of(placement.translation)};
}

quoin_feature to_c(const Feature& feature) {
  return {static_cast<int>(feature.kind), feature.index};
}

quoin_contact_point to_c(const ContactPoint& point) {
  quoin_contact_point made;
  made.a = point.key.a;
  made.b = point.key.b;
  made.feature_a = to_c(point.key.feature_a);
  made.feature_b = to_c(point.key.feature_b);
  made.type = static_cast<int>(point.type);
  made.indeterminate = point.indeterminate ? 1 : 0;
  made.previous = point.previous;
  copy(point.point_a, made.point_a);
  copy(point.point_b, made.point_b);
  copy(point.normal, made.normal);
  made.gap = point.gap;
  made.area = point.area;
  return made;
}

quoin_hint to_c(const FeatureHint& hint) {
  quoin_hint made;
  std::copy_n(hint.vertices_a.begin(), 4, made.vertices_a);
  std::copy_n(hint.vertices_b.begin(), 4, made.vertices_b);
  made.face_a = hint.face_a;
  made.face_b = hint.face_b;
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

quoin_pair to_c(const PairResult& pair) {
  quoin_pair made;
  made.a = pair.a;
  made.b = pair.b;
  made.status = static_cast<int>(pair.status);
  made.type = static_cast<int>(pair.type);
  made.event = static_cast<int>(pair.event);
  made.indeterminate = pair.indeterminate ? 1 : 0;
  made.gap = pair.gap;
  copy(pair.normal, made.normal);
  made.area = pair.area;
  made.first = pair.first;
  made.count = pair.count;
  return made;
}

void check(const quoin_body* body, int name) {
  if (body == nullptr || body->shape == nullptr)
    throw InputError("body " + std::to_string(name) + " or its shape is null");
  require_placement(placement_of(body->placement), name);
}

Body body_of(const quoin_body* body, int name) {
  check(body, name);
  return {*body->shape->solid, placement_of(body->placement)};
}

namespace {

/// Not copied before the number has been checked.
Eigen::Map<const Points> points_of(const double* points, int count) { return {points, 3, count}; }

/// Does a hint speak of features that the shapes have?
bool fits(const FeatureHint& hint, const Shape& a, const Shape& b) {
  const auto within = [](int index, int count) { return index >= -1 && index < count; };
  const auto all_within = [&](const std::array<int, 4>& vertices, int count) {
    return std::all_of(vertices.begin(), vertices.end(), [&](int v) { return within(v, count); });
  };
  return all_within(hint.vertices_a, a.vertex_count()) &&
         all_within(hint.vertices_b, b.vertex_count()) &&
         within(hint.face_a, a.topology().face_count()) &&
         within(hint.face_b, b.topology().face_count()) && hint.normal.allFinite();
}

quoin_shape* new_shape(Shape&& solid, std::vector<int>&& input_index) {
  return new quoin_shape{std::make_shared<Shape>(std::move(solid)), std::move(input_index)};
}

std::vector<std::vector<int>> faces_of(const int* sizes, int count, const int* vertices) {
  std::vector<std::vector<int>> faces;
  for (int f = 0; f < count; ++f) {
    if (sizes[f] < 0 || sizes[f] > kMostVertices) {
      throw InputError("face " + std::to_string(f) + " has " + std::to_string(sizes[f]) +
                       " vertices, at most " + std::to_string(kMostVertices) + " allowed");
    }
    faces.emplace_back(vertices, vertices + sizes[f]);
    vertices += sizes[f];
  }
  return faces;
}

std::span<const int> vertices_of(const Topology& topology, const quoin_feature& feature) {
  const auto below = [&](int count) { return feature.index >= 0 && feature.index < count; };
  if (feature.kind == QUOIN_VERTEX && below(topology.vertex_count())) return {&feature.index, 1};
  if (feature.kind == QUOIN_EDGE && below(topology.edge_count()))
    return topology.edge(feature.index);
  if (feature.kind == QUOIN_FACE && below(topology.face_count()))
    return topology.face(feature.index);
  throw InputError("the shape has no such feature");
}

}  // namespace

FeatureHint from_c(const quoin_hint* hint, const Body& a, const Body& b) {
  FeatureHint made;
  if (hint == nullptr) return made;
  std::copy_n(hint->vertices_a, 4, made.vertices_a.begin());
  std::copy_n(hint->vertices_b, 4, made.vertices_b.begin());
  made.face_a = hint->face_a;
  made.face_b = hint->face_b;
  made.normal = vector_of(hint->normal);
  return fits(made, a.shape(), b.shape()) ? made : FeatureHint{};
}

Ray ray_of(const quoin_ray* ray) {
  require(ray != nullptr, "the ray is null");
  return {vector_of(ray->origin), vector_of(ray->direction), ray->length};
}

quoin_ray_hit to_c(const RayHit& hit) {
  quoin_ray_hit made;
  made.s = hit.s;
  made.face = hit.face;
  copy(hit.point, made.point);
  copy(hit.normal, made.normal);
  return made;
}

quoin_status give(const NearestFeatures& found, quoin_hint* hint, quoin_nearest* nearest) {
  *nearest = to_c(found);
  if (hint != nullptr) *hint = to_c(found.hint);
  return found.status == PairStatus::NotConverged ? QUOIN_NOT_CONVERGED : QUOIN_OK;
}

}  // namespace quoin::geometry::bindings

using namespace quoin::geometry;            // NOLINT: nothing but the functions of C follows
using namespace quoin::geometry::bindings;  // NOLINT

extern "C" {

const char* quoin_version(void) { return QUOIN_VERSION; }

quoin_placement quoin_no_placement(void) {
  return {{1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}};
}

quoin_status quoin_make_hull(const double* points, int count, quoin_shape** made, char* message,
                             size_t message_size) {
  say("", message, message_size);
  return guarded(
      [&] {
        require(points != nullptr && made != nullptr && count >= 0,
                "points or made is null, or count is negative");
        Hull hull = make_hull(points_of(points, count));
        *made = new_shape(std::move(hull.polyhedron), std::move(hull.input_index));
      },
      message, message_size);
}

quoin_status quoin_make_shape(const double* points, int count, const int* face_sizes,
                              int face_count, const int* face_vertices, quoin_shape** made,
                              char* message, size_t message_size) {
  say("", message, message_size);
  return guarded(
      [&] {
        require(points != nullptr && face_sizes != nullptr && face_vertices != nullptr &&
                    made != nullptr && count >= 0 && face_count >= 0,
                "an argument is null, or a count is negative");
        require(face_count <= 2 * kMostVertices, "there are more faces than polyhedra have");
        Shape solid =
            make_shape(points_of(points, count), faces_of(face_sizes, face_count, face_vertices));
        std::vector<int> all(static_cast<std::size_t>(count));
        std::iota(all.begin(), all.end(), 0);
        *made = new_shape(std::move(solid), std::move(all));
      },
      message, message_size);
}

void quoin_free(quoin_shape* shape) { delete shape; }

int quoin_vertex_count(const quoin_shape* shape) {
  return shape == nullptr ? 0 : shape->solid->vertex_count();
}

quoin_status quoin_input_indices(const quoin_shape* shape, int* indices) {
  if (shape == nullptr || indices == nullptr) return QUOIN_BAD_INPUT;
  std::copy(shape->input_index.begin(), shape->input_index.end(), indices);
  return QUOIN_OK;
}

quoin_status quoin_feature_vertices(const quoin_shape* shape, quoin_feature feature, int* vertices,
                                    int* count) {
  return guarded([&] {
    require(shape != nullptr, "the shape is null");
    require_room(vertices, count);
    const std::span<const int> found = vertices_of(shape->solid->topology(), feature);
    return give(found, vertices, *count);
  });
}

quoin_status quoin_set_vertices(quoin_shape* shape, const double* vertices) {
  return guarded([&] {
    require(shape != nullptr && vertices != nullptr, "an argument is null");
    const Eigen::Map<const Points> points(vertices, 3, quoin_vertex_count(shape));
    require(points.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= kLargestCoordinate,
            "a coordinate is not finite or too large");
    if (shape->solid.use_count() > 1) shape->solid = std::make_shared<Shape>(*shape->solid);
    shape->solid->set_vertices(points);
  });
}

quoin_hint quoin_no_hint(void) { return to_c(FeatureHint{}); }

quoin_status quoin_nearest_features(const quoin_body* a, const quoin_body* b, double tolerance,
                                    quoin_hint* hint, quoin_nearest* nearest) {
  return guarded([&] {
    require(nearest != nullptr, "nearest is null");
    require_length(tolerance, "tolerance");
    const Body body_a = body_of(a, 0), body_b = body_of(b, 1);
    return give(
        nearest_features(body_a, body_b, {.tolerance = tolerance}, from_c(hint, body_a, body_b)),
        hint, nearest);
  });
}

quoin_status quoin_contact_points(const quoin_body* a, const quoin_body* b, double tolerance,
                                  double reach, quoin_hint* hint, quoin_nearest* nearest,
                                  quoin_contact_point* points, int* count) {
  return guarded([&] {
    require(nearest != nullptr, "nearest is null");
    require_room(points, count);
    require_length(tolerance, "tolerance");
    require_length(reach, "reach");
    const Body body_a = body_of(a, 0), body_b = body_of(b, 1);
    PairContact contact;
    contact.nearest.hint = from_c(hint, body_a, body_b);
    update_pair_contact(body_a, body_b, {.tolerance = tolerance, .reach = reach}, contact);
    const quoin_status status = give(contact.nearest, hint, nearest);
    const quoin_status listed = give(contact.points, points, *count);
    return listed == QUOIN_OK ? status : listed;
  });
}

quoin_status quoin_overlap(const quoin_body* a, const quoin_body* b, int* answer) {
  return guarded([&] {
    require(answer != nullptr, "answer is null");
    *answer = overlap(body_of(a, 0), body_of(b, 1)) ? 1 : 0;
  });
}

quoin_status quoin_distance_within(const quoin_body* a, const quoin_body* b, double cut_off,
                                   quoin_hint* hint, quoin_nearest* nearest, int* within) {
  return guarded([&] {
    require(nearest != nullptr && within != nullptr, "an argument is null");
    const Body body_a = body_of(a, 0), body_b = body_of(b, 1);
    const auto found =
        nearest_features_within(body_a, body_b, cut_off, {}, from_c(hint, body_a, body_b));
    *within = found.has_value() ? 1 : 0;
    return found.has_value() ? give(*found, hint, nearest) : QUOIN_OK;
  });
}

quoin_status quoin_first_hit(const quoin_body* body, const quoin_ray* ray, quoin_ray_hit* hit,
                             int* hits) {
  return guarded([&] {
    require(hit != nullptr && hits != nullptr, "an argument is null");
    const std::optional<RayHit> found = first_hit(body_of(body, 0), ray_of(ray));
    *hits = found.has_value() ? 1 : 0;
    if (found.has_value()) *hit = to_c(*found);
  });
}

quoin_status quoin_contains(const quoin_body* body, const double* point, double tolerance,
                            int* answer) {
  return guarded([&] {
    require(point != nullptr && answer != nullptr, "an argument is null");
    require_length(tolerance, "tolerance");
    *answer = contains(body_of(body, 0), vector_of(point), tolerance) ? 1 : 0;
  });
}

}  // extern "C"
