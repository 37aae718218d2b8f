/// What the parts of a wall would tell each other: bisected by place, counted from its contacts.
///
/// bench_partition [COLUMNS ROWS [solved]]: for 2, 4, … 64 parts, of each part the blocks of others
/// that its own touch (ghosts) and the parts that these belong to (messages of a product).
///
/// bench_partition model BRICKS LATENCY MESSAGE BYTE BLOCK [CORES]: an iteration by the model of
/// exchange_model.hpp on 1, 2, 4, … 100 parts of so many bricks each. LATENCY and MESSAGE in us,
/// BYTE and BLOCK in ns, as bench_exchange measures them; CORES that all parts share.

#include <cstdio>
#include <cstdlib>
#include <quoin/geometry/contact_finder.hpp>
#include <quoin/solver/parts.hpp>
#include <set>
#include <string_view>

#include "exchange_model.hpp"
#include "wall_scene.hpp"

namespace {

namespace geometry = quoin::geometry;
namespace solver = quoin::solver;

using Pairs = std::set<std::pair<int, int>>;

/// Of two blocks with unknowns.
void add(const solver::Scene& scene, const geometry::ContactPoint& contact, Pairs& pairs) {
  const auto fixed = [&](int b) {
    return scene.blocks[static_cast<std::size_t>(b)].kind == solver::BlockKind::Fixed;
  };
  if (fixed(contact.key.a) || fixed(contact.key.b)) return;
  pairs.emplace(contact.key.a, contact.key.b);
}

Pairs touching(const solver::Scene& scene) {
  geometry::ContactFinder finder({.reach = 1e-6});
  for (const solver::Block& block : scene.blocks) finder.add(block.shape, block.placement);
  std::vector<geometry::ContactPoint> contacts;
  finder.find(contacts);
  Pairs pairs;
  for (const geometry::ContactPoint& contact : contacts) add(scene, contact, pairs);
  return pairs;
}

/// Those that bear a force when the wall has come to rest: what the last matrices couple.
Pairs bearing(const solver::Scene& scene) {
  solver::Simulation simulation(scene, {.time_step = 0.01});
  static_cast<void>(simulation.advance());
  Pairs pairs;
  for (const solver::Contact& contact : simulation.state().contacts) {
    if (contact.mode != solver::ContactMode::Open) add(scene, contact.point, pairs);
  }
  return pairs;
}

struct Part {
  int own = 0;
  std::set<int> ghosts{}, neighbours{};
};

std::vector<Part> parts_of(const std::vector<int>& part_of, const Pairs& pairs, int count) {
  std::vector<Part> parts(static_cast<std::size_t>(count));
  for (const int part : part_of) ++parts[static_cast<std::size_t>(part)].own;
  const auto see = [&](int block, int other) {
    const int here = part_of[static_cast<std::size_t>(block)];
    const int there = part_of[static_cast<std::size_t>(other)];
    if (here == there) return;
    parts[static_cast<std::size_t>(here)].ghosts.insert(other);
    parts[static_cast<std::size_t>(here)].neighbours.insert(there);
  };
  for (const auto& [a, b] : pairs) {
    see(a, b);
    see(b, a);
  }
  return parts;
}

void print(const std::vector<Part>& parts) {
  std::size_t ghosts = 0, most_ghosts = 0, messages = 0, most_messages = 0;
  int least = parts.front().own, most = least;
  for (const Part& part : parts) {
    least = std::min(least, part.own);
    most = std::max(most, part.own);
    ghosts += part.ghosts.size();
    messages += part.neighbours.size();
    most_ghosts = std::max(most_ghosts, part.ghosts.size());
    most_messages = std::max(most_messages, part.neighbours.size());
  }
  const double count = static_cast<double>(parts.size());
  std::printf("%5zu parts: own %d to %d, ghosts %.1f (most %zu), messages %.2f (most %zu)\n",
              parts.size(), least, most, static_cast<double>(ghosts) / count, most_ghosts,
              static_cast<double>(messages) / count, most_messages);
}

/// By how much slower messages make an iteration take twice its arithmetic.
double slower(std::span<const quoin::bench::LevelWork> work, int parts,
              quoin::bench::Machine machine) {
  const double latency = machine.latency, message = machine.message;
  constexpr int kBisections = 60;
  double least = 0.0, most = 1e6;
  for (int i = 0; i < kBisections && most - least > 1e-3 * most; ++i) {
    const double factor = 0.5 * (least + most);
    machine.latency = factor * latency;
    machine.message = factor * message;
    const quoin::bench::IterationCost cost = simulate(work, parts, machine);
    (cost.time < 2.0 * cost.arithmetic ? least : most) = factor;
  }
  return most;
}

void print_model(int bricks, int parts, const quoin::bench::Machine& machine) {
  const double count = static_cast<double>(bricks) * parts;
  const int rows = static_cast<int>(std::sqrt(count / 1.5625));
  const auto levels = quoin::bench::wall_levels(static_cast<int>(count / rows), rows, parts);
  const auto work = quoin::bench::work_of(levels, parts);
  const quoin::bench::IterationCost cost = simulate(work, parts, machine);
  std::printf(
      "%4d parts, %8d bricks, %zu levels, %2d exchanges, %5.1f messages: %.4g ms, of it "
      "arithmetic %.1f %%, messages %.1f %%, waiting %.1f %%",
      parts, levels[0].matrix.rows(), levels.size(), cost.exchanges, cost.sent, 1e3 * cost.time,
      100.0 * cost.arithmetic / cost.time, 100.0 * cost.messages / cost.time,
      100.0 * cost.waiting / cost.time);
  if (parts > 1) {
    std::printf("; twice the arithmetic at %.3g us of latency",
                1e6 * machine.latency * slower(work, parts, machine));
  }
  std::printf("\n");
}

void model(char** arguments, int count) {
  const auto number = [&](int i) { return std::atof(arguments[i]); };
  const quoin::bench::Machine machine{.latency = 1e-6 * number(1),
                                      .message = 1e-6 * number(2),
                                      .byte = 1e-9 * number(3),
                                      .coupling = 1e-9 * number(4),
                                      .cores = count > 5 ? std::atoi(arguments[5]) : 0};
  for (const int parts : {1, 2, 4, 8, 16, 32, 64, 100})
    print_model(std::atoi(arguments[0]), parts, machine);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 6 && std::string_view(argv[1]) == "model") {
    model(argv + 2, argc - 2);
    return 0;
  }
  const int columns = argc > 2 ? std::atoi(argv[1]) : 125,
            rows = argc > 2 ? std::atoi(argv[2]) : 80;
  const solver::Scene scene = quoin::bench::wall_scene(columns, rows);
  const bool solved = argc > 3;
  const Pairs pairs = solved ? bearing(scene) : touching(scene);
  std::printf("%zu blocks, %zu pairs that %s\n", scene.blocks.size(), pairs.size(),
              solved ? "bear a force" : "touch");
  for (int count = 2; count <= 64; count *= 2) {
    print(parts_of(solver::parts_of_blocks(scene, count), pairs, count));
  }
}
