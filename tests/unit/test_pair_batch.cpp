#include <algorithm>
#include <array>
#include <limits>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/pair_batch.hpp>
#include <quoin/geometry/worker_pool.hpp>

#include "support/bricks.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"
#include "support/same_contacts.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;

Placement at(double z) { return {quoin::geometry::Matrix3::Identity(), Vector3(0, 0, z)}; }

struct Stack {
  Shape cube = quoin::geometry::make_box({0, 0, 0}, {1, 1, 1});
  std::vector<Body> bodies;
  explicit Stack(int count) {
    for (int i = 0; i < count; ++i) bodies.emplace_back(cube, at(i));
  }
};

}  // namespace

TEST_CASE("pair batch: the caller's pairs in any order, each answered once") {
  const Stack stack(4);
  PairBatch batch({.reach = 1e-3});
  const std::vector<BlockPair> pairs{{3, 2}, {0, 1}, {1, 0}, {0, 3}, {2, 1}};
  std::vector<ContactPoint> contacts;
  const quoin::geometry::FindCounts counts = batch.find(BodySource(stack.bodies), pairs, contacts);
  CHECK(counts.candidates == 4);
  REQUIRE(contacts.size() == 12);
  REQUIRE(batch.pairs().size() == 3);
  for (int i = 0; i < 3; ++i) {
    const quoin::geometry::PairResult& pair = batch.pairs()[static_cast<std::size_t>(i)];
    CHECK(pair.a == i);
    CHECK(pair.b == i + 1);
    CHECK(pair.event == PairEvent::Begin);
    CHECK(pair.first == 4 * i);
    CHECK(pair.count == 4);
    CHECK(contacts[static_cast<std::size_t>(4 * i)].key.a == i);
  }
}

TEST_CASE("pair batch: history goes by names, whatever place a body has in the row") {
  Stack stack(3);
  PairBatch batch({.reach = 1e-3});
  std::vector<ContactPoint> before, now;
  BodySource source(stack.bodies);
  const std::vector<int> names{10, 20, 30};
  source.names = names;
  batch.find(source, std::vector<BlockPair>{{0, 1}, {1, 2}}, before);
  CHECK(before.front().key.a == 10);
  CHECK(before.back().key.b == 30);
  stack.bodies.erase(stack.bodies.begin());  // 20 and 30 are left
  BodySource left(stack.bodies);
  left.names = std::span(names).subspan(1);
  batch.find(left, std::vector<BlockPair>{{0, 1}}, now);
  REQUIRE(now.size() == 4);
  for (int i = 0; i < 4; ++i) {
    CHECK(now[static_cast<std::size_t>(i)].key == before[static_cast<std::size_t>(4 + i)].key);
    CHECK(now[static_cast<std::size_t>(i)].previous == 4 + i);
  }
  REQUIRE(batch.pairs().size() == 2);
  CHECK(batch.pairs()[0].a == 10);
  CHECK(batch.pairs()[0].event == PairEvent::End);
  CHECK(batch.pairs()[1].a == 20);
  CHECK(batch.pairs()[1].event == PairEvent::Persist);
}

TEST_CASE("pair batch: pairs end whatever their names") {
  for (const std::vector<int>& names :
       {std::vector<int>{10, 20, 30}, {-5, 0, 7}, {std::numeric_limits<int>::min(), -7, -1}}) {
    Stack stack(3);
    PairBatch batch({.reach = 1e-3});
    std::vector<ContactPoint> contacts;
    BodySource source(stack.bodies);
    source.names = names;
    batch.find(source, std::vector<BlockPair>{{0, 1}, {1, 2}}, contacts);
    REQUIRE(batch.pairs().size() == 2);
    batch.find(source, {}, contacts);
    REQUIRE(batch.pairs().size() == 2);
    for (const PairResult& pair : batch.pairs()) {
      CHECK(pair.event == PairEvent::End);
      CHECK(pair.count == 0);
    }
  }
}

