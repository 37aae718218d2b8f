/// Bricks and other solids that lie flush, four pairs side by side: the bits of each pair asked
/// alone.

#include "geometry/src/contact/flush_batch.hpp"

#include <bit>
#include <cstdint>
#include <memory>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/pair_batch.hpp>
#include <vector>

#include "geometry/src/kernels/kernels.hpp"
#include "referee/pairs/families.hpp"
#include "support/bits.hpp"
#include "support/catch.hpp"
#include "support/counted_allocations.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using quoin::tests::Random;
using quoin::tests::rotation_about;

/// What an answer is made of, bit by bit.
struct Bits : quoin::tests::Bits {
  using quoin::tests::Bits::add;
  void add(const ContactPoint& point) {
    for (const int value : {point.key.a, point.key.b, static_cast<int>(point.type),
                            static_cast<int>(point.indeterminate), point.previous}) {
      add(value);
    }
    add(point.key.feature_a);
    add(point.key.feature_b);
    add(point.point_a);
    add(point.point_b);
    add(point.normal);
    add(point.gap);
    add(point.area);
  }
  void add(const FlushRow& row, unsigned lanes) {
    for (std::size_t k = 0; k < FlushRow::kPairs; ++k) {
      if ((lanes >> k & 1) != 0) add(row.of[k]);
    }
  }
};

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

/// A question and what the general way answers.
struct Question {
  Stack stack;
  Body a, b;
  ContactOptions options;
  std::vector<ContactPoint> points;
  NearestFeatures cold;
  Question(Random& random, const ContactOptions& asked, Solids kind)
      : stack(random, kind),
        a(random.chance(0.5) ? Body(stack.p, stack.at_p) : Body(stack.q, stack.at_q)),
        b(&a.shape() == &stack.p ? Body(stack.q, stack.at_q) : Body(stack.p, stack.at_p)),
        options(asked),
        cold(append_contacts_within_reach({3, 8}, a, b, options, {}, points)) {}
  Question(const Question&) = delete;
};

/// As the pair is answered alone, with last step's hint.
Bits expected(const Question& question) {
  std::vector<ContactPoint> points;
  const NearestFeatures warm = append_contacts_within_reach(
      {3, 8}, question.a, question.b, question.options, question.cold.hint, points);
  Bits bits;
  bits.add(static_cast<int>(warm.status));
  bits.add(warm.gap);
  bits.add(warm.normal);
  for (const ContactPoint& point : points) bits.add(point);
  return bits;
}

Bits found(const FlushBatch& batch, const FlushPairAnswer& answer) {
  Bits bits;
  bits.add(static_cast<int>(answer.status));
  bits.add(answer.gap);
  bits.add(answer.normal);
  for (const ContactPoint& point : batch.points(answer)) bits.add(point);
  return bits;
}

ContactOptions options_of(Random& random) {
  return {.tolerance = random.chance(0.2) ? 1e-5 : 0.0,
          .reach = random.chance(0.8) ? 1e-3 : 1e-8,
          .frame = random.chance(0.5) ? PointFrame::World : PointFrame::Bodies};
}

}  // namespace

TEST_CASE("flush batch: the bits of each pair asked alone") {
  const Solids kind = GENERATE(Solids::Bricks, Solids::Polygons);
  Random random(quoin::tests::environment_number("QUOIN_SEED", 5));
  const auto rounds = static_cast<int>(quoin::tests::environment_number("QUOIN_CASES", 4000) / 4);
  int solved = 0, flush = 0;
  for (int round = 0; round < rounds; ++round) {
    const ContactOptions options = options_of(random);
    std::vector<std::unique_ptr<Question>> questions;
    FlushBatch batch;
    batch.start(options);
    const int count = random.integer(1, 9);
    for (int k = 0; k < count; ++k) {
      ContactOptions own = options;
      if (random.chance(0.3)) own.reach = 1e-5;
      questions.push_back(std::make_unique<Question>(random, own, kind));
      const Question& question = *questions.back();
      batch.take(questions.size() - 1, {3, 8}, question.a, question.b, question.cold.hint,
                 own.reach);
      const FeatureHint& hint = question.cold.hint;
      flush += hint.face_a >= 0 && hint.face_b >= 0;
    }
    batch.finish();
    for (const FlushPairAnswer& answer : batch.answers()) {
      CAPTURE(static_cast<int>(kind), round, answer.pair);
      REQUIRE(found(batch, answer).all == expected(*questions[answer.pair]).all);
      ++solved;
    }
  }
  CAPTURE(static_cast<int>(kind), solved, flush);
  CHECK(solved > flush / 2);
  CHECK(flush > rounds);
}

