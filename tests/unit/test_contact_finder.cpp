#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <quoin/geometry.hpp>

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

const Vector3 kBrick(0.4, 0.2, 0.2);  // m

/// A wall in running bond: `rows` courses of `columns` bricks, each brick off its place by
/// `jitter`.
std::vector<Shape> wall(int rows, int columns, double jitter, Random& random) {
  std::vector<Shape> blocks;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Vector3 corner(kBrick.x() * (column + 0.5 * (row % 2)), 0, kBrick.z() * row);
      const Vector3 shift = jitter * random.point(-1, 1);
      blocks.push_back(make_box(corner + shift, corner + kBrick + shift));
    }
  }
  return blocks;
}

void shake(std::vector<Shape>& blocks, double jitter, Random& random) {
  for (Shape& block : blocks) {
    const Vector3 shift = jitter * random.point(-1, 1);
    block.set_vertices(block.vertices().colwise() + shift);
  }
}

bool sorted(const std::vector<ContactPoint>& contacts) {
  return std::is_sorted(contacts.begin(), contacts.end(),
                        [](const ContactPoint& c, const ContactPoint& d) { return c.key < d.key; });
}

/// A code that moves vertices freely: block i has handle i, and gets a new shape when it changes.
class VertexFinder {
 public:
  explicit VertexFinder(const FinderOptions& options) : finder_(options) {}

  FindCounts find(const std::vector<Shape>& blocks, std::vector<ContactPoint>& contacts) {
    for (; shapes_.size() > blocks.size(); shapes_.pop_back())
      finder_.remove(static_cast<int>(shapes_.size()) - 1);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (i < shapes_.size() && is(*shapes_[i], blocks[i])) continue;
      auto shape = std::make_shared<const Shape>(blocks[i]);
      if (i < shapes_.size()) {
        finder_.replace_shape(static_cast<int>(i), shape);
        shapes_[i] = shape;
      } else {
        finder_.add(shape);
        shapes_.push_back(shape);
      }
    }
    return finder_.find(contacts);
  }
  void set_reach(double reach) { finder_.set_reach(reach); }

 private:
  static bool is(const Shape& shape, const Shape& block) {
    return shape.shared_topology() == block.shared_topology() &&
           shape.vertices() == block.vertices();
  }
  ContactFinder finder_;
  std::vector<std::shared_ptr<const Shape>> shapes_;
};

std::vector<ContactPoint> found(const std::vector<Shape>& blocks, double reach) {
  std::vector<ContactPoint> contacts;
  VertexFinder({.reach = reach}).find(blocks, contacts);
  return contacts;
}

}  // namespace

TEST_CASE("finder: two stacked bricks, each corner a contact with its share of the area") {
  const std::vector<Shape> blocks{make_box(Vector3::Zero(), kBrick),
                                  make_box({0.2, 0, 0.2}, Vector3(0.6, 0.2, 0.4))};
  const std::vector<ContactPoint> contacts = found(blocks, 1e-3);
  REQUIRE(contacts.size() == 4);
  CHECK(sorted(contacts));
  double area = 0.0;
  for (const ContactPoint& contact : contacts) {
    CHECK(contact.key.a == 0);
    CHECK(contact.key.b == 1);
    CHECK(contact.type == ContactType::FaceFace);
    CHECK(contact.normal == Vector3::UnitZ());
    CHECK(contact.gap == 0.0);
    area += contact.area;
  }
  CHECK_THAT(area, WithinRel(0.04, 1e-14));
}

TEST_CASE("finder: gaps beyond reach are not listed, touching ones always are") {
  std::vector<Shape> blocks{make_box({0, 0, 0}, {1, 1, 1}), make_box({0, 0, 1.25}, {1, 1, 2})};
  CHECK(found(blocks, 0.2).empty());
  CHECK(found(blocks, 0.25).size() == 4);
  blocks[1] = make_box({0, 0, 1 + 0x1p-50}, {1, 1, 2});  // apart by less than tol
  CHECK(found(blocks, 0.0).size() == 4);
  VertexFinder finder({.reach = 0.0});
  std::vector<ContactPoint> contacts;
  blocks[1] = make_box({0, 0, 1.25}, {1, 1, 2});
  finder.find(blocks, contacts);
  CHECK(contacts.empty());
  finder.set_reach(0.5);
  finder.find(blocks, contacts);
  CHECK(contacts.size() == 4);
}

