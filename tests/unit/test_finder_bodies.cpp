#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <quoin/geometry.hpp>
#include <tuple>

#include "support/bricks.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"
#include "support/same_contacts.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;

Placement at(const Vector3& place, const Matrix3& linear = Matrix3::Identity()) {
  return {linear, place};
}

/// Of a wall of bricks that are off by `jitter`, m.
ContactFinder finder_of_wall(int rows, int columns, double jitter, std::uint64_t seed) {
  Random random(seed);
  const SharedShape brick = box(kBrick);
  ContactFinder finder({.reach = 1e-3});
  for (const Placement& place : wall(rows, columns, jitter, random)) finder.add(brick, place);
  return finder;
}

/// A rotation by a small angle (rad) about z, exact enough to be one.
Matrix3 turned(double angle) {
  Matrix3 m;
  m << std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1;
  return m;
}

bool sorted(const std::vector<ContactPoint>& contacts) {
  return std::is_sorted(contacts.begin(), contacts.end(),
                        [](const ContactPoint& c, const ContactPoint& d) { return c.key < d.key; });
}

/// What a finder without history finds for the bodies of `finder`, under their handles.
std::vector<ContactPoint> found_afresh(const ContactFinder& finder, int handles, double reach,
                                       const std::vector<BodyOptions>& options) {
  ContactFinder fresh({.reach = reach});
  std::vector<int> names;
  for (int handle = 0; handle < handles; ++handle) {
    if (!finder.contains(handle)) continue;
    const quoin::geometry::Body body = finder.body(handle);
    fresh.add(SharedShape(SharedShape(), &body.shape()), body.placement(),
              options[static_cast<std::size_t>(handle)]);
    names.push_back(handle);
  }
  std::vector<ContactPoint> contacts;
  fresh.find(contacts);
  for (ContactPoint& contact : contacts) {
    contact.key.a = names[static_cast<std::size_t>(contact.key.a)];
    contact.key.b = names[static_cast<std::size_t>(contact.key.b)];
  }
  return contacts;
}

/// What events, ranges and predecessors mean, held against the two lists and results themselves.
void check_against_before(const ContactFinder& finder, const std::vector<ContactPoint>& now,
                          const std::vector<PairResult>& results_before,
                          const std::vector<ContactPoint>& before) {
  std::map<std::pair<int, int>, PairResult> old;
  for (const PairResult& result : results_before)
    if (result.event != PairEvent::End) old[{result.a, result.b}] = result;
  int point = 0;
  std::pair<int, int> last(-1, -1);
  for (const PairResult& result : finder.pairs()) {
    const std::pair names(result.a, result.b);
    REQUIRE(last < names);
    last = names;
    const auto was = old.find(names);
    REQUIRE((was == old.end()) == (result.event == PairEvent::Begin));
    if (result.event == PairEvent::End) {
      REQUIRE(std::tie(result.count, result.first) == std::tuple(0, 0));
      REQUIRE(result.gap == was->second.gap);
    } else {
      REQUIRE(result.first == point);
      for (; point < result.first + result.count; ++point) {
        const ContactPoint& contact = now[static_cast<std::size_t>(point)];
        REQUIRE(std::pair(contact.key.a, contact.key.b) == names);
        if (was == old.end()) REQUIRE(contact.previous == -1);
      }
    }
    if (was != old.end()) old.erase(was);
  }
  REQUIRE(old.empty());
  REQUIRE(point == static_cast<int>(now.size()));
  std::map<quoin::geometry::ContactKey, int> place;
  for (const ContactPoint& contact : before) place.emplace(contact.key, place.size());
  for (const ContactPoint& contact : now) {
    const auto namesake = place.find(contact.key);
    if (namesake != place.end()) REQUIRE(contact.previous == namesake->second);
    if (contact.previous < 0) continue;
    const ContactPoint& old_one = before[static_cast<std::size_t>(contact.previous)];
    REQUIRE(std::tie(old_one.key.a, old_one.key.b) == std::tie(contact.key.a, contact.key.b));
  }
}

}  // namespace

