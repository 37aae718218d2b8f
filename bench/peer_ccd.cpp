/// libccd: GJK/EPA and MPR depth of overlapping pairs. It has no distance of its own.

#include <ccd/ccd.h>

#include <cmath>

#include "peer.hpp"

namespace quoin::bench {
namespace {

/// A solid as libccd's support function sees it: vertices in the world frame.
struct Solid {
  Points vertices;
  Vector3 centre = Vector3::Zero();
};

void support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* result) {
  const auto& vertices = static_cast<const Solid*>(object)->vertices;
  const Vector3 d(direction->v[0], direction->v[1], direction->v[2]);
  Eigen::Index best = 0;
  double greatest = -HUGE_VAL;
  for (Eigen::Index v = 0; v < vertices.cols(); ++v) {
    const double value = vertices.col(v).dot(d);
    if (value > greatest) {
      greatest = value;
      best = v;
    }
  }
  ccdVec3Set(result, vertices(0, best), vertices(1, best), vertices(2, best));
}

void centre(const void* object, ccd_vec3_t* result) {
  const Vector3& c = static_cast<const Solid*>(object)->centre;
  ccdVec3Set(result, c.x(), c.y(), c.z());
}

enum class Method { Epa, Mpr };

class Ccd final : public PeerOf<Ccd> {
 public:
  Ccd(std::string name, Method method, double tolerance)
      : PeerOf(std::move(name)), method_(method) {
    CCD_INIT(&ccd_);
    ccd_.support1 = ccd_.support2 = support;
    ccd_.center1 = ccd_.center2 = centre;
    ccd_.max_iterations = 500;
    ccd_.epa_tolerance = ccd_.mpr_tolerance = tolerance;
  }
  bool answers(const Workload& workload) const override { return workload.overlap; }
  void load(const Workload& workload) override {
    workload_ = &workload;
    solids_.resize(2 * workload.pairs.size());
    place(0);
  }
  void place(int step) override {
    const auto s = static_cast<std::size_t>(step);
    for (std::size_t k = 0; k < workload_->pairs.size(); ++k) {
      const Pair& pair = workload_->pairs[k];
      set(solids_[2 * k], pair.shape_a, pair.poses_a[s]);
      set(solids_[2 * k + 1], pair.shape_b, pair.poses_b[s]);
    }
  }
  Answer query(int pair) {
    const auto k = 2 * static_cast<std::size_t>(pair);
    double depth = 0.0;
    ccd_vec3_t normal{}, place{};
    const int failed =
        method_ == Method::Epa
            ? ccdGJKPenetration(&solids_[k], &solids_[k + 1], &ccd_, &depth, &normal, &place)
            : ccdMPRPenetration(&solids_[k], &solids_[k + 1], &ccd_, &depth, &normal, &place);
    if (failed != 0) return {};
    const Vector3 point(place.v[0], place.v[1], place.v[2]);
    return {-depth, {normal.v[0], normal.v[1], normal.v[2]}, point, point};
  }

 private:
  void set(Solid& solid, int shape, const Pose& pose) {
    solid.vertices = pose.apply(workload_->shapes[static_cast<std::size_t>(shape)].vertices);
    solid.centre = solid.vertices.rowwise().mean();
  }
  ccd_t ccd_{};
  Method method_;
  const Workload* workload_ = nullptr;
  std::vector<Solid> solids_;
};

}  // namespace

void append_ccd(Peers& peers, bool settings) {
  peers.push_back(std::make_unique<Ccd>("libccd EPA 1e-12", Method::Epa, 1e-12));
  peers.push_back(std::make_unique<Ccd>("libccd EPA", Method::Epa, 1e-4));
  peers.push_back(std::make_unique<Ccd>("libccd MPR", Method::Mpr, 1e-4));
  if (!settings) return;
  for (const int exponent : {-6, -8, -10}) {
    const std::string power = "1e" + std::to_string(exponent);
    const double tolerance = std::pow(10.0, exponent);
    peers.push_back(std::make_unique<Ccd>("libccd EPA " + power, Method::Epa, tolerance));
    peers.push_back(std::make_unique<Ccd>("libccd MPR " + power, Method::Mpr, tolerance));
  }
}

}  // namespace quoin::bench
