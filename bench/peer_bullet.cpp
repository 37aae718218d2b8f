/// Bullet in double precision, margins zero: GJK pair detector, its EPA, box-box, face clipping.

#include <BulletCollision/CollisionDispatch/btBoxBoxDetector.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btPolyhedralContactClipping.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include <limits>

#include "peer.hpp"

namespace quoin::bench {
namespace {

btVector3 to_bullet(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
Vector3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

btTransform transform(const Pose& pose) {
  const Matrix3& r = pose.rotation;
  return btTransform(
      btMatrix3x3(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)),
      to_bullet(pose.place));
}

std::unique_ptr<btConvexHullShape> hull_shape(const BenchShape& shape, bool features) {
  auto hull = std::make_unique<btConvexHullShape>();
  for (int v = 0; v < shape.vertices.cols(); ++v)
    hull->addPoint(to_bullet(shape.vertices.col(v)), false);
  hull->recalcLocalAabb();
  hull->setMargin(0);
  if (features) hull->initializePolyhedralFeatures();
  return hull;
}

std::unique_ptr<btBoxShape> box_shape_of(const BenchShape& shape) {
  auto box = std::make_unique<btBoxShape>(to_bullet(shape.half_size));
  box->setMargin(0);
  return box;
}

class BulletPairs : public Placed<btPolyhedralConvexShape, btTransform> {
 public:
  BulletPairs() : Placed(transform) {}
  void load(const Workload& workload, bool boxes, bool features) {
    Placed::load(workload,
                 [=](const BenchShape& shape) -> std::unique_ptr<btPolyhedralConvexShape> {
                   if (boxes) return box_shape_of(shape);
                   return hull_shape(shape, features);
                 });
  }
};

enum class Method { GjkPair, GjkEpa2 };

class Bullet final : public PeerOf<Bullet> {
 public:
  Bullet(std::string name, Method method, bool boxes, bool remember)
      : PeerOf(std::move(name)), method_(method), boxes_(boxes), remember_(remember) {}
  bool answers(const Workload& workload) const override {
    return (!boxes_ || workload.boxes_only()) && (!remember_ || workload.warm);
  }
  void load(const Workload& workload) override {
    overlap_ = workload.overlap;
    placed_.load(workload, boxes_, false);
    forget();
  }
  void place(int step) override { placed_.place(step); }
  void forget() override { axes_.assign(placed_.pair_count(), btVector3(0, 1, 0)); }
  Answer query(int p) { return method_ == Method::GjkPair ? gjk_pair(p) : gjk_epa2(p); }

 private:
  Answer gjk_pair(int p) {
    btGjkPairDetector detector(&placed_.a(p), &placed_.b(p), &simplex_, &depth_solver_);
    if (remember_) detector.setCachedSeparatingAxis(axes_[static_cast<std::size_t>(p)]);
    btGjkPairDetector::ClosestPointInput input;
    input.m_transformA = placed_.pose_a(p);
    input.m_transformB = placed_.pose_b(p);
    btPointCollector collector;
    detector.getClosestPointsNonVirtual(input, collector, nullptr);
    if (remember_) axes_[static_cast<std::size_t>(p)] = detector.getCachedSeparatingAxis();
    if (!collector.m_hasResult) return {std::numeric_limits<double>::quiet_NaN()};
    const Vector3 normal = from_bullet(collector.m_normalOnBInWorld);
    const Vector3 on_b = from_bullet(collector.m_pointInWorld);
    return {collector.m_distance, -normal, on_b + collector.m_distance * normal, on_b};
  }
  Answer gjk_epa2(int p) {
    btGjkEpaSolver2::sResults results;
    const btVector3 guess = placed_.pose_b(p).getOrigin() - placed_.pose_a(p).getOrigin();
    const bool found =
        overlap_ ? btGjkEpaSolver2::Penetration(&placed_.a(p), placed_.pose_a(p), &placed_.b(p),
                                                placed_.pose_b(p), guess, results, false)
                 : btGjkEpaSolver2::Distance(&placed_.a(p), placed_.pose_a(p), &placed_.b(p),
                                             placed_.pose_b(p), guess, results);
    if (!found) return {};
    return {results.distance, from_bullet(results.normal), from_bullet(results.witnesses[0]),
            from_bullet(results.witnesses[1])};
  }

