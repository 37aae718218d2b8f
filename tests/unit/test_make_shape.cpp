/// Solids as real cutting makes them: vertices that are collinear or coplanar within rounding. None
/// is refused, the faces are the polygons that were cut, and neither the numbering nor a mirror nor
/// a power of two changes them. QUOIN_CASES and QUOIN_SEED widen the search.

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/contact_point.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/geometry/queries.hpp>
#include <set>

#include "geometry/src/shape/convex_hull.hpp"
#include "geometry/src/shape/face_labels.hpp"
#include "geometry/src/shape/polygon_area.hpp"
#include "referee/pairs/families.hpp"
#include "referee/pairs/pair_sizes.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"
#include "support/sanitized.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;
using Vectors = std::vector<Vector3>;

Points columns(const Vectors& list) {
  Points points(3, static_cast<Eigen::Index>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i) points.col(static_cast<Eigen::Index>(i)) = list[i];
  return points;
}

Vectors box_corners(const Vector3& size) {
  Vectors corners;
  for (int v = 0; v < 8; ++v)
    corners.emplace_back(size.cwiseProduct(Vector3(v & 1, v >> 1 & 1, v >> 2 & 1)));
  return corners;
}

/// Turned and set down near the origin or far away.
Points turned(const Points& points, Random& random) {
  const Matrix3 turn = random.rotation();
  const double far = std::array{0.0, 1.0, 1e3, 1e6}[static_cast<std::size_t>(random.integer(0, 3))];
  const Vector3 shift = far * random.direction();
  return (turn * points).colwise() + shift;
}

/// A brick with the corners of its neighbours on edges and faces.
Points t_junction_brick(Random& random) {
  const Vector3 size(random.uniform(0.5, 2), random.uniform(0.3, 1), random.uniform(0.2, 1));
  Vectors list = box_corners(size);
  const int more = random.integer(1, 8);
  for (int k = 0; k < more; ++k) {
    const int axis = random.integer(0, 2), side = random.integer(0, 1), edge = random.integer(0, 2);
    Vector3 x(random.uniform(), random.uniform(), random.uniform());
    if (random.chance(0.5)) x = Vector3::Constant(0.5);
    x[axis] = side;
    if (edge > 0) x[(axis + edge) % 3] = random.integer(0, 1);
    list.push_back(x.cwiseProduct(size));
  }
  return turned(columns(list), random);
}

/// Every face: finite normal, three true corners, wide, all its vertices in its plane.
void check_faces(const Shape& solid, double length) {
  const Topology& topology = solid.topology();
  for (int f = 0; f < topology.face_count(); ++f) {
    const Vector3 normal = solid.face_normal(f);
    REQUIRE_THAT(normal.norm(), WithinAbs(1.0, 1e-14));
    CHECK(is_wider(solid.vertices(), topology.face(f), 0.99 * length));
    double low = INFINITY, high = -INFINITY;
    for (const int v : topology.face_set(f)) {
      const double height = normal.dot(solid.vertex(v) - solid.vertex(topology.face(f)[0]));
      low = std::min(low, height);
      high = std::max(high, height);
    }
    CHECK(high - low <= 2.001 * length);
    for (const int v : topology.face(f)) CHECK(topology.is_corner(v));
  }
}

/// Every vertex has faces, and lies on its host.
void check_hosts(const Shape& solid, double length) {
  const Topology& topology = solid.topology();
  int corners = 0;
  for (int v = 0; v < topology.vertex_count(); ++v) {
    REQUIRE_FALSE(topology.vertex_faces(v).empty());
    const auto [kind, index] = topology.host(v);
    corners += topology.is_corner(v) ? 1 : 0;
    if (kind == FeatureKind::Vertex) {
      CHECK((solid.vertex(v) - solid.vertex(index)).norm() <= 1.001 * length);
    } else if (kind == FeatureKind::Edge) {
      const Vector3 a = solid.vertex(topology.edge(index)[0]);
      const Vector3 line = solid.vertex(topology.edge(index)[1]) - a;
      CHECK(line.cross(solid.vertex(v) - a).norm() <= 1.001 * length * line.norm());
      CHECK(topology.find_edge(v, topology.edge(index)[0]) == index);
    }
    for (const int f : topology.vertex_faces(v)) {
      const std::span<const int> set = topology.face_set(f);
      CHECK(std::binary_search(set.begin(), set.end(), v));
    }
  }
  CHECK(corners - topology.edge_count() + topology.face_count() == 2);
}

