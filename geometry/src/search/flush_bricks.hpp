#pragma once
/// flush_answer (face_face.hpp) and the points of two flush faces for four pairs of brick-like
/// solids side by side, one in each lane. Internal.

#include <array>
#include <span>

#include "polygon/contact_polygon.hpp"
#include "shape/lane_frame.hpp"

namespace quoin::geometry {

/// A number of each pair.
struct alignas(32) FlushRow {
  static constexpr int kPairs = 4;
  double of[kPairs];
};

/// One solid of each of four pairs, which has eight vertices and carries its pair with a face of
/// four corners. Pointers are to three doubles each.
struct FlushSide {
  template <std::size_t kCount>
  using Places = std::array<LanePlace, kCount>;
  Places<3> linear, cofactors;    ///< columns of the placement
  Places<1> origin;               ///< Shape::origin()
  Places<1> mean;                 ///< Shape::vertex_mean()
  Places<4> corners;              ///< of the face, in order
  Places<4> set;                  ///< the same, ascending
  Places<4> others;               ///< the other vertices
  Places<1> normal;               ///< of the face
  Places<4> neighbours;           ///< normals of the faces around it
  FlushRow diameter, coordinate;  ///< Solid's, m
  std::array<bool, FlushRow::kPairs> turned;
};

/// Four pairs in the order in which they are worked, and as the caller has them.
struct FlushQuestion {
  FlushSide p, q;
  LaneCentres centres_a, centres_b;
  std::array<bool, FlushRow::kPairs> reversed;  ///< P is the caller's B
  double tolerance = 0.0;                       ///< ContactOptions
  FlushRow reach{};                             ///< likewise, of each pair
};

/// A corner of the shared part in those pairs that have it: two sides that cross, or the corner of
/// one face in the other. Sides and corners are counted around their face, which is itself number
/// 0. m, m2
struct FlushCorner {
  FlushRow x, y, height_p, height_q, share;
  unsigned pairs = 0;  ///< one bit each
  Feature feature_p, feature_q;
};

/// What is found of those pairs of which nothing is left to doubt.
struct FlushAnswer {
  unsigned solved = 0;  ///< one bit each
  unsigned listed = 0;  ///< of these: within reach, so that the corners are contact points
  FlushRow gap, tolerance;
  FlushRow between[3];                                  ///< from the centre of A to that of B
  FlushRow origin[3], normal[3], axis_u[3], axis_v[3];  ///< of the contact plane
  std::array<FlushCorner, 24> corners;
  int corner_count = 0;
};

/// The same bits as flush_answer and append_contacts_within_reach have, whatever the machine. The
/// distance of two points from each other is left to the caller.
void flush_bricks(const FlushQuestion& question, FlushAnswer& answer);

}  // namespace quoin::geometry
