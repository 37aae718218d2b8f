#include <algorithm>
#include <limits>
#include <numeric>
#include <quoin/geometry.hpp>

#include "support/bricks.hpp"
#include "support/catch.hpp"
#include "support/counted_allocations.hpp"
#include "support/random.hpp"
#include "support/same_contacts.hpp"

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;

std::vector<ContactPoint> found(const std::vector<Placement>& bricks, double reach) {
  ContactFinder finder({.reach = reach});
  for (const Placement& place : bricks) finder.add(box(kBrick), place);
  std::vector<ContactPoint> contacts;
  finder.find(contacts);
  return contacts;
}

}  // namespace

TEST_CASE("finder: gaps beyond reach are not listed, touching ones always are") {
  const auto gap = [](double height) {
    return std::vector<Placement>{{}, {.translation = {0, 0, kBrick.z() + height}}};
  };
  CHECK(found(gap(0.25), 0.2).empty());
  CHECK(found(gap(0.25), 0.2501).size() == 4);
  CHECK(found(gap(0x1p-50), 0.0).size() == 4);  // apart by less than tol
}

TEST_CASE("finder: the same contacts for any order of the blocks, but for their names") {
  Random random(8);
  const std::vector<Placement> blocks = wall(8, 8, 1e-4, random);
  std::vector<int> order(blocks.size());
  std::iota(order.begin(), order.end(), 0);
  for (int i = static_cast<int>(order.size()) - 1; i > 0; --i) {
    std::swap(order[static_cast<std::size_t>(i)],
              order[static_cast<std::size_t>(random.integer(0, i))]);
  }
  std::vector<Placement> shuffled;
  for (int i : order) shuffled.push_back(blocks[static_cast<std::size_t>(i)]);
  std::vector<ContactPoint> renamed = found(shuffled, 1e-3);
  for (ContactPoint& contact : renamed) {
    contact.key.a = order[static_cast<std::size_t>(contact.key.a)];
    contact.key.b = order[static_cast<std::size_t>(contact.key.b)];
    if (contact.key.a > contact.key.b) {
      std::swap(contact.key.a, contact.key.b);
      std::swap(contact.key.feature_a, contact.key.feature_b);
      std::swap(contact.point_a, contact.point_b);
      contact.normal = -contact.normal;
    }
  }
  std::sort(renamed.begin(), renamed.end(),
            [](const ContactPoint& c, const ContactPoint& d) { return c.key < d.key; });
  const std::vector<ContactPoint> contacts = found(blocks, 1e-3);
  REQUIRE(renamed.size() == contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i)
    REQUIRE(same_but_previous(contacts[i], renamed[i]));
}

TEST_CASE("finder: keys stay for the life of a contact") {
  Random random(2);
  ContactFinder finder({.reach = 1e-2});
  const std::vector<Placement> bricks = wall(6, 6, 0.0, random);
  for (const Placement& place : bricks) finder.add(box(kBrick), place);
  std::vector<ContactPoint> before, now;
  finder.find(before);
  for (int step = 1; step <= 20; ++step) {
    for (int i = 0; i < finder.size(); ++i) {  // each course slides on the one below
      const Vector3 slid(2e-4 * step * (i / 6), 0, 0);
      finder.move(i, {.translation = bricks[static_cast<std::size_t>(i)].translation + slid});
    }
    finder.find(now);
    REQUIRE(now.size() == before.size());
    const std::vector<int> previous = match_previous(now, before);
    for (std::size_t i = 0; i < now.size(); ++i) {
      REQUIRE(previous[i] >= 0);
      REQUIRE(now[i].previous == previous[i]);
    }
    std::swap(now, before);
  }
}

TEST_CASE("finder: once warm it allocates nothing") {
  for (const int threads : {1, 2}) {
    Random random(14);
    ContactFinder finder({.reach = 1e-2, .threads = threads});
    const std::vector<Placement> bricks = wall(12, 12, 1e-4, random);
    for (const Placement& place : bricks) finder.add(box(kBrick), place);
    std::vector<ContactPoint> contacts;
    const auto shake_and_find = [&](double jitter) {
      for (int i = 0; i < finder.size(); ++i)
        finder.move(i, {.translation = bricks[static_cast<std::size_t>(i)].translation +
                                       jitter * random.point(-1, 1)});
      finder.find(contacts);
    };
    for (int step = 0; step < 5; ++step) shake_and_find(2e-4);
    const long before = allocations;
    for (int step = 0; step < 20; ++step) shake_and_find(1e-4);
    CHECK(allocations == before);
    CHECK(contacts.size() > 1000);
  }
}

TEST_CASE("finder: options that make no sense are refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  CHECK_THROWS_AS(ContactFinder({.reach = -1e-9}), InputError);
  CHECK_THROWS_AS(ContactFinder({.reach = nan}), InputError);
  CHECK_THROWS_AS(ContactFinder({.reach = infinity}), InputError);
  CHECK_THROWS_AS(ContactFinder({.tolerance = -1.0}), InputError);
  CHECK_THROWS_AS(ContactFinder({.tolerance = nan}), InputError);
  CHECK_THROWS_AS(ContactFinder({.threads = 0}), InputError);
  CHECK_THROWS_AS(ContactFinder({.threads = 2000000000}), InputError);
  ContactFinder finder({.reach = 1e-3});
  CHECK_THROWS_AS(finder.set_reach(-1.0), InputError);
}