TEST_CASE("finder: the same list for any number of threads and any history") {
  Random random(21);
  std::vector<Shape> blocks = wall(20, 20, 1e-4, random);
  VertexFinder one({.reach = 1e-3}), two({.reach = 1e-3, .threads = 2}),
      five({.reach = 1e-3, .threads = 5});
  std::vector<ContactPoint> contacts, with_two, with_five;
  for (int step = 0; step < 10; ++step) {
    one.find(blocks, contacts);
    two.find(blocks, with_two);
    five.find(blocks, with_five);
    REQUIRE(contacts.size() > 1000);
    REQUIRE(sorted(contacts));
    REQUIRE(same_but_previous(contacts, with_two));
    REQUIRE(same_but_previous(contacts, with_five));
    REQUIRE(same_but_previous(contacts, found(blocks, 1e-3)));  // no history at all
    shake(blocks, step % 3 == 2 ? 0.02 : 1e-4, random);
  }
}

TEST_CASE("finder: pairs of blocks that stand still are not searched again, and nobody can tell") {
  Random random(34);
  std::vector<Shape> blocks = wall(12, 12, 1e-4, random);
  VertexFinder one({.reach = 1e-3}), two({.reach = 1e-3, .threads = 2});
  std::vector<ContactPoint> contacts, with_two;
  int least = 1 << 30;
  for (int step = 0; step < 60; ++step) {
    const double reach = step / 10 % 2 == 0 ? 1e-3 : 2e-3;
    one.set_reach(reach);
    two.set_reach(reach);
    const FindCounts counts = one.find(blocks, contacts);
    REQUIRE(two.find(blocks, with_two).searched == counts.searched);
    REQUIRE(same_but_previous(contacts, found(blocks, reach)));
    REQUIRE(same_but_previous(contacts, with_two));
    least = std::min(least, counts.searched);
    const double share = step % 7 == 0 ? 0.3 : step % 7 == 1 ? 0.01 : 0.0;
    for (Shape& block : blocks) {
      if (random.chance(share))
        block.set_vertices(block.vertices().colwise() + Vector3(1e-4 * random.direction()));
      if (random.chance(0.1 * share))  // the same place, other faces: triangles
        block = quoin::geometry::make_hull(block.vertices()).polyhedron;
    }
  }
  CHECK(least == 0);
}

TEST_CASE("finder: the same contacts for any order of the blocks, but for their names") {
  Random random(8);
  const std::vector<Shape> blocks = wall(8, 8, 1e-4, random);
  std::vector<int> order(blocks.size());
  std::iota(order.begin(), order.end(), 0);
  for (int i = static_cast<int>(order.size()) - 1; i > 0; --i) {
    std::swap(order[static_cast<std::size_t>(i)],
              order[static_cast<std::size_t>(random.integer(0, i))]);
  }
  std::vector<Shape> shuffled;
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
  std::vector<Shape> blocks = wall(6, 6, 0.0, random);
  VertexFinder finder({.reach = 1e-2});
  std::vector<ContactPoint> before, now;
  finder.find(blocks, before);
  for (int step = 0; step < 20; ++step) {
    for (std::size_t i = 0; i < blocks.size(); ++i) {  // each course slides on the one below
      blocks[i].set_vertices(blocks[i].vertices().colwise() +
                             Vector3(2e-4 * static_cast<double>(i / 6), 0, 0));
    }
    finder.find(blocks, now);
    REQUIRE(now.size() == before.size());
    const std::vector<int> previous = match_previous(now, before);
    for (std::size_t i = 0; i < now.size(); ++i) {
      REQUIRE(previous[i] >= 0);
      REQUIRE(now[i].previous == previous[i]);  // the finder knows, too: the topology is the same
    }
    std::swap(now, before);
  }
}

TEST_CASE("finder: a contact that slides over an edge hands its history on") {
  // a tetrahedron's tip goes along the slope of a wedge and over its ridge
  Points slope(3, 6), tip(3, 4);
  slope << -1, 1, -1, 1, 0, 0, -1, -1, 1, 1, -1, 1, 0, 0, 0, 0, 0.1, 0.1;
  tip << 0, 0.5, -0.5, 0, 0, 0.5, 0.5, -0.5, 0, 1, 1, 1;
  std::vector<Shape> blocks{quoin::geometry::make_hull(slope).polyhedron,
                            quoin::geometry::make_hull(tip).polyhedron};
  const Points at_origin = blocks[1].vertices();
  VertexFinder finder({.reach = 1e-2});
  std::vector<ContactPoint> before, now;
  std::vector<ContactKey> keys;
  for (int step = -10; step <= 10; ++step) {
    const double x = 0.01 * step + 0.003;
    blocks[1].set_vertices(at_origin.colwise() + Vector3(x, 0, 0.1 - 0.1 * std::abs(x) + 1e-4));
    finder.find(blocks, now);
    REQUIRE(now.size() >= 1);
    if (step > -10) {
      const std::vector<int> previous = match_previous(now, before, 0.05);
      CHECK(std::count_if(previous.begin(), previous.end(), [](int p) { return p >= 0; }) >= 1);
    }
    keys.push_back(now.front().key);
    std::swap(now, before);
  }
  CHECK(keys.front() != keys.back());  // it did change its face
}

