#pragma once
/// The published nearest-feature search as printed, to compare with, and what the certificate says
/// of its answer.

#include <quoin/geometry/body.hpp>

namespace quoin::geometry {

struct PublishedOptions {
  double still = 0.0;      ///< shorter ways of a point count as none, m; 0: 1e-12 of the smaller
                           ///< diameter (the source asks for equal points)
  int max_cycles = 10000;  ///< of one projecting to and fro; the source has no limit
};

/// The nearest two of the points that the published search finds, and how far they may be from
/// right. For solids apart the exact gap lies between least_gap() and |gap|, but for the lengths to
/// which the labels of both are known (label_length()): feet lie on the planes of labels.
struct PublishedAnswer {
  double gap = 0.0;                   ///< (point_b - point_a)·normal, m; negative: a vertex lies
                                      ///< behind a face
  Vector3 normal = Vector3::UnitX();  ///< unit, from A to B
  Vector3 point_a = Vector3::Zero(), point_b = Vector3::Zero();  ///< m
  double residual_a = 0.0;  ///< how far A reaches beyond point_a along the normal, m (>= 0)
  double residual_b = 0.0;  ///< how far B reaches beyond point_b against the normal, m (>= 0)
  int vertex_a = 0, vertex_b = 0;  ///< the nearest vertices, whose faces alone are searched
  int cycles = 0;                  ///< of the longest projecting to and fro
  bool stands_still = true;        ///< none of them was ended by max_cycles
  double least_gap() const { return gap - residual_a - residual_b; }
};

/// The nearest vertices R and Q by trying all pairs. Each vertex P of the faces around R against
/// each face f around Q, and the same with the solids exchanged: P and its foot on the plane of f,
/// where the foot lies in f; otherwise to the nearest point of f, from there to the nearest point
/// of the faces around R, and so on until a point stands still. The source leaves out vertices
/// farther from the plane than a tolerance; here none is left out, so nothing is missed that the
/// source finds. No optimum is promised: see the residuals. Throws nothing.
/// Source: [Beyabanaki 2009], section 3.1, steps 1.0–4.0; geometry/README.md.
PublishedAnswer published_search(const Body& a, const Body& b,
                                 const PublishedOptions& options = {});

}  // namespace quoin::geometry
