#include "iteration/contact_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/index.hpp"
#include "iteration/interior_point.hpp"

namespace quoin::solver {
namespace {

// Open-close iterations on one problem before it counts as unsolved. All rows of validate are
// solved in 80; of rigid blocks what ends in `quoin stability --quick` and in walls takes 200. With
// 150 seven deformable walls go over to yielding contacts, and gain energy, that the open-close
// iteration solves, and so does a rigid one shaken in its plane. More: see bench/tried.md.
constexpr int kMostOpenClose = 250;
// Attempts in a row that were not solved, a whole and a half step, before the proximal Newton
// method takes over from the whole one, whatever it leaves: walls near their limit load are solved
// in half steps.
constexpr int kFailures = 2;
// Of contacts whose forces the interior point method has found: ten times what the blocks oppose;
// and of many blocks that deform.
constexpr double kInsideSoftness = 1e-4, kRedundantSoftness = 0.1;
constexpr int kInsidePatience = 40;  // iterations from known forces, and from those found inside
// Residual of forces inside that are an answer: of rigid blocks, and where some deform.
constexpr double kGoodInside = 1e-6, kSoftInside = 1e-4;
// What a block's contact forces would do across the gaps that they leave, by what they do in
// straining it and its neighbours. Without this limit bricks hang in walls by forces that no strain
// makes (bench/README.md, Mechanisms). The second: of blocks that are far from rest, too.
constexpr double kSmallGap = 0.03, kFarGap = 0.3;
// Friction of what settles and is not found with that of what cannot slide, 100: on cones that wide
// gaps of 1 mm are within that residual, and what sticks by 2 sticks by 100.
constexpr double kSettlesSlowly = 2.0;
// Of a block: held points that are left so far from their places contradict each other. Turns by an
// angle leave half its square.
constexpr double kContradicts = 1e-4;
// Times the gap tolerance: blocks that have moved by less may be at rest, which asks for all digits
// of the forces. With 1e3 and 1e5 a sliding wall and those of bench/README.md take as many solves.
constexpr double kFarFromRest = 1e4;
// Like kMostOpenClose in a loose island, whose next attempt is the proximal Newton method's. A pile
// of 64 took three times the factorizations without.
constexpr int kMostOpenCloseLoose = 30;
// Resultants of the joints by the six balances of each block, up to which an island is loose. A
// tower has 1 while all of it sticks, walls 1.6, the piles of bench/problems 0.7 in the mean. With
// 1 a tower of 30 gained 3e-6 of its energy.
constexpr double kLooseShare = 0.8;
// A light block that bears one so many times heavier: the proximal Newton method yields by 1e-3 and
// more of what the light one opposes, and the heavy one opposes but the mass ratio's share of that.
// A boulder that slides on pebbles gained 3e-8 of its energy with it at a ratio of 100, 2e-7 at 300
// and 4e-3 at 1000.
constexpr double kUneven = 300.0;
// A friction coefficient: contacts that yield do so along their normals as easily as mu times the
// slip. Of piles of 64 boxes none gained energy at 59 to 63 degrees, some 1e-3 of it from 64 on.
constexpr double kSteep = 2.0;
// Cosines of what opposes what, clear of sides that hold nothing: a normal force and the force on
// the heavy block; two normal forces on the light one. Grains on a slab take 20 times the solves
// without the first, a wall with a pebble across a joint on top 25 times without the second.
constexpr double kHolds = 1e-3, kPinches = 0.1;

/// Held points that no motion brings where they are held: any residual is small by their forces.
bool contradict(const Slots& slots, std::span<const LinearContact> contacts) {
  return std::ranges::any_of(contacts, [&](const LinearContact& c) {
    const double apart = kContradicts * slots.length[index(c.first_slot())];
    return c.law == ContactLaw::Bilateral && c.relative.norm() > apart;
  });
}

/// Of the block with the most of it (kSmallGap).
double gap_share(const BlockSystem& base, std::span<const LinearContact> contacts) {
  std::vector<double> across(base.diagonal.size()), strained(base.diagonal.size());  // J
  for (const LinearContact& c : contacts) {
    if (c.mode == ContactMode::Open) continue;
    double compliance = 0.0;
    c.each_side([&](std::size_t s, const ContactJacobian& jacobian) {
      if (!jacobian.deforms()) return;
      const Vector6 row = jacobian.strain->row(0);
      compliance += row.dot(base.diagonal.part<6>(s, 6).llt().solve(row));
    });
    if (!(compliance > 0.0)) continue;
    c.each_side([&](std::size_t s, const ContactJacobian&) {
      across[s] += std::abs(c.relative[0] * c.force[0]);
      strained[s] += compliance * c.force[0] * c.force[0];
    });
  }
  double largest = 0.0;
  for (std::size_t s = 0; s < across.size(); ++s)
    if (strained[s] > 0.0) largest = std::max(largest, across[s] / strained[s]);
  return largest;
}

}  // namespace

/// Whether forces hang on balance alone: what yields then locks no stress in, which walls pay for
/// with energy. A joint has up to three normal resultants, and where it sticks as many of shear.
/// Rigid blocks alone: a deformable arch that falls gained energy.
bool ContactSolver::is_loose(std::span<const LinearContact> contacts) const {
  if (!slots_->rigid()) return false;
  constexpr std::array<int, 4> kSlides{0, 1, 2, 3}, kSticks{0, 3, 5, 6};  // by points
  double resultants = 0.0;
  for (std::size_t i = 0, end = 0; i < contacts.size(); i = end) {
    std::size_t points = 0;
    bool sticks = false;
    for (end = i; end < contacts.size() && contacts[end].slot_a == contacts[i].slot_a &&
                  contacts[end].slot_b == contacts[i].slot_b;
         ++end) {
      if (contacts[end].assumed == ContactMode::Open) continue;
      ++points;
      sticks = sticks || contacts[end].assumed == ContactMode::Stick;
    }
    resultants += (sticks ? kSticks : kSlides)[std::min<std::size_t>(points, 3)];
  }
  return resultants <= kLooseShare * slots_->unknowns();
}

/// Whether a light block bears a much heavier one: the heavy one is held by it against the forces
/// on it, and something else pushes the light one back.
bool ContactSolver::is_uneven(const BlockEquations& blocks,
                              std::span<const LinearContact> contacts) {
  loads_.assign(blocks.force.size(), {});
  const auto inertia = [&](int slot) { return blocks.base.diagonal.part<1>(index(slot))(0, 0); };
  const auto push = [](const ContactJacobian& jacobian) -> Vector3 {  // of a unit normal force
    return jacobian.rigid.row(0).head<3>();
  };
  const auto load = [&](int light, const ContactJacobian& on_light, int heavy,
                        const ContactJacobian& on_heavy) {
    if (light < 0 || heavy < 0 || !(inertia(heavy) > kUneven * inertia(light))) return;
    const Vector3 force = blocks.force[index(heavy)].head<3>();
    if (push(on_heavy).dot(force) < -kHolds * force.norm()) {
      loads_[index(light)] = {heavy, push(on_light)};
    }
  };
  const auto is_pinched = [&](int light, const ContactJacobian& on_light, int other) {
    if (light < 0) return false;
    const Load& borne = loads_[index(light)];
    return borne.heavy != Load::kNone && borne.heavy != other &&
           push(on_light).dot(borne.push) < -kPinches;
  };
  for (const LinearContact& c : contacts) {
    load(c.slot_a, c.jacobian_a, c.slot_b, c.jacobian_b);
    load(c.slot_b, c.jacobian_b, c.slot_a, c.jacobian_a);
  }
  return std::ranges::any_of(contacts, [&](const LinearContact& c) {
    return is_pinched(c.slot_a, c.jacobian_a, c.slot_b) ||
           is_pinched(c.slot_b, c.jacobian_b, c.slot_a);
  });
}

/// Whether friction is steep in a loose island. Walls, where hard contacts are rarely found, gain
/// 1e-8 of their energy at most with it.
bool ContactSolver::is_steep(std::span<const LinearContact> contacts) const {
  const auto steep = [](const LinearContact& c) { return c.friction > kSteep; };
  return std::ranges::any_of(contacts, steep) && is_loose(contacts);
}

OpenCloseResult ContactSolver::solve(const StepOptions& options, const BlockEquations& blocks,
                                     std::span<LinearContact> contacts, OpenCloseOptions tuning,
                                     BlockVector& increment) {
  tuning.max_iterations = iterations_left_;
  const OpenCloseResult solved = iterate(options, blocks, contacts, tuning, increment);
  iterations_left_ -= solved.iterations;
  return solved;
}

OpenCloseResult ContactSolver::iterate(const StepOptions& options, const BlockEquations& blocks,
                                       std::span<LinearContact> contacts, OpenCloseOptions tuning,
                                       BlockVector& increment) {
  automatic_ = options.contact_iteration == ContactIteration::Automatic &&
               options.analysis == Analysis::Dynamic;
  suits_ = ConeProblem::suits(contacts);
  yielding_ = asks_to_yield(options, blocks, contacts) && suits_;
  if (tuning.free != nullptr && contacts.empty()) {
    OpenCloseResult coasted{{}, true};
    coasted.change = coast(*tuning.free, *slots_, blocks.force, increment);
    return coasted;
  }
  if (yielding_) return yield(blocks, contacts, tuning, increment);
  if (automatic_) tuning.max_iterations = std::min(patience(contacts), tuning.max_iterations);
  if (may_go_inside(contacts, tuning))
    return solve_static(options.analysis, blocks, contacts, tuning, increment);
  return open_close_.solve(blocks.base, blocks.force, contacts, tuning, increment);
}

/// By the proximal Newton method.
OpenCloseResult ContactSolver::yield(const BlockEquations& blocks,
                                     std::span<LinearContact> contacts,
                                     const OpenCloseOptions& tuning, BlockVector& increment) {
  if (const auto free = open_close_.fly(blocks, contacts, tuning, tuning.mended_apart, increment))
    return *free;
  return moving_contacts_.solve(blocks.base, blocks.force, contacts, tuning, increment);
}

/// Statics, in contacts that the interior point method knows.
bool ContactSolver::may_go_inside(std::span<const LinearContact> contacts,
                                  const OpenCloseOptions& tuning) const {
  return tuning.at_rest && tuning.raise && std::ranges::all_of(contacts, InteriorPoint::suits) &&
         !contacts.empty();
}

/// The open-close iteration from forces that are known, and, while a scene settles and of few
/// blocks, from none: what it shares out between redundant contacts slides least in the next stage.
/// Where that is slow, and where none are known, the interior point method, and the open-close
/// iteration from there. Where that is slow, too, the forces inside are taken as they are, there
/// and, far from rest, in the problems that follow: the next pseudo-step goes by the gaps that they
/// leave.
OpenCloseResult ContactSolver::solve_static(Analysis analysis, const BlockEquations& blocks,
                                            std::span<LinearContact> contacts,
                                            OpenCloseOptions tuning, BlockVector& increment) {
  OpenCloseResult result;
  const int most = tuning.max_iterations;
  const auto open_close = [&](int iterations) {
    tuning.max_iterations = std::min(iterations, most - result.iterations);
    add(open_close_.solve(blocks.base, blocks.force, contacts, tuning, increment), result);
    return result.converged;
  };
  const bool unknown = std::ranges::all_of(
      contacts, [](const LinearContact& c) { return c.multiplier.isZero(0.0); });
  const BlockVector guess = increment;
  const bool first = tuning.predicted;
  inexact_ = false;
  const bool settles = analysis == Analysis::Settle;
  const bool patient = settles || slots_->count() < kMany;
  if ((!unknown || patient) && !slow_) {
    const std::vector<LinearContact> before(contacts.begin(), contacts.end());
    if (open_close(patient ? kMostOpenClose : kInsidePatience)) return result;
    std::ranges::copy(before, contacts.begin());
    increment = guess;
  }
  InteriorPoint interior_point(*slots_, watch_);
  interior_point.use(threads_);
  if (settles)
    for (LinearContact& c : contacts) c.friction = std::min(c.friction, kSettlesSlowly);
  const OpenCloseResult inside = interior_point.solve(blocks.base, blocks.force, contacts,
                                                      most - result.iterations, increment);
  add(inside, result);
  if (inside.converged) {
    tuning.predicted = false;
    tuning.softness = tuning.redundant ? kRedundantSoftness : kInsideSoftness;
  }
  const bool good = inside.residual <= (slots_->rigid() ? kGoodInside : kSoftInside) &&
                    !contradict(*slots_, contacts) &&
                    gap_share(blocks.base, contacts) <= (slow_ ? kFarGap : kSmallGap);
  const std::vector<LinearContact> found(contacts.begin(), contacts.end());
  BlockVector moved = increment;
  const bool exact = !(good && slow_) && open_close(good ? kInsidePatience : most);
  inexact_ = good && !exact;
  if (inexact_) {
    std::ranges::copy(found, contacts.begin());
    increment = moved;
    result.residual = inside.residual;
    result.converged = true;
    result.closed = false;
  }
  for (std::size_t s = 0; s < moved.size(); ++s) moved[s] = increment[s] - guess[s];
  result.change = largest_motion(*slots_, moved);
  if (!inexact_ || first) slow_ = inexact_ && result.change > kFarFromRest * tuning.gap_tolerance;
  return result;
}

/// Whether the proximal Newton method is to have this problem.
bool ContactSolver::asks_to_yield(const StepOptions& options, const BlockEquations& blocks,
                                  std::span<const LinearContact> contacts) {
  if (!automatic_)
    return options.analysis == Analysis::Dynamic &&
           options.contact_iteration == ContactIteration::ProximalNewton;
  // Of positions, or of velocities.
  stays_hard_ = stays_hard_ || is_uneven(blocks, contacts) || is_steep(contacts);
  if (stays_hard_ && !gave_up_) stage_ = Stage::OpenClose;
  return stage_ != Stage::OpenClose;
}

/// Whether the checked stage may have a sub-step that the open-close iteration has not solved.
bool ContactSolver::can_check() const { return suits_ && !stays_hard_ && checked_ == Try::None; }

/// Iterations of the open-close iteration on this problem, at most.
int ContactSolver::patience(std::span<const LinearContact> contacts) const {
  return can_check() && is_loose(contacts) ? kMostOpenCloseLoose : kMostOpenClose;
}

void ContactSolver::choose(const StepOptions& options) {
  linear_solver().choose(options.linear_solver, options.distributed_solver.get());
}

void ContactSolver::begin() {
  failures_ = 0;
  gave_up_ = false;
  step_began_.reset();
  move_on();
}

void ContactSolver::move_on() {
  checked_ = Try::None;
  cannot_yield_ = false;
}

void ContactSolver::start(int crowd) {
  moving_contacts_.begin();
  open_close_.begin();
  stays_hard_ = inexact_ = false;
  slow_ = crowd == kSlow;
  stage_ = slow_ ? Stage::OpenClose : static_cast<Stage>(crowd);
  if (!step_began_) step_began_ = stage_;
  if (stage_ == Stage::Again) stage_ = Stage::OpenClose;
  if (gave_up_) stage_ = Stage::Crowd;
  if (stage_ == Stage::OpenClose && checked_ == Try::Now) stage_ = Stage::Checked;
}

Fate ContactSolver::judge(const AttemptOutcome& outcome) {
  if (!automatic_) return Fate::End;
  const bool gained = outcome.gains > outcome.allowed;
  const Fate last = outcome.solved && outcome.can_cut ? Fate::Halved : Fate::End;
  switch (stage_) {
    case Stage::Checked: {
      if (outcome.solved && (!yielding_ || (outcome.closed && !gained))) return Fate::End;
      checked_ = Try::Failed;
      cannot_yield_ = !outcome.solved;
      return Fate::Again;
    }
    case Stage::Crowd:
      return yielding_ && gained ? last : Fate::End;
    default: {
      const bool pushed = gained && outcome.contact_work > outcome.allowed;
      if (outcome.solved && !pushed) return Fate::End;
      if (!can_check()) return last;
      checked_ = Try::Now;
      return Fate::Again;
    }
  }
}

/// A crowd is one for good once the open-close iteration has failed in two steps in a row. A slope
/// whose toe goes has one such step.
int ContactSolver::crowd() const {
  if (!automatic_) return slow_ ? kSlow : 0;
  if (stage_ == Stage::OpenClose) return 0;
  return static_cast<int>(step_began_ == Stage::OpenClose ? Stage::Again : Stage::Crowd);
}

double ContactSolver::note(bool solved, bool can_cut) {
  if (!automatic_ || gave_up_) return 0.5;
  if (stays_hard_) {
    gave_up_ = !solved && !can_cut && suits_;
    return gave_up_ ? std::numeric_limits<double>::infinity() : 0.5;
  }
  failures_ = solved ? 0 : failures_ + 1;
  gave_up_ = failures_ >= kFailures && suits_ && !yielding_;
  if (!gave_up_) return 0.5;
  return cannot_yield_ ? 1.0 : 2.0;
}

}  // namespace quoin::solver
