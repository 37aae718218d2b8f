#pragma once
/// What an iteration of GMRES with GAMG takes on a wall in parts, by a model of messages.

#include <span>

#include "wall_levels.hpp"

namespace quoin::bench {

/// The LogGP model [Alexandrov et al. 1997] and the rate of a core, s.
struct Machine {
  double latency = 0.0;   ///< of a message of no length, half of there and back
  double message = 0.0;   ///< of that, what each of the two processes is busy with
  double byte = 0.0;      ///< of a long message
  double coupling = 0.0;  ///< of a block of 36 numbers in a product
  int cores = 0;          ///< that all parts share; 0: each part has its own
};

/// What an iteration does on a level that is not the last, as PETSc's log of GAMG has it.
constexpr int kProductsBefore = 1;  ///< Chebyshev, two steps from zero
constexpr int kProductsResidual = 1;
constexpr int kProductsAfter = 2;  ///< Chebyshev, two steps
constexpr int kDots = 12;          ///< of GMRES, numbers in one sum, mean of a solution; and a norm

/// What an iteration does, in its order: of a V-cycle on levels 0 … `last`.
template <class Does>
void cycle(int level, int last, Does& does) {
  if (level == last) return does.solve_last();
  for (int i = 0; i < kProductsBefore + kProductsResidual; ++i) does.product(level);
  does.restrict_from(level);
  cycle(level + 1, last, does);
  does.prolong_to(level);
  for (int i = 0; i < kProductsAfter; ++i) does.product(level);
}

template <class Does>
void iterate(int last, Does& does) {
  does.product(0);
  cycle(0, last, does);
  does.sum(kDots);
  does.sum(1);
}

/// Rows that one part sends another.
struct Message {
  int from = 0, to = 0, rows = 0;
};

/// What a level's products and its prolongation tell, and what a part multiplies. Restriction is
/// the prolongation's way back.
struct LevelWork {
  std::vector<Message> product, prolongation;
  std::vector<long> matrix, transfer;  ///< by part: blocks in its rows
};

std::vector<LevelWork> work_of(std::span<const Level> levels, int parts);

/// Means over the parts but for the time.
struct IterationCost {
  double time = 0.0;        ///< of the last part to end, s
  double arithmetic = 0.0;  ///< s
  double messages = 0.0;    ///< sending and taking, s
  double waiting = 0.0;     ///< for others, s
  double sent = 0.0;        ///< messages of a part, without those of the sums
  int exchanges = 0;        ///< in which any part sends
};

/// Each part posts its messages one after the other, multiplies, takes what others have sent and
/// goes on. Sums go by dissemination [Hensgen, Finkel & Manber 1988].
IterationCost simulate(std::span<const LevelWork> levels, int parts, const Machine& machine);

}  // namespace quoin::bench