TEST_CASE("bodies: two stacked bricks of one shape") {
  const SharedShape brick = box(kBrick);
  ContactFinder finder({.reach = 1e-3});
  CHECK(finder.add(brick, at({0, 0, 0})) == 0);
  CHECK(finder.add(brick, at({0.2, 0, 0.25})) == 1);
  CHECK(finder.size() == 2);
  std::vector<ContactPoint> contacts;
  finder.find(contacts);
  CHECK(contacts.empty());
  finder.move(1, at({0.2, 0, 0.2}));
  const FindCounts counts = finder.find(contacts);
  CHECK(counts.candidates == 1);
  REQUIRE(contacts.size() == 4);
  CHECK(sorted(contacts));
  double area = 0.0;
  for (const ContactPoint& contact : contacts) {
    CHECK(contact.key.a == 0);
    CHECK(contact.key.b == 1);
    CHECK(contact.normal == Vector3::UnitZ());
    CHECK_THAT(contact.gap, WithinAbs(0.0, 1e-15));
    CHECK(contact.previous == -1);
    area += contact.area;
  }
  CHECK_THAT(area, WithinRel(0.04, 1e-12));
}

TEST_CASE("bodies: placed and deformed ones touch as their vertices in the world do") {
  Random random(5);
  const SharedShape brick = box(kBrick), tip = tetrahedron();
  ContactFinder finder({.reach = 2e-3});
  std::vector<Shape> blocks;
  const Matrix3 turn = random.rotation();
  Matrix3 strain = Matrix3::Identity();
  strain.diagonal() += Vector3(1e-4, -2e-4, 1e-4);
  for (const Placement& place : wall(6, 6, 2e-4, random)) {
    const SharedShape& shape = random.chance(0.2) ? tip : brick;
    const Placement placement{turn * strain, turn * place.translation + Vector3(3, -8, 5)};
    Points vertices(3, shape->vertex_count());
    for (int v = 0; v < shape->vertex_count(); ++v)
      vertices.col(v) = placement.translation + placement.linear * shape->vertex(v);
    blocks.push_back(*shape);
    blocks.back().set_vertices(vertices);
    finder.add(shape, placement);
  }
  std::vector<ContactPoint> contacts, expected;
  finder.find(contacts);
  ContactFinder by_vertices({.reach = 2e-3});
  for (const Shape& block : blocks) by_vertices.add(std::make_shared<const Shape>(block));
  by_vertices.find(expected);
  REQUIRE(expected.size() > 100);
  REQUIRE(contacts.size() == expected.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    CHECK(contacts[i].key == expected[i].key);
    CHECK(contacts[i].type == expected[i].type);
    CHECK((contacts[i].point() - expected[i].point()).norm() < 1e-12);
    CHECK_THAT(contacts[i].gap, WithinAbs(expected[i].gap, 1e-13));
    CHECK_THAT(contacts[i].area, WithinAbs(expected[i].area, 1e-12));
  }
}

TEST_CASE("bodies: a million metres away nothing is lost") {
  const Vector3 away(1e6, -1e6, 1e6);
  const SharedShape brick = box({0.5, 0.25, 0.25});
  ContactFinder finder({.reach = 1e-3});
  for (int i = 0; i < 40; ++i) finder.add(brick, at(away + Vector3(0, 0, 0.25 * i)));
  std::vector<ContactPoint> contacts;
  finder.find(contacts);
  REQUIRE(contacts.size() == 4 * 39);
  for (const ContactPoint& contact : contacts) CHECK(contact.gap == 0.0);
  CHECK(finder.pairs().size() == 39);
  for (const PairResult& pair : finder.pairs()) CHECK(pair.area == 0.125);
}

TEST_CASE("bodies: boxes hold the image in any placement") {
  Random random(17);
  const SharedShape tip = tetrahedron();
  for (int i = 0; i < 200; ++i) {
    // a vertex touches a plate from above, wherever the pair stands and however the body is turned
    const Matrix3 turn = random.rotation();
    const Vector3 away = random.log_uniform(1e-3, 1e6) * random.direction();
    double lowest = 1.0;
    for (int v = 0; v < 4; ++v) lowest = std::min(lowest, turn.row(2).dot(tip->vertex(v)));
    ContactFinder finder({.reach = 1e-6});
    finder.add(box({2, 2, 1}), at(away));
    finder.add(tip, at(away + Vector3(0, 0, 0.5 - lowest), turn));
    for (int k = 0; k < 20; ++k) finder.add(tip, at(away + Vector3(10.0 + k, 0, 0)));
    std::vector<ContactPoint> contacts;
    finder.find(contacts);
    CHECK(contacts.size() >= 1);
  }
}

