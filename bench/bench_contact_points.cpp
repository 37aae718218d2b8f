/// W4: one block on another in running bond, the whole manifold (all points, type, areas, gap).

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "harness.hpp"
#include "peer.hpp"

namespace quoin::bench {
namespace {

constexpr const char* kYardstick = "ODE dBoxBox";

/// Area of the convex hull of points that lie in a plane with the given normal, m2.
double hull_area(const std::vector<ManifoldPoint>& points, const Vector3& normal) {
  const Vector3 u = normal.unitOrthogonal(), v = normal.cross(u);
  std::vector<Eigen::Vector2d> flat;
  for (const ManifoldPoint& p : points) flat.emplace_back(p.place.dot(u), p.place.dot(v));
  std::sort(flat.begin(), flat.end(), [](const auto& p, const auto& q) {
    return p.x() != q.x() ? p.x() < q.x() : p.y() < q.y();
  });
  const auto turn = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                       const Eigen::Vector2d& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
  };
  std::vector<Eigen::Vector2d> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t first = hull.size();
    for (const auto& p : flat) {
      while (hull.size() >= first + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0)
        hull.pop_back();
      hull.push_back(p);
    }
    if (!hull.empty()) hull.pop_back();
    std::reverse(flat.begin(), flat.end());
  }
  double twice = 0.0;
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const auto &p = hull[k], &q = hull[(k + 1) % hull.size()];
    twice += p.x() * q.y() - p.y() * q.x();
  }
  return 0.5 * twice;
}

struct Verdict {
  std::vector<int> right;
  int none = 0, area = 0, gap = 0;  ///< wrong by: no point, lost or gained area, gap
  std::vector<double> errors;  ///< of the area spanned by the points, as a share of the true one
};

/// Wrong: no point at all, an area off by more than 1 %, or the least gap, or one of the others
/// beyond what the faces lean, off by more than the allowance of Workload.
Verdict judge(ManifoldPeer& peer, const Workload& workload) {
  constexpr double kAreaShare = 0.01;
  Verdict verdict;
  std::vector<ManifoldPoint> points;
  for (std::size_t k = 0; k < workload.pairs.size(); ++k) {
    const Pair& pair = workload.pairs[k];
    points.clear();
    try {
      peer.ask(static_cast<int>(k), points);
    } catch (const std::exception&) {
      // gave up: no points
    }
    double gap_error = 0.0, least = std::numeric_limits<double>::infinity();
    for (const ManifoldPoint& p : points) {
      gap_error = std::max(gap_error, p.gap - pair.gap[0] - pair.rise);
      least = std::min(least, p.gap);
    }
    gap_error = std::max(gap_error, std::abs(least - pair.gap[0]));
    const double spanned = hull_area(points, pair.poses_a[0].rotation.col(2));
    const double area_error = std::abs(spanned - pair.area) / pair.area;
    verdict.errors.push_back(points.empty() ? 1.0 : area_error);
    if (points.empty())
      ++verdict.none;
    else if (!(area_error <= kAreaShare))
      ++verdict.area;
    else if (!(gap_error <= workload.allowed_error(pair, 0)))
      ++verdict.gap;
    else
      verdict.right.push_back(static_cast<int>(k));
  }
  return verdict;
}

Entry make_entry(ManifoldPeer& peer, const std::string& name, const Workload& workload) {
  peer.load(workload);
  const Verdict verdict = judge(peer, workload);
  Entry entry{.workload = name, .peer = peer.name()};
  entry.pairs = static_cast<int>(workload.pairs.size());
  entry.wrong = entry.pairs - static_cast<int>(verdict.right.size());
  entry.error_median = median(verdict.errors);
  entry.error_max = quantile(verdict.errors, 1.0);
  if (entry.wrong > 0) {
    entry.note = "none " + std::to_string(verdict.none) + ", area " + std::to_string(verdict.area) +
                 ", gap " + std::to_string(verdict.gap);
  }
  // A peer that never has the whole manifold is timed on what it does instead, and marked.
  std::vector<int> timed = verdict.right;
  if (timed.empty()) {
    timed.resize(workload.pairs.size());
    std::iota(timed.begin(), timed.end(), 0);
    entry.note += "; timed on wrong answers";
  }
  entry.queries = static_cast<double>(timed.size());
  entry.pass = [&peer, timed] {
    const double start = thread_seconds();
    benchmark::DoNotOptimize(peer.ask_all(timed));
    return thread_seconds() - start;
  };
  return entry;
}

std::vector<Entry> run_workload(const std::string& name, const Arguments& arguments) {
  const Workload workload = make_workload(name, {arguments.quick ? 0.125 : 1.0, 1});
  ManifoldPeers peers;
  append_quoin(peers);
  append_plugins(peers);
  std::vector<Entry> entries =
      entries_of(peers, name, workload, arguments,
                 [&](ManifoldPeer& peer) { return make_entry(peer, name, workload); });
  if (entries.empty() || !arguments.count.empty()) return entries;
  // The yardstick of all of W4: ODE on the overlapping boxes, timed in the same group.
  const Workload boxes = make_workload("W4/box-overlap", {arguments.quick ? 0.125 : 1.0, 1});
  const auto yardstick = std::ranges::find(peers, kYardstick, &ManifoldPeer::name);
  if (yardstick != peers.end() && !(*yardstick)->answers(workload)) {
    entries.push_back(make_entry(**yardstick, name, boxes));
    entries.back().note = "on W4/box-overlap";
  }
  run_group(entries, arguments.harness);
  return entries;
}

}  // namespace
}  // namespace quoin::bench

int main(int argc, char** argv) {
  using namespace quoin::bench;
  return run_contests(
      argc, argv,
      contests_of(
          manifold_workload_names(), [](const auto&) { return kYardstick; }, run_workload));
}
