#include "step/step_flags.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/index.hpp"
#include "contact/contact_history.hpp"

namespace quoin::solver {
namespace {

constexpr double kLargestStrain = 0.05;   // small-strain theory; of a block that closes a spring
constexpr double kLargestOverlap = 1e-3;  // of the smaller block: as at the start of a scene
constexpr double kThrownApart = 1e-4;     // likewise: up to there all are found (Reach)

double size(const CompiledScene& compiled, int block) { return compiled.models[index(block)].size; }

/// Of the smaller block.
double overlap_share(const CompiledScene& compiled, const geometry::ContactPoint& point) {
  return -point.gap / std::min(size(compiled, point.key.a), size(compiled, point.key.b));
}

/// Of the smaller block, beyond which no joint's stiffness accounts for an overlap.
double hard_overlap(const CompiledScene& compiled, const geometry::ContactPoint& point) {
  const Joint& joint = joint_between(compiled.scene, point.key.a, point.key.b);
  return joint.normal_stiffness > 0.0 ? kLargestStrain : kLargestOverlap;
}

void note_overlap(const CompiledScene& compiled, const geometry::ContactPoint& point,
                  WorstOverlap& worst) {
  const double share = overlap_share(compiled, point);
  const bool hard = share > kLargestOverlap && share > hard_overlap(compiled, point);
  const WorstOverlap now{hard, share, &point};
  if (now.size() > worst.size()) worst = now;
}

bool is_before(const geometry::ContactPoint* x, const geometry::ContactPoint* y) {
  return x != nullptr && (y == nullptr || x->key < y->key);
}

/// Of equal ones that of the first point.
void add(const WorstOverlap& now, WorstOverlap& total) {
  if (now.size() < total.size()) return;
  if (now.size() > total.size() || is_before(now.point, total.point)) total = now;
}

/// Overlaps of springs are by their law.
StepFlag worst_overlap(const CompiledScene& compiled, const StepEvidence& evidence,
                       const Extremes& extremes) {
  const WorstOverlap& worst =
      extremes.held.size() > extremes.found.size() ? extremes.held : extremes.found;
  StepFlag flag{.kind = FlagKind::Overlap, .limit = kLargestOverlap};
  if (worst.point == nullptr) return flag;
  flag.value = worst.share;
  flag.block = worst.point->key.a;
  flag.other = worst.point->key.b;
  flag.fails = !evidence.springs && worst.hard;
  if (flag.fails) flag.limit = hard_overlap(compiled, *worst.point);
  return flag;
}

StepFlag missing_contact(const CompiledScene& compiled, const geometry::ContactPoint& point) {
  const int a = point.key.a, b = point.key.b;
  return {.kind = FlagKind::LostContact,
          .value = std::abs(point.gap) / std::min(size(compiled, a), size(compiled, b)),
          .block = a,
          .other = b,
          .fails = true};
}

}  // namespace

const geometry::ContactPoint* vanished(const CompiledScene& compiled,
                                       std::span<const Contact> contacts,
                                       std::span<const geometry::ContactPoint> found) {
  const auto pair = [](const geometry::ContactPoint& p) { return std::pair(p.key.a, p.key.b); };
  auto at = found.begin();
  for (const Contact& contact : contacts) {
    if (contact.mode == ContactMode::Open) continue;
    if (contact.impact && -overlap_share(compiled, contact.point) > kThrownApart) continue;
    while (at != found.end() && pair(*at) < pair(contact.point)) ++at;
    if (at == found.end() || pair(*at) != pair(contact.point)) return &contact.point;
  }
  return nullptr;
}

std::string_view name(FlagKind kind) {
  constexpr std::array<std::string_view, kFlagKinds> kNames = {
      "unconverged",   "strain",       "overlap", "rounding",
      "energy_growth", "lost_contact", "turn",    "impacts"};
  return kNames[static_cast<std::size_t>(kind)];
}

void EnergyScale::note(double kinetic, double gain) {
  rest_ += gain;
  lowest_ = std::min(lowest_, rest_);
  highest_ = std::max(highest_, rest_);
  kinetic_ = std::max(kinetic_, kinetic);
}

void note_block(const BlockState& state, int block, double speed, Extremes& extremes) {
  extremes.speed = std::max(extremes.speed, speed);
  const double strain = state.strain.cwiseAbs().maxCoeff();
  if (!(strain > extremes.strain)) return;
  extremes.strain = strain;
  extremes.strained = block;
}

void note_contacts(const CompiledScene& compiled, std::span<const Contact> contacts,
                   std::span<const geometry::ContactPoint> found, Extremes& extremes) {
  for (const geometry::ContactPoint& point : found) {
    extremes.overlap = std::max(extremes.overlap, -point.gap);
    note_overlap(compiled, point, extremes.found);
  }
  for (const Contact& contact : contacts) {
    if (contact.mode == ContactMode::Open) continue;
    ++extremes.closed;
    note_overlap(compiled, contact.point, extremes.held);
  }
  extremes.vanished = vanished(compiled, contacts, found);
}

void add(const Extremes& part, Extremes& total) {
  total.closed += part.closed;
  total.overlap = std::max(total.overlap, part.overlap);
  total.speed = std::max(total.speed, part.speed);
  const bool sooner = part.strain == total.strain && part.strained < total.strained;
  if (part.strain > total.strain || sooner) {
    total.strain = part.strain;
    total.strained = part.strained;
  }
  add(part.found, total.found);
  add(part.held, total.held);
  if (is_before(part.vanished, total.vanished)) total.vanished = part.vanished;
}

void append_flags(const CompiledScene& compiled, const Extremes& extremes,
                  const StepEvidence& evidence, StepReport& report) {
  const auto append = [&](const StepFlag& flag) {
    if (flag.value > flag.limit) report.flags.push_back(flag);
  };
  if (report.status != StepStatus::Converged) {
    report.flags.push_back(
        {.kind = FlagKind::Unconverged, .value = report.residual, .fails = true});
  }
  append({.kind = FlagKind::Strain,
          .value = extremes.strain,
          .limit = kLargestStrain,
          .block = extremes.strained,
          .fails = true});
  append(worst_overlap(compiled, evidence, extremes));
  append({.kind = FlagKind::Rounding,
          .value = evidence.rounding / evidence.gap_tolerance,
          .limit = 1.0});
  if (evidence.energy_growth > evidence.energy_noise) {
    append({.kind = FlagKind::EnergyGrowth,
            .value = evidence.energy_growth / evidence.energy_scale,
            .limit = kEnergyGrowth,
            .block = evidence.energy_block});
  }
  append(evidence.turn);
  append(evidence.impacts);
  const geometry::ContactPoint* missing =
      evidence.missing != nullptr ? evidence.missing : extremes.vanished;
  if (missing != nullptr) append(missing_contact(compiled, *missing));
}

}  // namespace quoin::solver
