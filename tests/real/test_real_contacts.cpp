/// The face contacts of an assembly that other authors solved (not part of the repository): the
/// barrel vault in the folder QUOIN_REAL_DATA, whose results list a polygon and its area for each.

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <quoin/geometry/contact_finder.hpp>

#include "scene_file/mesh_file.hpp"
#include "support/catch.hpp"
#include "support/real_data.hpp"

using namespace quoin;
using namespace quoin::tests;

namespace {

using geometry::Vector3;
using Names = std::pair<int, int>;

struct FaceContact {
  double area = 0.0;  // m2
  std::vector<Vector3> corners{};
};

Vector3 place_of(const nlohmann::json& point) {
  const nlohmann::json& x = point["data"];
  return {x[0].get<double>(), x[1].get<double>(), x[2].get<double>()};
}

/// The contacts that the file lists, by their blocks' places in it.
std::map<Names, FaceContact> listed_contacts(const std::string& path) {
  std::ifstream file(path);
  const nlohmann::json graph = nlohmann::json::parse(file)["data"]["model"]["data"]["graph"];
  std::map<Names, FaceContact> contacts;
  for (const auto& [from, edges] : graph["edge"].items()) {
    for (const auto& [to, edge] : edges.items()) {
      const int a = std::stoi(from), b = std::stoi(to);
      for (const nlohmann::json& contact : edge["contacts"]) {
        FaceContact& made = contacts[{std::min(a, b), std::max(a, b)}];
        made.area += contact["data"]["size"].get<double>();
        for (const nlohmann::json& point : contact["data"]["points"])
          made.corners.push_back(place_of(point));
      }
    }
  }
  return contacts;
}

double distance_to(const std::vector<Vector3>& places, const Vector3& x) {
  double least = HUGE_VAL;
  for (const Vector3& place : places) least = std::min(least, (place - x).norm());
  return least;
}

/// The farthest corner of one from all corners of the other, m.
double corners_apart(const std::vector<Vector3>& ours, const std::vector<Vector3>& theirs) {
  double most = 0.0;
  for (const Vector3& x : ours) most = std::max(most, distance_to(theirs, x));
  for (const Vector3& x : theirs) most = std::max(most, distance_to(ours, x));
  return most;
}

/// The face contacts of the blocks as they stand, and the pairs in contact in another way.
std::map<Names, FaceContact> found_contacts(const std::vector<scene_file::MeshBlock>& blocks,
                                            std::vector<Names>& others) {
  geometry::ContactFinder finder({});
  for (const scene_file::MeshBlock& block : blocks)
    finder.add(std::make_shared<const geometry::Shape>(convex_block(block, -1.0)));
  std::vector<geometry::ContactPoint> points;
  finder.find(points);
  std::map<Names, FaceContact> contacts;
  for (const geometry::PairResult& pair : finder.pairs()) {
    if (pair.type != geometry::ContactType::FaceFace) {
      others.emplace_back(pair.a, pair.b);
      continue;
    }
    geometry::PairContact contact;
    update_pair_contact(finder.body(pair.a), finder.body(pair.b), {}, contact);
    CHECK_THAT(contact.area, WithinRel(pair.area, 1e-12));
    contacts[{pair.a, pair.b}] = {pair.area, contact.polygon};
  }
  return contacts;
}

}  // namespace

TEST_CASE("the barrel vault's face contacts are those of its results") {
  const std::string folder = real_data();
  if (folder.empty()) return;
  const auto blocks = scene_file::read_mesh_file(folder + "/barrel_vault_DEM_model.json",
                                                 scene_file::MeshFormat::Compas);
  const auto listed = listed_contacts(folder + "/barrel_vault_DEM_results.json");
  REQUIRE(blocks.size() == 121);
  REQUIRE(listed.size() == 320);
  std::vector<Names> others;
  const auto found = found_contacts(blocks, others);
  CHECK(others.empty());
  REQUIRE(found.size() == listed.size());
  double most_area = 0.0, most_apart = 0.0;
  for (const auto& [names, theirs] : listed) {
    INFO("blocks " << names.first << " and " << names.second);
    REQUIRE(found.contains(names));
    const FaceContact& ours = found.at(names);
    CHECK(ours.corners.size() == theirs.corners.size());
    most_area = std::max(most_area, std::abs(ours.area - theirs.area) / theirs.area);
    most_apart = std::max(most_apart, corners_apart(ours.corners, theirs.corners));
  }
  std::printf("%zu face contacts; off by at most %.1e of the area, corners %.1e m\n", found.size(),
              most_area, most_apart);
  CHECK(most_area <= 1e-12);
  CHECK(most_apart <= 1e-12);
}
