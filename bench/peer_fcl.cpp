/// FCL's narrow phase, asked straight at its solvers: no dispatch, no objects in between.

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/narrowphase/detail/gjk_solver_indep.h>
#include <fcl/narrowphase/detail/gjk_solver_libccd.h>

#include <cmath>

#include "peer.hpp"

namespace quoin::bench {
namespace {

using LibccdSolver = fcl::detail::GJKSolver_libccd<double>;
using IndepSolver = fcl::detail::GJKSolver_indep<double>;

fcl::Convexd convex(const BenchShape& shape) {
  auto vertices = std::make_shared<std::vector<Vector3>>();
  for (int v = 0; v < shape.vertices.cols(); ++v) vertices->push_back(shape.vertices.col(v));
  auto faces = std::make_shared<std::vector<int>>();
  for (int f = 0; f < shape.topology->face_count(); ++f) {
    const auto face = shape.topology->face(f);
    faces->push_back(static_cast<int>(face.size()));
    faces->insert(faces->end(), face.begin(), face.end());
  }
  return fcl::Convexd(vertices, shape.topology->face_count(), faces, false);
}

fcl::Transform3d transform(const Pose& pose) {
  fcl::Transform3d t = fcl::Transform3d::Identity();
  t.linear() = pose.rotation;
  t.translation() = pose.place;
  return t;
}

template <class Geometry>
bool can_hold(const Workload& workload) {
  return std::is_same_v<Geometry, fcl::Convexd> || workload.boxes_only();
}

template <class Geometry>
class FclPairs : public Placed<Geometry, fcl::Transform3d> {
 public:
  FclPairs() : Placed<Geometry, fcl::Transform3d>(transform) {}
  void load(const Workload& workload) {
    Placed<Geometry, fcl::Transform3d>::load(workload, [](const BenchShape& shape) {
      if constexpr (std::is_same_v<Geometry, fcl::Boxd>)
        return std::make_unique<fcl::Boxd>(Vector3(2 * shape.half_size));
      else
        return std::make_unique<fcl::Convexd>(convex(shape));
    });
  }
};

/// Distance of separated pairs, depth of overlapping ones.
template <class Geometry, class Solver>
class Fcl final : public PeerOf<Fcl<Geometry, Solver>> {
 public:
  Fcl(std::string name, const Solver& solver, bool remember = false)
      : PeerOf<Fcl>(std::move(name)), solver_(solver), remember_(remember) {}
  bool answers(const Workload& workload) const override {
    return can_hold<Geometry>(workload) && (!remember_ || workload.warm);
  }
  void load(const Workload& workload) override {
    placed_.load(workload);
    overlap_ = workload.overlap;
    guesses_.assign(placed_.pair_count(), Vector3::UnitX());
  }
  void place(int step) override { placed_.place(step); }
  void forget() override { guesses_.assign(guesses_.size(), Vector3::UnitX()); }
  Answer query(int p) { return overlap_ ? depth(p) : distance(p); }

 private:
  Answer distance(int p) {
    Answer answer;
    if constexpr (std::is_same_v<Solver, IndepSolver>) {
      if (remember_) solver_.cached_guess = guesses_[static_cast<std::size_t>(p)];
    }
    const bool apart =
        solver_.shapeDistance(placed_.a(p), placed_.pose_a(p), placed_.b(p), placed_.pose_b(p),
                              &answer.gap, &answer.point_a, &answer.point_b);
    if constexpr (std::is_same_v<Solver, IndepSolver>) {
      if (remember_) guesses_[static_cast<std::size_t>(p)] = solver_.cached_guess;
    }
    if (!apart) answer.gap = 0.0;
    answer.normal = answer.point_b - answer.point_a;
    return answer;
  }
  Answer depth(int p) {
    contacts_.clear();
    const bool touch = solver_.shapeIntersect(placed_.a(p), placed_.pose_a(p), placed_.b(p),
                                              placed_.pose_b(p), &contacts_);
    if (!touch || contacts_.empty()) return {};
    Answer answer;
    for (const auto& contact : contacts_)  // the indep solver's depth has the other sign
      answer.gap = std::min(answer.gap, -std::abs(contact.penetration_depth));
    answer.normal = contacts_[0].normal;
    answer.point_a = answer.point_b = contacts_[0].pos;
    return answer;
  }

  Solver solver_;
  bool remember_, overlap_ = false;
  FclPairs<Geometry> placed_;
  std::vector<Vector3> guesses_;
  std::vector<fcl::ContactPointd> contacts_;
};

template <class Geometry>
class FclManifold final : public ManifoldPeer {
 public:
  using ManifoldPeer::ManifoldPeer;
  bool answers(const Workload& workload) const override { return can_hold<Geometry>(workload); }
  void load(const Workload& workload) override { placed_.load(workload); }
  void ask(int pair, std::vector<ManifoldPoint>& points) override {
    find(pair);
    points.clear();
    for (const auto& c : contacts_) points.push_back({c.pos, -c.penetration_depth});
  }
  double ask_all(std::span<const int> pairs) override {
    double sum = 0.0;
    for (const int pair : pairs) {
      find(pair);
      sum += contacts_.empty() ? 0.0 : contacts_[0].penetration_depth;
    }
    return sum;
  }

 private:
  void find(int p) {
    contacts_.clear();
    solver_.shapeIntersect(placed_.a(p), placed_.pose_a(p), placed_.b(p), placed_.pose_b(p),
                           &contacts_);
  }
  LibccdSolver solver_;
  FclPairs<Geometry> placed_;
  std::vector<fcl::ContactPointd> contacts_;
};

template <class Geometry, class Solver>
void append(Peers& peers, const std::string& name, const Solver& solver, bool remember = false) {
  peers.push_back(std::make_unique<Fcl<Geometry, Solver>>(name, solver, remember));
}

std::string power(int exponent) { return "1e" + std::to_string(exponent); }

}  // namespace

void append_fcl(Peers& peers, bool settings) {
  append<fcl::Convexd>(peers, "FCL libccd Convex", LibccdSolver{});
  append<fcl::Boxd>(peers, "FCL libccd Box", LibccdSolver{});
  append<fcl::Convexd>(peers, "FCL indep Convex", IndepSolver{});
  IndepSolver remembering;
  remembering.enable_cached_guess = true;
  append<fcl::Convexd>(peers, "FCL indep Convex warm", remembering, true);
  if (!settings) return;
  for (const int exponent : {-2, -4, -9, -12}) {
    LibccdSolver libccd;
    libccd.distance_tolerance = libccd.collision_tolerance = std::pow(10.0, exponent);
    append<fcl::Convexd>(peers, "FCL libccd Convex " + power(exponent), libccd);
    IndepSolver indep;
    indep.gjk_tolerance = indep.epa_tolerance = std::pow(10.0, exponent);
    append<fcl::Convexd>(peers, "FCL indep Convex " + power(exponent), indep);
  }
}

void append_fcl(ManifoldPeers& peers) {
  peers.push_back(std::make_unique<FclManifold<fcl::Boxd>>("FCL Box"));
  peers.push_back(std::make_unique<FclManifold<fcl::Convexd>>("FCL libccd Convex"));
}

}  // namespace quoin::bench
