#pragma once
/// Pairs that come near each other by a vertex or an edge: several planes keep the two apart, and
/// it is enough that one of them does so at the end of the step.   [Shi 2015], entrance; [Wang
/// 2020]

#include <quoin/geometry/contact_point.hpp>

#include "contact/contact_history.hpp"
#include "step/sub_step.hpp"

namespace quoin::solver {

/// A face of one block; its plane keeps the other block of the pair, or a part of it, apart.
struct FacePlane {
  int block = 0, other = 0, other_part = 0;
  int face = 0;
};

/// A pair of convex parts whose contacts the step is first tried without.
struct PassingPair {
  std::vector<FacePlane> planes;      ///< that keep the two apart at the start of the step
  std::vector<BodyContact> contacts;  ///< as found at the start
  double limit = 0.0;                 ///< an overlap that is none, m
  double stored = 0.0;                ///< in springs of these contacts, J: gone without them
};

/// Takes the contacts of those pairs out of `contacts` (in joint_order) that touched nowhere in the
/// last step, would close in this one by the motion they have, and are then kept farther apart by a
/// face's plane other than that of their contacts, and adds them to `aside`. `limit`: m, an overlap
/// that is none. Blocks on springs have sunk into their support, and would hit the side of the next
/// one as they slide onto it: for them twice that depth is no overlap, either, and pairs that touch
/// are taken out, too, unless bonded.
void set_aside_passing(const SubStep& step, double limit, std::vector<BodyContact>& contacts,
                       std::vector<PassingPair>& aside);

/// PassingPair::limit of two blocks that pass each other, else 0.
double passing_limit(std::span<const PassingPair> pairs, int a, int b);

/// After the step was tried without them: pairs that overlap at its end although no plane of theirs
/// is least violated there (they passed none), or end far behind all of them, have their contacts
/// back, in place of those found at the end. `found_end`: contact points at the end, sorted. True
/// when there were any; they are taken out of `pairs`.
bool put_back_blocked(const CompiledScene& compiled, std::span<const BlockState> end,
                      std::span<const geometry::ContactPoint> found_end,
                      std::vector<PassingPair>& pairs, std::vector<BodyContact>& contacts);

}  // namespace quoin::solver
