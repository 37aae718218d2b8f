#pragma once
/// Seeded random pairs of convex polyhedra, ordinary and hard, and how to print one.

#include <optional>
#include <quoin/geometry/polyhedron.hpp>
#include <string>
#include <vector>

#include "support/random.hpp"

namespace quoin::tests {

/// Two solids that somebody may ask about.
struct SolidPair {
  std::string family;
  geometry::Polyhedron a, b;
};

/// Names of the families, in the order of their numbers.
const std::vector<std::string>& family_names();

/// A pair of family `family` (index into family_names()).
SolidPair make_pair(int family, Random& random);

/// A pair of any family, the costly ones (200 vertices) seldom.
SolidPair make_pair(Random& random);

/// The same pair moved on: B turned and shifted by a little (at most `amount` of its size and that
/// many radians), as from one time step to the next.
SolidPair moved_on(const SolidPair& pair, double amount, Random& random);

/// The solid with every vertex put through v -> scale * rotation * v + shift.
geometry::Polyhedron transformed(const geometry::Polyhedron& solid, double scale,
                                 const geometry::Matrix3& rotation, const geometry::Vector3& shift);

/// The same solid with its vertices and faces in another order.
geometry::Polyhedron renumbered(const geometry::Polyhedron& solid, Random& random);

/// C++ that makes the pair again, to the last bit.
std::string rebuild_code(const SolidPair& pair);

/// The pair as text (hexadecimal floats), and back: the format of tests/regressions.
std::string to_text(const SolidPair& pair);
SolidPair from_text(const std::string& text);

/// Largest distance between two vertices, m.
double diameter(const geometry::Polyhedron& solid);
double largest_coordinate(const geometry::Polyhedron& solid);

}  // namespace quoin::tests
