#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <quoin/geometry/contact_point.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/geometry/nearest_features.hpp>
#include <random>

#include "scene_file/cut.hpp"
#include "scene_file/scene_error.hpp"
#include "support/catch.hpp"
#include "support/trial.hpp"

using Eigen::Vector3d;
using nlohmann::json;
using namespace quoin::scene_file;
using namespace quoin::tests;

namespace {

json box(const Vector3d& min, const Vector3d& max) {
  return {
      {"type", "box"}, {"min", {min.x(), min.y(), min.z()}}, {"max", {max.x(), max.y(), max.z()}}};
}

double volume(const CutBody& body) {
  double sum = 0.0;
  for (const CutCell& cell : body.cells) sum += mass_properties(cell.shape).volume;
  return sum;
}

int in_region(const CutBody& body, const std::string& name) {
  return static_cast<int>(std::count_if(body.cells.begin(), body.cells.end(),
                                        [&](const CutCell& cell) { return cell.region == name; }));
}

json joint_set(double dip, double direction, const Vector3d& origin, double spacing) {
  return {{"type", "joint_set"},
          {"dip_deg", dip},
          {"dip_direction_deg", direction},
          {"origin", {origin.x(), origin.y(), origin.z()}},
          {"spacing", spacing}};
}

}  // namespace

TEST_CASE("three orthogonal joint sets make bricks") {
  const json cut = {{"body", box({0, 0, 0}, {4, 3, 2})},
                    {"cuts",
                     {joint_set(0, 0, {0, 0, 0}, 0.5), joint_set(90, 90, {0, 0, 0}, 1),
                      joint_set(90, 0, {0, 0, 0}, 1)}}};
  const CutBody body = cut_body(cut, "/cut");
  CHECK(body.cells.size() == 4 * 3 * 4);
  for (const CutCell& cell : body.cells) {
    CHECK_THAT(mass_properties(cell.shape).volume, WithinRel(0.5, 1e-12));
    CHECK(cell.shape.topology().face_count() == 6);
  }
}

TEST_CASE("dip direction is clockwise from north, dip downwards from the horizontal") {
  // A plane that dips 30 degrees towards east (+x) falls in that direction.
  const json cut = {
      {"body", box({-1, -1, -1}, {1, 1, 1})},
      {"cuts",
       {{{"type", "plane"}, {"dip_deg", 30}, {"dip_direction_deg", 90}, {"point", {0, 0, 0}}}}}};
  const CutBody body = cut_body(cut, "/cut");
  REQUIRE(body.cells.size() == 2);
  const CutCell& below = body.cells[0];
  int found = 0;
  for (std::size_t f = 0; f < below.face_joints.size(); ++f) {
    if (below.face_joints[f] != 0) continue;
    ++found;
    const Vector3d normal = below.shape.face_normal(static_cast<int>(f));
    CHECK_THAT(normal.x(), WithinAbs(0.5, 1e-12));
    CHECK_THAT(normal.y(), WithinAbs(0, 1e-12));
    CHECK_THAT(normal.z(), WithinAbs(std::sqrt(0.75), 1e-12));
  }
  CHECK(found == 1);
}

TEST_CASE("number, only_in, disc and excavation") {
  json three = joint_set(0, 0, {0, 0, 1}, 1);
  three["number"] = 3;
  const json column = box({0, 0, 0}, {1, 1, 10});
  CHECK(cut_body({{"body", column}, {"cuts", {three}}}, "").cells.size() == 4);

  json above = joint_set(0, 0, {0, 0, 0}, 1);
  above["only_in"] = {{{"point", {0, 0, 5}}, {"normal", {0, 0, -1}}}};
  const json half = {{"type", "plane"}, {"dip_deg", 0}, {"point", {0, 0, 4}}};
  CHECK(cut_body({{"body", column}, {"cuts", {half, above}}}, "").cells.size() == 7);

  const json disc = {{"type", "disc"}, {"dip_deg", 0}, {"centre", {0.5, 0.5, 5}}, {"radius", 0.2}};
  const json beside = {{"type", "disc"}, {"dip_deg", 0}, {"centre", {9, 0.5, 7}}, {"radius", 0.2}};
  CHECK(cut_body({{"body", column}, {"cuts", {disc, beside}}}, "").cells.size() == 2);

  const json tunnel = {
      {"type", "excavation"}, {"name", "tunnel"}, {"shape", box({1, -1, 1}, {2, 9, 2})}};
  const CutBody body = cut_body({{"body", box({0, 0, 0}, {3, 8, 3})}, {"cuts", {tunnel}}}, "");
  CHECK(in_region(body, "tunnel") == 1);
  json typo = three;
  typo["only_in"] = {{{"region", "tunel"}}};
  CHECK_THROWS_AS(cut_body({{"body", column}, {"cuts", {tunnel, typo}}}, ""),
                  quoin::scene_file::SceneError);
  CHECK_THAT(volume(body), WithinRel(72, 1e-12));
  for (const CutCell& cell : body.cells)
    if (cell.region == "tunnel")
      CHECK_THAT(mass_properties(cell.shape).volume, WithinRel(8, 1e-12));
}

TEST_CASE("volumes sum to the body's, neighbours lie on each other, seeds repeat") {
  std::mt19937_64 random(7);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
  };
  const char* const cases = std::getenv("QUOIN_CUT_CASES");
  for (int i = 0; i < (cases == nullptr ? 40 : std::atoi(cases)); ++i) {
    const Vector3d at(uniform(-1e3, 1e3), uniform(-1e3, 1e3), uniform(-1e3, 1e3));
    const Vector3d size(uniform(1, 9), uniform(1, 9), uniform(1, 9));
    json cuts = json::array();
    for (int k = 0; k < 3; ++k) {
      cuts.push_back(joint_set(uniform(0, 90), uniform(0, 360), at, uniform(0.7, 3)));
      cuts.back()["scatter_deg"] = 5;
      cuts.back()["spacing_scatter"] = 0.2;
      cuts.back()["seed"] = i;
    }
    const json cut = {{"body", box(at, at + size)}, {"cuts", cuts}};
    const CutBody body = cut_body(cut, "/cut");
    CAPTURE(cut.dump());
    const double surface = size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
    const double rounding = 16 * 0x1p-52 * 1e3 * 2 * surface / size.prod();
    CHECK_THAT(volume(body), WithinRel(size.prod(), 1e-12 + 40 * rounding));
    const CutBody again = cut_body(cut, "/cut");
    REQUIRE(again.cells.size() == body.cells.size());
    for (std::size_t c = 0; c < body.cells.size(); ++c)
      CHECK(again.cells[c].shape.vertices() == body.cells[c].shape.vertices());
    if (body.cells.size() < 2) continue;
    const auto nearest =
        quoin::geometry::nearest_features(body.cells[0].shape, body.cells[1].shape);
    CHECK(nearest.gap >= -1e-10);
  }
}

TEST_CASE("what cannot be cut is refused with its place") {
  json many = joint_set(0, 0, {0, 0, 0}, 1e-9);
  const json cut = {{"body", box({0, 0, 0}, {1, 1, 1})}, {"cuts", {many}}};
  CHECK_THROWS_WITH(cut_body(cut, "/cut"), ContainsSubstring("/cut/cuts/0") &&
                                               ContainsSubstring("at most 100000 are cut"));
}