TEST_CASE("flush batch: every instruction set gives the bits of the plain one") {
  Random random(6);
  int solved = 0;
  for (int round = 0; round < 300; ++round) {
    FlushQuestion question;
    const ContactOptions options = options_of(random);
    question.tolerance = options.tolerance;
    std::vector<std::unique_ptr<Question>> questions;
    std::array<FlushPair, FlushRow::kPairs> pairs;
    for (std::size_t lane = 0; lane < pairs.size(); ++lane) {
      do {
        questions.push_back(std::make_unique<Question>(random, options, Solids::Bricks));
      } while (
          !pairs[lane].take(questions.back()->a, questions.back()->b, questions.back()->cold.hint));
      pairs[lane].reach = lane % 2 == 0 ? options.reach : 1e-4;
      pairs[lane].pack(lane, question);
    }
    std::vector<std::uint64_t> first;
    for (const Kernels* kernels : runnable_kernels()) {
      INFO(kernels->name);
      FlushAnswer answer;
      kernels->flush_bricks(question, answer);
      Bits bits;
      bits.add(static_cast<int>(answer.solved));
      bits.add(static_cast<int>(answer.listed & answer.solved));
      if (answer.solved != 0) {
        for (const FlushRow& row : {answer.gap, answer.tolerance}) bits.add(row, answer.solved);
        for (const auto& rows :
             {answer.between, answer.origin, answer.normal, answer.axis_u, answer.axis_v}) {
          for (int k = 0; k < 3; ++k) bits.add(rows[k], answer.solved);
        }
      }
      for (int k = 0; answer.solved != 0 && k < answer.corner_count; ++k) {
        const FlushCorner& corner = answer.corners[static_cast<std::size_t>(k)];
        const unsigned here = corner.pairs & answer.solved;
        if (here == 0) continue;
        bits.add(corner.feature_p);
        bits.add(corner.feature_q);
        for (const FlushRow& row :
             {corner.x, corner.y, corner.height_p, corner.height_q, corner.share}) {
          bits.add(row, here);
        }
      }
      if (kernels == runnable_kernels().front()) {
        first = bits.all;
        solved += std::popcount(answer.solved);
      }
      REQUIRE(bits.all == first);
    }
  }
  CHECK(solved > 300);
}

TEST_CASE("flush polygons: every instruction set gives the bits of the plain one") {
  Random random(7);
  int solved = 0;
  for (int round = 0; round < 300; ++round) {
    const ContactOptions options = options_of(random);
    std::vector<std::unique_ptr<Question>> questions;
    PolygonQuestion question;
    PolygonPair pair;
    for (std::size_t lane = 0; lane < FlushRow::kPairs; ++lane) {
      do {
        questions.push_back(std::make_unique<Question>(random, options, Solids::Polygons));
      } while (!pair.take(questions.back()->a, questions.back()->b, questions.back()->cold.hint,
                          options.tolerance, lane, question));
    }
    std::vector<std::uint64_t> first;
    for (const Kernels* kernels : runnable_kernels()) {
      INFO(kernels->name);
      PolygonAnswer answer;
      kernels->flush_polygons(question, answer);
      Bits bits;
      bits.add(static_cast<int>(answer.solved));
      bits.add(answer.area, answer.solved);
      bits.add(answer.margin, answer.solved);
      for (std::size_t lane = 0; lane < FlushRow::kPairs; ++lane) {
        if ((answer.solved >> lane & 1) == 0) continue;
        const auto count = static_cast<std::size_t>(answer.count[lane]);
        for (const PolygonCorner& c : std::span(answer.corners[lane]).first(count)) {
          bits.add(c.feature_p);
          bits.add(c.feature_q);
          for (const double value : {c.x, c.y, c.height_p, c.height_q, c.share}) bits.add(value);
        }
      }
      if (kernels == runnable_kernels().front()) {
        first = bits.all;
        solved += std::popcount(answer.solved);
      }
      REQUIRE(bits.all == first);
    }
  }
  CHECK(solved > 600);
}