/// No point lies outside the triangles of the solid, exactly.
void check_exact(const Hull& hull, const Points& points) {
  const Points& vertices = hull.polyhedron.vertices();
  for (const auto& [i, j, k] : hull.polyhedron.topology().triangles())
    for (int p = 0; p < points.cols(); ++p)
      REQUIRE(orientation(vertices.col(i), vertices.col(j), vertices.col(k), points.col(p)) <= 0);
  for (std::size_t v = 0; v < hull.input_index.size(); ++v)
    CHECK(vertices.col(static_cast<int>(v)) == points.col(hull.input_index[v]));
}

/// The corners of each face as places in the sample; `column`: where the points made were.
std::set<std::set<int>> faces_of(const Hull& hull, const std::vector<int>& column) {
  std::set<std::set<int>> faces;
  for (int f = 0; f < hull.polyhedron.topology().face_count(); ++f) {
    std::set<int> corners;
    for (const int v : hull.polyhedron.topology().face(f)) {
      corners.insert(
          column[static_cast<std::size_t>(hull.input_index[static_cast<std::size_t>(v)])]);
    }
    faces.insert(corners);
  }
  return faces;
}

/// For each point the first within the label length.
std::vector<int> clusters(const Points& points) {
  std::vector<int> near;
  for (int i = 0; i < points.cols(); ++i) {
    int first = 0;
    while ((points.col(first) - points.col(i)).norm() > label_length(points)) ++first;
    near.push_back(first);
  }
  return near;
}

/// Numbering, mirror, names of the axes and scale change no face; a mirror may take another of
/// several nearly equal vertices for the corner.
void check_invariance(const Hull& hull, const Points& points, Random& random) {
  std::vector<int> order(static_cast<std::size_t>(points.cols()));
  std::iota(order.begin(), order.end(), 0);
  const std::set<std::set<int>> faces = faces_of(hull, order);
  CHECK(faces_of(make_hull(std::ldexp(1.0, random.integer(-40, 40)) * points), order) == faces);
  const std::vector<int> near = clusters(points);
  const std::set<std::set<int>> near_faces = faces_of(hull, near);
  CHECK(faces_of(make_hull(-points), near) == near_faces);
  Points mirrored = points;
  mirrored.row(random.integer(0, 2)) *= -1.0;
  mirrored.row(random.integer(0, 1)).swap(mirrored.row(2));
  CHECK(faces_of(make_hull(mirrored), near) == near_faces);
  for (int i = static_cast<int>(order.size()) - 1; i > 0; --i) {
    std::swap(order[static_cast<std::size_t>(i)],
              order[static_cast<std::size_t>(random.integer(0, i))]);
  }
  CHECK(faces_of(make_hull(points(Eigen::all, order)), order) == faces);
}

/// Of equal points only one: which of them keeps its number hangs on the numbering.
Points each_once(const Points& points) {
  Vectors list;
  for (int i = 0; i < points.cols(); ++i) {
    const Vector3 x = points.col(i);
    if (std::find(list.begin(), list.end(), x) == list.end()) list.push_back(x);
  }
  return columns(list);
}

std::string bits(const Points& points) {
  std::string out;
  char buffer[100];
  for (int i = 0; i < points.cols(); ++i) {
    std::snprintf(buffer, sizeof buffer, "%a, %a, %a,\n", points(0, i), points(1, i), points(2, i));
    out += buffer;
  }
  return out;
}

}  // namespace

TEST_CASE("make shape: no thick solid is refused; faces, hosts and the exact hull; other numbers") {
  const std::uint64_t cases = environment_number("QUOIN_CASES", unless_sanitized(20000, 5000));
  const int families = static_cast<int>(family_names().size());
  Random random(environment_number("QUOIN_SEED", 1));
  int made = 0;
  for (std::uint64_t i = 0; i < cases; ++i) {
    const SolidPair pair = make_pair(static_cast<int>(i / 20) % families, random);
    Points points = (random.chance(0.5) ? pair.a : pair.b).placed.points;
    if (random.chance(0.5)) points = turned(points, random);
    if (i % 20 == 0) points = each_once(points);
    INFO(pair.family << ", case " << i << "\n" << bits(points));
    std::optional<Hull> hull;
    try {
      hull = make_hull(points);
      ++made;
    } catch (const InputError& error) {
      INFO(error.what());
      const Solid solid(points);
      CHECK((!in_range(solid) || thickness(solid) <= stated_thickness(solid)));
    }
    if (!hull || i % 20 != 0) continue;
    const double length = label_length(hull->polyhedron.vertices());
    check_faces(hull->polyhedron, length);
    check_hosts(hull->polyhedron, length);
    check_exact(*hull, points);
    check_invariance(*hull, points, random);
  }
  CHECK(static_cast<double>(made) > 0.9 * static_cast<double>(cases));
}