TEST_CASE("pair batch: bodies that are said to stand are not searched again") {
  Stack stack(3);
  PairBatch batch({.reach = 1e-3});
  const std::vector<BlockPair> pairs{{0, 1}, {1, 2}};
  std::vector<ContactPoint> contacts;
  std::vector<BodyChange> changes(3, BodyChange::None);
  BodySource source(stack.bodies);
  source.changes = changes;
  CHECK(batch.find(source, pairs, contacts).searched == 2);
  CHECK(batch.find(source, pairs, contacts).searched == 0);
  CHECK(contacts.size() == 8);
  stack.bodies[2] = Body(stack.cube, at(2.5));
  changes[2] = BodyChange::Moved;
  CHECK(batch.find(source, pairs, contacts).searched == 1);
  CHECK(contacts.size() == 4);
  batch.set_reach(0.75);
  changes[2] = BodyChange::None;
  CHECK(batch.find(source, pairs, contacts).searched == 2);
  CHECK(contacts.size() == 8);
}

TEST_CASE("pair batch: input that makes no sense is refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Stack stack(3);
  CHECK_THROWS_AS(PairBatch({.reach = -1.0}), InputError);
  CHECK_THROWS_AS(PairBatch({.tolerance = nan}), InputError);
  PairBatch batch({.reach = 1e-3});
  CHECK_THROWS_AS(batch.set_reach(nan), InputError);
  std::vector<ContactPoint> contacts;
  BodySource source(stack.bodies);
  const auto find = [&](const std::vector<BlockPair>& pairs) {
    return message([&] { batch.find(source, pairs, contacts); });
  };
  CHECK(find({{0, 1}, {1, 3}}) == "pair 1 is (1, 3), must name two of 3 bodies");
  CHECK(find({{-1, 1}}) == "pair 0 is (-1, 1), must name two of 3 bodies");
  CHECK(find({{2, 2}}) == "pair 0 is (2, 2), must name two of 3 bodies");
  const std::vector<int> names{4, 4, 5}, two_names{1, 2};
  source.names = names;
  CHECK(find({{0, 1}}) == "pair batch: body 1 is named 4, must be more than 4");
  source.names = two_names;
  CHECK(find({{0, 1}}) == "pair batch: 2 names for 3 bodies");
  source.names = {};
  stack.bodies[1] = Body(stack.cube, at(nan));
  CHECK(find({{0, 1}}) ==
        "body 1: translation[2] of its placement is nan, must be finite and at most 1e+30");
  CHECK(find({{0, 2}}).empty());  // nobody asks for it
  CHECK(find({{2, 1}}) ==
        "body 1: translation[2] of its placement is nan, must be finite and at most 1e+30");
  stack.bodies[1] = Body(stack.cube, at(1));
  CHECK(find({{0, 1}}).empty());
  CHECK(contacts.size() == 4);
  source.body = nullptr;
  CHECK(find({{0, 1}}) == "pair batch: there is no function that gives the 3 bodies");
  PairBatch next = std::move(batch);
  CHECK(find({{0, 1}}) == "pair batch: it was moved from");  // NOLINT: meant
}

TEST_CASE("pair batch: more bodies than are kept made at a time") {
  const Stack stack(1100);
  PairBatch batch({.reach = 1e-3});
  std::vector<BlockPair> pairs;
  for (int i = 0; i + 1 < 1100; ++i) pairs.push_back({i, i + 1});
  for (int i = 0; i + 512 < 1100; ++i) pairs.push_back({i, i + 512});  // far apart
  std::vector<ContactPoint> contacts;
  batch.find(BodySource(stack.bodies), pairs, contacts);
  REQUIRE(contacts.size() == 4 * 1099);
  for (std::size_t k = 0; k < contacts.size(); ++k)
    CHECK(contacts[k].point().z() == static_cast<double>(k / 4 + 1));
}