TEST_CASE("bodies: erasing one renames nothing, and its handle never comes again") {
  ContactFinder finder = finder_of_wall(5, 5, 1e-5, 6);
  const SharedShape brick = box(kBrick);
  std::vector<ContactPoint> before, now;
  finder.find(before);
  finder.remove(7);
  CHECK(!finder.contains(7));
  CHECK(finder.size() == 24);
  finder.find(now);
  std::erase_if(before, [](const ContactPoint& c) { return c.key.a == 7 || c.key.b == 7; });
  CHECK(same_but_previous(now, before));
  CHECK(std::all_of(now.begin(), now.end(), [](const auto& c) { return c.previous >= 0; }));
  CHECK(finder.add(brick, at({0, 5, 0})) == 25);
  CHECK(message([&] { finder.move(7, {}); }) == "body 7 has been removed");
  CHECK(message([&] { finder.remove(7); }) == "body 7 has been removed");
  CHECK(message([&] { finder.replace_shape(7, brick); }) == "body 7 has been removed");
  CHECK(message([&] { finder.set_options(26, {}); }) == "body 26 does not exist");
  CHECK(message([&] { finder.body(-1); }) == "body -1 does not exist");
}

TEST_CASE("bodies: whatever happened before, the list is that of a new finder") {
  const SharedShape brick = box(kBrick), tip = tetrahedron();
  Random random(77);
  ContactFinder finder({.reach = 1e-3}), two({.reach = 1e-3, .threads = 5});
  std::vector<BodyOptions> options;
  std::vector<Placement> places = wall(12, 12, 1e-4, random);
  const auto add = [&](const Placement& place) {
    BodyOptions some;
    some.category = random.chance(0.1) ? 2 : 1;
    some.collides_with = random.chance(0.1) ? 1 : 3;
    some.motion = random.chance(0.1) ? BodyMotion::Idle : BodyMotion::Moving;
    const SharedShape& shape = random.chance(0.2) ? tip : brick;
    options.push_back(some);
    REQUIRE(two.add(shape, place, some) == finder.add(shape, place, some));
  };
  for (const Placement& place : places) add(place);
  std::vector<ContactPoint> contacts, with_two, before;
  int least = 1 << 30;  // pairs searched in a step
  for (int step = 0; step < 60; ++step) {
    const int handles = static_cast<int>(options.size());
    const double share = step % 5 == 0 ? 0.5 : step % 5 == 1 ? 0.02 : 0.0;
    for (int handle = 0; handle < handles; ++handle) {
      if (!finder.contains(handle)) continue;
      if (random.chance(share)) {
        const Placement place{
            turned(random.uniform(-1e-4, 1e-4)),
            finder.body(handle).placement().translation + 1e-4 * random.direction()};
        finder.move(handle, place);
        two.move(handle, place);
      }
      if (random.chance(step == 30 ? 0.7 : 0.1 * share)) {
        finder.remove(handle);
        two.remove(handle);
      } else if (random.chance(0.1 * share)) {
        finder.replace_shape(handle, tip);
        two.replace_shape(handle, tip);
      } else if (random.chance(0.1 * share)) {
        BodyOptions& some = options[static_cast<std::size_t>(handle)];
        some.motion = some.motion == BodyMotion::Idle ? BodyMotion::Moving : BodyMotion::Idle;
        finder.set_options(handle, some);
        two.set_options(handle, some);
      }
    }
    const int more = step == 40 ? 100 : step % 4 == 3 ? 3 : 0;
    for (int k = 0; k < more; ++k) add(places[static_cast<std::size_t>(random.integer(0, 143))]);
    const double reach = step / 10 % 2 == 0 ? 1e-3 : 2e-3;
    finder.set_reach(reach);
    two.set_reach(reach);
    const int searched = finder.find(contacts).searched;
    REQUIRE(two.find(with_two).searched == searched);
    least = std::min(least, searched);
    REQUIRE(sorted(contacts));
    REQUIRE(same_but_previous(contacts, with_two));
    const int names = static_cast<int>(options.size());
    REQUIRE(same_but_previous(contacts, found_afresh(finder, names, reach, options)));
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      REQUIRE(contacts[i].previous == with_two[i].previous);
      REQUIRE(contacts[i].previous < static_cast<int>(before.size()));
    }
    before = contacts;
  }
  CHECK(finder.size() > 20);
  CHECK(least == 0);
}

