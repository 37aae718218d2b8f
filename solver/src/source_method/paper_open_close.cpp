#include "source_method/paper_open_close.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/index.hpp"

namespace quoin::solver {
namespace {

// Solves in which what F changes by has not fallen to this share: it is rounding, if no more than
// that. Chosen: all cells of `quoin stability` keep their digits.
constexpr int kIdle = 10;
constexpr double kResidualFalls = 0.9;

Vector12 increment_of(int slot, const BlockVector& increment) {
  return slot < 0 ? Vector12(Vector12::Zero()) : increment[index(slot)];
}

void push(const PaperContact& c, const ContactForces& forces, BlockVector& right) {
  if (c.slot_i >= 0) right[index(c.slot_i)] += forces.i;
  if (c.slot_j >= 0) right[index(c.slot_j)] += forces.j;
}

/// A closed contact without friction and cohesion has no shear spring at all.
ContactMode closed_mode(const PaperContact& c, const PaperOptions& options) {
  const bool sticks = !options.sliding || c.friction > 0.0 || c.cohesion > 0.0;
  return sticks ? ContactMode::Stick : ContactMode::Slip;
}

/// Where the increment brings the contact, and what the next iteration takes for its normal force
/// and for the direction of sliding.
void measure(const BlockVector& increment, const PaperOptions& options, PaperContact& c) {
  const Vector12 d_i = increment_of(c.slot_i, increment), d_j = increment_of(c.slot_j, increment);
  const Vector3& n = c.normal.normal;
  c.gap = n.dot(between_after(c.normal, d_i, d_j));
  const Vector3 between = between_after(c.shear, d_i, d_j);
  c.slide = between - n.dot(between) * n;  // (51)
  if (c.mode == ContactMode::Open) return;
  c.compression = -(c.multiplier + options.normal_stiffness * c.gap);
  const bool onward = c.direction.isZero(0.0) || c.slide.dot(c.direction) > 0.0;
  if (c.mode == ContactMode::Slip && onward) c.direction = c.slide.stableNormalized();
}

/// (49): the shear spring is beyond the strength that the normal force `compression` gives.
bool slides(const PaperContact& c, const PaperOptions& options, double compression,
            double force_tolerance) {
  const double strength = std::max(compression, 0.0) * c.friction + c.cohesion;
  return options.shear_stiffness * c.slide.norm() > strength + force_tolerance;
}

/// An open contact that overlaps closes, and slides at once where the springs of its overlap and of
/// its slide say so: a block set in motion on a rough plane would first be held and tipped over.
/// One with cohesion sticks until its own shear spring is beyond that: the slide of a block that
/// nothing holds yet would break it.
ContactMode mode_after_open(const PaperContact& c, const PaperOptions& options,
                            double force_tolerance) {
  if (!(c.gap < -options.rounding)) return ContactMode::Open;
  const ContactMode closed = closed_mode(c, options);
  if (closed == ContactMode::Slip || !options.sliding || c.cohesion > 0.0) return closed;
  const double compression = -options.normal_stiffness * c.gap;
  return slides(c, options, compression, force_tolerance) ? ContactMode::Slip : ContactMode::Stick;
}

/// The mode that the result asks for; `force_tolerance`: N, no force is known better.
ContactMode next_mode(const PaperContact& c, const PaperOptions& options, double force_tolerance) {
  if (c.mode == ContactMode::Open) return mode_after_open(c, options, force_tolerance);
  if (c.compression < -c.tension - force_tolerance) return ContactMode::Open;
  if (!options.sliding || closed_mode(c, options) == ContactMode::Slip) return c.mode;
  if (c.mode == ContactMode::Slip)
    return c.slide.dot(c.direction) < 0.0 ? ContactMode::Stick : ContactMode::Slip;
  return slides(c, options, c.compression, force_tolerance) ? ContactMode::Slip
                                                            : ContactMode::Stick;
}

double largest_compression(std::span<const PaperContact> contacts) {
  double largest = 0.0;
  for (const PaperContact& c : contacts)
    if (c.mode != ContactMode::Open) largest = std::max(largest, std::abs(c.compression));
  return largest;
}

/// Tol1, N: a share of the largest normal force, and no less than what rounding makes of a gap.
double force_tolerance(std::span<const PaperContact> contacts, const PaperOptions& options) {
  return std::max(options.tolerance * largest_compression(contacts),
                  options.normal_stiffness * options.rounding);
}

/// What rounding of gaps makes of F, N: of each contact, and of all by chance. Below it F changes
/// for ever, and falls no more.
double rounding_of_right(std::span<const PaperContact> contacts, const PaperOptions& options) {
  return options.normal_stiffness * options.rounding *
         std::sqrt(static_cast<double>(contacts.size()));
}

/// Step 18: true when no contact changes its mode.
bool switch_modes(std::span<PaperContact> contacts, const PaperOptions& options) {
  const double tolerance = force_tolerance(contacts, options);
  bool same = true;
  for (PaperContact& c : contacts) {
    const ContactMode next = next_mode(c, options, tolerance);
    if (next == c.mode) continue;
    same = false;
    if (next == ContactMode::Slip) c.direction = c.slide.stableNormalized();
    if (next == ContactMode::Open) c.compression = 0.0;
    c.mode = next;
  }
  return same;
}

}  // namespace

void PaperOpenClose::add(const PaperContact& c, const ContactBlocks& blocks) {
  push(c, blocks.force, constant_);
  const int n = system_.diagonal.width();
  if (c.slot_i >= 0) system_.diagonal[index(c.slot_i)] += blocks.ii.topLeftCorner(n, n);
  if (c.slot_j >= 0) system_.diagonal[index(c.slot_j)] += blocks.jj.topLeftCorner(n, n);
  if (c.pair < 0) return;
  const auto ij = blocks.ij.topLeftCorner(n, n);
  auto upper = system_.off_diagonal[index(c.pair)];
  c.slot_i < c.slot_j ? upper += ij : upper += ij.transpose();
}

/// K and the part of F that stays while no contact changes its mode.
void PaperOpenClose::assemble(const BlockSystem& base, const BlockVector& force,
                              std::span<const PaperContact> contacts, const PaperOptions& options) {
  system_.diagonal = base.diagonal;
  system_.pairs = base.pairs;
  system_.off_diagonal.resize(base.pairs.size(), base.diagonal.width());
  system_.off_diagonal.set_zero();
  constant_ = force;
  for (const PaperContact& c : contacts) {
    if (c.mode == ContactMode::Open) continue;
    add(c, normal_blocks(c.normal, options.normal_stiffness, 0.0));
    if (c.mode == ContactMode::Stick) add(c, shear_blocks(c.shear, options.shear_stiffness));
  }
}

void PaperOpenClose::set_right(std::span<const PaperContact> contacts) {
  right_ = constant_;
  for (const PaperContact& c : contacts) {
    if (c.mode == ContactMode::Open) continue;
    push(c, multiplier_forces(c.normal, c.multiplier), right_);
    if (c.mode != ContactMode::Slip) continue;
    const double friction = c.friction * std::max(c.compression, 0.0);  // (50)
    push(c, friction_forces(c.shear, friction, c.direction), right_);
  }
}

/// Of (58): K stays, and K D is F.
PaperOpenClose::Change PaperOpenClose::change_of_right() const {
  double change = 0.0, size = 0.0;
  for (std::size_t s = 0; s < right_.size(); ++s) {
    change += (right_[s] - last_[s]).squaredNorm();
    size += last_[s].squaredNorm();
  }
  return {std::sqrt(change), std::sqrt(size)};
}

/// K D = F, and once more with what that leaves: K is stiff (springs of 5e10 N/m beside the inertia
/// of a block), and its rounding in D would come back in every step.   [Skeel 1980]
void PaperOpenClose::solve_refined(BlockVector& increment) {
  solver_.solve(right_, increment);
  rest_ = right_;
  for (std::size_t s = 0; s < rest_.size(); ++s)
    rest_[s] -= system_.diagonal.times(s, increment[s]);
  for (std::size_t k = 0; k < system_.pairs.size(); ++k) {
    const std::size_t i = index(system_.pairs[k].first), j = index(system_.pairs[k].second);
    rest_[i] -= system_.off_diagonal.times(k, increment[j]);
    rest_[j] -= system_.off_diagonal.times(k, increment[i], true);
  }
  correction_.resize(rest_.size());
  solver_.solve(rest_, correction_);
  for (std::size_t s = 0; s < rest_.size(); ++s) increment[s] += correction_[s];
}

/// Steps 10–17, contacts keep their modes. False when it does not end within the solves that are
/// left.
bool PaperOpenClose::augment(std::span<PaperContact> contacts, const PaperOptions& options,
                             BlockVector& increment, OpenCloseResult& result) {
  for (PaperContact& c : contacts) c.multiplier = 0.0;
  set_right(contacts);
  double least = std::numeric_limits<double>::infinity();  // that F changed by in a solve, N
  int idle = 0;                                            // solves since that fell
  while (result.solves < options.max_solves) {
    if (watch_ != nullptr) watch_->look();
    solve_refined(increment);
    ++result.solves;
    double update = 0.0;  // of the multipliers, N
    for (PaperContact& c : contacts) {
      measure(increment, options, c);
      if (c.mode == ContactMode::Open || !options.multipliers) continue;
      const double change = options.normal_stiffness * c.gap;
      update = std::max(update, std::abs(change));
      c.multiplier += change;  // (10)
    }
    std::swap(right_, last_);
    set_right(contacts);
    const auto [change, size] =
        change_of_right();  // K D of the next iteration, before it is solved
    result.residual = size > 0.0 ? change / size : 0.0;
    if (!std::isfinite(result.residual)) return false;
    idle = change < kResidualFalls * least ? 0 : idle + 1;
    least = std::min(least, change);
    const bool rounds = idle >= kIdle && change <= rounding_of_right(contacts, options);
    const bool agrees = rounds || result.residual <= options.tolerance;
    if (agrees && update <= force_tolerance(contacts, options)) return true;
  }
  return false;
}

OpenCloseResult PaperOpenClose::solve(const BlockSystem& base, const BlockVector& force,
                                      std::span<PaperContact> contacts, const PaperOptions& options,
                                      BlockVector& increment) {
  OpenCloseResult result;
  while (result.solves < options.max_solves) {
    ++result.iterations;
    assemble(base, force, contacts, options);
    ++result.factorizations;
    if (!solver_.factorize(system_)) break;
    if (!augment(contacts, options, increment, result)) break;
    if (switch_modes(contacts, options)) {
      result.converged = true;
      break;
    }
  }
  result.condition = solver_.condition_estimate();
  return result;
}

}  // namespace quoin::solver