TEST_CASE("bodies: a further one of a known shape takes at most 256 bytes") {
  const auto brick = std::make_shared<const Shape>(make_box(Vector3::Zero(), kBrick));
  const auto bytes_for = [&](int count, bool moving) {
    const long before = bytes_in_use;
    ContactFinder finder({.reach = 1e-3});
    std::vector<ContactPoint> contacts;
    for (int step = 0; step < 3; ++step) {
      for (int i = 0; i < count; ++i) {
        const Placement place{.translation = Vector3(i % 64, i / 64, step)};
        if (step == 0) finder.add(brick, place);
        if (moving && step > 0) finder.move(i, place);
      }
      finder.find(contacts);
    }
    return bytes_in_use - before;
  };
  for (const bool moving :
       {false, true}) {  // lists grow by doubling: at powers of two they are full
    const double bytes =
        static_cast<double>(bytes_for(65536, moving) - bytes_for(4096, moving)) / (65536 - 4096);
    INFO(bytes << " bytes a body" << (moving ? ", moving" : ""));
    CHECK(bytes <= 256.0);
    CHECK(bytes > 96.0);  // its placement
  }
}

/// FCL's tree loses its nodes where it runs out of memory while it is made: while this lives, what
/// is allocated is no leak.
struct LeaksOfFcl {
#ifdef __SANITIZE_ADDRESS__
  LeaksOfFcl() { __lsan_disable(); }
  ~LeaksOfFcl() { __lsan_enable(); }
#endif
};

TEST_CASE("finder: a call that runs out of memory leaves nothing behind that is wrong") {
  const auto brick = std::make_shared<const Shape>(make_box(Vector3::Zero(), kBrick));
  const auto make_finder = [&] {
    ContactFinder finder({.reach = 1e-3});
    for (int i = 0; i < 36; ++i)
      finder.add(brick, {.translation = Vector3(0.4 * (i % 6), 0.0, 0.2 * (i / 6))});
    return finder;
  };
  std::vector<ContactPoint> expected, contacts;
  make_finder().find(expected);
  REQUIRE(expected.size() > 200);
  int failed = 0;
  for (bool fails = true; fails; ++failed) {
    ContactFinder finder = make_finder();
    contacts.reserve(expected.size());
    [[maybe_unused]] const LeaksOfFcl leaks{};
    until_failure = failed;
    try {
      finder.find(contacts);
      fails = false;
    } catch (const std::bad_alloc&) {
    }
    until_failure = -1;
    finder.find(contacts);
    CAPTURE(failed);
    REQUIRE(same_but_previous(contacts, expected));
  }
  CHECK(failed > 100);
}

// Lists of the last call that were given back because they were longer than expected: some 35
// allocations in each call.
TEST_CASE("bodies: pairs that come and go in each step allocate nothing, once warm") {
  const auto brick = box(kBrick);
  ContactFinder finder({.reach = 1e-3});
  std::vector<Vector3> places;
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 40; ++column) {
      places.emplace_back(0.4001 * (column + 0.5 * (row % 2)), 0.0, 0.2001 * row);
      finder.add(brick, {.translation = places.back()});
    }
  }
  std::vector<ContactPoint> contacts;
  long in_find = 0, begun = 0;
  for (int step = 0; step < 60; ++step) {
    Random random(static_cast<unsigned>(step % 10));  // ten states for ever
    for (int i = 0; i < finder.size(); ++i) {
      const Vector3 noise(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      finder.move(i, {.translation = places[static_cast<std::size_t>(i)] + 2e-3 * noise});
    }
    const long before = allocations;
    finder.find(contacts);
    if (step < 40) continue;
    in_find += allocations - before;
    begun +=
        std::ranges::count(finder.pairs(), quoin::geometry::PairEvent::Begin, &PairResult::event);
  }
  CHECK(begun > 20 * 500);
  CHECK(in_find == 0);
}

TEST_CASE("Corners that coincide keep their history where rounding names them otherwise") {
  ContactFinder finder({});  // reach 0
  const auto brick = std::make_shared<Shape>(make_box({0, 0, 0}, {2, 1, 1}));
  finder.add(brick);
  const int upper = finder.add(brick, {.translation = {0, 0, 1}});
  std::vector<ContactPoint> before, now;
  finder.find(before);
  bool renamed = false;
  for (const double off : {1e-12, -1e-12, 2e-12}) {
    finder.move(upper, {.translation = {off, off, 1}});
    finder.find(now);
    REQUIRE(now.size() == 4);
    for (const ContactPoint& point : now) {
      REQUIRE(point.previous >= 0);
      const ContactPoint& was = before[static_cast<std::size_t>(point.previous)];
      CHECK((point.point() - was.point()).norm() < 1e-11);
      renamed = renamed || !(point.key == was.key);
    }
    before = now;
  }
  CHECK(renamed);
}

TEST_CASE("A pair that stands nowhere has no contact points") {
  const Shape box = make_box({0, 0, 0}, {1, 1, 1});
  Placement nowhere;
  nowhere.translation.x() = std::numeric_limits<double>::quiet_NaN();
  const quoin::geometry::Body here(box), lost(box, nowhere);
  std::vector<ContactPoint> points;
  quoin::geometry::append_contacts_within_reach({0, 1}, here, lost, {}, FeatureHint{}, points);
  CHECK(points.empty());
  quoin::geometry::PairContact contact;
  quoin::geometry::update_pair_contact(here, lost, {}, contact);
  CHECK(contact.nearest.status == quoin::geometry::PairStatus::NotConverged);
  CHECK(contact.points.empty());
}