TEST_CASE("bodies: masks, the caller's filter and idle bodies leave pairs out") {
  const SharedShape brick = box({1, 1, 1});
  ContactFinder finder({.reach = 1e-3});
  std::vector<ContactPoint> contacts;
  for (int i = 0; i < 4; ++i) finder.add(brick, at({0, 0, 1.0 * i}));
  const auto touching = [&] {
    finder.find(contacts);
    std::vector<std::array<int, 2>> pairs;
    for (const PairResult& pair : finder.pairs())
      if (pair.event != PairEvent::End) pairs.push_back({pair.a, pair.b});
    return pairs;
  };
  using Pairs = std::vector<std::array<int, 2>>;
  CHECK(touching() == Pairs{{0, 1}, {1, 2}, {2, 3}});
  finder.set_options(1, {.category = 2, .collides_with = 1});
  CHECK(touching() == Pairs{{0, 1}, {1, 2}, {2, 3}});
  finder.set_options(2, {.category = 1, .collides_with = 1});  // 1 is none of what 2 meets
  CHECK(touching() == Pairs{{0, 1}, {2, 3}});
  finder.set_filter([](int a, int b) { return a != 2 || b != 3; });
  CHECK(touching() == Pairs{{0, 1}});
  finder.set_filter({});
  finder.set_options(1, {.motion = BodyMotion::Idle});
  finder.set_options(2, {.motion = BodyMotion::Idle});
  CHECK(touching() == Pairs{{0, 1}, {2, 3}});
  finder.set_options(1, {});
  finder.set_options(2, {});
  CHECK(touching() == Pairs{{0, 1}, {1, 2}, {2, 3}});
}

TEST_CASE("bodies: contacts begin, persist and end") {
  const SharedShape brick = box({1, 1, 1});
  ContactFinder finder({.reach = 0.01});
  std::vector<ContactPoint> contacts;
  finder.add(brick, at({0, 0, 0}));
  finder.add(brick, at({0, 0, 1.25}));
  finder.add(brick, at({0.5, 0, -1.0}));
  finder.find(contacts);
  REQUIRE(finder.pairs().size() == 1);
  CHECK(finder.pairs()[0].event == PairEvent::Begin);
  finder.move(1, at({0, 0, 1 - 0x1p-10}));
  finder.find(contacts);
  REQUIRE(finder.pairs().size() == 2);
  const PairResult over = finder.pairs()[0], under = finder.pairs()[1];
  CHECK(over.a == 0);
  CHECK(over.b == 1);
  CHECK(over.event == PairEvent::Begin);
  CHECK(over.status == PairStatus::Overlapping);
  CHECK(over.type == quoin::geometry::ContactType::FaceFace);
  CHECK(over.gap == -0x1p-10);
  CHECK(over.normal == Vector3::UnitZ());
  CHECK_THAT(over.area, WithinRel(1.0, 1e-12));
  CHECK(over.first == 0);
  CHECK(over.count == 4);
  CHECK(under.b == 2);
  CHECK(under.event == PairEvent::Persist);
  CHECK(under.status == PairStatus::Touching);
  CHECK(under.normal == -Vector3::UnitZ());
  CHECK(under.first == 4);
  CHECK(under.count == 4);
  finder.move(1, at({0, 0, 1.25}));
  finder.remove(2);
  finder.find(contacts);
  CHECK(contacts.empty());
  REQUIRE(finder.pairs().size() == 2);
  for (const PairResult& pair : finder.pairs()) {
    CHECK(pair.event == PairEvent::End);
    CHECK(pair.count == 0);
  }
  CHECK(finder.pairs()[0].gap == -0x1p-10);
  finder.find(contacts);
  CHECK(finder.pairs().empty());
}

