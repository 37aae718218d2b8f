/// Rays, boxes and points asked of the finder, and compounds, against each body by itself.
#include <algorithm>
#include <cmath>
#include <limits>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/contact_finder.hpp>

#include "support/catch.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using quoin::tests::Random;
using quoin::tests::WithinAbs;

std::shared_ptr<const Shape> box(const Vector3& size) {
  return std::make_shared<const Shape>(make_box(-0.5 * size, 0.5 * size));
}

/// Boxes in all directions around a place.
struct Scene {
  ContactFinder finder{FinderOptions{}};
  std::vector<int> handles;

  Scene(int count, const Vector3& middle, Random& random) {
    const auto shape = box({1, 0.6, 0.3});
    for (int i = 0; i < count; ++i) {
      handles.push_back(finder.add(shape, {random.rotation(), middle + random.point(-5, 5)},
                                   {.category = i % 3 == 0 ? 2U : 1U}));
    }
  }

  std::vector<BodyHit> hits(const Ray& ray, std::uint32_t categories = ~0U) const {
    std::vector<BodyHit> found;
    for (const int h : handles) {
      if (((h % 3 == 0 ? 2U : 1U) & categories) == 0 || !finder.contains(h)) continue;
      if (const auto hit = first_hit(finder.body(h), ray)) found.push_back({h, *hit});
    }
    std::ranges::sort(found, {}, [](const BodyHit& x) { return std::pair(x.hit.s, x.handle); });
    return found;
  }
};

void check_same(const std::vector<BodyHit>& found, const std::vector<BodyHit>& expected) {
  REQUIRE(found.size() == expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    CHECK(found[k].handle == expected[k].handle);
    CHECK(found[k].hit.s == expected[k].hit.s);
    CHECK(found[k].hit.face == expected[k].hit.face);
  }
}

}  // namespace

TEST_CASE("finder queries: rays meet what they meet body by body, while bodies come, move and go") {
  Random random(2);
  for (const int count : {5, 15, 16, 200}) {
    for (const Vector3& middle : {Vector3(0, 0, 0), Vector3(1e5, -2e5, 3e5)}) {
      Scene scene(count, middle, random);
      std::vector<BodyHit> found;
      for (int i = 0; i < 60; ++i) {
        const int h = scene.handles[static_cast<std::size_t>(i % count)];
        if (i % 7 == 3 && scene.finder.contains(h))
          scene.finder.move(h, {random.rotation(), middle + random.point(-5, 5)});
        if (i == 40) scene.finder.remove(scene.handles[1]);
        Ray ray{.origin = middle + random.point(-6, 6), .direction = random.point(-1, 1)};
        if (i % 4 == 0) ray.length = 3.0;
        if (i % 4 == 1) ray.direction = Vector3::Unit(i % 3);
        const std::vector<BodyHit> expected = scene.hits(ray);
        scene.finder.all_hits(ray, found);
        check_same(found, expected);
        const auto nearest = scene.finder.nearest_hit(ray);
        REQUIRE(nearest.has_value() == !expected.empty());
        if (nearest) check_same({*nearest}, {expected[0]});
        scene.finder.all_hits(ray, found, {.categories = 2});
        check_same(found, scene.hits(ray, 2));
        const auto other = scene.finder.nearest_hit(
            ray, {.accepts = [&](int x) { return !nearest || x != nearest->handle; }});
        CHECK(other.has_value() == (expected.size() > 1));
        if (other) CHECK(other->handle == expected[1].handle);
      }
    }
  }
}