TEST_CASE("pair batch: bodies known as apart come into reach as in a batch that knows nothing") {
  const Stack stack(1);
  PairBatch warm({.reach = 0.1});
  std::vector<ContactPoint> found, expected;
  int in_reach = 0, changes = 0;
  bool was_in_reach = false;
  for (int step = 0; step < 400; ++step) {
    const double angle = 0.3 * step;
    quoin::geometry::Placement aside;
    aside.linear = quoin::tests::rotation_about({0.6, 0.0, 0.8}, 0.1 * angle);
    aside.translation = 1.4 * Vector3(std::cos(angle), std::sin(angle), std::sin(3 * angle));
    const std::vector<Body> bodies{Body(stack.cube), Body(stack.cube, aside)};
    const std::vector<BlockPair> pairs{{0, 1}};
    PairBatch cold({.reach = 0.1});
    warm.find(BodySource(bodies), pairs, found);
    cold.find(BodySource(bodies), pairs, expected);
    REQUIRE(found.size() == expected.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      CHECK(found[k].key == expected[k].key);
      CHECK(found[k].gap == expected[k].gap);
    }
    in_reach += !found.empty();
    changes += was_in_reach != !found.empty();
    was_in_reach = !found.empty();
  }
  CHECK(in_reach > 50);
  CHECK(changes > 50);
}

namespace {

/// A wall of bricks, turned as a whole; each brick is shaken by so much, m and rad.
std::vector<Body> shaken_wall(const Shape& brick, quoin::tests::Random& random, double shake,
                              double lean) {
  const quoin::geometry::Matrix3 heading =
      quoin::tests::rotation_about(Vector3(0.6, 0.0, 0.8), 0.4);
  std::vector<Body> bodies;
  for (int row = 0; row < 6; ++row) {
    for (int k = 0; k < 8; ++k) {
      const Vector3 at(0.501 * (k + 0.5 * (row % 2)), 0.0, 0.201 * row);
      const auto turn = quoin::tests::rotation_about(random.direction(), lean);
      bodies.emplace_back(brick, Placement{lean > 0.0 ? heading * turn : heading,
                                           heading * (at + shake * random.direction())});
    }
  }
  return bodies;
}

}  // namespace

TEST_CASE(
    "pair batch: a shaken wall is answered as its pairs are alone, on any number of threads") {
  quoin::tests::Random random(41);
  const Shape brick = quoin::geometry::make_box({0.1, 0, 0}, {0.6, 0.3, 0.2});
  const quoin::geometry::ContactOptions options{.reach = 4e-3};
  std::vector<BlockPair> pairs;
  for (int i = 0; i < 48; ++i)
    for (int k = i + 1; k < 48; ++k) pairs.push_back({i, k});
  quoin::geometry::WorkerPool one(1), two(2), three(3);
  const std::array<quoin::geometry::WorkerPool*, 3> pools{&one, &two, &three};
  for (const double lean : {0.0, 1e-12, 1e-4}) {
    std::vector<PairBatch> batches;
    for (int k = 0; k < 3; ++k) batches.emplace_back(options);
    for (int step = 0; step < 12; ++step) {
      const std::vector<Body> bodies = shaken_wall(brick, random, 3e-4, lean);
      std::vector<ContactPoint> expected, found;
      for (const BlockPair& pair : pairs) {
        append_contacts_within_reach({pair.a, pair.b}, bodies[static_cast<std::size_t>(pair.a)],
                                     bodies[static_cast<std::size_t>(pair.b)], options, {},
                                     expected);
      }
      REQUIRE(expected.size() > 300);
      for (std::size_t k = 0; k < 3; ++k) {
        CAPTURE(lean, step, k);
        batches[k].find(BodySource(bodies), pairs, found, pools[k]);
        REQUIRE(same_but_previous(found, expected));
      }
    }
  }
}
