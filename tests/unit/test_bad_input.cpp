/// What cannot be worked with is refused when it comes in, with a message that names what and
/// where.
#include <algorithm>
#include <cmath>
#include <limits>
#include <quoin/geometry/broad_phase.hpp>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/contact_finder.hpp>
#include <quoin/geometry/queries.hpp>

#include "support/catch.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using quoin::tests::ContainsSubstring;
using Faces = std::vector<std::vector<int>>;

Points cube() {
  Points points(3, 8);
  for (int i = 0; i < 8; ++i) points.col(i) = Vector3(i & 1, i >> 1 & 1, i >> 2 & 1);
  return points;
}

const Faces kCubeFaces{{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                       {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

template <class Make>
std::string complaint(Make&& make) {
  try {
    make();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was refused";
}

std::string shape_complaint(const Points& points, const Faces& faces) {
  return complaint([&] { make_shape(points, faces); });
}

std::string hull_complaint(const Points& points) {
  return complaint([&] { make_hull(points); });
}

}  // namespace

TEST_CASE("bad input: what is good is accepted") {
  CHECK(make_shape(cube(), kCubeFaces).topology().face_count() == 6);
  Faces inverted = kCubeFaces;  // throughout: either orientation will do
  for (std::vector<int>& face : inverted) std::reverse(face.begin(), face.end());
  CHECK(make_shape(cube(), inverted).topology().face_count() == 6);
  CHECK(make_hull(cube()).polyhedron.topology().edge_count() == 12);
}

TEST_CASE("bad input: 0 to 3 points") {
  for (int count = 0; count <= 3; ++count) {
    const Points few = cube().leftCols(count);
    CHECK_THAT(hull_complaint(few), ContainsSubstring(std::to_string(count) + " points"));
    CHECK_THAT(shape_complaint(few, {}), ContainsSubstring("points"));
  }
}

TEST_CASE("bad input: NaN, infinity, and numbers too large to be squared") {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity(), 1e300}) {
    Points points = cube();
    points(1, 5) = bad;
    CHECK_THAT(hull_complaint(points), ContainsSubstring("point 5"));
    CHECK_THAT(shape_complaint(points, kCubeFaces), ContainsSubstring("point 5"));
  }
  CHECK_THROWS_AS(make_box({0, 0, 0}, {1, std::nan(""), 1}), InputError);
}

TEST_CASE("bad input: flat, in a line, all in one place") {
  Points flat = cube();
  flat.row(0) += 0.25 * flat.row(2);
  flat.row(1) += 0.125 * flat.row(2);
  flat.row(2).setZero();
  CHECK_THAT(hull_complaint(flat), ContainsSubstring("plane"));
  Points line = flat;
  line.row(0) += 2 * line.row(1);
  line.row(1).setZero();
  CHECK_THAT(hull_complaint(line), ContainsSubstring("line"));
  CHECK_THROWS_AS(make_hull(Points::Zero(3, 8)), InputError);
  CHECK_THROWS_AS(make_shape(flat, kCubeFaces), InputError);
  CHECK_THROWS_AS(make_box({0, 0, 0}, {1, 0, 1}), InputError);
  CHECK_THROWS_AS(make_box({0, 0, 0}, {1, -1, 1}), InputError);
}

TEST_CASE("bad input: duplicate points and unused points of a polyhedron") {
  Points twice(3, 9);
  twice << cube(), cube().col(3);
  Faces faces = kCubeFaces;
  faces[1] = {4, 5, 7, 6};
  CHECK_THAT(shape_complaint(twice, faces), ContainsSubstring("3"));
  Points unused(3, 9);
  unused << cube(), Vector3(0.5, 0.5, 0.5);
  CHECK_THAT(shape_complaint(unused, kCubeFaces), ContainsSubstring("8"));
  CHECK_THAT(shape_complaint(unused, kCubeFaces), ContainsSubstring("vertex 8 belongs to no face"));
  // a hull does with equal points and with those that do not span it
  CHECK(make_hull(twice).input_index == std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7});
  CHECK(make_hull(unused).polyhedron.topology().vertex_count() == 8);
}

