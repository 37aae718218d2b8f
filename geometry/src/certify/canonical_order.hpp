#pragma once
/// The order in which a pair is worked, whichever way round it was asked: swapping A and B then
/// gives the same bits. Internal.

#include "certify/certificate.hpp"

namespace quoin::geometry {

/// Of two rows of numbers: -1, 0 or 1.
inline int compare(const double* x, const double* y, Eigen::Index count) {
  for (Eigen::Index k = 0; k < count; ++k)
    if (x[k] != y[k]) return x[k] < y[k] ? -1 : 1;
  return 0;
}

/// True when q comes before p: fewer vertices, then smaller coordinates in the shapes' own frames,
/// first vertex first, then smaller placement.
[[gnu::always_inline]] inline bool in_reverse_order(const Solid& p, const Solid& q) {
  if (p.vertex_count() != q.vertex_count()) return q.vertex_count() < p.vertex_count();
  if (&p.shape() != &q.shape()) {
    const Points &x = p.shape().vertices(), &y = q.shape().vertices();
    if (const int order = compare(x.data(), y.data(), x.size()); order != 0) return order > 0;
  }
  if (p.body() == nullptr || q.body() == nullptr) return p.body() != nullptr;
  const Placement &s = p.body()->placement(), &t = q.body()->placement();
  const int order = compare(s.translation.data(), t.translation.data(), 3);
  return (order != 0 ? order : compare(s.linear.data(), t.linear.data(), 9)) > 0;
}

/// A pair in the order in which it is worked.
struct CanonicalPair {
  const Solid& p;
  const Solid& q;
  bool reversed;  // q is the caller's A
  Lengths length;
  const Solid& a() const { return reversed ? q : p; }
  const Solid& b() const { return reversed ? p : q; }
};

inline CanonicalPair ordered(const Solid& a, const Solid& b, const Lengths& length) {
  const bool reversed = in_reverse_order(a, b);
  return {reversed ? b : a, reversed ? a : b, reversed, length};
}

inline void swap_names(FeatureHint& hint) {
  hint.normal = one_zero(-Vec3(hint.normal));
  std::swap(hint.vertices_a, hint.vertices_b);
  std::swap(hint.face_a, hint.face_b);
}

inline void swap_names(NearestFeatures& answer) {
  answer.normal = one_zero(-Vec3(answer.normal));
  std::swap(answer.point_a, answer.point_b);
  std::swap(answer.feature_a, answer.feature_b);
  std::swap(answer.residual_a, answer.residual_b);
  swap_names(answer.hint);
}

}  // namespace quoin::geometry
