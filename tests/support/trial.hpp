#pragma once
/// One pair on trial: as it is given, as the library takes it, in exact numbers, with what is
/// allowed; and what was found to be wrong.
///
/// What is allowed, m:
///   gap    1e-12 of itself + 16 eps of the larger diameter (the library's promise), + 4 eps of the
///          largest coordinate of a shape that a placement turns (its own frame rounds there)
///   place  the same + 4 eps of the largest coordinate in the world (a point is three doubles: half
///   an
///          eps each, once for the place, once for what it is measured from, in three axes)

#include <limits>
#include <optional>
#include <quoin/geometry/contact_point.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "support/exact_arbiter.hpp"
#include "support/solids.hpp"

namespace quoin::tests {

/// Something that does not hold. Kinds are counted; the text has the numbers.
struct Fault {
  std::string kind, text;
};
std::ostream& operator<<(std::ostream& out, const Fault& fault);

class Faults {
 public:
  template <class... Parts>
  void expect(bool holds, const char* kind, const Parts&... parts) {
    if (!holds) {
      std::ostringstream out;
      out.precision(17);
      (out << ... << parts);
      list.push_back({kind, out.str()});
    }
  }
  std::vector<Fault> list;
};

/// Both shapes as the library makes them, and where they stand.
class Query {
 public:
  /// Throws InputError where the library refuses one.
  explicit Query(const SolidPair& pair);

  geometry::Body a() const { return {shape_a_, place_a_}; }
  geometry::Body b() const { return {shape_b_, place_b_}; }

  geometry::NearestFeatures nearest(const geometry::FeatureHint& hint = {}) const;
  geometry::NearestFeatures nearest_swapped() const;
  geometry::PairContact contact(double reach = 0.0) const;
  /// Both in one call; `reach` is the gap itself.
  geometry::NearestFeatures contacts_within(double reach,
                                            std::vector<geometry::ContactPoint>& points) const;

 private:
  bool own_frames_;
  geometry::Shape shape_a_, shape_b_;
  geometry::Placement place_a_, place_b_;
};

struct Trial {
  const SolidPair& pair;
  Query query;
  ExactPair exact;
  double larger = 0, smaller = 0;  ///< diameters, m
  double shape_coordinate = 0;     ///< largest in the shapes' own frames, m
  double world_coordinate = 0;     ///< largest of all, m
  double tolerance = 0;            ///< the library's contact length tol, m

  /// Throws InputError where the library refuses a solid.
  explicit Trial(const SolidPair& pair);

  double allowed_gap(long double gap) const;
  double allowed_place(long double gap) const;
};

/// The library took both solids, or refused one and said so: right if and only if both keep to the
/// promised range and are thicker than the stated length. Thin ones that are taken are no fault.
void check_taken(const SolidPair& pair, Faults& faults);
void check_refused(const SolidPair& pair, const std::string& message, Faults& faults);

}  // namespace quoin::tests
