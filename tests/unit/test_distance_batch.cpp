/// Nearest features of many pairs in one call: the bits of each pair asked alone.

#include <cmath>
#include <limits>
#include <memory>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/pair_batch.hpp>
#include <vector>

#include "support/bits.hpp"
#include "support/bricks.hpp"
#include "support/catch.hpp"
#include "support/counted_allocations.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using quoin::tests::Random;
using quoin::tests::rotation_about;

/// With its hint and the work that it took.
quoin::tests::Bits all_of(const NearestFeatures& answer) {
  return quoin::tests::bits_of(answer, answer.hint, answer.iterations);
}

Shape hull(Random& random, int count) {
  Points points(3, count);
  for (int k = 0; k < count; ++k) points.col(k) = 0.5 * random.direction();
  return make_hull(points).polyhedron;
}

Shape solid(Random& random) {
  if (random.chance(0.3)) return hull(random, random.integer(4, random.chance(0.1) ? 80 : 20));
  const Vector3 half(random.uniform(0.2, 0.9), random.uniform(0.2, 0.9), random.uniform(0.2, 0.9));
  const Vector3 at = random.chance(0.5) ? Vector3(0, 0, 0) : random.point(-3, 3);
  return make_box(at - half, at + half);
}

/// A few shapes, and pairs of bodies near each other that move a little in each step.
class Crowd {
 public:
  std::vector<std::unique_ptr<Shape>> shapes;
  std::vector<Body> bodies;
  std::vector<BlockPair> pairs;

  Crowd(Random& random, int count) : random_(random) {
    for (int k = 0; k < 16; ++k) shapes.push_back(std::make_unique<Shape>(solid(random)));
    for (int k = 0; k < count; ++k) add();
  }
  /// By so much of a metre and of a radian at most; some bodies stay.
  void move(double amount) {
    for (Body& body : bodies) {
      if (body.stands_in_own_frame() || random_.chance(0.2)) continue;
      Placement at = body.placement();
      at.linear = rotation_about(random_.direction(), random_.uniform(0, amount)) * at.linear;
      at.translation += random_.uniform(0, amount) * random_.direction();
      body.move(at);
    }
  }

 private:
  const Shape& any_shape() { return *shapes[static_cast<std::size_t>(random_.integer(0, 15))]; }
  Matrix3 any_linear() {
    if (random_.chance(0.1)) return Matrix3::Identity();
    const Matrix3 turned = random_.rotation();
    if (random_.chance(0.8)) return turned;
    Matrix3 strain = Matrix3::Identity();  // of a deforming block
    strain.diagonal() += random_.point(-0.05, 0.05);
    return turned * strain;
  }
  void add() {
    const double far = random_.chance(0.3) ? 1e6 : 2.0, size = random_.chance(0.1) ? 1e-3 : 1.0;
    const Shape *a = &any_shape(), *b = random_.chance(0.2) ? a : &any_shape();
    Placement at_a{any_linear(), random_.point(-far, far)}, at_b{any_linear(), {}};
    if (random_.chance(0.15)) at_a = {};
    at_a.linear *= size;
    const Vector3 middle = at_a.translation + at_a.linear * a->origin();
    at_b.translation =
        middle - at_b.linear * b->origin() + random_.uniform(1, 4) * random_.direction();
    const double gaps[] = {0.3, 0.1, 0.01, 1e-3, 1e-6, 1e-9, 0.0, -1e-6, -1e-3, -0.05};
    const double gap = gaps[random_.integer(0, std::ssize(gaps) - 1)];
    Body body_a(*a, at_a), body_b(*b, at_b);
    for (int step = 0; step < 3; ++step) {
      const NearestFeatures now = nearest_features(body_a, body_b);
      at_b.translation += (gap - now.gap) * now.normal;
      body_b.move(at_b);
    }
    if (random_.chance(0.15)) own_frame(body_b, body_a);
    if (random_.chance(0.5)) std::swap(body_a, body_b);
    pairs.push_back({static_cast<int>(bodies.size()), static_cast<int>(bodies.size()) + 1});
    bodies.push_back(body_a);
    bodies.push_back(body_b);
  }
  /// Both by their places in the world.
  void own_frame(Body& a, Body& b) {
    for (Body* body : {&a, &b}) {
      shapes.push_back(std::make_unique<Shape>(body->shape().shared_topology(), body->vertices()));
      *body = Body(*shapes.back());
    }
  }

  Random& random_;
};

/// What each pair gives alone with the hint of its last answer.
std::vector<NearestFeatures> asked_alone(const std::vector<Body>& bodies,
                                         const std::vector<BlockPair>& pairs,
                                         const std::vector<NearestFeatures>& last,
                                         const SearchOptions& options) {
  std::vector<NearestFeatures> answers;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    answers.push_back(nearest_features(bodies[static_cast<std::size_t>(pairs[k].a)],
                                       bodies[static_cast<std::size_t>(pairs[k].b)], options,
                                       last[k].hint));
  }
  return answers;
}

}  // namespace

