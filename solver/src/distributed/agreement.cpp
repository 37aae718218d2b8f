#include "distributed/agreement.hpp"

#include <algorithm>
#include <numeric>

#include "base/index.hpp"
#include "distributed/distributed_solver.hpp"

namespace quoin::solver {

double Agreement::largest(double mine) const {
  if (!shares()) return mine;
  const std::vector<double> all = of_all(std::span<const double>(&mine, 1));
  double most = all[0];
  for (const double other : all) most = std::max(most, other);
  return most;
}

double Agreement::sum(double mine) const {
  if (!shares()) return mine;
  const std::vector<double> all = of_all(std::span<const double>(&mine, 1));
  return std::accumulate(all.begin(), all.end(), 0.0);
}

/// `told`: what one process is enough for.
void Agreement::agree(char told, std::vector<char>& flags) const {
  if (!shares()) return;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (flags[i] == told) places.push_back(i);
  }
  places = of_all(places);
  std::ranges::for_each(places, [&](std::size_t i) { flags[i] = told; });
}

void Agreement::complete(const Slots& slots, std::size_t width, std::span<double> by_slot) const {
  if (!shares()) return;
  const std::size_t count = slots.block_of_slot.size();
  std::vector<std::size_t> next(index(processes_->count()) + 1, 0);  // place of each rank's rows
  std::vector<double> mine;
  for (std::size_t s = 0; s < count; ++s) {
    const int block = slots.block_of_slot[s];
    ++next[index(processes_->rank_of(block)) + 1];
    if (!owns(block)) continue;
    const std::span<const double> row = by_slot.subspan(s * width, width);
    mine.insert(mine.end(), row.begin(), row.end());
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  const std::vector<double> all = of_all(mine);
  for (std::size_t s = 0; s < count; ++s) {
    const std::size_t from = next[index(processes_->rank_of(slots.block_of_slot[s]))]++;
    std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(from * width), width,
                by_slot.begin() + static_cast<std::ptrdiff_t>(s * width));
  }
}

void Agreement::complete(const Slots& slots, std::vector<double>& by_slot) const {
  complete(slots, 1, by_slot);
}

void Agreement::complete(const Slots& slots, BlockVector& by_slot) const {
  if (!shares()) return;
  const std::size_t width = index(slots.width());
  std::vector<double> rows(width * by_slot.size());
  for (std::size_t s = 0; s < by_slot.size(); ++s) {
    std::copy_n(by_slot[s].data(), width, rows.begin() + static_cast<std::ptrdiff_t>(s * width));
  }
  complete(slots, width, rows);
  for (std::size_t s = 0; s < by_slot.size(); ++s) {
    std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(s * width), width, by_slot[s].data());
  }
}

Agreement agreement(const StepOptions& options) {
  return Agreement(options.distributed_solver.get());
}

}  // namespace quoin::solver
