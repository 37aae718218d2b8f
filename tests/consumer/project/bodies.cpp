// Bodies of one shape under stable handles: they come, move, are filtered and go.
#include <cstdio>
#include <quoin/geometry.hpp>
namespace geometry = quoin::geometry;

int main() {
  const auto brick =
      std::make_shared<const geometry::Shape>(geometry::make_box({0, 0, 0}, {2, 1, 1}));  // m
  geometry::ContactFinder finder({.reach = 1e-3});                                        // m
  const int floor = finder.add(brick, {}, {.motion = geometry::BodyMotion::Idle});
  const int lower = finder.add(brick, {.translation = {1, 0, 1}});
  const int upper = finder.add(brick, {.translation = {0, 0, 2}});
  finder.set_filter([=](int a, int b) { return a != lower || b != upper; });

  std::vector<geometry::ContactPoint> contacts;
  const auto report = [&](const char* when) {
    finder.find(contacts);
    std::printf("%s: %zu points;", when, contacts.size());
    for (const geometry::PairResult& pair : finder.pairs()) {
      const char* events[] = {"begins", "persists", "ends"};
      std::printf(" %d-%d %s at %g m2;", pair.a, pair.b, events[static_cast<int>(pair.event)],
                  pair.area);
    }
    std::printf("\n");
  };
  report("built");
  finder.set_filter({});
  report("unfiltered");
  finder.move(upper, {.translation = {0.5, 0, 2}});
  report("moved");
  finder.remove(lower);
  finder.move(upper, {.translation = {0.5, 0, 1}});
  report("removed");
  return finder.contains(lower) || contacts.empty() || contacts[0].key.a != floor ? 1 : 0;
}
