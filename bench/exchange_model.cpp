#include "exchange_model.hpp"

#include <algorithm>

namespace quoin::bench {
namespace {

constexpr double kBytesOfRow = 48.0, kBytesOfNumber = 8.0;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

std::vector<Message> messages_of(const std::vector<Ghost>& ghosts) {
  std::vector<Message> messages;
  for (const Ghost& ghost : ghosts) {
    const bool same = !messages.empty() && messages.back().from == ghost.owner &&
                      messages.back().to == ghost.reader;
    if (!same) messages.push_back({ghost.owner, ghost.reader, 0});
    ++messages.back().rows;
  }
  return messages;
}

std::vector<long> blocks_of(const Graph& graph, const std::vector<int>& part_of, int parts) {
  std::vector<long> blocks(index(parts), 0);
  for (int row = 0; row < graph.rows(); ++row)
    blocks[index(part_of[index(row)])] += graph.end(row) - graph.begin(row);
  return blocks;
}

class Simulation {
 public:
  Simulation(std::span<const LevelWork> levels, int parts, const Machine& machine)
      : levels_(levels), machine_(machine), now_(index(parts), 0.0), arrivals_(index(parts)) {
    const double sharing = machine.cores > 0 ? static_cast<double>(parts) / machine.cores : 1.0;
    coupling_ = machine.coupling * std::max(1.0, sharing);
  }

  IterationCost run() {
    iterate(static_cast<int>(levels_.size()) - 1, *this);
    const double count = static_cast<double>(now_.size());
    cost_.time = *std::ranges::max_element(now_);
    for (double* total : {&cost_.arithmetic, &cost_.messages, &cost_.waiting, &cost_.sent})
      *total /= count;
    return cost_;
  }

  void product(int level) {
    const LevelWork& work = levels_[index(level)];
    exchange(work.product, Way::There, work.matrix);
  }

  void restrict_from(int level) {
    multiply(levels_[index(level)].transfer);
    exchange(levels_[index(level)].prolongation, Way::Back, {});
  }

  void prolong_to(int level) {
    exchange(levels_[index(level)].prolongation, Way::There, levels_[index(level)].transfer);
  }

  void solve_last() { multiply(levels_.back().matrix); }  // factors of one part

  /// In each round a part tells what it knows to the one twice as far on.
  void sum(int numbers) {
    const int parts = static_cast<int>(now_.size());
    for (int far = 1; far < parts; far *= 2) {
      for (int p = 0; p < parts; ++p) send(p, (p + far) % parts, kBytesOfNumber * numbers);
      take();
    }
  }

 private:
  enum class Way { There, Back };

  void multiply(std::span<const long> blocks) {
    for (std::size_t p = 0; p < blocks.size(); ++p) {
      const double time = coupling_ * static_cast<double>(blocks[p]);
      now_[p] += time;
      cost_.arithmetic += time;
    }
  }

  /// `blocks`: multiplied while the messages are under way.
  void exchange(std::span<const Message> messages, Way way, std::span<const long> blocks) {
    for (const Message& m : messages) {
      const bool there = way == Way::There;
      send(there ? m.from : m.to, there ? m.to : m.from, kBytesOfRow * m.rows);
    }
    cost_.sent += static_cast<double>(messages.size());
    cost_.exchanges += messages.empty() ? 0 : 1;
    multiply(blocks);
    take();
  }

  void send(int from, int to, double bytes) {
    busy(from);
    const double on_way = machine_.latency - 2.0 * machine_.message + machine_.byte * bytes;
    arrivals_[index(to)].push_back(now_[index(from)] + std::max(0.0, on_way));
  }

  void take() {
    for (std::size_t p = 0; p < now_.size(); ++p) {
      std::ranges::sort(arrivals_[p]);
      for (const double arrival : arrivals_[p]) {
        cost_.waiting += std::max(0.0, arrival - now_[p]);
        now_[p] = std::max(now_[p], arrival);
        busy(static_cast<int>(p));
      }
      arrivals_[p].clear();
    }
  }

  void busy(int part) {
    now_[index(part)] += machine_.message;
    cost_.messages += machine_.message;
  }

  std::span<const LevelWork> levels_;
  Machine machine_;
  double coupling_ = 0.0;
  std::vector<double> now_;                    // of each part, s
  std::vector<std::vector<double>> arrivals_;  // at each part
  IterationCost cost_;
};

}  // namespace

std::vector<LevelWork> work_of(std::span<const Level> levels, int parts) {
  std::vector<LevelWork> work;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const Level& level = levels[l];
    LevelWork next;
    next.product = messages_of(ghosts_of(level.matrix, level.part_of, level.part_of));
    next.matrix = blocks_of(level.matrix, level.part_of, parts);
    if (l + 1 < levels.size()) {
      next.prolongation =
          messages_of(ghosts_of(level.prolongation, level.part_of, levels[l + 1].part_of));
      next.transfer = blocks_of(level.prolongation, level.part_of, parts);
    }
    work.push_back(std::move(next));
  }
  return work;
}

IterationCost simulate(std::span<const LevelWork> levels, int parts, const Machine& machine) {
  return Simulation(levels, parts, machine).run();
}

}  // namespace quoin::bench