  Method method_;
  bool boxes_, remember_, overlap_ = false;
  BulletPairs placed_;
  btVoronoiSimplexSolver simplex_;
  btGjkEpaPenetrationDepthSolver depth_solver_;
  std::vector<btVector3> axes_;
};

/// Collects every point without reducing them to four.
struct AllPoints final : btDiscreteCollisionDetectorInterface::Result {
  struct Point {
    btVector3 on_b;
    btScalar depth;
  };
  std::vector<Point> points;
  void setShapeIdentifiersA(int, int) override {}
  void setShapeIdentifiersB(int, int) override {}
  void addContactPoint(const btVector3&, const btVector3& on_b, btScalar depth) override {
    points.push_back({on_b, depth});
  }
};

class BulletManifold final : public ManifoldPeer {
 public:
  BulletManifold(std::string name, bool boxes) : ManifoldPeer(std::move(name)), boxes_(boxes) {}
  bool answers(const Workload& workload) const override { return !boxes_ || workload.boxes_only(); }
  void load(const Workload& workload) override { placed_.load(workload, boxes_, !boxes_); }
  void ask(int pair, std::vector<ManifoldPoint>& points) override {
    find(pair);
    points.clear();
    for (const auto& p : found_.points) points.push_back({from_bullet(p.on_b), p.depth});
  }
  double ask_all(std::span<const int> pairs) override {
    double sum = 0.0;
    for (const int pair : pairs) {
      find(pair);
      sum += found_.points.empty() ? 0.0 : found_.points[0].depth;
    }
    return sum;
  }

 private:
  void find(int p) {
    found_.points.clear();
    if (boxes_) {
      btBoxBoxDetector detector(static_cast<const btBoxShape*>(&placed_.a(p)),
                                static_cast<const btBoxShape*>(&placed_.b(p)));
      btDiscreteCollisionDetectorInterface::ClosestPointInput input;
      input.m_transformA = placed_.pose_a(p);
      input.m_transformB = placed_.pose_b(p);
      detector.getClosestPoints(input, found_, nullptr);
      return;
    }
    const btConvexPolyhedron& a = *placed_.a(p).getConvexPolyhedron();
    const btConvexPolyhedron& b = *placed_.b(p).getConvexPolyhedron();
    btVector3 axis;
    const bool overlap = btPolyhedralContactClipping::findSeparatingAxis(
        a, b, placed_.pose_a(p), placed_.pose_b(p), axis, found_);
    if (!overlap) return;
    btPolyhedralContactClipping::clipHullAgainstHull(axis, a, b, placed_.pose_a(p),
                                                     placed_.pose_b(p), -1.0, 0.01, vertices_1_,
                                                     vertices_2_, found_);
  }
  bool boxes_;
  BulletPairs placed_;
  AllPoints found_;
  btVertexArray vertices_1_, vertices_2_;
};

}  // namespace

void append_bullet(Peers& peers, bool) {
  peers.push_back(std::make_unique<Bullet>("Bullet GjkPair", Method::GjkPair, false, false));
  peers.push_back(std::make_unique<Bullet>("Bullet GjkPair Box", Method::GjkPair, true, false));
  peers.push_back(std::make_unique<Bullet>("Bullet GjkPair warm", Method::GjkPair, false, true));
  peers.push_back(std::make_unique<Bullet>("Bullet GjkEpa2", Method::GjkEpa2, false, false));
}

void append_bullet(ManifoldPeers& peers) {
  peers.push_back(std::make_unique<BulletManifold>("Bullet box-box", true));
  peers.push_back(std::make_unique<BulletManifold>("Bullet clipping", false));
}

}  // namespace quoin::bench