TEST_CASE("finder: two idle blocks are never tested") {
  Random random(4);
  const std::vector<Shape> blocks = wall(5, 5, 0.0, random);
  ContactFinder finder({.reach = 1e-3});
  std::vector<ContactPoint> contacts;
  for (const Shape& block : blocks)
    finder.add(std::make_shared<const Shape>(block), {}, {.motion = BodyMotion::Idle});
  finder.find(contacts);
  CHECK(contacts.empty());
  finder.set_options(12, {});
  finder.find(contacts);
  CHECK(!contacts.empty());
  for (const ContactPoint& contact : contacts) CHECK((contact.key.a == 12 || contact.key.b == 12));
}

TEST_CASE("finder: blocks come, go and change their shape between calls") {
  Random random(9);
  std::vector<Shape> blocks = wall(6, 6, 1e-4, random);
  VertexFinder finder({.reach = 1e-3, .threads = 2});
  std::vector<ContactPoint> contacts;
  for (int step = 0; step < 12; ++step) {
    if (step % 3 == 1) {
      blocks.pop_back();
    } else if (step % 3 == 2) {  // another topology in the same place
      const Points points = blocks[7].vertices().leftCols(7);
      blocks[7] = quoin::geometry::make_hull(points).polyhedron;
    } else {
      blocks[7] = make_box(blocks[8].box().min, blocks[8].box().max);
    }
    finder.find(blocks, contacts);
    REQUIRE(same_but_previous(contacts, found(blocks, 1e-3)));
  }
  finder.find({}, contacts);
  CHECK(contacts.empty());
}

TEST_CASE("finder: once warm it allocates nothing") {
  for (const int threads : {1, 2}) {
    Random random(14);
    ContactFinder finder({.reach = 1e-2, .threads = threads});
    for (const Shape& block : wall(12, 12, 1e-4, random))
      finder.add(std::make_shared<const Shape>(block));
    std::vector<ContactPoint> contacts;
    const auto shake_and_find = [&](double jitter) {
      for (int i = 0; i < finder.size(); ++i)
        finder.move(i, {.translation = jitter * random.point(-1, 1)});
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

TEST_CASE("bodies: once warm the finder itself allocates nothing") {
  for (const int threads : {1, 2}) {
    Random random(14);
    const auto brick = std::make_shared<const Shape>(make_box(-0.5 * kBrick, 0.5 * kBrick));
    ContactFinder finder({.reach = 1e-2, .threads = threads});
    std::vector<Placement> places;
    for (const Shape& block : wall(12, 12, 1e-4, random)) {
      places.push_back({.translation = 0.5 * (block.box().min + block.box().max)});
      finder.add(brick, places.back());
    }
    std::vector<ContactPoint> contacts, alone;
    for (int step = 0; step < 25; ++step) {
      for (int i = 0; i < finder.size(); ++i) {
        places[static_cast<std::size_t>(i)].translation +=
            (step < 5 ? 1e-4 : 1e-5) * random.direction();
        finder.move(i, places[static_cast<std::size_t>(i)]);
      }
      const long before = allocations;
      const int searched = finder.find(contacts).searched;
      const long in_find = allocations - before;
      if (step < 5) continue;
      const PairResult& pair = finder.pairs()[0];  // what the query of one pair allocates
      alone.reserve(100);
      alone.clear();
      const long before_one = allocations;
      append_contacts_within_reach({0, 1}, finder.body(pair.a), finder.body(pair.b),
                                   {.reach = 1e-2}, FeatureHint{}, alone);
      CHECK(in_find == searched * (allocations - before_one));
    }
    CHECK(contacts.size() > 1000);
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
  const auto brick = std::make_shared<const Shape>(make_box(-0.5 * kBrick, 0.5 * kBrick));
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