TEST_CASE("bad input: open, inverted and inconsistent surfaces") {
  Faces open = kCubeFaces;
  open.pop_back();
  CHECK_THAT(shape_complaint(cube(), open), ContainsSubstring("edge"));
  Faces one_inverted = kCubeFaces;
  std::reverse(one_inverted[2].begin(), one_inverted[2].end());
  CHECK_THAT(shape_complaint(cube(), one_inverted), ContainsSubstring("edge"));
  Faces doubled = kCubeFaces;
  doubled.push_back(kCubeFaces[0]);
  CHECK_THROWS_AS(make_shape(cube(), doubled), InputError);
  Faces short_face = kCubeFaces;
  short_face[3] = {2, 6};
  CHECK_THAT(shape_complaint(cube(), short_face), ContainsSubstring("face 3"));
  Faces no_such_vertex = kCubeFaces;
  no_such_vertex[4][0] = 8;
  CHECK_THAT(shape_complaint(cube(), no_such_vertex), ContainsSubstring("face 4"));
  no_such_vertex[4][0] = -1;
  CHECK_THAT(shape_complaint(cube(), no_such_vertex), ContainsSubstring("face 4"));
  CHECK_THROWS_AS(make_shape(cube(), {}), InputError);
}

TEST_CASE("bad input: two closed surfaces are not one solid") {
  Points points(3, 16);
  points << cube(), cube().colwise() + Vector3(3, 0, 0);
  Faces faces = kCubeFaces;
  for (std::vector<int> face : kCubeFaces) {
    for (int& v : face) v += 8;
    faces.push_back(face);
  }
  CHECK_THROWS_AS(make_shape(points, faces), InputError);
}

TEST_CASE("bad input: faces off their plane, dents") {
  Points bent = cube();
  bent(2, 7) = 1.001;
  CHECK_THAT(shape_complaint(bent, kCubeFaces), ContainsSubstring("face"));
  // a cube whose lid is pushed in: four triangles to a point inside
  Points dented(3, 9);
  dented << cube(), Vector3(0.5, 0.5, 0.7);
  Faces faces = kCubeFaces;
  faces.erase(faces.begin() + 1);
  for (const std::vector<int>& triangle : Faces{{4, 5, 8}, {5, 7, 8}, {7, 6, 8}, {6, 4, 8}})
    faces.push_back(triangle);
  CHECK_THAT(shape_complaint(dented, faces), ContainsSubstring("convex"));
  dented.col(8).z() = 1.5;  // pushed out it is fine
  CHECK(make_shape(dented, faces).topology().face_count() == 9);
}

TEST_CASE("bad input: sizes beyond the promised range") {
  CHECK_THAT(hull_complaint(1e-83 * cube()), ContainsSubstring("largest extent"));
  CHECK_THAT(shape_complaint(1e-31 * cube(), kCubeFaces), ContainsSubstring("1e-31 m, limit"));
  CHECK_THAT(hull_complaint(1e31 * cube()), ContainsSubstring("limit 1e+30 m"));
  CHECK(make_hull(1e-30 * cube()).polyhedron.topology().face_count() == 6);
  CHECK(make_hull(1e30 * cube()).polyhedron.topology().face_count() == 6);
}

TEST_CASE("bad input: moved vertices are checked, and leave the body as it was") {
  quoin::geometry::Shape box = make_box({0, 0, 0}, {1, 1, 1});
  const auto moved = [&](double value) {
    Points points = 3.0 * cube();
    points(1, 5) = value;
    return complaint([&] { box.set_vertices(points); });
  };
  CHECK_THAT(moved(std::nan("")), ContainsSubstring("vertex 5 has a coordinate of nan m"));
  CHECK_THAT(moved(-std::numeric_limits<double>::infinity()), ContainsSubstring("vertex 5"));
  CHECK_THAT(moved(1e31), ContainsSubstring("vertex 5 has a coordinate of 1e+31 m, limit 1e+30 m"));
  CHECK_THAT(complaint([&] { box.set_vertices(cube().leftCols(7)); }),
             ContainsSubstring("7 vertices for a topology of 8"));
  CHECK_THAT(complaint([&] { box.set_vertices(Points::Zero(3, 8)); }),
             ContainsSubstring("largest extent"));
  CHECK(box.vertices() == cube());
  CHECK(box.box().max == Vector3(1, 1, 1));
  box.set_vertices(3.0 * cube());
  CHECK(box.box().max == Vector3(3, 3, 3));
}

