#pragma once
/// `cut`: a body of convex cells parted by joint planes into blocks.

#include <nlohmann/json_fwd.hpp>
#include <quoin/geometry/shape.hpp>
#include <string>
#include <vector>

namespace quoin::scene_file {

/// One block of a cut body.
struct CutCell {
  geometry::Shape shape;           ///< in the world frame, m
  std::vector<int> face_joints{};  ///< of each face: its entry of CutBody::joints, -1: the surface
  std::string region{};            ///< name of the excavation that it lies in; empty: none
};

struct CutBody {
  std::vector<CutCell> cells{};
  std::vector<std::string> joints{};  ///< names of the joint sets, planes, discs and excavations
  double volume = 0.0;                ///< m3, of the body before it was cut
  std::vector<std::string> notes{};   ///< joint sets and discs that cut no block
};

/// Cuts the body of `cut` (an object as scene.schema.json has it) by its `cuts`, in order.
///
/// Frame: x east, y north, z up. A plane of dip d and dip direction a (clockwise from north) has
/// the upward normal (sin d sin a, sin d cos a, cos d). Two blocks on either side of a plane have
/// the same doubles on it; volumes sum to the body's within 1e-12 of it for each cut.
/// Throws SceneError with the place below `pointer`.
CutBody cut_body(const nlohmann::json& cut, const std::string& pointer);

/// Puts blocks behind /blocks of a checked scene in place of /cut, of which `body` came: one a
/// cell, named NAME0, NAME1, … or REGION:NAME0 in an excavation.
void expand_cut(nlohmann::json& scene, const CutBody& body);

/// The same, where a scene has /cut: its CutBody::notes. Throws SceneError.
std::vector<std::string> expand_cut(nlohmann::json& scene);

}  // namespace quoin::scene_file