TEST_CASE("bodies: what stands still is not searched again, and keeps its events and history") {
  ContactFinder finder = finder_of_wall(8, 8, 1e-5, 9);
  std::vector<ContactPoint> first, again;
  CHECK(finder.find(first).searched > 100);
  finder.find(first);
  for (int step = 0; step < 3; ++step) {
    const Placement same = finder.body(5).placement();
    finder.move(5, same);  // to where it is
    CHECK(finder.find(again).searched == 0);
    CHECK(same_but_previous(first, again));
    for (std::size_t i = 0; i < again.size(); ++i) CHECK(again[i].previous == static_cast<int>(i));
    for (const PairResult& pair : finder.pairs()) CHECK(pair.event == PairEvent::Persist);
  }
  finder.move(5, at({0.4001 * 5, 0.01, 0}));
  const int searched = finder.find(again).searched;
  CHECK(searched > 0);
  CHECK(searched < 10);
}

TEST_CASE("bodies: two that travel and turn together keep their history over an edge") {
  // a tetrahedron's tip goes along the slope of a wedge and over its ridge, while both fly along
  Points slope(3, 6), tip(3, 4);
  slope << -1, 1, -1, 1, 0, 0, -1, -1, 1, 1, -1, 1, 0, 0, 0, 0, 0.1, 0.1;
  tip << 0, 0.5, -0.5, 0, 0, 0.5, 0.5, -0.5, 0, 1, 1, 1;
  const auto shape = [](const Points& points) {
    return std::make_shared<const Shape>(quoin::geometry::make_hull(points).polyhedron);
  };
  ContactFinder finder({.reach = 0.05});
  finder.add(shape(slope));
  finder.add(shape(tip));
  std::vector<ContactPoint> before, now;
  int changes = 0;
  for (int step = -10; step <= 10; ++step) {
    const Matrix3 turn = turned(0.3 * step);
    const Vector3 flight(7.0 * step, -3.0 * step, 0.5 * step);
    const double x = 0.01 * step + 0.003;
    finder.move(0, at(flight, turn));
    finder.move(1, at(flight + turn * Vector3(x, 0, 0.1 - 0.1 * std::abs(x) + 1e-4), turn));
    finder.find(now);
    REQUIRE(now.size() == 1);
    if (step > -10) {
      CHECK(now[0].previous == 0);
      changes += now[0].key != before[0].key;
    }
    std::swap(now, before);
  }
  CHECK(changes >= 1);
}

TEST_CASE("bodies: places in their own frames are as good anywhere, and follow a moving pair") {
  Random random(71);
  const SharedShape brick = box({0.5, 0.25, 0.25}), tip = tetrahedron();
  for (int trial = 0; trial < 200; ++trial) {
    const Matrix3 turn = random.rotation();
    Matrix3 strain = Matrix3::Identity();
    if (trial % 2 == 1) strain.diagonal() += Vector3(1e-3, -2e-3, 1e-3);
    const Vector3 step(random.uniform(-0.3, 0.3), random.uniform(-0.1, 0.1), 0.2501);
    const Placement low{turn * strain, Vector3::Zero()}, high{turn * strain, turn * strain * step};
    const SharedShape& other = trial % 4 < 2 ? brick : tip;
    ContactFinder here({.reach = 0.5, .frame = PointFrame::Bodies});
    ContactFinder there({.reach = 0.5, .frame = PointFrame::Bodies});
    here.add(brick, low);
    here.add(other, high);
    // a translation that takes the rounding of the other one with it: the same pair, to the bit
    const Vector3 away(0x1p20, -0x1p21, 0x1p19);
    Placement far_high = high;
    far_high.translation += away;
    const Vector3 kept = far_high.translation - away;
    here.move(1, {high.linear, kept});
    there.add(brick, {low.linear, away});
    there.add(other, far_high);
    std::vector<ContactPoint> near, far;
    here.find(near);
    there.find(far);
    REQUIRE(near.size() >= 1);
    REQUIRE(near.size() == far.size());
    for (std::size_t i = 0; i < near.size(); ++i) {
      CHECK((near[i].point_a - far[i].point_a).norm() < 1e-14);
      CHECK((near[i].point_b - far[i].point_b).norm() < 1e-14);
      const Vector3 between = kept + high.linear * far[i].point_b - low.linear * far[i].point_a;
      CHECK_THAT(between.dot(far[i].normal), WithinAbs(far[i].gap, 1e-14));
    }
    there.move(0, {low.linear, away + Vector3(1, 0, 0)});
    there.move(1, {high.linear, far_high.translation + Vector3(1, 0, 0)});
    there.find(far);
    for (std::size_t i = 0; i < far.size(); ++i) CHECK(far[i].previous == static_cast<int>(i));
  }
}