TEST_CASE("bad input: prisms of no height, and over polygons that are none") {
  Points square(3, 4);
  square << 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0;
  CHECK(make_prism(square, {0, 0, 1}).topology().face_count() == 6);
  CHECK_THROWS_AS(make_prism(square, {0, 0, 0}), InputError);
  CHECK_THROWS_AS(make_prism(square, {1, 0, 0}), InputError);
  CHECK_THROWS_AS(make_prism(square.leftCols(2), {0, 0, 1}), InputError);
  Points crossed = square;
  crossed.col(2).swap(crossed.col(3));
  CHECK_THROWS_AS(make_prism(crossed, {0, 0, 1}), InputError);
}

TEST_CASE("bad input: a million points end in a hull or in a message, soon") {
  quoin::tests::Random random(1);
  Points cloud(3, 1000000);
  for (Eigen::Index i = 0; i < cloud.cols(); ++i) cloud.col(i) = random.point(-1, 1);
  const std::string text = hull_complaint(cloud);
  if (text == "nothing was refused")
    CHECK(make_hull(cube()).polyhedron.topology().vertex_count() == 8);
  else
    CHECK_THAT(text, ContainsSubstring("at most"));
}

TEST_CASE("bad input: a box is refused where a hull of its corners is") {
  for (const double thickness : {1e-40, 1e-12, 1e-9, 1.5e-9, 1e-6}) {
    for (const double far : {0.0, 1e6}) {
      const Vector3 min(far, 0, 0), max(far + 1, 1, thickness);
      Points corners(3, 8);
      for (int v = 0; v < 8; ++v)
        for (int k = 0; k < 3; ++k) corners(k, v) = (v >> k & 1 ? max : min)[k];
      CHECK(complaint([&] { make_box(min, max); }) == hull_complaint(corners));
    }
  }
}

TEST_CASE("bad input: topologies that are none, and shapes without one") {
  const auto topology_complaint = [](int count, const Faces& faces,
                                     const std::vector<HostedVertex>& hosted = {},
                                     const Faces& surface = {}) {
    return complaint([&] { Topology(count, faces, hosted, surface); });
  };
  CHECK_THAT(topology_complaint(-1, {}), ContainsSubstring("-1 vertices"));
  CHECK_THAT(topology_complaint(-1, kCubeFaces), ContainsSubstring("-1 vertices"));
  CHECK_THAT(topology_complaint(9, kCubeFaces, {{8, {8, -1}}}), ContainsSubstring("vertex 8"));
  CHECK_THAT(topology_complaint(10, kCubeFaces, {{8, {9, -1}}, {9, {0, -1}}}),
             ContainsSubstring("vertex 8"));
  CHECK_THAT(topology_complaint(8, kCubeFaces, {}, {{0, 1, 99}}),
             ContainsSubstring("surface polygon 0 names vertex 99"));
  CHECK_THAT(topology_complaint(8, kCubeFaces, {}, {{0, 1, 2}}), ContainsSubstring("open"));
  Faces inside_out = kCubeFaces;
  std::reverse(inside_out[2].begin(), inside_out[2].end());
  CHECK_THAT(topology_complaint(8, kCubeFaces, {}, inside_out),
             ContainsSubstring("surface polygons"));
  CHECK(complaint([] { Shape(nullptr, cube()); }) == "shape: its topology is null");
}