TEST_CASE("make shape: a brick with T-junctions is a brick, turned or far away") {
  Random random(4);
  for (int round = 0; round < 500; ++round) {
    const Points points = t_junction_brick(random);
    INFO(bits(points));
    const Hull hull = make_hull(points);
    const Topology& topology = hull.polyhedron.topology();
    CHECK(topology.face_count() == 6);
    CHECK(topology.edge_count() == 12);
    for (int v = 0; v < topology.vertex_count(); ++v)
      CHECK(topology.is_corner(v) == (hull.input_index[static_cast<std::size_t>(v)] < 8));
  }
}

TEST_CASE("make shape: hosts answer for their vertices") {
  Points points(3, 11);
  points << columns(box_corners({1, 1, 1})), Vector3(0.5, -1e-12, -1e-12),
      Vector3(0.3, 0.4, -1e-12), Vector3(1 + 1e-12, 1 - 1e-12, 1);
  const Hull hull = make_hull(points);
  REQUIRE(hull.input_index.size() == 11);
  const Topology& topology = hull.polyhedron.topology();
  const int edge = topology.find_edge(0, 1);
  REQUIRE(edge >= 0);
  CHECK(topology.host(8) == Feature{FeatureKind::Edge, edge});
  CHECK(topology.neighbours(8).size() == 2);
  CHECK(topology.vertex_edges(8)[0] == edge);
  CHECK(topology.find_edge(8, 1) == edge);
  CHECK(topology.find_edge(0, 8) == edge);
  CHECK(topology.find_edge(8, 2) == -1);
  CHECK(std::ranges::is_permutation(topology.vertex_faces(8), topology.edge_faces(edge)));
  REQUIRE(topology.host(9).kind == FeatureKind::Face);
  CHECK(topology.vertex_faces(9).size() == 1);
  CHECK(topology.neighbours(9).size() == 4);
  CHECK(topology.vertex_edges(9).empty());
  CHECK(topology.find_edge(9, 0) == -1);
  const int corner = topology.is_corner(7) ? 7 : 10, other = 17 - corner;
  CHECK(topology.host(other) == Feature{FeatureKind::Vertex, corner});
  CHECK(topology.find_edge(other, 3) == topology.find_edge(corner, 3));
  CHECK(topology.face_set(topology.host(9).index).size() == 6);
  const std::vector<HostedVertex> hosted = topology.hosted_vertices();
  REQUIRE(hosted.size() == 3);
  CHECK((hosted[0].vertex == other || hosted[2].vertex == other));
  const HostedVertex& on_edge = hosted[other == 7 ? 1 : 0];
  CHECK(on_edge.vertex == 8);
  CHECK(on_edge.corners == std::array{0, 1});
  const HostedVertex& in_face = hosted[other == 7 ? 2 : 1];
  CHECK(in_face.vertex == 9);
  CHECK(in_face.corners == std::array{-1, -1});
  CHECK(in_face.face == topology.host(9).index);
  CHECK_FALSE(topology.three_faces_at_vertices());
}

TEST_CASE("make shape: a moved body keeps its labels") {
  Random random(7);
  const Hull hull = make_hull(t_junction_brick(random));
  Shape moved = hull.polyhedron;
  moved.set_vertices((random.rotation() * moved.vertices()).colwise() + Vector3(3, 4, 5));
  CHECK(&moved.topology() == &hull.polyhedron.topology());
  check_hosts(moved, 1e-8);
}

