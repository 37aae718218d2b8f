/// What cannot be worked with is refused when it comes in, with a message that names what and
/// where.
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <quoin/geometry/broad_phase.hpp>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/contact_finder.hpp>
#include <quoin/geometry/queries.hpp>

#include "scene_file/read_shape.hpp"
#include "support/catch.hpp"
#include "support/json_lines.hpp"
#include "support/message.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using nlohmann::json;
using quoin::tests::ContainsSubstring, quoin::tests::message;
using Faces = std::vector<std::vector<int>>;

Points cube() {
  Points points(3, 8);
  for (int i = 0; i < 8; ++i) points.col(i) = Vector3(i & 1, i >> 1 & 1, i >> 2 & 1);
  return points;
}

const Faces kCubeFaces{{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                       {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

std::string shape_complaint(const Points& points, const Faces& faces) {
  return message([&] { make_shape(points, faces); });
}

std::string hull_complaint(const Points& points) {
  return message([&] { make_hull(points); });
}

}  // namespace

TEST_CASE("bad input: each solid of bad_shapes.jsonl is made, or one line says what is wrong") {
  quoin::tests::for_each_line(
      QUOIN_SOURCE_DIR "/tests/unit/bad_shapes.jsonl", 50, [](const json& line) {
        Points points(3, line["points"].size());
        for (Eigen::Index i = 0; i < points.cols(); ++i)
          points.col(i) = quoin::scene_file::read_vector(line["points"][i]);
        const Faces faces = line.value("faces", Faces{});
        const ShapeOptions options{.coordinate_rounding = line.value("rounding", 0.0)};
        int made = -1;
        const std::string said = message([&] {
          if (line.contains("sweep")) {
            const Vector3 sweep = quoin::scene_file::read_vector(line["sweep"]);
            made = make_prism(points, sweep).topology().face_count();
          } else if (line.contains("box")) {
            made = make_box(points.col(0), points.col(1)).topology().face_count();
          } else if (line.contains("faces")) {
            made = make_shape(points, faces, options).topology().face_count();
          } else {
            const Hull hull = make_hull(points);
            made = hull.polyhedron.topology().face_count();
            if (line.contains("input")) CHECK(hull.input_index == line["input"]);
          }
        });
        CHECK(made == line.value("made", -1));
        if (line.contains("said"))
          CHECK_THAT(said, ContainsSubstring(line["said"].get<std::string>()));
        if (!line.contains("fault")) return;
        const std::vector<ShapeFault> faults = shape_faults(points, faces, options);
        REQUIRE(faults.size() >= line.value("faults", 1U));
        CHECK_THAT(faults[0].text, ContainsSubstring(line["fault"].get<std::string>()));
        CHECK(faults[0].refused == line.contains("said"));
      });
}

TEST_CASE("bad input: NaN, infinity, and numbers too large to be squared") {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    Points points = cube();
    points(1, 5) = bad;
    CHECK_THAT(hull_complaint(points), ContainsSubstring("point 5"));
    CHECK_THAT(shape_complaint(points, kCubeFaces), ContainsSubstring("point 5"));
  }
  CHECK_THROWS_AS(make_box({0, 0, 0}, {1, std::nan(""), 1}), InputError);
}

TEST_CASE("bad input: moved vertices are checked, and leave the body as it was") {
  quoin::geometry::Shape box = make_box({0, 0, 0}, {1, 1, 1});
  const auto moved = [&](double value) {
    Points points = 3.0 * cube();
    points(1, 5) = value;
    return message([&] { box.set_vertices(points); });
  };
  CHECK_THAT(moved(std::nan("")), ContainsSubstring("vertex 5 has a coordinate of nan m"));
  CHECK_THAT(moved(-std::numeric_limits<double>::infinity()), ContainsSubstring("vertex 5"));
  CHECK_THAT(moved(1e31), ContainsSubstring("vertex 5 has a coordinate of 1e+31 m, limit 1e+30 m"));
  CHECK_THAT(message([&] { box.set_vertices(cube().leftCols(7)); }),
             ContainsSubstring("7 vertices for a topology of 8"));
  CHECK_THAT(message([&] { box.set_vertices(Points::Zero(3, 8)); }),
             ContainsSubstring("largest extent"));
  CHECK(box.vertices() == cube());
  CHECK(box.box().max == Vector3(1, 1, 1));
  box.set_vertices(3.0 * cube());
  CHECK(box.box().max == Vector3(3, 3, 3));
}

TEST_CASE("bad input: a million points end in a hull or in a message, soon") {
  quoin::tests::Random random(1);
  Points cloud(3, 1000000);
  for (Eigen::Index i = 0; i < cloud.cols(); ++i) cloud.col(i) = random.point(-1, 1);
  const std::string text = hull_complaint(cloud);
  if (text.empty())
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
      CHECK(message([&] { make_box(min, max); }) == hull_complaint(corners));
    }
  }
}

TEST_CASE("bad input: topologies that are none, and shapes without one") {
  const auto topology_complaint = [](int count, const Faces& faces,
                                     const std::vector<HostedVertex>& hosted = {},
                                     const Faces& surface = {}) {
    return message([&] { Topology(count, faces, hosted, surface); });
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
  CHECK(message([] { Shape(nullptr, cube()); }) == "shape: its topology is null");
}

TEST_CASE("bad input: lengths of single calls") {
  using namespace quoin::geometry;
  const Shape shape = make_box({0, 0, 0}, {1, 1, 1});
  const Body body(shape), moved(shape, {Matrix3::Identity(), {0, 0, 2}});
  std::vector<ContactPoint> points;
  PairContact pair;
  BroadPhase boxes;
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), -1.0}) {
    for (const Body& b : {body, moved}) {
      CHECK_THROWS_AS(nearest_features(body, b, {.tolerance = bad}), InputError);
      CHECK_THROWS_AS(update_pair_contact(body, b, {.reach = bad}, pair), InputError);
      CHECK_THROWS_AS(append_contacts_within_reach({0, 1}, body, b, {.tolerance = bad}, {}, points),
                      InputError);
      if (!std::isfinite(bad)) {  // its reach is a gap, which may be below 0
        CHECK_THROWS_AS(append_contacts_within_reach({0, 1}, body, b, {.reach = bad}, {}, points),
                        InputError);
      }
      CHECK_THROWS_AS(update_pair_contact(body, b, {.tolerance = bad}, pair), InputError);
    }
    CHECK_THROWS_AS(nearest_features_within(body, moved, 0.0, {.tolerance = bad}), InputError);
    CHECK_THROWS_AS(contains(body, {0, 0, 0}, bad), InputError);
    CHECK_THROWS_AS(boxes.find_candidates(bad), InputError);
    CHECK_THROWS_AS(boxes.find_candidates(std::vector<Box>(20), bad), InputError);
    CHECK_THROWS_AS(boxes.find_candidates_of({}, bad), InputError);
    CHECK_THROWS_AS(boxes.set(0, Box{}, BoxUse::Moving, bad), InputError);
  }
  CHECK(points.empty());
}

TEST_CASE("bad input: placements that are not finite") {
  using namespace quoin::geometry;
  const Shape shape = make_box({0, 0, 0}, {1, 1, 1});
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (int k = 0; k < 12; ++k) {
      Placement placement;
      (k < 9 ? placement.linear.data()[k] : placement.translation[k - 9]) = bad;
      CHECK(!first_hit({shape, placement}, {.origin = {0.5, 0.5, 0.5}}));
      CHECK(!contains({shape, placement}, {0.5, 0.5, 0.5}));
    }
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
