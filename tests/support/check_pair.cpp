#include "support/check_pair.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "support/check_contact.hpp"
#include "support/same_contacts.hpp"

namespace quoin::tests {
namespace {

using namespace geometry;

using Real = long double;
constexpr double kEps = std::numeric_limits<double>::epsilon();

bool finite(const NearestFeatures& n) {
  return std::isfinite(n.gap) && n.normal.allFinite() && n.point_a.allFinite() &&
         n.point_b.allFinite() && std::isfinite(n.residual_a) && std::isfinite(n.residual_b);
}

/// How far a solid reaches beyond its witness along `sign` times the normal, m.
double beyond_witness(const ExactPair& exact, int side, const PlaneFrame& frame,
                      const Vector3& witness) {
  const Real sign = side == 0 ? 1 : -1, from = frame.height(exact.place(witness));
  Real most = -std::numeric_limits<Real>::infinity();
  for (const RealPoint& x : exact.places(side))
    most = std::max(most, sign * (frame.height(x) - from));
  return static_cast<double>(most);
}

void check_certificate(const Trial& trial, const NearestFeatures& n, Faults& faults) {
  const double slack = trial.allowed_place(n.gap);
  const PlaneFrame frame(n.normal);
  for (const int side : {0, 1}) {
    const double residual = side == 0 ? n.residual_a : n.residual_b;
    const double beyond =
        beyond_witness(trial.exact, side, frame, side == 0 ? n.point_a : n.point_b);
    faults.expect(residual >= 0 && residual <= slack, "certificate", "residual ", residual,
                  " allowed ", slack);
    faults.expect(beyond <= residual + slack, "certificate", "residual ", residual,
                  " but the solid reaches ", beyond, " beyond its witness");
  }
}

void check_witnesses(const Trial& trial, const NearestFeatures& n, Faults& faults) {
  const double slack = trial.allowed_place(n.gap);
  const double along = (n.point_b - n.point_a).dot(n.normal);
  faults.expect(std::abs(along - n.gap) <= slack, "witness", "(point_b - point_a)·normal ", along,
                " but gap ", n.gap);
  judge_places(trial.exact, {n.point_a, n.point_b}, slack, "witness", 0.0, faults);
  const double apart = (n.point_b - n.point_a - n.gap * n.normal).norm();
  faults.expect(apart <= slack, "witness", "not over each other along the normal, off by ", apart);
}

void check_status(const Trial& trial, const NearestFeatures& n, Faults& faults) {
  const PairStatus expected = std::abs(n.gap) <= trial.tolerance ? PairStatus::Touching
                              : n.gap > 0                        ? PairStatus::Separated
                                                                 : PairStatus::Overlapping;
  faults.expect(n.status == expected, "status", name(n.status), " at gap ", n.gap,
                " and tolerance ", trial.tolerance);
  const double stated = std::max(1e-9 * trial.smaller, 16 * kEps * trial.shape_coordinate);
  faults.expect(trial.tolerance >= 0.999 * stated && trial.tolerance <= 2 * stated, "tolerance",
                trial.tolerance, " where ", stated, " is stated");
}

/// Finite and converged. Without these nothing else can be asked.
bool usable(const NearestFeatures& n, Faults& faults) {
  faults.expect(n.status != PairStatus::NotConverged, "not converged", n.iterations, " iterations");
  faults.expect(finite(n), "not finite", "gap ", n.gap);
  return faults.list.empty();
}

void check_gap(const Trial& trial, const NearestFeatures& n, PairVerdict& verdict, Faults& faults) {
  const Real gap = verdict.exact.gap;
  verdict.allowed_error = trial.allowed_gap(gap);
  verdict.gap_error = judge_gap(verdict.exact, n.gap, verdict.allowed_error, faults);
  judge_normal(trial.exact, verdict.exact, n.normal, 4 * kEps, verdict.allowed_error, faults);
  if (gap > 1e3 * trial.allowed_place(gap)) {  // the normal of a distance is unique
    const double off = (n.normal - verdict.exact.normal).norm();
    const double allowed = 16 * trial.allowed_gap(0) / static_cast<double>(gap) + 1e-12;
    faults.expect(off <= allowed, "normal", "off by ", off, " allowed ", allowed);
  }
}

NearestFeatures swapped(const NearestFeatures& n) {
  NearestFeatures s = n;
  s.normal = -n.normal;
  std::swap(s.point_a, s.point_b);
  std::swap(s.feature_a, s.feature_b);
  std::swap(s.residual_a, s.residual_b);
  return s;
}

/// Bitwise, up to the sign of zero.
void expect_same(const NearestFeatures& n, const NearestFeatures& m, const char* after,
                 Faults& faults) {
  faults.expect(n.gap == m.gap && n.status == m.status, after, "gap ", m.gap, " ", name(m.status),
                ", was ", n.gap, " ", name(n.status));
  if (n.indeterminate) return;  // one of the optimal set
  faults.expect(n.normal == m.normal, after, "another normal, off by ",
                (n.normal - m.normal).norm());
  faults.expect(n.point_a == m.point_a && n.point_b == m.point_b, after, "other witnesses, off ",
                (n.point_a - m.point_a).norm(), " and ", (n.point_b - m.point_b).norm());
  faults.expect(n.feature_a == m.feature_a && n.feature_b == m.feature_b, after, "other features");
  faults.expect(n.residual_a == m.residual_a && n.residual_b == m.residual_b, after,
                "other residuals");
}

void check_hints(const Trial& trial, const NearestFeatures& n, Random& random, Faults& faults) {
  expect_same(n, trial.query.nearest(n.hint), "hint: own answer", faults);
  FeatureHint any;
  const auto vertex = [&](const geometry::Body& body) {
    return random.integer(-1, body.shape().vertex_count() - 1);
  };
  for (std::size_t k = 0; k < 4; ++k) {
    any.vertices_a[k] = vertex(trial.query.a());
    any.vertices_b[k] = vertex(trial.query.b());
  }
  any.normal = random.direction();
  expect_same(n, trial.query.nearest(any), "hint: any", faults);
}

/// From the answer of a step before. The faces must be the same: only bodies that move can be
/// asked.
void check_step_before(const Trial& trial, const NearestFeatures& n, Random& random,
                       Faults& faults) {
  const geometry::Body b = trial.query.b();
  const Vector3 centre = b.placement().translation + b.placement().linear * b.shape().vertex_mean();
  const Matrix3 turn = rotation_about(random.direction(), 0.01 * random.uniform());
  const Vector3 shift = 0.01 * trial.smaller * random.uniform() * random.direction();
  const geometry::Placement before{turn * b.placement().linear,
                                   turn * (b.placement().translation - centre) + centre + shift};
  const NearestFeatures then = nearest_features(trial.query.a(), geometry::Body(b.shape(), before));
  expect_same(n, trial.query.nearest(then.hint), "hint: step before", faults);
}

/// The points of a wider reach, where they are others.
void check_reach(const Trial& trial, const PairContact& contact, Faults& faults) {
  const double reach = 1e-3 * trial.smaller;
  const PairContact wider = trial.query.contact({.reach = reach});
  if (!same_but_previous(wider.points, contact.points)) check_points(trial, wider, reach, faults);
}

/// Nearest features and points asked in one: the way there is another, the answer is not.
void check_in_one(const Trial& trial, const NearestFeatures& n, Faults& faults) {
  const double reach = n.gap + 1e-3 * trial.smaller;
  std::vector<ContactPoint> points;
  const NearestFeatures m = trial.query.contacts_within(reach, points);
  expect_same(n, m, "in one", faults);
  const PairContact apart = trial.query.contact({.reach = std::max(0.0, reach - m.gap)});
  faults.expect(same_but_previous(points, apart.points), "in one", "other points");
}

/// May a motion that rounds have made the solids so thin that they are refused?
enum class Rounding { None, Some };

/// The pair made anew in another way, or nothing and perhaps a fault.
std::unique_ptr<Query> asked_again(const SolidPair& pair, Rounding rounding, const char* after,
                                   Faults& faults) {
  try {
    return std::make_unique<Query>(pair);
  } catch (const geometry::InputError& error) {
    Faults wrongly;
    check_refused(pair, error.what(), wrongly);
    faults.expect(rounding == Rounding::Some && wrongly.list.empty(), after,
                  "refused: ", error.what());
    return nullptr;
  }
}

void expect_near(const Trial& trial, const NearestFeatures& n, const SolidPair& other,
                 const char* after, Faults& faults) {
  const std::unique_ptr<Query> query = asked_again(other, Rounding::Some, after, faults);
  if (!query) return;
  const NearestFeatures m = query->nearest();
  const double coordinate =
      std::max(largest_world_coordinate(other.a), largest_world_coordinate(other.b));
  // the motion itself rounds each coordinate
  const double moved = 32 * kEps * (trial.world_coordinate + coordinate);
  const double allowed = moved + 2 * trial.allowed_gap(n.gap);
  faults.expect(std::abs(n.gap - m.gap) <= allowed, after, "gap ", m.gap, ", was ", n.gap,
                ", allowed ", allowed);
}

/// Another order of the vertices, or the mirror image: the same exact numbers. `open`: the type may
/// fall either way.
void expect_alike(const Trial& trial, const PairContact& contact, bool open, const SolidPair& other,
                  const char* after, Faults& faults) {
  const std::unique_ptr<Query> query = asked_again(other, Rounding::None, after, faults);
  if (!query) return;
  const PairContact m = query->contact();
  const NearestFeatures& n = contact.nearest;
  const double allowed = 2 * trial.allowed_gap(n.gap);
  faults.expect(std::abs(n.gap - m.nearest.gap) <= allowed, after, "gap ", m.nearest.gap, ", was ",
                n.gap, ", allowed ", allowed);
  faults.expect(open || n.indeterminate == m.nearest.indeterminate, after, "indeterminate ",
                m.nearest.indeterminate, ", was ", n.indeterminate);
  if (n.indeterminate || m.nearest.indeterminate) return;
  faults.expect(open || contact.type == m.type, after, name(m.type), ", was ", name(contact.type));
  const double around = 8 * trial.larger * trial.allowed_place(n.gap);
  faults.expect(open || std::abs(contact.area - m.area) <= around, after, "area ", m.area, ", was ",
                contact.area, ", allowed ", around);
}

SolidPair both(const SolidPair& pair, const Matrix3& rotation, const Vector3& shift) {
  return {pair.family, transformed(pair.a, rotation, shift), transformed(pair.b, rotation, shift)};
}

/// Does scaling by 2^-30 or more round nothing in what is made of a solid's numbers? Where one is
/// subnormal, or products of it are, bits are lost at one scale and not at another. Of three
/// lengths of at least 2^-275 m, scaled, the product is 2^-915, and what double-double keeps below
/// it, by 2^-106, still normal (2^-1022).
bool scales_exactly(const Solid& solid) {
  const auto scales = [](const auto& numbers) {
    return (numbers.array() == 0.0 || numbers.array().abs() >= 0x1p-275).all();
  };
  return scales(solid.placed.points) && scales(solid.placed.placement.translation) &&
         scales(solid.placed.placement.linear);
}

void check_scaled(const Trial& trial, const NearestFeatures& n, Random& random, Faults& faults) {
  const bool tiny = trial.smaller < 1e-9;  // smaller still, it would leave the promised range
  const double scale = std::ldexp(1.0, random.integer(tiny ? 0 : -30, 30));
  if (!scales_exactly(trial.pair.a) || !scales_exactly(trial.pair.b)) return;
  const SolidPair other{"", scaled(trial.pair.a, scale), scaled(trial.pair.b, scale)};
  if (const std::unique_ptr<Query> query = asked_again(other, Rounding::None, "scaled", faults)) {
    NearestFeatures m = query->nearest();
    m.gap /= scale;
    m.point_a /= scale;
    m.point_b /= scale;
    m.residual_a /= scale;
    m.residual_b /= scale;
    expect_same(n, m, "scaled", faults);
  }
}

/// Placements of both translated by the same multiple of a large power of two, where that rounds
/// nothing: the same answer to the bit.
void check_elsewhere(const Trial& trial, const NearestFeatures& n, Random& random, Faults& faults) {
  SolidPair other = trial.pair;
  const Vector3 shift = std::ldexp(1.0, random.integer(0, 20)) *
                        Vector3(random.integer(-3, 3), random.integer(-3, 3), 1);
  for (Solid* solid : {&other.a, &other.b}) {
    Vector3& t = solid->placed.placement.translation;
    const Vector3 before = t;
    t += shift;
    if (t - shift != before) return;
  }
  if (const std::unique_ptr<Query> query =
          asked_again(other, Rounding::None, "elsewhere", faults)) {
    const NearestFeatures m = query->nearest();
    faults.expect(n.gap == m.gap && n.status == m.status, "elsewhere", "gap ", m.gap, " ",
                  name(m.status), ", was ", n.gap, " ", name(n.status));
  }
}

void check_other_ways(const Trial& trial, const PairContact& contact, Random& random,
                      Faults& faults) {
  const SolidPair& pair = trial.pair;
  const NearestFeatures& n = contact.nearest;
  expect_same(n, trial.query.nearest(), "without points", faults);
  expect_same(n, swapped(trial.query.nearest_swapped()), "swapped", faults);
  check_scaled(trial, n, random, faults);
  check_hints(trial, n, random, faults);
  check_step_before(trial, n, random, faults);
  check_in_one(trial, n, faults);
  const Vector3 shift = trial.larger * random.uniform() * random.direction();
  expect_near(trial, n, both(pair, Matrix3::Identity(), shift), "shifted", faults);
  expect_near(trial, n, both(pair, random.rotation(), Vector3::Zero()), "turned", faults);
  const PatchBands bands{trial.tolerance, trial.allowed_place(n.gap), 0.0};
  const bool open = !exact_patch(trial.exact, n.normal, bands).clear;
  expect_alike(trial, contact, open,
               {pair.family, renumbered(pair.a, random), renumbered(pair.b, random)}, "renumbered",
               faults);
  const int axis = random.integer(0, 2);
  expect_alike(trial, contact, open, {pair.family, mirrored(pair.a, axis), mirrored(pair.b, axis)},
               "mirrored", faults);
  if (!stands_in_own_frame(pair.a) && !stands_in_own_frame(pair.b))
    check_elsewhere(trial, n, random, faults);
}

/// `random`: nullptr where the answer alone is judged.
PairVerdict judged(const SolidPair& pair, Random* random) {
  PairVerdict verdict;
  Faults faults;
  std::unique_ptr<Trial> trial;
  try {
    trial = std::make_unique<Trial>(pair);
  } catch (const geometry::InputError& error) {
    check_refused(pair, error.what(), faults);
    verdict.faults = std::move(faults.list);
    return verdict;
  }
  verdict.answered = true;
  verdict.contact = trial->query.contact();
  verdict.exact = trial->exact.gap();
  const NearestFeatures& n = verdict.contact.nearest;
  check_taken(pair, faults);
  if (usable(n, faults)) {
    check_gap(*trial, n, verdict, faults);
    check_certificate(*trial, n, faults);
    check_witnesses(*trial, n, faults);
    check_status(*trial, n, faults);
    faults.expect(n.iterations >= 0 && n.iterations <= 256, "iterations", n.iterations);
    check_contact(*trial, verdict.contact, faults);
    check_reach(*trial, verdict.contact, faults);
    if (random != nullptr) check_other_ways(*trial, verdict.contact, *random, faults);
  }
  verdict.faults = std::move(faults.list);
  return verdict;
}

}  // namespace

PairVerdict check_against_exact(const SolidPair& pair) { return judged(pair, nullptr); }

PairVerdict check_pair(const SolidPair& pair, Random& random) { return judged(pair, &random); }

}  // namespace quoin::tests
