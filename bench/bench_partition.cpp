/// What the parts of a wall would tell each other: bisected by place, counted from its contacts.
///
/// bench_partition [COLUMNS ROWS [solved]]: for 2, 4, … 64 parts, of each part the blocks of others
/// that its own touch (ghosts) and the parts that these belong to (messages of a product).

#include <cstdio>
#include <cstdlib>
#include <quoin/geometry/contact_finder.hpp>
#include <quoin/solver/parts.hpp>
#include <set>

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
  for (const solver::Contact& contact : simulation.state().contacts)
    if (contact.mode != solver::ContactMode::Open) add(scene, contact.point, pairs);
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

}  // namespace

int main(int argc, char** argv) {
  const int columns = argc > 2 ? std::atoi(argv[1]) : 125,
            rows = argc > 2 ? std::atoi(argv[2]) : 80;
  const solver::Scene scene = quoin::bench::wall_scene(columns, rows);
  const bool solved = argc > 3;
  const Pairs pairs = solved ? bearing(scene) : touching(scene);
  std::printf("%zu blocks, %zu pairs that %s\n", scene.blocks.size(), pairs.size(),
              solved ? "bear a force" : "touch");
  for (int count = 2; count <= 64; count *= 2)
    print(parts_of(solver::parts_of_blocks(scene, count), pairs, count));
}
