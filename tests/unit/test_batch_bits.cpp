/// What a batch of pairs answers has the bits of each pair asked alone.

#include <memory>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/pair_batch.hpp>
#include <vector>

#include "referee/pairs/families.hpp"
#include "support/bits.hpp"
#include "support/catch.hpp"
#include "support/counted_allocations.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using quoin::tests::bits_of;
using quoin::tests::Random;
using quoin::tests::rotation_about;

Shape brick(Random& random) {
  const Vector3 half(random.uniform(0.2, 0.9), random.uniform(0.2, 0.9), random.uniform(0.2, 0.9));
  const Vector3 at = random.chance(0.5) ? Vector3(0, 0, 0) : random.point(-3, 3);
  return make_box(at - half, at + half);
}

/// Six faces of four corners, none of them a rectangle.
Shape block(Random& random) {
  const Vector3 half(random.uniform(0.3, 0.9), random.uniform(0.3, 0.9), random.uniform(0.3, 0.9));
  Points polygon(3, 4);
  polygon.col(0) = Vector3(-half.x(), -half.y(), -half.z());
  polygon.col(1) = Vector3(half.x(), -1.2 * half.y(), -half.z());
  polygon.col(2) = Vector3(0.7 * half.x(), half.y(), -half.z());
  polygon.col(3) = Vector3(-half.x(), 0.9 * half.y(), -half.z());
  return make_prism(polygon, {0.1, 0.05, 2 * half.z()});
}

/// Top and bottom of 3 to 14 corners, the sides upright or leaning outward.
Shape prism(Random& random) {
  const int count = random.integer(3, random.chance(0.9) ? 10 : 14);
  const double radius = random.uniform(0.3, 0.9), start = random.uniform(0.0, 6.0);
  Points polygon(3, count);
  for (int k = 0; k < count; ++k) {
    const double angle = start + (k + random.uniform(-0.3, 0.3)) * 2.0 * 3.14159265358979 / count;
    polygon.col(k) = Vector3(1.3 * radius * std::cos(angle), radius * std::sin(angle), 0.0);
  }
  const double lean = random.chance(0.5) ? 0.0 : 0.2;
  return make_prism(polygon, {lean, -0.5 * lean, random.uniform(0.2, 1.2)});
}

/// A voussoir: six faces of four corners, of which four lean against each other.
Shape wedge(Random& random) {
  const double depth = random.uniform(0.2, 0.6), height = random.uniform(0.2, 0.6);
  Points polygon(3, 4);
  polygon.col(0) = Vector3(-0.6, -depth, 0.0);
  polygon.col(1) = Vector3(0.6, -depth, 0.0);
  polygon.col(2) = Vector3(0.5, depth, 0.0);
  polygon.col(3) = Vector3(-0.5, depth, 0.0);
  return make_prism(polygon, {0.0, 0.0, height});
}

enum class Solids { Bricks, Polygons };

Shape solid(Random& random, Solids kind) {
  if (kind == Solids::Polygons) return random.chance(0.8) ? prism(random) : brick(random);
  if (random.chance(0.2)) return wedge(random);
  return random.chance(0.7) ? brick(random) : block(random);
}

