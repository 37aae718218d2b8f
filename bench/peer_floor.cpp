/// Not a peer but a floor: the normal is known beforehand and only the certificate is formed again
/// – how far either solid reaches along it. No search, no features, no witnesses.

#include <algorithm>
#include <limits>
#include <quoin/geometry/nearest_features.hpp>

#if defined(__x86_64__)
#include <immintrin.h>
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // of gcc 12's own header, its bug 105593
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif

#include "peer.hpp"

namespace quoin::bench {
namespace {

/// Coordinates of one solid, rows of a multiple of eight, the last vertex repeated.
struct Rows {
  std::vector<double> x, y, z;
  explicit Rows(const Points& points) {
    const auto count = static_cast<std::size_t>((points.cols() + 7) / 8 * 8);
    for (std::size_t v = 0; v < count; ++v) {
      const Eigen::Index column =
          std::min<Eigen::Index>(static_cast<Eigen::Index>(v), points.cols() - 1);
      x.push_back(points(0, column));
      y.push_back(points(1, column));
      z.push_back(points(2, column));
    }
  }
};

double plain_reach(const Rows& rows, const Vector3& n) {
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < rows.x.size(); ++v)
    most = std::max(most, rows.x[v] * n.x() + rows.y[v] * n.y() + rows.z[v] * n.z());
  return most;
}

#if defined(__x86_64__)
__attribute__((target("avx512f"))) double wide_reach(const Rows& rows, const Vector3& n) {
  const __m512d x = _mm512_set1_pd(n.x()), y = _mm512_set1_pd(n.y()), z = _mm512_set1_pd(n.z());
  __m512d most = _mm512_set1_pd(-std::numeric_limits<double>::infinity());
  for (std::size_t v = 0; v < rows.x.size(); v += 8) {
    const __m512d xy = _mm512_add_pd(_mm512_mul_pd(_mm512_loadu_pd(&rows.x[v]), x),
                                     _mm512_mul_pd(_mm512_loadu_pd(&rows.y[v]), y));
    most = _mm512_max_pd(most, _mm512_add_pd(xy, _mm512_mul_pd(_mm512_loadu_pd(&rows.z[v]), z)));
  }
  return _mm512_reduce_max_pd(most);
}
#endif

double reach(const Rows& rows, const Vector3& n) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f")) return wide_reach(rows, n);
#endif
  return plain_reach(rows, n);
}

class Floor final : public PeerOf<Floor> {
 public:
  using PeerOf::PeerOf;
  bool answers(const Workload&) const override { return true; }
  void load(const Workload& workload) override {
    workload_ = &workload;
    normals_of_step_.assign(static_cast<std::size_t>(workload.steps), {});
  }
  void place(int step) override {
    const auto s = static_cast<std::size_t>(step);
    solids_.clear();
    std::vector<Vector3>& normals = normals_of_step_[s];
    const bool known = !normals.empty();
    for (const Pair& pair : workload_->pairs) {
      const BenchShape& a = workload_->shapes[static_cast<std::size_t>(pair.shape_a)];
      const BenchShape& b = workload_->shapes[static_cast<std::size_t>(pair.shape_b)];
      const Points in_a = pair.poses_a[s].apply(a.vertices),
                   in_b = pair.poses_b[s].apply(b.vertices);
      solids_.emplace_back(in_a);
      solids_.emplace_back(in_b);
      if (known) continue;
      normals.push_back(
          nearest_features(geometry::Shape(a.topology, in_a), geometry::Shape(b.topology, in_b))
              .normal);
    }
    normals_ = normals;
  }
  Answer query(int pair) {
    const auto k = static_cast<std::size_t>(pair);
    const Vector3& n = normals_[k];
    return {-reach(solids_[2 * k + 1], -n) - reach(solids_[2 * k], n), n};
  }

 private:
  const Workload* workload_ = nullptr;
  std::vector<Rows> solids_;
  std::vector<std::vector<Vector3>> normals_of_step_;
  std::vector<Vector3> normals_;
};

}  // namespace

void append_floor(Peers& peers) {
  peers.push_back(std::make_unique<Floor>("floor: certificate alone"));
}

}  // namespace quoin::bench
