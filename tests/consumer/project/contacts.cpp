#include <cstdio>
#include <quoin/geometry.hpp>
namespace geometry = quoin::geometry;

int main() {
  const std::vector<geometry::Shape> blocks = {geometry::make_box({0, 0, 0}, {2, 1, 1}),  // m
                                                    geometry::make_box({1, 0, 1}, {3, 1, 2})};
  geometry::ContactFinder finder({.reach = 1e-3});  // m
  std::vector<geometry::ContactPoint> contacts;
  finder.find(blocks, contacts);
  for (const geometry::ContactPoint& contact : contacts) {
    std::printf("%s: gap %g m, %g m2 at (%g, %g, %g)\n", name(contact.type).data(), contact.gap,
                contact.area, contact.point().x(), contact.point().y(), contact.point().z());
  }
}
