#include <cmath>
#include <limits>
#include <quoin/geometry/queries.hpp>
#include <sstream>

#include "numeric/error_bounds.hpp"
#include "numeric/numbers.hpp"
#include "search/still_apart.hpp"

namespace quoin::geometry {
namespace {

Vector3 middle_arm(const Body& body) {
  return body.placement().linear * body.shape().vertex_mean();
}

/// Does a plane clearly keep the solids more than `gap` apart: that of the hint, or across the line
/// of the middles?
bool clearly_beyond(const Body& a, const Body& b, double gap, const Vector3& hint) {
  const Vector3 between = b.placement().translation - a.placement().translation;
  const Vector3 line = hint.squaredNorm() > 0.0 ? hint : between + middle_arm(b) - middle_arm(a);
  return apart_beyond(a, b, line.normalized(), gap) > 0.0;
}

/// The planes of a body's face labels in the world: a face's plane holds all x with
/// normal · (x − place) = offset, where normal = cof(A) n is no unit vector.
class FacePlanes {
 public:
  explicit FacePlanes(const Body& body) : body_(body) {
    const Matrix3& m = body.placement().linear;
    cofactors_.col(0) = m.col(1).cross(m.col(2));
    cofactors_.col(1) = m.col(2).cross(m.col(0));
    cofactors_.col(2) = m.col(0).cross(m.col(1));
    determinant_ = m.col(0).dot(cofactors_.col(0));
  }

  int count() const { return body_.shape().topology().face_count(); }
  /// Flat to rounding: then all faces that have a normal have the same one, but for its sign.
  bool is_flat() const {
    int f = 0;
    while (f < count() && body_.shape().face_normal(f).isZero(0.0)) ++f;
    if (f == count()) return true;
    const Vector3 own = body_.shape().face_normal(f);
    const double rounding = kPointRounding * kEpsilon * body_.shape().diameter();
    return !(farthest(own) + farthest(-own) > rounding);
  }
  Vector3 normal(int f) const { return cofactors_ * body_.shape().face_normal(f); }
  double offset(int f) const { return determinant_ * farthest(body_.shape().face_normal(f)); }
  /// A point that is given from the body's translation, as seen from the place that offsets are
  /// counted from, m.
  Vector3 relative(const Vector3& arm) const {
    return arm - body_.placement().linear * body_.shape().origin();
  }
  /// Rounding of a height over a plane whose normal is a unit vector, m.
  double rounding() const {
    return kPointRounding * kEpsilon * body_.stretch() *
           (body_.shape().diameter() + body_.shape().largest_coordinate());
  }

 private:
  /// Of the vertices, from the shape's origin, along a direction in its frame, m.
  double farthest(const Vector3& own) const { return support(body_.shape(), own).value; }

  const Body& body_;
  Matrix3 cofactors_;
  double determinant_ = 0.0;
};

/// `arm`: from the body's translation.
bool within_planes(const Body& body, const Vector3& arm, double tolerance) {
  const FacePlanes planes(body);
  if (planes.is_flat()) return false;
  const Vector3 place = planes.relative(arm);
  const double limit = tolerance + planes.rounding();
  for (int f = 0; f < planes.count(); ++f) {
    const Vector3 normal = planes.normal(f);
    if (!(normal.dot(place) - planes.offset(f) <= limit * normal.norm())) return false;
  }
  return true;
}

/// Is the middle of another body inside by more than the labels of the faces are off their planes?
bool clearly_contains(const Body& body, const Body& other) {
  constexpr double kFlat =
      1e-6;  // of the diameter: the most that a face given may be off its plane
  const Vector3 between = other.placement().translation - body.placement().translation;
  return within_planes(body, between + middle_arm(other),
                       -kFlat * body.shape().diameter() * body.placement().linear.norm());
}

}  // namespace

void require_ray(const Ray& ray) {
  if (!ray.origin.allFinite() || !ray.direction.allFinite())
    throw InputError("ray: origin or direction is not finite");
  if (!(ray.direction.cwiseAbs().maxCoeff() > 0.0)) throw InputError("ray: its direction is zero");
  if (!(ray.length >= 0.0)) {
    std::ostringstream line;
    line << "ray: length is " << ray.length << " m, must not be negative";
    throw InputError(line.str());
  }
}

bool overlap(const Body& a, const Body& b, const FeatureHint& hint) {
  if (clearly_beyond(a, b, 0.0, hint.normal)) return false;
  if (clearly_contains(b, a) || clearly_contains(a, b)) return true;
  return nearest_features(a, b, {}, hint).gap <= 0.0;
}

std::optional<NearestFeatures> nearest_features_within(const Body& a, const Body& b, double cut_off,
                                                       const SearchOptions& options,
                                                       const FeatureHint& hint) {
  if (std::isnan(cut_off)) throw InputError("distance: cut_off is nan");
  require_length(options.tolerance, "tolerance");
  if (cut_off >= 0.0 && clearly_beyond(a, b, cut_off, hint.normal)) return std::nullopt;
  const NearestFeatures nearest = nearest_features(a, b, options, hint);
  if (!(nearest.gap <= cut_off)) return std::nullopt;
  return nearest;
}

/// The ray is cut by each plane in turn [Ericson 2005, section 5.3.8].
std::optional<RayHit> first_hit(const Body& body, const Ray& ray) {
  require_ray(ray);
  const Placement& stands = body.placement();
  if (!std::isfinite(stands.linear.sum() + stands.translation.sum())) return std::nullopt;
  const FacePlanes planes(body);
  if (planes.is_flat()) return std::nullopt;
  const Vector3 place = planes.relative(ray.origin - body.placement().translation);
  RayHit hit;
  double leaves = ray.length;
  for (int f = 0; f < planes.count(); ++f) {
    const Vector3 normal = planes.normal(f);
    const double below = planes.offset(f) - normal.dot(place);
    const double climb = normal.dot(ray.direction);
    if (climb == 0.0) {
      if (below < 0.0) return std::nullopt;
    } else if (climb > 0.0) {
      leaves = std::min(leaves, below / climb);
    } else if (below / climb > hit.s) {
      hit.s = below / climb;
      hit.face = f;
      hit.normal = normal.normalized();
    }
    if (!(hit.s <= leaves)) return std::nullopt;
  }
  hit.point = ray.origin + hit.s * ray.direction;
  if (!hit.point.allFinite()) return std::nullopt;  // of a direction that is hardly more than zero
  return hit;
}

bool contains(const Body& body, const Vector3& point, double tolerance) {
  require_length(tolerance, "point: tolerance");
  return within_planes(body, point - body.placement().translation, tolerance);
}

}  // namespace quoin::geometry
