#pragma once
/// Blocks that no contact has to push.
///
/// Where gravity is switched off, or a support goes, the exact contact forces are zero. Multipliers
/// come to that by a share each update: relative to the forces at a block, which are these and
/// nothing else, they never get there.

#include <span>

#include "block/block_system.hpp"
#include "contact/linear_contact.hpp"

namespace quoin::solver {

/// How blocks move in a dynamic step by what acts on them but contacts, by slot.
struct FreeMotion {
  const SquareBlocks& compliance;  ///< inverse of K
  const BlockVector& coasting;     ///< v dt: without loads, too
};

/// Whether no contact has to push where the blocks move freely: each opens; or it lets blocks come
/// no nearer than rounding makes of where they are, loads do not press it, and it overlaps no more
/// than `overlap`, m. A bonded one and a held point keep where they were in all directions, springs
/// are never left alone.
bool is_unforced(const FreeMotion& free, const BlockVector& force,
                 std::span<const LinearContact> contacts, double overlap);

/// Of blocks that touch nothing. Where the increments are as good as a guess they stay. Largest
/// change of a motion, m.
double coast(const FreeMotion& free, const Slots& slots, const BlockVector& force,
             BlockVector& increment);

/// Increments of free motion, and contacts that bear nothing.
void move_freely(const FreeMotion& free, const BlockVector& force,
                 std::span<LinearContact> contacts, BlockVector& increment);

}  // namespace quoin::solver