namespace {

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

/// Is a pair taken by the lanes, with faces that are not both of four corners?
bool is_side_by_side(const Body& a, const Body& b, const FeatureHint& hint) {
  if (hint.face_a < 0 || hint.face_b < 0) return false;
  FlushBatch batch;
  batch.start({.reach = 1e-3});
  batch.take(0, {0, 1}, a, b, hint, 1e-3);
  batch.finish();
  return !batch.answers().empty() && a.shape().topology().face(hint.face_a).size() +
                                             b.shape().topology().face(hint.face_b).size() !=
                                         8;
}

}  // namespace

TEST_CASE("pair batch: pairs of every family, cold and warm, as they are alone") {
  Random random(quoin::tests::environment_number("QUOIN_SEED", 8));
  const auto count = static_cast<int>(quoin::tests::environment_number("QUOIN_CASES", 1500));
  const ContactOptions options{.reach = 1e-3};
  const FamilyPairs drawn(count, random);
  std::vector<FeatureHint> hints(drawn.pairs.size());
  PairBatch batch(options);
  int beside = 0;
  for (int step = 0; step < 3; ++step) {
    std::vector<ContactPoint> alone, found;
    for (std::size_t k = 0; k < drawn.pairs.size(); ++k) {
      const auto [i, j] = drawn.pairs[k];
      const Body &a = drawn.bodies[static_cast<std::size_t>(i)],
                 &b = drawn.bodies[static_cast<std::size_t>(j)];
      beside += step == 2 && is_side_by_side(a, b, hints[k]);
      hints[k] = append_contacts_within_reach({i, j}, a, b, options, hints[k], alone).hint;
    }
    batch.find(BodySource(drawn.bodies), drawn.pairs, found);
    for (ContactPoint& point : found) point.previous = -1;
    REQUIRE(found.size() == alone.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      Bits of_batch, by_itself;
      of_batch.add(found[k]);
      by_itself.add(alone[k]);
      CAPTURE(step, k, found[k].key.a);
      REQUIRE(of_batch.all == by_itself.all);
    }
  }
  CAPTURE(beside);
  CHECK(beside > count / 100);
}

TEST_CASE("flush batch: once warm nothing is allocated") {
  Random random(9);
  std::vector<std::unique_ptr<Stack>> stacks;
  std::vector<Body> bodies;
  std::vector<BlockPair> pairs;
  for (int k = 0; k < 100; ++k) {
    stacks.push_back(std::make_unique<Stack>(random, Solids::Polygons));
    bodies.emplace_back(stacks.back()->p, stacks.back()->at_p);
    bodies.emplace_back(stacks.back()->q, stacks.back()->at_q);
    pairs.push_back({2 * k, 2 * k + 1});
  }
  PairBatch batch({.reach = 1e-3});
  std::vector<ContactPoint> contacts;
  for (int step = 0; step < 4; ++step) batch.find(BodySource(bodies), pairs, contacts);
  const long before = quoin::tests::allocations;
  for (int step = 0; step < 4; ++step) batch.find(BodySource(bodies), pairs, contacts);
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
      std::vector<std::vector<std::uint64_t>> asked;
      for (const FeatureHint& hint : {FeatureHint{}, alone.hint, of_vertices}) {
        std::vector<ContactPoint> points;
        const NearestFeatures answer = append_contacts_within_reach({0, 1}, bodies[0], bodies[1],
                                                                    {.reach = 0.1}, hint, points);
        Bits bits;
        bits.add(answer.gap);
        bits.add(answer.normal);
        for (const ContactPoint& point : points) bits.add(point);
        asked.push_back(bits.all);
      }
      PairBatch batch({.reach = 0.1});
      const std::vector<BlockPair> pairs{{0, 1}};
      for (int step = 0; step < 2; ++step) {
        std::vector<ContactPoint> points;
        batch.find(BodySource(bodies), pairs, points);
        for (ContactPoint& point : points) point.previous = -1;
        Bits bits;
        bits.add(batch.pairs()[0].gap);
        bits.add(batch.pairs()[0].normal);
        for (const ContactPoint& point : points) bits.add(point);
        asked.push_back(bits.all);
      }
      for (std::size_t way = 1; way < asked.size(); ++way) {
        INFO("way " << way);
        CHECK(asked[way] == asked.front());
      }
    }
  }
}
