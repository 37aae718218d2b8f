#include <cstdio>
#include <quoin/geometry.hpp>
namespace geometry = quoin::geometry;

int main() {
  geometry::ContactFinder finder({.reach = 1e-3});  // m
  const auto brick =
      std::make_shared<geometry::Shape>(geometry::make_box({0, 0, 0}, {2, 1, 1}));  // m
  finder.add(brick);                              // both are the same shape:
  finder.add(brick, {.translation = {1, 0, 1}});  // a body is a shape and its placement
  std::vector<geometry::ContactPoint> contacts;
  finder.find(contacts);
  for (const geometry::ContactPoint& contact : contacts) {
    std::printf("%s: gap %g m, %g m2 at (%g, %g, %g)\n", name(contact.type).data(), contact.gap,
                contact.area, contact.point().x(), contact.point().y(), contact.point().z());
  }
}
