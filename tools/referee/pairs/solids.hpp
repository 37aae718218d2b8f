#pragma once
/// Two solids that somebody may ask about: as they are given, as the library takes them, as text.

#include <memory>
#include <quoin/geometry/body.hpp>
#include <string>

#include "referee/pairs/exact_arbiter.hpp"
#include "referee/pairs/random.hpp"

namespace quoin::referee {

/// A solid as it is given: the convex hull of points, where it stands, and perhaps its faces.
struct Solid {
  PlacedPoints placed;
  /// Faces over the points, which are then all vertices; none: the library finds the hull.
  std::shared_ptr<const geometry::Topology> topology;

  Solid() = default;
  Solid(const geometry::Shape& polyhedron)  // NOLINT: a polyhedron is such a solid
      : placed{polyhedron.vertices(), {}}, topology(polyhedron.shared_topology()) {}
  Solid(geometry::Points points,
        const geometry::Placement& placement = {})  // NOLINT: so are points
      : placed{std::move(points), placement} {}
};

struct SolidPair {
  std::string family;
  Solid a, b;
};

/// The shape in its own frame. Throws InputError where the library refuses it.
geometry::Shape shape_of(const Solid& solid);
/// A polyhedron with its vertices, rounded, where the solid stands.
geometry::Shape polyhedron_of(const Solid& solid);

/// The same pair moved on: B turned and shifted by a little (at most `amount` of its size and that
/// many radians), as from one time step to the next.
SolidPair moved_on(const SolidPair& pair, double amount, Random& random);

/// The polyhedron with every vertex put through v -> scale * rotation * v + shift.
geometry::Shape transformed(const geometry::Shape& polyhedron, double scale,
                            const geometry::Matrix3& rotation, const geometry::Vector3& shift);
/// The solid put through x -> rotation * x + shift: by its placement where it has one, else by its
/// points.
Solid transformed(const Solid& solid, const geometry::Matrix3& rotation,
                  const geometry::Vector3& shift);
/// Larger or smaller by a power of two, without rounding.
Solid scaled(const Solid& solid, double power_of_two);
/// Mirrored in a coordinate of its own frame and of the world, without rounding.
Solid mirrored(const Solid& solid, int axis);

/// The same solid with its vertices and faces in another order.
geometry::Shape renumbered(const geometry::Shape& polyhedron, Random& random);
Solid renumbered(const Solid& solid, Random& random);

bool stands_in_own_frame(const Solid& solid);

/// C++ that makes the pair again, to the last bit.
std::string rebuild_code(const SolidPair& pair);

/// The pair as a line of text (hexadecimal floats), and back: the format of
/// tests/regressions/pairs.txt.
std::string to_text(const SolidPair& pair);
SolidPair from_text(const std::string& text);

/// Largest distance between two points, and largest coordinate, of the points as given, m.
double diameter(const geometry::Points& points);
double diameter(const geometry::Shape& polyhedron);
double diameter(const Solid& solid);
double largest_coordinate(const Solid& solid);
/// Largest coordinate where the solid stands, m.
double largest_world_coordinate(const Solid& solid);

}  // namespace quoin::referee
