#pragma once
/// What several processes must agree on, where each holds the contacts of its own blocks alone.

#include <cstring>
#include <quoin/solver/simulation.hpp>
#include <span>
#include <vector>

#include "block/block_system.hpp"

namespace quoin::solver {

/// Messages between the processes of a run. All of them call of_all() in the same order.
class Communicator {
 public:
  virtual ~Communicator() = default;

  virtual int rank() const = 0;              ///< 0 … count() - 1
  virtual int count() const = 0;             ///< of processes, >= 1
  virtual int rank_of(int block) const = 0;  ///< whose it is, of the scene's blocks

  /// What every process gives, in the order of ranks: the same everywhere.
  virtual std::vector<char> of_all(std::span<const char> mine) const = 0;
};

/// Whether this process is one of several, and what all of these come to: the same to the bit
/// everywhere, also where numbers are none. Where it is alone all calls give back what they were
/// given. Each of several holds the contacts that touch its own blocks; what lies between blocks of
/// two is held by both, and counts once.
class Agreement {
 public:
  Agreement() = default;
  explicit Agreement(const Communicator* processes)
      : processes_(processes != nullptr && processes->count() > 1 ? processes : nullptr) {}

  bool shares() const { return processes_ != nullptr; }
  bool owns(int block) const {
    return !shares() || processes_->rank_of(block) == processes_->rank();
  }
  /// Whether a contact of these slots counts here: where the first that has unknowns is owned.
  bool counts(const Slots& slots, int slot_a, int slot_b) const {
    return owns(slots.block_of_slot[static_cast<std::size_t>(slot_a >= 0 ? slot_a : slot_b)]);
  }

  bool any(bool mine) const { return shares() ? largest(mine ? 1.0 : 0.0) > 0.0 : mine; }
  bool all(bool mine) const { return !any(!mine); }
  double largest(double mine) const;
  double sum(double mine) const;

  /// Flags that any process has set, or that all have.
  void any(std::vector<char>& flags) const { agree(1, flags); }
  void all(std::vector<char>& flags) const { agree(0, flags); }

  /// By slot: those of own blocks in, those of all blocks out. Of vectors, Slots::width() rows.
  void complete(const Slots& slots, BlockVector& by_slot) const;
  void complete(const Slots& slots, std::vector<double>& by_slot) const;
  /// The same of `width` numbers each.
  void complete(const Slots& slots, std::size_t width, std::span<double> by_slot) const;

  /// Lists of plain records, one after the other in the order of ranks.
  template <class Record>
  std::vector<Record> of_all(std::span<const Record> mine) const {
    if (!shares()) return {mine.begin(), mine.end()};
    const std::vector<char> bytes = processes_->of_all(
        {reinterpret_cast<const char*>(mine.data()), mine.size() * sizeof(Record)});
    std::vector<Record> all(bytes.size() / sizeof(Record));
    if (!all.empty()) std::memcpy(static_cast<void*>(all.data()), bytes.data(), bytes.size());
    return all;
  }
  template <class Record>
  std::vector<Record> of_all(const std::vector<Record>& mine) const {
    return of_all(std::span<const Record>(mine));
  }

 private:
  void agree(char told, std::vector<char>& flags) const;

  const Communicator* processes_ = nullptr;
};

/// Of the processes that solve together.
Agreement agreement(const StepOptions& options);

}  // namespace quoin::solver