TEST_CASE("distance batch: the bits of each pair asked alone, cold and warm") {
  Random random(quoin::tests::environment_number("QUOIN_SEED", 12));
  const auto rounds = static_cast<int>(quoin::tests::environment_number("QUOIN_CASES", 4000) / 500);
  int at_once = 0;
  for (int round = 0; round < rounds; ++round) {
    Crowd crowd(random, 100);
    const SearchOptions options{.tolerance = round % 4 == 3 ? 1e-5 : 0.0};
    std::vector<NearestFeatures> answers(crowd.pairs.size());
    for (const double amount : {0.0, 0.0, 1e-14, 1e-9, 1e-4, 5e-3}) {
      crowd.move(amount);
      const std::vector<NearestFeatures> alone =
          asked_alone(crowd.bodies, crowd.pairs, answers, options);
      update_nearest_features(crowd.bodies, crowd.pairs, answers, options);
      for (std::size_t k = 0; k < answers.size(); ++k) {
        CAPTURE(round, amount, k);
        REQUIRE(all_of(answers[k]) == all_of(alone[k]));
        at_once += alone[k].iterations == 1;
      }
    }
  }
  CHECK(at_once > rounds * 200);
}

TEST_CASE("distance batch: any number of workers, and nothing allocated") {
  Random random(14);
  Crowd crowd(random, 1500);
  std::vector<NearestFeatures> first(crowd.pairs.size());
  update_nearest_features(crowd.bodies, crowd.pairs, first);
  crowd.move(1e-3);
  std::vector<NearestFeatures> expected = first;
  update_nearest_features(crowd.bodies, crowd.pairs, expected);
  for (const int workers : {1, 2, 3, 5, 7}) {
    quoin::tests::Backwards turns(workers);
    std::vector<NearestFeatures> answers = first;
    const long before = quoin::tests::allocations;
    update_nearest_features(crowd.bodies, crowd.pairs, answers, {}, &turns);
    CHECK(quoin::tests::allocations == before);
    for (std::size_t k = 0; k < answers.size(); ++k) {
      CAPTURE(workers, k);
      REQUIRE(all_of(answers[k]) == all_of(expected[k]));
    }
  }
}

TEST_CASE("distance batch: refused before any answer is touched") {
  const Shape box = make_box({0, 0, 0}, {1, 1, 1});
  const std::vector<Body> bodies{box, Body(box, {.translation = {2, 0, 0}})};
  std::vector<NearestFeatures> answers(2);
  const std::vector<BlockPair> good{{0, 1}, {1, 0}}, bad{{0, 1}, {0, 2}}, same{{0, 1}, {1, 1}};
  CHECK_THROWS_AS(update_nearest_features(bodies, bad, answers), InputError);
  CHECK_THROWS_AS(update_nearest_features(bodies, same, answers), InputError);
  CHECK_THROWS_AS(update_nearest_features(bodies, std::span(good).first(1), answers), InputError);
  CHECK(answers[0].status == PairStatus::NotConverged);
  update_nearest_features(bodies, good, answers);
  const auto check_answers = [&] {
    CHECK(answers[0].gap == 1.0);
    CHECK(answers[1].normal == Vector3(-1, 0, 0));
  };
  check_answers();
  for (const double stretch : {std::nan(""), std::numeric_limits<double>::infinity(), -1.0}) {
    std::vector<Body> moved = bodies;
    moved[1].move({.linear = stretch * Matrix3::Identity(), .translation = {2, 0, 0}});
    CHECK_THROWS_AS(update_nearest_features(moved, good, answers), InputError);
    check_answers();
    moved.push_back(moved[1]);
    moved[1] = bodies[1];
    update_nearest_features(moved, good, answers);  // nobody asks for it
    check_answers();
  }
  update_nearest_features(bodies, {}, {});
}

// Bodies 2048 apart share a place among those that have been checked.
TEST_CASE("distance batch: any body of a long row that is none is refused") {
  constexpr int kBodies = 5000;
  const Shape box = make_box({0, 0, 0}, {1, 1, 1});
  std::vector<Body> bodies;
  std::vector<BlockPair> pairs;
  for (int i = 0; i < kBodies; ++i)
    bodies.emplace_back(box, Placement{.translation = {2.0 * i, 0, 0}});
  for (int i = 0; i + 2049 < kBodies; ++i)
    for (const int step : {1, 2048, 2049}) pairs.push_back({i, i + step});
  std::vector<NearestFeatures> answers(pairs.size());
  update_nearest_features(bodies, pairs, answers);
  for (const std::size_t i : {0, 1, 2047, 2048, 2049, 4097, 4999}) {
    CAPTURE(i);
    const Body good = bodies[i];
    bodies[i].move({.translation = {std::nan(""), 0, 0}});
    CHECK_THROWS_AS(update_nearest_features(bodies, pairs, answers), InputError);
    bodies[i] = good;
  }
}

// What is left of a hint may be of another shape.
TEST_CASE("distance batch: hints of anything") {
  Random random(16);
  Crowd crowd(random, 300);
  std::vector<NearestFeatures> answers(crowd.pairs.size());
  for (NearestFeatures& answer : answers) {
    for (int& v : answer.hint.vertices_a) v = random.integer(-2, 12);
    for (int& v : answer.hint.vertices_b) v = random.integer(-2, 12);
    if (random.chance(0.7)) answer.hint.vertices_a[2] = answer.hint.vertices_b[2] = -1;
    answer.hint.face_a = random.integer(-1, 9);
    answer.hint.face_b = random.chance(0.7) ? -1 : 3;
    answer.hint.normal = random.chance(0.1) ? Vector3(NAN, 0, 0) : random.direction();
  }
  const std::vector<NearestFeatures> alone = asked_alone(crowd.bodies, crowd.pairs, answers, {});
  update_nearest_features(crowd.bodies, crowd.pairs, answers);
  for (std::size_t k = 0; k < answers.size(); ++k) {
    CAPTURE(k);
    REQUIRE(all_of(answers[k]) == all_of(alone[k]));
  }
}