TEST_CASE("bad input: lengths of single calls") {
  using namespace quoin::geometry;
  const Shape shape = make_box({0, 0, 0}, {1, 1, 1});
  const Body body(shape), moved(shape, {Matrix3::Identity(), {0, 0, 2}});
  const NearestFeatures nearest = nearest_features(body, moved);
  std::vector<ContactPoint> points;
  PairContact pair;
  SupportSet set;
  BroadPhase boxes;
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), -1.0}) {
    for (const Body& b : {body, moved}) {
      CHECK_THROWS_AS(nearest_features(body, b, {.tolerance = bad}), InputError);
      CHECK_THROWS_AS(append_contact_points({0, 1}, body, b, nearest, {.reach = bad}, points),
                      InputError);
      CHECK_THROWS_AS(append_contacts_within_reach({0, 1}, body, b, {.tolerance = bad}, {}, points),
                      InputError);
      if (!std::isfinite(bad)) {  // its reach is a gap, which may be below 0
        CHECK_THROWS_AS(append_contacts_within_reach({0, 1}, body, b, {.reach = bad}, {}, points),
                        InputError);
      }
      CHECK_THROWS_AS(update_pair_contact(body, b, {.tolerance = bad}, pair), InputError);
    }
    CHECK_THROWS_AS(nearest_features_within(body, moved, 0.0, {.tolerance = bad}), InputError);
    CHECK_THROWS_AS(find_support_set(body, Vector3::UnitZ(), bad, set), InputError);
    CHECK_THROWS_AS(contains(body, {0, 0, 0}, bad), InputError);
    CHECK_THROWS_AS(boxes.find_candidates(bad), InputError);
    CHECK_THROWS_AS(boxes.find_candidates(std::vector<Box>(20), bad), InputError);
    CHECK_THROWS_AS(boxes.find_candidates_of({}, bad), InputError);
    CHECK_THROWS_AS(boxes.set(0, Box{}, BoxUse::Moving, bad), InputError);
  }
  CHECK(points.empty());
}

TEST_CASE("bad input: normals and placements that are not finite") {
  using namespace quoin::geometry;
  const Shape shape = make_box({0, 0, 0}, {1, 1, 1});
  SupportSet set;
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (int k = 0; k < 12; ++k) {
      Placement placement;
      (k < 9 ? placement.linear.data()[k] : placement.translation[k - 9]) = bad;
      CHECK(!first_hit({shape, placement}, {.origin = {0.5, 0.5, 0.5}}));
      CHECK(!contains({shape, placement}, {0.5, 0.5, 0.5}));
      if (k < 3) {
        CHECK_THROWS_AS(find_support_set({shape, placement}, Vector3::UnitX(), 0.0, set),
                        InputError);
      }
    }
    CHECK_THROWS_AS(find_support_set(Body(shape), {0, bad, 0}, 0.0, set), InputError);
  }
  CHECK(first_hit(Body(shape), {.origin = {-9, 0.5, 0.5}})->s == 9.0);  // rays have no end
}

TEST_CASE("bad input: an executor without workers leaves the work to the caller") {
  using namespace quoin::geometry;
  struct None final : Executor {
    int workers() const override { return -3; }
    void run(Task, void*) override { FAIL("nobody is there to run it"); }
  } none;
  ContactFinder finder({.executor = &none});
  const auto shape = std::make_shared<const Shape>(make_box({0, 0, 0}, {1, 1, 1}));
  for (int i = 0; i < 40; ++i) finder.add(shape, {Matrix3::Identity(), {0, 0, 1.0 * i}});
  std::vector<ContactPoint> contacts;
  CHECK(finder.find(contacts).candidates == 39);
  CHECK(contacts.size() == 4 * 39);
}

TEST_CASE("a vector of bodies is a source of bodies") {
  using namespace quoin::geometry;
  const Shape shape = make_box({0, 0, 0}, {1, 1, 1});
  const std::vector<Body> bodies{shape, {shape, {Matrix3::Identity(), {0, 0, 1}}}};
  const std::vector<BlockPair> pairs{{0, 1}};
  std::vector<ContactPoint> contacts;
  PairBatch batch({});
  batch.find(bodies, pairs, contacts);
  CHECK(contacts.size() == 4);
}