TEST_CASE("bodies: a copy with other vertices has moved, and keeps its history") {
  ContactFinder finder({.reach = 1e-2});
  const SharedShape brick = box({1, 1, 1});
  finder.add(brick);
  finder.add(brick, at({0, 0, 1}));
  std::vector<ContactPoint> contacts;
  finder.find(contacts);
  Shape bent = *brick;
  Points vertices = bent.vertices();
  vertices.row(2) *= 0.999;
  bent.set_vertices(vertices);
  finder.replace_shape(1, std::make_shared<const Shape>(bent));
  finder.find(contacts);
  REQUIRE(contacts.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(contacts[i].previous == static_cast<int>(i));
}

TEST_CASE("bodies: another shape has no history") {
  ContactFinder finder({.reach = 1e-3});
  finder.add(box({1, 1, 1}));
  finder.add(box({1, 1, 1}), at({0, 0, 1}));
  std::vector<ContactPoint> contacts;
  finder.find(contacts);
  finder.replace_shape(1, box({1, 0.5, 1}));
  finder.find(contacts);
  REQUIRE(contacts.size() == 4);
  for (const ContactPoint& contact : contacts) CHECK(contact.previous == -1);
  CHECK(finder.pairs()[0].event == PairEvent::Persist);
  CHECK_THAT(finder.pairs()[0].area, WithinRel(0.5, 1e-12));
  finder.replace_shape(1, box({1, 0.5, 1}));  // its features may have any names
  finder.find(contacts);
  REQUIRE(contacts.size() == 4);
  for (const ContactPoint& contact : contacts) CHECK(contact.previous == -1);
  finder.find(contacts);
  for (const ContactPoint& contact : contacts) CHECK(contact.previous >= 0);
}

TEST_CASE("bodies: the results of many pairs, put in their place by two workers") {
  Random random(32);
  const SharedShape brick = box(kBrick);
  Backwards two(2);
  ContactFinder one({.reach = 1e-3}), other({.reach = 1e-3, .executor = &two});
  std::vector<Placement> places = wall(60, 60, 1e-5, random);
  for (const Placement& place : places) {
    one.add(brick, place);
    other.add(brick, place);
  }
  std::vector<ContactPoint> contacts, theirs;
  for (int step = 0; step < 4; ++step) {
    if (step == 3) {
      one.remove(1700);
      other.remove(1700);
    }
    one.find(contacts);
    other.find(theirs);
    REQUIRE(one.pairs().size() > 2 * 4096);
    REQUIRE(one.pairs().size() == other.pairs().size());
    for (std::size_t i = 0; i < one.pairs().size(); ++i) {
      const PairResult &x = one.pairs()[i], &y = other.pairs()[i];
      REQUIRE(std::tie(x.a, x.b, x.event, x.first, x.count, x.gap) ==
              std::tie(y.a, y.b, y.event, y.first, y.count, y.gap));
    }
    for (std::size_t i = 0; i < contacts.size(); ++i)
      REQUIRE(contacts[i].previous == theirs[i].previous);
    for (int i = 0; step < 2 && i < one.size(); ++i) {
      places[static_cast<std::size_t>(i)].translation += 1e-6 * random.direction();
      one.move(i, places[static_cast<std::size_t>(i)]);
      other.move(i, places[static_cast<std::size_t>(i)]);
    }
  }
  CHECK(one.threads() == 1);
  CHECK(other.threads() == 2);
  CHECK(two.calls == 2 * 4);  // pairs in each call, their points
}

TEST_CASE("bodies: pairs that begin, end, come and go, by any number of workers") {
  const SharedShape shapes[] = {box(kBrick), tetrahedron()};
  for (const int workers : {1, 2, 5}) {
    Random random(33);
    Backwards executor(workers);
    ContactFinder one({.reach = 2e-2}), other({.reach = 2e-2, .executor = &executor});
    std::vector<Placement> places = wall(14, 14, 1e-3, random);
    for (std::size_t i = 0; i < places.size(); ++i) {
      one.add(shapes[i % 3 == 0], places[i]);
      other.add(shapes[i % 3 == 0], places[i]);
    }
    std::vector<ContactPoint> contacts, theirs, before;
    std::vector<PairResult> results_before;
    std::map<PairEvent, int> seen;
    for (int step = 0; step < 40; ++step) {
      one.find(contacts);
      other.find(theirs);
      REQUIRE(same_but_previous(contacts, theirs));
      for (std::size_t i = 0; i < contacts.size(); ++i)
        REQUIRE(contacts[i].previous == theirs[i].previous);
      check_against_before(other, theirs, results_before, before);
      for (const PairResult& result : other.pairs()) ++seen[result.event];
      results_before.assign(other.pairs().begin(), other.pairs().end());
      before = theirs;
      for (std::size_t i = 0; i < places.size(); ++i) {
        if (!random.chance(step % 4 == 0 ? 0.05 : 0.7)) continue;
        places[i].translation += (step % 5 == 0 ? 5e-2 : 5e-3) * random.direction();
        one.move(static_cast<int>(i), places[i]);
        other.move(static_cast<int>(i), places[i]);
      }
    }
    CHECK(std::min({seen[PairEvent::Begin], seen[PairEvent::Persist], seen[PairEvent::End]}) > 500);
    CHECK((executor.calls >= 40) == (workers > 1));
  }
}

TEST_CASE("bodies: placements that are none are refused, and change nothing") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  ContactFinder finder({.reach = 1e-3});
  finder.add(box({1, 1, 1}));
  const auto refused = [&](const Placement& placement) {
    const std::string said = message([&] { finder.move(0, placement); });
    CHECK(finder.body(0).placement().translation == Vector3::Zero());
    CHECK(finder.body(0).placement().linear == Matrix3::Identity());
    return said;
  };
  CHECK(refused(at({0, nan, 0})) ==
        "body 0: translation[1] of its placement is nan, must be finite and at most 1e+30");
  CHECK(refused(at({0, 0, -infinity})) ==
        "body 0: translation[2] of its placement is -inf, must be finite and at most 1e+30");
  CHECK(refused(at({1e31, 0, 0})) ==
        "body 0: translation[0] of its placement is 1e+31, must be finite and at most 1e+30");
  Matrix3 linear = Matrix3::Identity();
  linear(2, 1) = nan;
  CHECK(refused(at({0, 0, 0}, linear)) ==
        "body 0: linear(2, 1) of its placement is nan, must be finite and at most 1e+30");
  linear = Matrix3::Identity();
  linear(2, 2) = -1;
  CHECK(refused(at({0, 0, 0}, linear)) ==
        "body 0: the determinant of its placement is -1, must be positive");
  CHECK(refused(at({0, 0, 0}, Matrix3::Zero())) ==
        "body 0: the determinant of its placement is 0, must be positive");
  CHECK(message([&] { finder.add(nullptr); }) == "body 1 has no shape");
  CHECK(message([&] { finder.replace_shape(0, nullptr); }) == "body 0 has no shape");
  CHECK_THROWS_AS(finder.add(box({1, 1, 1}), at({nan, 0, 0})), InputError);
  CHECK(finder.size() == 1);
}

TEST_CASE("bodies: a finder that was moved from says so") {
  ContactFinder finder({.reach = 1e-3});
  finder.add(box({1, 1, 1}));
  ContactFinder next = std::move(finder);
  CHECK(next.size() == 1);
  std::vector<ContactPoint> contacts;
  const std::string said = "finder: it was moved from";
  CHECK(message([&] { finder.add(box({1, 1, 1})); }) == said);  // NOLINT: meant
  CHECK(message([&] { finder.move(0, {}); }) == said);
  CHECK(message([&] { finder.remove(0); }) == said);
  CHECK(message([&] { finder.find(contacts); }) == said);
  CHECK(message([&] { finder.set_reach(1); }) == said);
  CHECK(message([&] { finder.set_filter({}); }) == said);
  CHECK(message([&] { (void)finder.pairs(); }) == said);
  CHECK(message([&] { (void)finder.size(); }) == said);
  CHECK(message([&] { (void)finder.threads(); }) == said);
  finder = std::move(next);
  CHECK(finder.size() == 1);
}