/// The second body's top or bottom on the first one's, moved aside and leaned by a little.
struct Stack {
  Shape p, q;
  Placement at_p, at_q;
  Stack(Random& random, Solids kind)
      : p(solid(random, kind)), q(random.chance(0.3) ? p : solid(random, kind)) {
    const double heights[] = {0.0, 1e-16, 1e-13, 1e-9, 1e-6, 1e-4, -1e-13, -1e-6, -1e-3};
    const double leans[] = {0.0, 0.0, 0.0, 1e-16, 1e-14, 1e-12, 1e-9, 1e-6};
    const double rise = heights[random.integer(0, std::ssize(heights) - 1)];
    const double lean = leans[random.integer(0, std::ssize(leans) - 1)];
    at_q.translation = p.origin() - q.origin() +
                       Vector3(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), 0.0) +
                       Vector3::UnitZ() * (p.box().max.z() - p.origin().z() - q.box().min.z() +
                                           q.origin().z() + rise);
    if (random.chance(0.3)) at_q.translation.head<2>() = (p.origin() - q.origin()).head<2>();
    if (random.chance(0.3)) poke(random);
    // Upright: still flush, but sides that coincided cross.
    const Vector3 axis = random.chance(0.5) ? Vector3(0, 0, 1) : random.direction();
    if (lean > 0.0) turn(rotation_about(axis, lean), at_q);
    if (random.chance(0.6)) {
      const Matrix3 all = random.rotation();
      turn(all, at_p);
      turn(all, at_q);
    }
    const Vector3 far = random.chance(0.5) ? random.point(-1, 1) : random.point(-1e6, 1e6);
    at_p.translation += far;
    at_q.translation += far;
    if (random.chance(0.1)) at_p = {};
  }
  /// A corner of the one face beyond a side of the other by so little that two crossings are as
  /// near as the tolerance.
  void poke(Random& random) {
    turn(rotation_about(Vector3::UnitZ(), random.uniform(0.3, 1.2)), at_q);
    const double beyond = random.log_uniform(1e-11, 1e-4);
    at_q.translation.x() += p.box().max.x() + beyond - Body(q, at_q).vertices().row(0).maxCoeff();
  }
  static void turn(const Matrix3& by, Placement& at) {
    at.linear = by * at.linear;
    at.translation = by * at.translation;
  }
};

struct Stacks {
  std::vector<std::unique_ptr<Stack>> stacks;
  std::vector<Body> bodies;
  std::vector<BlockPair> pairs;
  Stacks(int count, Solids kind, Random& random) {
    for (int k = 0; k < count; ++k) {
      stacks.push_back(std::make_unique<Stack>(random, kind));
      bodies.emplace_back(stacks.back()->p, stacks.back()->at_p);
      bodies.emplace_back(stacks.back()->q, stacks.back()->at_q);
      if (random.chance(0.5)) std::swap(bodies[bodies.size() - 2], bodies.back());
      pairs.push_back({2 * k, 2 * k + 1});
    }
  }
};

ContactOptions options_of(Random& random) {
  return {.tolerance = random.chance(0.2) ? 1e-5 : 0.0,
          .reach = random.chance(0.8) ? 1e-3 : 1e-8,
          .frame = random.chance(0.5) ? PointFrame::World : PointFrame::Bodies};
}

/// Pairs of every family, each turned as a whole, as bodies in a row.
struct FamilyPairs {
  std::vector<std::unique_ptr<Shape>> shapes;
  std::vector<Body> bodies;
  std::vector<BlockPair> pairs;
  FamilyPairs(int count, Random& random) {
    while (std::ssize(pairs) < count) {
      const quoin::tests::SolidPair pair = quoin::tests::make_pair(random);
      const Matrix3 all = random.chance(0.7) ? random.rotation() : Matrix3::Identity();
      try {
        auto a = std::make_unique<Shape>(shape_of(pair.a));
        auto b = std::make_unique<Shape>(shape_of(pair.b));
        add(std::move(a), pair.a.placed.placement, all);
        add(std::move(b), pair.b.placed.placement, all);
      } catch (const InputError&) {
        continue;  // flat, or too large
      }
      pairs.push_back({static_cast<int>(bodies.size()) - 2, static_cast<int>(bodies.size()) - 1});
    }
  }
  void add(std::unique_ptr<Shape> shape, Placement at, const Matrix3& all) {
    Stack::turn(all, at);
    bodies.emplace_back(*shape, at);
    shapes.push_back(std::move(shape));
  }
};

