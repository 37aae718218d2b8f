#pragma once
/// A body as the searches see it: all places are relative to the middle of the pair, so that
/// nothing depends on where the pair stands. Vertices stay in the shape's frame and are placed when
/// they are asked for; directions are turned into that frame to be scanned there. Of two shapes in
/// their own frame the vertices are the places. Internal.

#include <quoin/geometry/body.hpp>

#include "numeric/double_double.hpp"
#include "numeric/vec3.hpp"

namespace quoin::geometry {

class Solid {
 public:
  Solid(const Shape& shape)  // NOLINT: a shape stands in its own frame
      : shape_(&shape), body_(nullptr), turned_(nullptr), origin_(shape.origin()) {}
  /// `origin`: where the shape's origin lies, from the middle of the pair, m.
  Solid(const Body& body, const Vector3& origin)
      : shape_(&body.shape()),
        body_(&body),
        turned_(body.is_turned() ? &body : nullptr),
        origin_(origin) {}

  const Shape& shape() const { return *shape_; }
  const Body* body() const { return body_; }      ///< null: the shape in its own frame
  const Body* turned() const { return turned_; }  ///< null: `linear` is the identity
  bool is_rigid() const { return turned_ == nullptr || turned_->is_rigid(); }
  const Topology& topology() const { return shape_->topology(); }
  int vertex_count() const { return shape_->vertex_count(); }
  int padded_count() const { return shape_->padded_count(); }
  const Vector3& origin() const { return origin_; }
  double diameter() const {  ///< never less than the diameter, m
    const double diameter = shape_->diameter();
    return turned_ == nullptr ? diameter : turned_->stretch() * diameter;
  }
  /// Largest coordinate of the shape in its own frame: its data are known to eps of that, m.
  double largest_coordinate() const { return shape_->largest_coordinate(); }

  Vector3 vertex(int v) const { return place(v); }
  Vec3 place(int v) const {
    const double* x = shape_->vertices().data() + 3 * v;
    return image({x[0], x[1], x[2]});
  }
  Vector3 vertex_mean() const { return image(shape_->vertex_mean()); }  ///< a point inside
  Vector3 face_normal(int f) const;                                     ///< unit, outward
  /// Along an edge, right to the last places however short it is: from vertex v to w, m.
  Vector3 line(int v, int w) const {
    const Vector3 line = shape_->vertex(w) - shape_->vertex(v);
    return turned_ == nullptr ? line : Vector3(product(turned_->placement().linear, line));
  }
  WideVector wide_line(int v, int w) const {
    return turned_vector(wide_difference(shape_->vertex(w), shape_->vertex(v)));
  }
  /// From the shape's origin.
  WideVector wide_offset(int v) const {
    return turned_vector(wide_difference(shape_->vertex(v), shape_->origin()));
  }

  /// A direction in the shape's frame: offset · turned_back(d) = placed offset · d.
  Vec3 turned_back(const Vec3& d) const {
    if (turned_ == nullptr) return d;
    const double* a = turned_->placement().linear.data();
    return {dot(Vec3(a[0], a[1], a[2]), d), dot(Vec3(a[3], a[4], a[5]), d),
            dot(Vec3(a[6], a[7], a[8]), d)};
  }
  /// An offset from the shape's origin, placed.
  Vec3 turn(const Vec3& offset) const {
    return turned_ == nullptr ? offset : product(turned_->placement().linear, offset);
  }

 private:
  Vec3 image(const Vec3& x) const {
    if (body_ == nullptr) return x;
    return turn(x - Vec3(shape_->origin())) + Vec3(origin_);
  }
  WideVector turned_vector(const WideVector& v) const;

  const Shape* shape_;
  const Body* body_;
  const Body* turned_;
  Vector3 origin_;
};

inline Vector3 Solid::face_normal(int f) const {
  const Vector3 own = shape_->face_normal(f);
  if (turned_ == nullptr) return own;
  const Vector3 normal = product(turned_->cofactors(), own);
  // Of a rotation a step of Newton's method for the inverse root leaves nothing.
  if (turned_->is_rigid()) return (1.5 - 0.5 * normal.squaredNorm()) * normal;
  return normal.normalized();
}

inline WideVector Solid::turned_vector(const WideVector& v) const {
  if (turned_ == nullptr) return v;
  const Matrix3& a = turned_->placement().linear;
  return {v.x * a(0, 0) + v.y * a(0, 1) + v.z * a(0, 2),
          v.x * a(1, 0) + v.y * a(1, 1) + v.z * a(1, 2),
          v.x * a(2, 0) + v.y * a(2, 1) + v.z * a(2, 2)};
}

inline Vec3 place(const Solid& solid, int vertex) { return solid.place(vertex); }
inline Vec3 face_normal(const Solid& solid, int face) { return solid.face_normal(face); }

/// From one centre to another. The translations go in as one exact difference, so that nothing
/// depends on where the bodies stand.
inline WideVector wide_apart(const Body& a, const Body& b) {
  return wide_difference(b.placement().translation, a.placement().translation) +
         (wide_difference(b.turned_origin(), a.turned_origin()) +
          wide_difference(b.turned_origin_rest(), a.turned_origin_rest()));
}

/// q_j - p_i of two bodies, or of two shapes in their own frame, in double-double: right to about
/// 1e-31 of the lengths that go in.
inline WideVector exact_corner(const Solid& p, const Solid& q, int i, int j) {
  if (p.body() == nullptr || q.body() == nullptr)
    return wide_difference(q.shape().vertex(j), p.shape().vertex(i));
  return wide_apart(*p.body(), *q.body()) + (q.wide_offset(j) - p.wide_offset(i));
}

/// wide_apart(), right to its own last place, in a quarter of the operations.
inline Vector3 apart(const Body& a, const Body& b) {
  Vector3 way;
  for (int k = 0; k < 3; ++k) {
    const DoubleDouble moved =
        two_difference(b.placement().translation[k], a.placement().translation[k]);
    const DoubleDouble turned = two_difference(b.turned_origin()[k], a.turned_origin()[k]);
    const DoubleDouble sum = two_sum(moved.high, turned.high);
    const double rest = b.turned_origin_rest()[k] - a.turned_origin_rest()[k];
    way[k] = sum.high + (sum.low + ((moved.low + turned.low) + rest));
  }
  return way;
}

/// Two bodies from the middle between their centres; those that both stand in their own frames as
/// the shapes.
struct PlacedPair {
  bool as_shapes;
  Vector3 middle;  ///< in the world, m; as shapes: zero
  Solid a, b;

  PlacedPair(const Body& body_a, const Body& body_b)
      : PlacedPair(body_a, body_b, body_a.stands_in_own_frame() && body_b.stands_in_own_frame()) {}

 private:
  PlacedPair(const Body& body_a, const Body& body_b, bool own)
      : PlacedPair(body_a, body_b, own, own ? Vector3(Vector3::Zero()) : apart(body_a, body_b)) {}
  PlacedPair(const Body& body_a, const Body& body_b, bool own, const Vector3& between)
      : as_shapes(own),
        middle(own ? Vector3(Vector3::Zero())
                   : Vector3(0.5 * body_a.centre() + 0.5 * body_b.centre())),
        a(own ? Solid(body_a.shape()) : Solid(body_a, -0.5 * between)),
        b(own ? Solid(body_b.shape()) : Solid(body_b, 0.5 * between)) {}
};

}  // namespace quoin::geometry
