#include "step_flags.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace quoin::solver {
namespace {

constexpr double kLargestStrain = 0.05;   // small-strain theory
constexpr double kLargestOverlap = 1e-3;  // of the smaller block: as at the start of a scene

double size(const CompiledScene& compiled, int block) {
  return compiled.models[static_cast<std::size_t>(block)].size;
}

StepFlag worst_strain(const State& state) {
  StepFlag flag{.kind = FlagKind::Strain, .limit = kLargestStrain};
  for (std::size_t b = 0; b < state.blocks.size(); ++b) {
    const double strain = state.blocks[b].strain.cwiseAbs().maxCoeff();
    if (!(strain > flag.value)) continue;
    flag.value = strain;
    flag.block = static_cast<int>(b);
  }
  return flag;
}

/// Of what is found, and of what the step's own springs let through: a block that has sunk right
/// through another one is not found any more.
StepFlag worst_overlap(const CompiledScene& compiled, const State& state,
                       std::span<const geometry::ContactPoint> found) {
  StepFlag flag{.kind = FlagKind::Overlap, .limit = kLargestOverlap};
  const auto note = [&](const geometry::ContactPoint& point) {
    const int a = point.key.a, b = point.key.b;
    const double share = -point.gap / std::min(size(compiled, a), size(compiled, b));
    if (!(share > flag.value)) return;
    flag.value = share;
    flag.block = a;
    flag.other = b;
  };
  for (const geometry::ContactPoint& point : found) note(point);
  for (const Contact& contact : state.contacts) {
    if (contact.mode != ContactMode::Open) note(contact.point);
  }
  return flag;
}

StepFlag missing_contact(const CompiledScene& compiled, const geometry::ContactPoint& point) {
  const int a = point.key.a, b = point.key.b;
  return {.kind = FlagKind::LostContact,
          .value = std::abs(point.gap) / std::min(size(compiled, a), size(compiled, b)),
          .block = a,
          .other = b};
}

}  // namespace

const geometry::ContactPoint* vanished(std::span<const Contact> contacts,
                                       std::span<const geometry::ContactPoint> found) {
  const auto pair = [](const geometry::ContactPoint& p) { return std::pair(p.key.a, p.key.b); };
  auto at = found.begin();
  for (const Contact& contact : contacts) {
    if (contact.mode == ContactMode::Open) continue;
    while (at != found.end() && pair(*at) < pair(contact.point)) ++at;
    if (at == found.end() || pair(*at) != pair(contact.point)) return &contact.point;
  }
  return nullptr;
}

std::string_view name(FlagKind kind) {
  constexpr std::array<std::string_view, 6> kNames = {
      "unconverged", "strain", "overlap", "rounding", "energy_growth", "lost_contact"};
  return kNames[static_cast<std::size_t>(kind)];
}

void EnergyScale::note(double kinetic, double gain) {
  rest_ += gain;
  lowest_ = std::min(lowest_, rest_);
  highest_ = std::max(highest_, rest_);
  kinetic_ = std::max(kinetic_, kinetic);
}

void append_flags(const CompiledScene& compiled, const State& state, const StepEvidence& evidence,
                  StepReport& report) {
  const auto append = [&](const StepFlag& flag) {
    if (flag.value > flag.limit) report.flags.push_back(flag);
  };
  if (report.status != StepStatus::Converged) {
    report.flags.push_back({.kind = FlagKind::Unconverged, .value = report.residual});
  }
  append(worst_strain(state));
  append(worst_overlap(compiled, state, evidence.found));
  append({.kind = FlagKind::Rounding,
          .value = evidence.rounding / evidence.gap_tolerance,
          .limit = 1.0});
  if (evidence.energy_growth > evidence.energy_noise) {
    append({.kind = FlagKind::EnergyGrowth,
            .value = evidence.energy_growth / evidence.energy_scale,
            .limit = kEnergyGrowth,
            .block = evidence.energy_block});
  }
  if (evidence.missing != nullptr) append(missing_contact(compiled, *evidence.missing));
}

}  // namespace quoin::solver