TEST_CASE("finder queries: boxes and points") {
  Random random(3);
  for (const int count : {10, 150}) {
    Scene scene(count, {10, 20, 30}, random);
    std::vector<int> found;
    for (int i = 0; i < 100; ++i) {
      const Vector3 place = Vector3(10, 20, 30) + random.point(-5, 5);
      const Box asked{place, place + random.point(0, 2)};
      scene.finder.bodies_in_box(asked, found);
      CHECK(std::ranges::is_sorted(found));
      for (const int h : scene.handles) {
        const Box own = scene.finder.body(h).box();
        const double apart =
            std::max((own.min - asked.max).maxCoeff(), (asked.min - own.max).maxCoeff());
        const bool listed = std::ranges::binary_search(found, h);
        if (apart <= 0.0) CHECK(listed);
        if (apart > 1e-5) CHECK(!listed);
      }
      scene.finder.bodies_at(place, 0.0, found);
      std::vector<int> expected;
      for (const int h : scene.handles)
        if (contains(scene.finder.body(h), place)) expected.push_back(h);
      CHECK(found == expected);
    }
    scene.finder.bodies_at(scene.finder.body(3).centre(), 0.0, found, {.categories = 1});
    CHECK(!std::ranges::binary_search(found, 3));
  }
}

TEST_CASE("finder queries: the next find() goes on as though nobody had asked") {
  Random random(4);
  Scene asked(100, {0, 0, 0}, random);
  Random again(4);
  Scene alone(100, {0, 0, 0}, again);
  std::vector<ContactPoint> x, y;
  std::vector<int> found;
  for (int step = 0; step < 6; ++step) {
    for (int h = step; h < 100; h += 5) {
      const Placement to{Matrix3::Identity(), random.point(-5, 5)};
      asked.finder.move(h, to);
      alone.finder.move(h, to);
      asked.finder.nearest_hit({.origin = {-9, 0, 0}});
      asked.finder.bodies_in_box({{0, 0, 0}, {1, 1, 1}}, found);
    }
    const FindCounts counts = asked.finder.find(x), other = alone.finder.find(y);
    CHECK(counts.candidates == other.candidates);
    REQUIRE(x.size() == y.size());
    for (std::size_t k = 0; k < x.size(); ++k) {
      CHECK(x[k].key == y[k].key);
      CHECK(x[k].gap == y[k].gap);
      CHECK(x[k].previous == y[k].previous);
    }
  }
}

TEST_CASE("finder queries: what is none is refused") {
  ContactFinder finder{FinderOptions{}};
  std::vector<int> found;
  std::vector<BodyHit> hits;
  const double nan = std::nan("");
  CHECK(!finder.nearest_hit({}));
  CHECK_THROWS_AS(finder.nearest_hit({.direction = {0, 0, 0}}), InputError);
  CHECK_THROWS_AS(finder.all_hits({.origin = {nan, 0, 0}}, hits), InputError);
  CHECK_THROWS_AS(finder.bodies_in_box({{0, 0, 0}, {1, -1, 1}}, found), InputError);
  CHECK_THROWS_AS(finder.bodies_in_box({{0, 0, nan}, {1, 1, 1}}, found), InputError);
  CHECK_THROWS_AS(finder.bodies_at({0, 0, 0}, nan, found), InputError);
  finder.bodies_at({0, nan, 0}, 0.0, found);
  CHECK(found.empty());
}

