#include <quoin/geometry/mass_properties.hpp>

namespace quoin::geometry {
namespace {

/// Adds the tetrahedron (0, p, q, r): exact integrals of 1, x and x xᵀ over it.
/// Source: [Shi 1988], simplex integration; moments of a simplex: integral x xᵀ = V/20 (sum p pᵀ +
/// s sᵀ).
void add_tetrahedron(const Vector3& p, const Vector3& q, const Vector3& r, double& volume,
                     Vector3& first, Matrix3& second) {
  const double v = p.dot(q.cross(r)) / 6.0;
  const Vector3 sum = p + q + r;
  volume += v;
  first += v / 4.0 * sum;
  second += v / 20.0 *
            (p * p.transpose() + q * q.transpose() + r * r.transpose() + sum * sum.transpose());
}

}  // namespace

MassProperties mass_properties(const Shape& polyhedron) {
  const Vector3 origin = polyhedron.origin();
  double volume = 0.0;
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();
  for (const auto& [i, j, k] : polyhedron.topology().triangles()) {
    add_tetrahedron(polyhedron.vertex(i) - origin, polyhedron.vertex(j) - origin,
                    polyhedron.vertex(k) - origin, volume, first, second);
  }
  MassProperties result;
  result.volume = volume;
  const Vector3 centroid = first / volume;
  result.centroid = origin + centroid;
  result.second_moment = second - volume * centroid * centroid.transpose();
  return result;
}

MassProperties mass_properties(const Body& body) {
  const Matrix3& a = body.placement().linear;
  const double stretch = a.col(0).dot(body.cofactors().col(0));  // of volume
  MassProperties result = mass_properties(body.shape());
  result.volume *= stretch;
  result.centroid = body.placement().translation + a * result.centroid;
  result.second_moment = (stretch * a * result.second_moment * a.transpose()).eval();
  return result;
}

}  // namespace quoin::geometry
