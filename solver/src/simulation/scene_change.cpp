#include "simulation/scene_change.hpp"

#include <algorithm>

#include "base/index.hpp"
#include "contact/contact_history.hpp"
#include "contact/joint_law.hpp"
#include "contact/joint_springs.hpp"

namespace quoin::solver {
namespace {

constexpr double kVelocityRounding = 1e-12;  // of the speeds, some thousand roundings

/// Moved by a motion: its place in CompiledScene::prescribed; -1: it is not.
std::ptrdiff_t prescribed_index(const CompiledScene& compiled, int block) {
  const auto found = std::ranges::find(compiled.prescribed, block);
  return found == compiled.prescribed.end() ? -1 : found - compiled.prescribed.begin();
}

/// The velocity that a block without unknowns goes on with. A motion that both scenes have goes on
/// as the last step left it.
Vector3 velocity_without_unknowns(const CompiledScene& before, const CompiledScene& now, int block,
                                  const Vector3& reached, double time) {
  if (prescribed_index(now, block) < 0) return Vector3::Zero();
  const Vector3 velocity = velocity_from(now.scene.blocks[index(block)].motion, reached, time);
  check_motion_velocity(now.scene, block, velocity, time);
  if (prescribed_index(before, block) < 0) return velocity;
  const Motion& last = before.scene.blocks[index(block)].motion;
  return velocity == velocity_from(last, reached, time) ? reached : velocity;
}

void take_over_block(const CompiledScene& before, const State& state_before,
                     const CompiledScene& now, int block, State& state) {
  BlockState& moved = state.blocks[index(block)];
  moved = state_before.blocks[index(block)];
  const int unknowns = now.models[index(block)].unknowns;
  if (unknowns < 12) moved.strain_rate.setZero();
  if (unknowns > 0) return;
  moved.angular_velocity.setZero();
  moved.velocity = velocity_without_unknowns(before, now, block, moved.velocity, state_before.time);
}

bool is_in_place(const BlockState& start, const BlockState& now) {
  return now.centroid == start.centroid && now.centroid_rest == start.centroid_rest &&
         now.rotation.coeffs() == start.rotation.coeffs() && now.strain == start.strain;
}

Vector3 velocity_of_place(const BlockState& block, const Vector3& place) {
  return block.velocity + (block.rotation * block.angular_velocity).cross(place - block.centroid);
}

void take_over_motions(const CompiledScene& before, const Workspace& work_before,
                       const CompiledScene& now, const State& state, Workspace& work) {
  for (std::size_t p = 0; p < now.prescribed.size(); ++p) {
    const int block = now.prescribed[p];
    const Motion& motion = now.scene.blocks[index(block)].motion;
    const std::ptrdiff_t known = prescribed_index(before, block);
    if (known >= 0)
      work.motion[p] = work_before.motion[static_cast<std::size_t>(known)];
    else
      work.motion[p].velocity = state.blocks[index(block)].velocity;
    work.motion[p].turn = turn_at(motion, state.time);
    if (motion.kind != MotionKind::Displacement) continue;
    const auto goes_on = [&](const Motion& last) {
      return last.kind == motion.kind && last.value.is(motion.value);
    };
    if (known < 0 || !goes_on(before.scene.blocks[index(block)].motion))
      work.motion[p].displacement = motion.value.at(state.time);
  }
}

void take_over_held(const CompiledScene& before, const State& state_before, CompiledScene& now,
                    State& state) {
  for (std::size_t h = 0; h < now.held.size(); ++h) {
    HeldPoint& held = now.held[h];
    held.since = state.time;
    const auto same = std::ranges::find_if(before.held, [&](const HeldPoint& other) {
      return other.block == held.block && other.arm == held.arm;
    });
    if (same == before.held.end()) {
      held.from = displacement(now, held, pose(state.blocks[index(held.block)]));
    } else {
      held.from = same->from;
      state.held_forces[h] =
          state_before.held_forces[static_cast<std::size_t>(same - before.held.begin())];
    }
  }
}

/// Ties that both scenes have go on; others are put in where their blocks stand now.
void take_over_ties(const CompiledScene& before, const State& state_before,
                    const CompiledScene& now, State& state) {
  lay_ties(now, state);
  for (std::size_t t = 0; t < now.ties.size(); ++t) {
    const TieModel& tie = now.ties[t];
    const auto same = std::ranges::find_if(before.ties, [&](const TieModel& other) {
      return other.tie.a == tie.tie.a && other.tie.b == tie.tie.b && other.arm_a == tie.arm_a &&
             other.arm_b == tie.arm_b && other.tie.name == tie.tie.name;
    });
    if (same == before.ties.end()) continue;
    state.ties[t] = state_before.ties[static_cast<std::size_t>(same - before.ties.begin())];
  }
}

/// Quiet faces that both scenes have go on bearing what they bore.
void take_over_quiet(const CompiledScene& before, const State& state_before,
                     const CompiledScene& now, State& state) {
  for (std::size_t q = 0; q < now.quiet.size(); ++q) {
    const auto same = std::ranges::find_if(before.quiet, [&](const QuietPoint& other) {
      return other.block == now.quiet[q].block && other.arm == now.quiet[q].arm;
    });
    if (same == before.quiet.end()) continue;
    const auto known = static_cast<std::size_t>(same - before.quiet.begin());
    state.quiet_forces[q] = state_before.quiet_forces[known];
  }
}

/// By how much the gap at which a spring is closed grows where its stiffness changes: what presses
/// it stays.
double further_gap(const Joint& was, const Joint& is, const Contact& contact) {
  const double before = was.normal_stiffness, now = is.normal_stiffness;
  if (before == now || before == 0.0 || contact.mode == ContactMode::Open) return 0.0;
  const double squeezed = opening(was, contact) - contact.point.gap;
  return squeezed * ((now > 0.0 ? before / now : 0.0) - 1.0);
}

/// What shears a spring stays likewise: its anchors go with its stiffness, onto each other where
/// the joint is rigid from now on.
void take_over_stretch(const Joint& was, const Joint& is, const State& state, Contact& contact) {
  const double before = was.shear_stiffness, now = is.shear_stiffness;
  if (before == now || before == 0.0 || contact.mode == ContactMode::Open) return;
  const Pose a = pose(state.blocks[index(contact.point.key.a)]);
  const Pose b = pose(state.blocks[index(contact.point.key.b)]);
  const Vector3 stretch = shear_stretch(a, b, contact.point.normal, contact);
  const double kept = now > 0.0 ? before / now : 0.0;
  contact.anchor_b -= reference_arm(b, (1.0 - kept) * stretch);
}

/// Bonds that bear no tension by the new law are gone, without harm to the joint's other strength.
/// What joints have opened by their slip stays, whatever opens them from now on.
void take_over_joint(const Scene& before, const Scene& now, const State& state, Contact& contact) {
  const auto& key = contact.point.key;
  const Joint &was = joint_between(before, key.a, key.b), &is = joint_between(now, key.a, key.b);
  take_over_stretch(was, is, state, contact);
  const double further = further_gap(was, is, contact);
  const double stays = opening(was, contact) + further;
  contact.closed_gap += stays - opening(is, contact);
  if (strength(is, contact).tension > 0.0) return;
  part(contact);
  if (further != 0.0) contact.closed_gap += stays - opening(is, contact);
}

bool are_same(const geometry::Shape& a, const geometry::Shape& b) {
  return &a == &b || (a.topology().face_count() == b.topology().face_count() &&
                      a.vertex_count() == b.vertex_count() && a.vertices() == b.vertices());
}

bool are_same(const geometry::Placement& a, const geometry::Placement& b) {
  return a.linear == b.linear && a.translation == b.translation;
}

/// Joints of two blocks without unknowns wait until one of them is set free, if neither has moved
/// by then.
void take_over_contacts(const State& state_before, const Workspace& work_before,
                        const CompiledScene& now, State& state, Workspace& work) {
  const std::vector<BlockState>& blocks = state_before.blocks;
  const auto key = [](const Contact& contact) { return contact.point.key; };
  std::vector<WaitingContact> all;
  for (const Contact& contact : state_before.contacts) {
    const auto [a, b] = std::pair(contact.point.key.a, contact.point.key.b);
    all.push_back({contact, blocks[index(a)], blocks[index(b)]});
  }
  all.insert(all.end(), work_before.waiting.begin(), work_before.waiting.end());
  std::ranges::stable_sort(all, {}, [&](const WaitingContact& one) { return key(one.contact); });
  for (const WaitingContact& one : all) {
    const auto [a, b] = std::pair(one.contact.point.key.a, one.contact.point.key.b);
    if (is_absent(now, a) || is_absent(now, b)) continue;
    if (!is_in_place(one.a, blocks[index(a)]) || !is_in_place(one.b, blocks[index(b)])) continue;
    if (now.idle[index(a)] && now.idle[index(b)])
      work.waiting.push_back(one);
    else
      state.contacts.push_back(one.contact);
  }
}

}  // namespace

void check_same_blocks(const Scene& before, const Scene& now) {
  if (before.blocks.size() != now.blocks.size()) {
    throw InputError("a scene of " + std::to_string(before.blocks.size()) +
                     " blocks can't become one of " + std::to_string(now.blocks.size()));
  }
  for (std::size_t b = 0; b < now.blocks.size(); ++b) {
    const Block &was = before.blocks[b], &is = now.blocks[b];
    if (is.shape == nullptr || !was.parts != !is.parts || !are_same(*was.shape, *is.shape) ||
        !are_same(was.placement, is.placement))
      throw InputError("block " + std::to_string(b) + " can't change its shape or its placement");
  }
}

void take_over(const CompiledScene& before, const State& state_before, const Workspace& work_before,
               CompiledScene& now, State& state, Workspace& work) {
  state.time = state_before.time;
  state.step = state_before.step;
  state.energy = state_before.energy;
  work.laid = work_before.laid;
  for (int b = 0; b < static_cast<int>(now.models.size()); ++b) {
    if (is_absent(now, b)) continue;
    if (is_absent(before, b)) {
      work.laid[index(b)] = kLaid;
      continue;
    }
    const bool in_place = is_in_place(state.blocks[index(b)], state_before.blocks[index(b)]);
    if (work.laid[index(b)] == kStands && !in_place) work.laid[index(b)] = kMet;
    take_over_block(before, state_before, now, b, state);
  }
  take_over_contacts(state_before, work_before, now, state, work);
  for (Contact& contact : state.contacts) take_over_joint(before.scene, now.scene, state, contact);
  for (WaitingContact& waiting : work.waiting)
    take_over_joint(before.scene, now.scene, state, waiting.contact);
  take_over_motions(before, work_before, now, state, work);
  take_over_held(before, state_before, now, state);
  take_over_ties(before, state_before, now, state);
  take_over_quiet(before, state_before, now, state);
  work.counted = work_before.counted;
  work.energy_scale = work_before.energy_scale;
  work.initial_depths.entries = work_before.initial_depths.entries;
  work.initial_depths.remember(now, {}, work.laid);
  place_bodies(now, state, work);
}

std::vector<char> set_on(const State& before, const State& now) {
  std::vector<char> changed(now.blocks.size());
  for (std::size_t b = 0; b < changed.size(); ++b) {
    const BlockState &was = before.blocks[b], &is = now.blocks[b];
    changed[b] = was.velocity != is.velocity || was.angular_velocity != is.angular_velocity;
  }
  return changed;
}

void part_hit_contacts(std::span<const char> set_on, ContactMethod method, State& state) {
  if (method != ContactMethod::AugmentedLagrangian) return;  // springs alone
  for (Contact& contact : state.contacts) {
    const std::size_t a = index(contact.point.key.a), b = index(contact.point.key.b);
    if (contact.bonded || contact.spring_area > 0.0 || (!set_on[a] && !set_on[b])) continue;
    const Vector3 place = contact.point.point();
    const Vector3 of_a = velocity_of_place(state.blocks[a], place);
    const Vector3 of_b = velocity_of_place(state.blocks[b], place);
    const double rounding = kVelocityRounding * (of_a.norm() + of_b.norm());
    if (contact.point.normal.dot(of_b - of_a) < -rounding) contact.mode = ContactMode::Open;
  }
}

}  // namespace quoin::solver
