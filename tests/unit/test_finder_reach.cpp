/// Reaches of bodies: whatever a finder has seen, it answers as a new one with the same reaches.

#include <algorithm>
#include <limits>
#include <quoin/geometry.hpp>

#include "support/bricks.hpp"
#include "support/catch.hpp"
#include "support/counted_allocations.hpp"
#include "support/random.hpp"
#include "support/same_contacts.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;

/// Bodies as their owner knows them.
struct Crowd {
  std::vector<SharedShape> shapes{};
  std::vector<Placement> places{};
  std::vector<double> reaches{};  // m
  double reach = 0.0;             // of all, m

  void put_into(ContactFinder& finder) const {
    for (std::size_t i = 0; i < shapes.size(); ++i) finder.add(shapes[i], places[i]);
  }
  void tell(ContactFinder& finder) const {
    finder.set_reach(reach);
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      finder.move(static_cast<int>(i), places[i]);
      finder.set_reach(static_cast<int>(i), reaches[i]);
    }
  }
  std::vector<ContactPoint> found_afresh() const {
    ContactFinder fresh({});
    put_into(fresh);
    tell(fresh);
    std::vector<ContactPoint> contacts;
    fresh.find(contacts);
    return contacts;
  }
};

Crowd crowd(int rows, int columns, Random& random) {
  Crowd made{.places = wall(rows, columns, 1e-4, random)};
  const SharedShape block = box(kBrick), tip = tetrahedron();
  for (std::size_t i = 0; i < made.places.size(); ++i) {
    made.shapes.push_back(random.chance(0.2) ? tip : block);
    made.reaches.push_back(0.0);
  }
  return made;
}

void change(Crowd& crowd, double share, Random& random) {
  const double lengths[] = {0.0, 1e-9, 5e-5, 1e-4, 2e-4, 1e-3, 0.05, 0.3};
  for (std::size_t i = 0; i < crowd.places.size(); ++i) {
    if (random.chance(share)) crowd.places[i].translation += 5e-5 * random.direction();
    if (random.chance(share)) crowd.reaches[i] = lengths[random.integer(0, 7)];
  }
  if (random.chance(0.1)) crowd.reach = lengths[random.integer(0, 5)];
}

}  // namespace

TEST_CASE("reach: that of a pair is the larger of its bodies', and no less than that of all") {
  const SharedShape block = box(kBrick);
  ContactFinder finder({.reach = 1e-3});
  const int a = finder.add(block);
  const int b = finder.add(block, {Matrix3::Identity(), {0, 0, 0.21}});  // 1 cm above
  const int c = finder.add(block, {Matrix3::Identity(), {0, 0, 0.44}});  // 3 cm above that
  std::vector<ContactPoint> contacts;
  const auto touches = [&](int first, int second) {
    finder.find(contacts);
    return std::ranges::any_of(contacts, [&](const ContactPoint& point) {
      return point.key.a == first && point.key.b == second;
    });
  };
  CHECK_FALSE(touches(a, b));
  finder.set_reach(a, 0.02);
  CHECK(touches(a, b));
  CHECK_FALSE(touches(b, c));
  finder.set_reach(c, 0.029);
  CHECK_FALSE(touches(b, c));
  finder.set_reach(c, 0.031);
  CHECK(touches(b, c));
  finder.set_reach(a, 0.009);
  CHECK_FALSE(touches(a, b));
  finder.set_reach(0.011);
  CHECK(touches(a, b));
  CHECK_THROWS_AS(finder.set_reach(a, -1e-3), InputError);
  CHECK_THROWS_AS(finder.set_reach(a, std::numeric_limits<double>::quiet_NaN()), InputError);
  CHECK_THROWS_AS(finder.set_reach(3, 1e-3), InputError);
}

TEST_CASE("reach: whatever happened before, the list is that of a new finder") {
  Random random(quoin::tests::environment_number("QUOIN_SEED", 20));
  for (const auto& [rows, columns] : {std::pair(3, 4), std::pair(9, 9)}) {
    Crowd bodies = crowd(rows, columns, random);
    ContactFinder finder({}), two({.threads = 2});
    bodies.put_into(finder);
    bodies.put_into(two);
    std::vector<ContactPoint> contacts, with_two;
    for (int step = 0; step < 60; ++step) {
      CAPTURE(rows, step);
      change(bodies, step % 5 == 0 ? 0.5 : step % 5 == 1 ? 0.02 : 0.0, random);
      bodies.tell(finder);
      bodies.tell(two);
      finder.find(contacts);
      two.find(with_two);
      REQUIRE(same_but_previous(contacts, with_two));
      REQUIRE(same_but_previous(contacts, bodies.found_afresh()));
    }
  }
}

TEST_CASE("reach: a fast body makes nobody search pairs that it has no part in") {
  Random random(3);
  const SharedShape block = box(kBrick);
  ContactFinder finder({.reach = 1e-3});
  for (const Placement& place : wall(10, 10, 0.0, random)) finder.add(block, place);
  const int fast = finder.add(block, {Matrix3::Identity(), {-2, 0, 5}});
  std::vector<ContactPoint> contacts;
  for (int k = 0; k < 2; ++k) finder.find(contacts);  // in the second all have stood still
  const std::size_t count = contacts.size();
  for (int step = 1; step < 10; ++step) {
    finder.move(fast, {Matrix3::Identity(), {-2, 0, 5.0 - 0.01 * step * step}});
    finder.set_reach(fast, 0.02 * step);
    const FindCounts counts = finder.find(contacts);
    CHECK(counts.searched == 0);
    CHECK(contacts.size() == count);
  }
}

