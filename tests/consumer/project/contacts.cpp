#include <cstdio>
#include <quoin/geometry.hpp>
namespace geometry = quoin::geometry;

int main() {
  const auto brick =
      std::make_shared<const geometry::Shape>(geometry::make_box({0, 0, 0}, {2, 1, 1}));  // m
  geometry::ContactFinder finder({.reach = 1e-3});                                        // m
  finder.add(brick);  // all bodies share the shape
  const int upper = finder.add(brick, {.translation = {1, 0, 2}});
  finder.move(upper, {.translation = {1, 0, 1}});  // onto the other
  std::vector<geometry::ContactPoint> contacts;
  finder.find(contacts);
  for (const geometry::ContactPoint& contact : contacts) {
    std::printf("%d on %d, %s: gap %g m, %g m2 at (%g, %g, %g)\n", contact.key.b, contact.key.a,
                name(contact.type).data(), contact.gap, contact.area, contact.point().x(),
                contact.point().y(), contact.point().z());
  }
}