/// Asks for all pairs alone and in one batch, three times, with last step's hints.
void check_bits(const std::vector<Body>& bodies, const std::vector<BlockPair>& pairs,
                const ContactOptions& options) {
  std::vector<FeatureHint> hints(pairs.size());
  std::vector<NearestFeatures> distances(pairs.size());
  PairBatch batch(options);
  for (int step = 0; step < 3; ++step) {
    std::vector<ContactPoint> alone, found;
    std::vector<NearestFeatures> nearest;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto [i, j] = pairs[k];
      const Body &a = bodies[static_cast<std::size_t>(i)], &b = bodies[static_cast<std::size_t>(j)];
      hints[k] = append_contacts_within_reach({i, j}, a, b, options, hints[k], alone).hint;
      nearest.push_back(nearest_features(a, b, {options.tolerance}, distances[k].hint));
    }
    batch.find(BodySource(bodies), pairs, found);
    update_nearest_features(bodies, pairs, distances, {options.tolerance});
    REQUIRE(found.size() == alone.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      CAPTURE(step, k, found[k].key.a);
      REQUIRE(bits_of(found[k]) == bits_of(alone[k]));
    }
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      CAPTURE(step, k);
      REQUIRE(bits_of(distances[k], distances[k].hint) == bits_of(nearest[k], nearest[k].hint));
    }
  }
}

}  // namespace

TEST_CASE("pair batch: pairs of every family, cold and warm, as they are alone") {
  Random random(quoin::tests::environment_number("QUOIN_SEED", 8));
  const auto count = static_cast<int>(quoin::tests::environment_number("QUOIN_CASES", 1500));
  const FamilyPairs drawn(count, random);
  check_bits(drawn.bodies, drawn.pairs, {.reach = 1e-3});
}

TEST_CASE("pair batch: solids that lie with faces on each other, as they are alone") {
  Random random(quoin::tests::environment_number("QUOIN_SEED", 7));
  const auto rounds = static_cast<int>(quoin::tests::environment_number("QUOIN_CASES", 800) / 100);
  for (int round = 0; round < rounds; ++round) {
    const Stacks drawn(100, round % 2 == 0 ? Solids::Bricks : Solids::Polygons, random);
    check_bits(drawn.bodies, drawn.pairs, options_of(random));
  }
}

TEST_CASE("pair batch: once warm nothing is allocated for solids that lie on each other") {
  Random random(9);
  const Stacks drawn(100, Solids::Polygons, random);
  PairBatch batch({.reach = 1e-3});
  std::vector<ContactPoint> contacts;
  for (int step = 0; step < 4; ++step) batch.find(BodySource(drawn.bodies), drawn.pairs, contacts);
  const long before = quoin::tests::allocations;
  for (int step = 0; step < 4; ++step) batch.find(BodySource(drawn.bodies), drawn.pairs, contacts);
  CHECK(quoin::tests::allocations == before);
  CHECK(contacts.size() > 200);
}

// Along axes of the world normals have zeros, and the way back along a normal turns their signs.
TEST_CASE("However it is asked, a stack has the same bits, signs of zeros too") {
  const Shape shapes[] = {make_box({-1, -1, -1}, {1, 1, 0}), make_box({-2, -2, 0}, {2, 2, 1}),
                          make_box({-0.5, -0.5, 0}, {0.5, 0.5, 1})};
  const Body low(shapes[0]), large(shapes[1]), small(shapes[2]);
  for (const Body* high : {&large, &small}) {
    for (const bool swapped : {false, true}) {
      const std::vector<Body> bodies{swapped ? *high : low, swapped ? low : *high};
      const NearestFeatures alone = nearest_features(bodies[0], bodies[1]);
      FeatureHint of_vertices = alone.hint;
      of_vertices.face_a = of_vertices.face_b = -1;
      std::vector<quoin::tests::Bits> asked;
      std::vector<ContactPoint> points;
      for (const FeatureHint& hint : {FeatureHint{}, alone.hint, of_vertices}) {
        points.clear();
        const NearestFeatures answer = append_contacts_within_reach({0, 1}, bodies[0], bodies[1],
                                                                    {.reach = 0.1}, hint, points);
        asked.push_back(bits_of(answer.gap, answer.normal, points));
      }
      PairBatch batch({.reach = 0.1});
      for (int step = 0; step < 2; ++step) {
        batch.find(BodySource(bodies), std::vector<BlockPair>{{0, 1}}, points);
        asked.push_back(bits_of(batch.pairs()[0].gap, batch.pairs()[0].normal, points));
      }
      for (std::size_t way = 1; way < asked.size(); ++way) {
        INFO("way " << way);
        CHECK(asked[way] == asked.front());
      }
    }
  }
}