TEST_CASE("contacts of some bodies: those that find() lists, whatever happened before") {
  Random random(quoin::tests::environment_number("QUOIN_SEED", 21));
  for (const auto& [rows, columns] : {std::pair(3, 4), std::pair(9, 9)}) {
    Crowd bodies = crowd(rows, columns, random);
    ContactFinder asked({}), two({.threads = 2}), silent({});
    for (ContactFinder* finder : {&asked, &two, &silent}) bodies.put_into(*finder);
    std::vector<ContactPoint> contacts, with_two, all, asked_before;
    for (int step = 0; step < 80; ++step) {
      CAPTURE(rows, step);
      change(bodies, step % 5 == 0 ? 0.5 : step % 5 == 1 ? 0.02 : 0.0, random);
      for (ContactFinder* finder : {&asked, &two, &silent}) bodies.tell(*finder);
      std::vector<int> handles;
      const double share = random.chance(0.2) ? 1.0 : 0.1;
      for (int i = static_cast<int>(bodies.places.size()) - 1; i >= 0; --i)
        if (random.chance(share)) handles.push_back(i);
      asked.contacts_of(handles, contacts);
      two.contacts_of(handles, with_two);
      std::vector<ContactPoint> expected = bodies.found_afresh();
      std::erase_if(expected, [&](const ContactPoint& point) {
        return std::ranges::find(handles, point.key.a) == handles.end() &&
               std::ranges::find(handles, point.key.b) == handles.end();
      });
      REQUIRE(same_but_previous(contacts, expected));
      REQUIRE(same_but_previous(with_two, expected));
      CHECK(std::ranges::all_of(contacts, [](const ContactPoint& p) { return p.previous == -1; }));
      if (step % 7 != 0) continue;
      asked.find(asked_before);
      silent.find(all);
      REQUIRE(same_but_previous(all, asked_before));
      for (std::size_t i = 0; i < all.size(); ++i)
        REQUIRE(all[i].previous == asked_before[i].previous);
    }
  }
}

TEST_CASE("contacts of some bodies: bodies that come, go and change their shape in between") {
  Random random(8);
  const SharedShape block = box(kBrick), tip = tetrahedron();
  ContactFinder finder({.reach = 1e-3});
  for (const Placement& place : wall(6, 6, 1e-4, random)) finder.add(block, place);
  std::vector<ContactPoint> contacts, all;
  finder.find(contacts);
  std::vector<int> present;
  for (int i = 0; i < 36; ++i) present.push_back(i);
  for (int step = 0; step < 60; ++step) {
    CAPTURE(step);
    const auto some =
        static_cast<std::size_t>(random.integer(0, static_cast<int>(present.size()) - 1));
    const Placement place = finder.body(present[some]).placement();
    if (step % 3 == 0) finder.replace_shape(present[some], random.chance(0.5) ? tip : block);
    if (step % 3 == 1) present.push_back(finder.add(random.chance(0.5) ? tip : block, place));
    if (step % 3 == 2) {
      finder.remove(present[some]);
      present.erase(present.begin() + static_cast<std::ptrdiff_t>(some));
    }
    finder.contacts_of(present, contacts);
    ContactFinder fresh({.reach = 1e-3});
    for (const int handle : present) {
      fresh.add(SharedShape(SharedShape(), &finder.body(handle).shape()),
                finder.body(handle).placement());
    }
    fresh.find(all);
    for (ContactPoint& point : all) {
      point.key.a = present[static_cast<std::size_t>(point.key.a)];
      point.key.b = present[static_cast<std::size_t>(point.key.b)];
    }
    REQUIRE(same_but_previous(contacts, all));
  }
  CHECK_THROWS_AS(finder.contacts_of(std::vector<int>{1000}, contacts), InputError);
}

TEST_CASE("contacts of some bodies: once warm nothing is allocated") {
  Random random(4);
  const SharedShape block = box(kBrick);
  ContactFinder finder({.reach = 1e-3});
  for (const Placement& place : wall(10, 10, 0.0, random)) finder.add(block, place);
  const Vector3 start = finder.body(44).placement().translation;
  const std::vector<int> handles{44};
  std::vector<ContactPoint> contacts;
  finder.find(contacts);
  const auto move = [&](int step) {
    finder.move(44, {Matrix3::Identity(), start + Vector3(0, 1e-5 * (step % 4), 0)});
    const FindCounts counts = finder.contacts_of(handles, contacts);
    CHECK(counts.candidates < 12);
  };
  for (int step = 0; step < 8; ++step) move(step);
  const long before = quoin::tests::allocations;
  for (int step = 0; step < 8; ++step) move(step);
  CHECK(quoin::tests::allocations == before);
  CHECK(contacts.size() > 10);
}