TEST_CASE("make shape: faces given as triangles, with T-junctions that both neighbours name") {
  Points points(3, 9);
  points << columns(box_corners({1, 1, 1})), Vector3(0.5, 0, 0);
  const Faces faces{{0, 2, 3, 1, 8}, {4, 5, 7},    {4, 7, 6},    {0, 8, 5},   {8, 1, 5},
                    {0, 5, 4},       {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  Random random(3);
  for (int round = 0; round < 20; ++round) {
    const Points placed =
        round == 0 ? points : Points((random.rotation() * points).colwise() + random.direction());
    const Shape solid = make_shape(placed, faces);
    CHECK(solid.vertex_count() == 9);
    CHECK(solid.topology().face_count() == 6);
    CHECK(solid.topology().edge_count() == 12);
    CHECK(solid.topology().host(8) == Feature{FeatureKind::Edge, solid.topology().find_edge(0, 1)});
    CHECK_THAT(mass_properties(solid).volume, WithinRel(1.0, 1e-14));
  }
}

TEST_CASE("make shape: a mesh with slivers along an edge") {
  Points points(3, 10);
  points << columns(box_corners({1, 1, 1})), Vector3(0.3, 0, 0), Vector3(0.6, 0, 0);
  // the front is cut from corner 4 and 5, the bottom knows nothing of the two vertices but slivers
  const Faces faces{{0, 2, 3, 1}, {0, 1, 9},    {0, 9, 8},    {0, 8, 4},    {8, 9, 4},   {9, 5, 4},
                    {9, 1, 5},    {4, 5, 7, 6}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  const Shape solid = make_shape(points, faces);
  CHECK(solid.topology().face_count() == 6);
  CHECK(solid.topology().edge_count() == 12);
  check_faces(solid, label_length(points));
  check_hosts(solid, label_length(points));
}

TEST_CASE("make shape: thickness is the solid's, and flat sets are refused") {
  Random random(11);
  for (int round = 0; round < 300; ++round) {
    Points plate(3, 40);
    for (int i = 0; i < plate.cols(); ++i) plate.col(i) = random.point(-1, 1);
    Points depth = plate.row(2).cwiseSign().colwise().replicate(3);
    plate.row(2).setZero();
    const Matrix3 turn = random.rotation();
    plate = (turn * plate).eval();
    const double thickness = (round % 2 == 0 ? 1.01 : 0.3) * label_length(plate);
    plate += 0.5 * thickness * turn.col(2).asDiagonal() * depth;
    INFO(bits(plate));
    if (round % 2 == 0)
      CHECK_NOTHROW(make_hull(plate));
    else
      CHECK_THROWS_AS(make_hull(plate), InputError);
  }
}

TEST_CASE("make shape: no points have no length") {
  CHECK_THROWS_AS(label_length(Points(3, 0)), InputError);
}

TEST_CASE("make shape: mass properties are those of the exact hull") {
  Points points(3, 9);  // a slab as thick as two label lengths, with a vertex on its top
  points << columns(box_corners({1, 1, 4e-9})), Vector3(0.5, 0.5, 5e-9);
  const Hull hull = make_hull(points);
  CHECK_THAT(mass_properties(hull.polyhedron).volume, WithinRel(4e-9 + 1e-9 / 3, 1e-12));
}

/// A cube whose sides are nets of triangles, in single precision after a turn.
struct Net {
  Points points;
  std::vector<std::vector<int>> faces;
};

Net single_precision_cube(Random& random, int cells) {
  Net net;
  std::vector<Vector3> places;
  const auto vertex = [&](const Vector3& x) {
    const auto known = std::find(places.begin(), places.end(), x);
    if (known != places.end()) return static_cast<int>(known - places.begin());
    places.push_back(x);
    return static_cast<int>(places.size()) - 1;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {0, cells}) {
      const auto place = [&](int i, int j) {
        Vector3 x;
        x[axis] = side;
        x[(axis + 1) % 3] = side > 0 ? i : j;
        x[(axis + 2) % 3] = side > 0 ? j : i;
        return vertex(x);
      };
      for (int i = 0; i < cells; ++i) {
        for (int j = 0; j < cells; ++j) {
          net.faces.push_back({place(i, j), place(i + 1, j), place(i + 1, j + 1)});
          net.faces.push_back({place(i, j), place(i + 1, j + 1), place(i, j + 1)});
        }
      }
    }
  }
  net.points = columns(places) / cells;
  net.points = (random.rotation() * net.points).cast<float>().cast<double>().eval();
  return net;
}

TEST_CASE("make shape: faces dented by single precision mean the hull of the vertices") {
  Random random(12);
  int alike = 0;  // contacts to which no vertex below the hull belongs, within tol
  for (int round = 0; round < 60; ++round) {
    const Net net = single_precision_cube(random, random.integer(1, 4));
    const Shape solid = make_shape(net.points, net.faces);
    const Hull hull = make_hull(net.points);
    const MassProperties mass = mass_properties(solid), expected = mass_properties(hull.polyhedron);
    CHECK_THAT(mass.volume, WithinRel(expected.volume, 1e-15));
    CHECK_THAT((mass.centroid - expected.centroid).norm(), WithinAbs(0.0, 1e-15));
    REQUIRE(solid.vertices() == net.points);
    CHECK(solid.topology().face_count() == hull.polyhedron.topology().face_count());
    for (int v = 0; v < solid.vertex_count(); ++v) {
      CHECK(contains(solid, solid.vertex(v)));
      CHECK(!solid.topology().vertex_faces(v).empty());
    }
    for (int k = 0; k < 50; ++k) {
      const Vector3 place = 3 * random.direction(), way = random.point(-0.2, 0.8) - place;
      const auto hit = first_hit(solid, {place, way, 2.0});
      const auto of_hull = first_hit(hull.polyhedron, {place, way, 2.0});
      REQUIRE(hit.has_value() == of_hull.has_value());
      if (hit) CHECK_THAT(hit->s, WithinAbs(of_hull->s, 1e-14));
    }
    const Shape box = make_box({0.2, 0.2, 0.2}, {0.9, 0.7, 0.8});
    for (int k = 0; k < 20; ++k) {
      const Placement place{random.rotation(), random.uniform(0, 2) * random.direction()};
      PairContact contact, of_hull;
      update_pair_contact(solid, Body(box, place), {}, contact);
      update_pair_contact(hull.polyhedron, Body(box, place), {}, of_hull);
      CHECK_THAT(contact.nearest.gap, WithinAbs(of_hull.nearest.gap, 1e-14));
      if (contact.support_a.vertices.size() != of_hull.support_a.vertices.size()) continue;
      CHECK(contact.points.size() == of_hull.points.size());
      CHECK(contact.type == of_hull.type);
      ++alike;
    }
  }
  CHECK(alike > 800);
}

TEST_CASE("make shape: where the hull takes the place of dented faces, these keep their names") {
  Points points(3, 9);
  points << columns(box_corners({1, 1, 1})), Vector3(0.5, 0.5, 1 - 8e-7);
  const std::vector<std::vector<int>> faces{{0, 1, 5, 4}, {0, 2, 3, 1}, {2, 6, 7, 3},
                                            {4, 5, 8},    {5, 7, 8},    {7, 6, 8},
                                            {6, 4, 8},    {0, 4, 6, 2}, {1, 3, 7, 5}};
  const Shape solid = make_shape(points, faces);
  const Topology& topology = solid.topology();
  REQUIRE(topology.face_count() == 6);
  const std::vector<std::set<int>> expected{{0, 1, 4, 5}, {0, 1, 2, 3}, {2, 3, 6, 7},
                                            {4, 5, 6, 7}, {0, 2, 4, 6}, {1, 3, 5, 7}};
  for (int f = 0; f < 6; ++f) {
    const std::set<int> corners(topology.face(f).begin(), topology.face(f).end());
    CHECK(corners == expected[static_cast<std::size_t>(f)]);
    CHECK(topology.face_set(f).size() == 4);
  }
  CHECK(topology.host(8) == Feature{FeatureKind::Face, 3});
  CHECK_THAT(mass_properties(solid).volume, WithinRel(1.0, 1e-15));
  // A box on it touches four corners and not the vertex below.
  PairContact contact;
  update_pair_contact(solid, make_box({-1, -1, 1}, {2, 2, 2}), {}, contact);
  CHECK(contact.type == ContactType::FaceFace);
  CHECK(contact.support_a.vertices == std::vector<int>{4, 5, 6, 7});
  CHECK(contact.points.size() == 4);
  CHECK(contact.area == 1.0);
}

TEST_CASE("make shape: a vertex below an edge or a corner is theirs") {
  Points points(3, 10);
  points << columns(box_corners({1, 1, 1})), Vector3(0.5, 5e-7, 1 - 5e-7),
      Vector3(1e-7, 1e-7, 1e-7);
  // the top's front edge is pushed in, and beside corner 0 there is another vertex, in the bottom
  const std::vector<std::vector<int>> faces{{9, 2, 3, 1},    {0, 2, 9},       {0, 9, 1},
                                            {0, 1, 5, 8, 4}, {4, 8, 5, 7, 6}, {2, 6, 7, 3},
                                            {0, 4, 6, 2},    {1, 3, 7, 5}};
  const Shape solid = make_shape(points, faces);
  const Topology& topology = solid.topology();
  CHECK(topology.face_count() == 6);
  CHECK(topology.host(8) == Feature{FeatureKind::Edge, topology.find_edge(4, 5)});
  CHECK(topology.host(9) == Feature{FeatureKind::Vertex, 0});
}