TEST_CASE("compounds: an L lies on the ground, its parts never touch each other") {
  for (const Vector3& away : {Vector3(0, 0, 0), Vector3(1e4, -2e4, 3e4)}) {
    ContactFinder finder{FinderOptions{.tolerance = 1e-9}};
    const int ground =
        finder.add(box({10, 10, 1}), {Matrix3::Identity(), away - Vector3(0, 0, 0.5)});
    const std::vector<CompoundPart> parts{{box({2, 1, 1}), {}},
                                          {box({1, 1, 3}), {Matrix3::Identity(), {-1.5, 0, 1}}}};
    const Placement place{Matrix3::Identity(), away + Vector3(0, 0, 0.5)};
    const int bent = finder.add_compound(parts, place);
    const int single = finder.add(box({1, 1, 1}), {Matrix3::Identity(), away + Vector3(0, 0, 1.5)});
    CHECK(finder.size() == 4);
    CHECK(finder.part_name(bent + 1).compound == bent);
    CHECK(finder.part_name(bent + 1).part == 1);
    CHECK(finder.part_name(single).compound == single);
    const auto contacts_of_parts = [&] {
      std::vector<ContactPoint> contacts;
      finder.find(contacts);
      std::vector<std::array<int, 2>> pairs;
      for (const PairResult& pair : finder.pairs())
        if (pair.count > 0) pairs.push_back({pair.a, pair.b});
      return pairs;
    };
    using Pairs = std::vector<std::array<int, 2>>;
    // the part that stands up reaches down to -0.5, too; the single box is beside it on part 0
    CHECK(contacts_of_parts() == Pairs{{ground, bent}, {ground, bent + 1}, {bent, single}});
    finder.move(single, {Matrix3::Identity(), away + Vector3(-0.5, 0, 1.5)});
    CHECK(contacts_of_parts() ==
          Pairs{{ground, bent}, {ground, bent + 1}, {bent, single}, {bent + 1, single}});
    Matrix3 turn;  // a quarter about z: all parts go with it
    turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    finder.move(bent, {turn, place.translation});
    CHECK((finder.body(bent + 1).placement().translation - away - Vector3(0, -1.5, 1.5)).norm() <
          1e-14 * (1 + away.norm()));
    finder.move(bent, {turn, away + Vector3(0, 0, 5)});
    CHECK(contacts_of_parts().empty());
    const auto hit =
        finder.nearest_hit({.origin = away + Vector3(0, -1.5, 9), .direction = {0, 0, -1}});
    REQUIRE(hit.has_value());
    CHECK(hit->handle == bent + 1);
    CHECK_THAT(hit->hit.s, WithinAbs(1.5, 1e-10));
    for (const auto& refused : std::vector<std::function<void()>>{
             [&] { finder.move(bent + 1, {}); }, [&] { finder.remove(bent + 1); },
             [&] { finder.add_compound({}); },
             [&] {
               finder.add_compound(std::vector<CompoundPart>{parts[0], {nullptr, {}}});
             }}) {
      CHECK_THROWS_AS(refused(), InputError);
      CHECK(finder.size() == 4);
    }
    finder.move(bent, place);
    std::vector<ContactPoint> some;
    const int handles[] = {bent};
    finder.contacts_of(handles, some);
    CHECK(some.size() == 16);
    finder.set_options(bent, {.motion = BodyMotion::Idle});
    finder.set_options(ground, {.motion = BodyMotion::Idle});
    CHECK(contacts_of_parts() == Pairs{{bent, single}, {bent + 1, single}});
    finder.remove(bent);
    CHECK(finder.size() == 2);
    CHECK(!finder.contains(bent + 1));
  }
}

TEST_CASE("compounds: a crowd is found as its parts are as bodies by themselves") {
  Random random(8);
  ContactFinder crowd{FinderOptions{.reach = 0.05}}, bodies{FinderOptions{.reach = 0.05}};
  const std::vector<CompoundPart> parts{{box({1, 0.5, 0.5}), {}},
                                        {box({0.5, 0.5, 0.5}), {random.rotation(), {0.4, 0.3, 0}}},
                                        {box({0.5, 0.5, 0.5}), {random.rotation(), {0, 0, 0.5}}}};
  bodies.set_filter([](int a, int b) { return a / 3 != b / 3; });
  std::vector<int> handles;
  for (int i = 0; i < 60; ++i) {
    handles.push_back(crowd.add_compound(parts));
    for (const CompoundPart& part : parts) bodies.add(part.shape);
  }
  std::vector<ContactPoint> x, y;
  for (int step = 0; step < 4; ++step) {
    for (const int h : handles) {
      const Placement to{random.rotation(), random.point(-2, 2)};
      crowd.move(h, to);
      for (int k = 0; k < 3; ++k) {
        const Placement& own = parts[static_cast<std::size_t>(k)].placement;
        bodies.move(h + k, {to.linear * own.linear, to.translation + to.linear * own.translation});
      }
    }
    crowd.find(x);
    bodies.find(y);
    REQUIRE(x.size() == y.size());
    CHECK(x.size() > 100);
    for (std::size_t k = 0; k < x.size(); ++k) {
      CHECK(x[k].key == y[k].key);
      CHECK(x[k].gap == y[k].gap);
    }
  }
}
