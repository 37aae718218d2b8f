#include "step/missed_contacts.hpp"

#include <algorithm>
#include <limits>

#include "base/index.hpp"
#include "contact/joint_springs.hpp"
#include "step/contact_search.hpp"
#include "step/sorted_by_key.hpp"

namespace quoin::solver {
namespace {

// Of the smaller block of a pair.
constexpr double kMissed = 1e-9;  // an overlap that is none

using Pair = std::pair<int, int>;

/// As a body holds it at the end, where blocks have met that were not laid.
BodyContact missed_contact(const CompiledScene& compiled, const StepPoses& poses,
                           std::span<const geometry::ContactPoint> found,
                           const geometry::ContactPoint& point) {
  BodyContact added = make_body_contact({compiled.scene, compiled.models, poses.end}, point);
  added.state.failed = true;
  const auto points = points_of_pair(found, added.a, added.b);
  double area = 0.0;
  for (const geometry::ContactPoint& p : points) area += p.area;
  added.penalty_share = shared_penalty(points.size(), point.area, area);
  if (added.joint->normal_stiffness > 0.0) {
    const std::size_t a = index(added.a), b = index(added.b);
    const BlockModel &model_a = compiled.models[a], &model_b = compiled.models[b];
    const JointBlocks blocks{model_a, model_b, poses.end[a], poses.end[b]};
    set_spring_areas(blocks, joint_polygon(blocks, added), std::span(&added, 1));
    begin_spring({model_a, model_b, poses.start[a], poses.start[b]}, added);
  }
  return added;
}

/// What the attempt knew, sorted.
struct Known {
  std::vector<std::pair<geometry::ContactKey, std::size_t>> keys;  ///< and which contact
  std::vector<Pair> soft;      ///< pairs that a closed spring holds, but not exactly
  std::vector<Pair> yielding;  ///< pairs that a closed contact holds, nearly
};

Known known_contacts(const Island& island) {
  Known known;
  for (std::size_t i = 0; i < island.contacts.size(); ++i) {
    const BodyContact& contact = island.contacts[i];
    const SolvedContact& c = island.attempt.positions[i];
    known.keys.emplace_back(contact.state.point.key, i);
    if (c.mode == ContactMode::Open) continue;
    if (c.compliant) known.soft.emplace_back(contact.a, contact.b);
    const ContactSolver& solver = island.memory.solver;
    if (solver.yielding() || solver.inexact()) known.yielding.emplace_back(contact.a, contact.b);
  }
  std::ranges::sort(known.keys);
  std::ranges::sort(known.soft);
  std::ranges::sort(known.yielding);
  return known;
}

constexpr std::size_t kUnknown = std::numeric_limits<std::size_t>::max();

/// The contact of the attempt with this key.
std::size_t known_contact(const Known& known, const geometry::ContactKey& key) {
  const auto at =
      std::ranges::lower_bound(known.keys, key, {}, [](const auto& k) { return k.first; });
  return at != known.keys.end() && at->first == key ? at->second : kUnknown;
}

/// Whether the features of a contact overlap by `most` (m) more than its place and normal have it:
/// of edges that were nearly parallel where it was found, and have turned, or a face that strain
/// has tilted. A spring keeps its overlap, which is another along another normal.
bool has_turned(const BodyContact& contact, const SolvedContact& solved, std::span<const Pose> end,
                const geometry::ContactPoint& point, double most) {
  if (solved.compliant) return false;
  const double gap = contact_geometry(contact, end[index(contact.a)], end[index(contact.b)]).gap;
  return point.gap < gap - most;
}

/// The same contact, held where and as it stands at the end. A closed one keeps its anchors: its
/// slip is that of the whole step.
BodyContact turned(const BodyContact& contact, const BodyContact& at_end) {
  BodyContact result = at_end;
  result.state = contact.state;
  result.state.point = at_end.state.point;
  if (!contact.was_closed) {
    result.state.anchor_a = at_end.state.anchor_a;
    result.state.anchor_b = at_end.state.anchor_b;
  }
  result.laid = contact.laid;
  result.was_closed = contact.was_closed;
  return result;
}

/// Does the attempt hold what is there as well as it holds anything?
bool holds(const Known& known, const geometry::ContactPoint& point, double most) {
  const Pair pair(point.key.a, point.key.b);
  return std::ranges::binary_search(known.soft, pair) ||
         (point.gap > -most && std::ranges::binary_search(known.yielding, pair));
}

}  // namespace

double overlap_limit(double size) { return kMissed * size; }

bool add_missed(const CompiledScene& compiled, const StepPoses& poses, double tolerance,
                Island& island) {
  const std::vector<Pose>& end = poses.end;
  const auto overlaps = [&](const geometry::ContactPoint& point) {
    return point.gap < -overlap_limit(pair_size(compiled, point.key.a, point.key.b));
  };
  if (std::ranges::none_of(island.found_end, overlaps)) return false;
  const Known known = known_contacts(island);
  const std::vector<SolvedContact>& positions = island.attempt.positions;
  bool any = false;
  for (const geometry::ContactPoint& point : island.found_end) {
    if (!overlaps(point)) continue;
    const double most = tolerance * pair_size(compiled, point.key.a, point.key.b);
    const std::size_t i = known_contact(known, point.key);
    const bool held = i == kUnknown
                          ? holds(known, point, most)
                          : !has_turned(island.contacts[i], positions[i], end, point, most);
    if (held) continue;
    island.missing = point;
    any = true;
    const BodyContact missed = missed_contact(compiled, poses, island.found_end, point);
    if (i == kUnknown)
      island.contacts.push_back(missed);
    else
      island.contacts[i] = turned(island.contacts[i], missed);
  }
  return any;
}

}  // namespace quoin::solver
