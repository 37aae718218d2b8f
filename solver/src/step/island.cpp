#include "step/island.hpp"

#include <numeric>

namespace quoin::solver {

IslandBlocks whole_scene(const CompiledScene& compiled) {
  IslandBlocks whole{.slots = compiled.slots, .smallest_size = compiled.smallest_size};
  whole.loads.resize(compiled.loads.size());
  std::iota(whole.loads.begin(), whole.loads.end(), 0);
  whole.held.resize(compiled.held.size());
  std::iota(whole.held.begin(), whole.held.end(), 0);
  return whole;
}

}  // namespace quoin::solver
