#include "step/attempt_rounds.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
#include <numeric>

#include "base/index.hpp"
#include "contact/joint_springs.hpp"
#include "iteration/moving_contacts.hpp"
#include "step/contact_search.hpp"
#include "step/form_islands.hpp"
#include "step/linearise.hpp"
#include "step/sorted_by_key.hpp"

namespace quoin::solver {
namespace {

// Contacts and blocks: some 20 us of work, what it takes to wake a thread.
constexpr std::size_t kWorthThreads = 32;
constexpr std::chrono::microseconds kBetweenLooks{500};
// An island of more than this share of the contacts and blocks, and of so many, has all threads to
// itself, before the others: of two threads it takes 0.6 to 0.7 of the time of one.
constexpr double kLargeShare = 0.6;
constexpr std::size_t kLarge = 2048;

/// Formulas of loads are the user's functions: they are asked on one thread. Processes that solve
/// together do so in one order.
bool can_share(const StepRun& run) {
  const CompiledScene& compiled = run.compiled;
  const auto constant_load = [](const PointForce& load) {
    return !load.pressure && load.force.is_constant();
  };
  const auto constant_held = [](const HeldPoint& held) { return held.displacement.is_constant(); };
  return run.work.threads.workers() > 1 && !run.options.contact_problem &&
         !run.options.distributed_solver && compiled.scene.gravity.is_constant() &&
         std::ranges::all_of(compiled.loads, constant_load) && compiled.quiet.empty() &&
         std::ranges::all_of(compiled.held, constant_held);
}

std::size_t size(const Island& island) { return island.own().size() + island.contacts.size(); }

/// The largest islands first: the last to end is then a small one.
std::vector<Island*> by_size(std::span<Island* const> islands) {
  std::vector<Island*> sorted(islands.begin(), islands.end());
  std::ranges::stable_sort(sorted, std::greater{}, [](const Island* i) { return size(*i); });
  return sorted;
}

/// An island has all threads; no more, whatever its task throws: the next one may be a worker's.
class AllThreads {
 public:
  AllThreads(const StepRun& run, Island& island) : solver_(island.memory.solver) {
    solver_.use(Threads(&run.work.threads));
  }
  ~AllThreads() { solver_.use(Threads()); }
  AllThreads(const AllThreads&) = delete;
  AllThreads& operator=(const AllThreads&) = delete;

 private:
  ContactSolver& solver_;
};

void take_alone(const StepRun& run, Island& island, const std::function<void(Island&)>& task) {
  const AllThreads has(run, island);
  task(island);
}

/// The first worker looks at the watch while others work.
void take_together(const StepRun& run, std::span<Island* const> islands,
                   const std::function<void(Island&)>& task) {
  std::atomic<std::size_t> next{0}, left{islands.size()};
  std::atomic<bool> thrown{false};
  StepWatch& watch = run.work.watch;
  auto take = [&](int worker) {
    try {
      for (std::size_t i; (i = next++) < islands.size(); --left) task(*islands[i]);
    } catch (...) {
      thrown = true;
      throw;
    }
    while (worker == 0 && watch.watches() && left > 0 && !thrown) {
      std::this_thread::sleep_for(kBetweenLooks);
      watch.look();
    }
  };
  run.work.threads.run_each(take);
}

}  // namespace

void side_by_side(const StepRun& run, std::span<Island* const> islands,
                  const std::function<void(Island&)>& task) {
  const auto timed = [&](Island& island) {
    island.memory.clock.start();
    task(island);
  };
  std::size_t work = 0;
  for (const Island* island : islands) work += size(*island);
  if (islands.size() > 1 && work >= kWorthThreads && can_share(run)) {
    const std::vector<Island*> sorted = by_size(islands);
    const std::size_t largest = size(*sorted.front());
    const bool alone =
        largest >= kLarge && static_cast<double>(largest) > kLargeShare * static_cast<double>(work);
    if (alone) take_alone(run, *sorted.front(), timed);
    take_together(run, std::span(sorted).subspan(alone ? 1 : 0), timed);
  } else {
    for (Island* island : islands) take_alone(run, *island, timed);
  }
  for (Island* island : islands) run.work.clock.add(island->memory.clock.seconds);
}

namespace {

// Of a block: overlaps that a static step leaves to the next one where forces are inexact.
constexpr double kInexact = 1e-4;
constexpr int kRounds = 4;
// Of |I + strain|^3. A determinant is six products of three factors, a placement's are products of
// three matrices: each is known to some twenty eps, and the sign of a sum below that says nothing.
constexpr double kFlat = 128.0 * std::numeric_limits<double>::epsilon();

/// By its volume; the sign of a smaller determinant says nothing.
bool is_flat(const Matrix3& stretch) {
  const double size = stretch.norm();
  return !(stretch.determinant() > kFlat * size * size * size);
}

}  // namespace

bool is_sound(const BlockState& block) {
  const double far = block.centroid.cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
  return far < geometry::kLargestCoordinate &&
         !is_flat(Matrix3::Identity() + strain_matrix(block.strain)) &&
         std::isfinite(block.velocity.squaredNorm()) && block.rotation.coeffs().allFinite() &&
         block.strain.allFinite() && std::isfinite(block.angular_velocity.squaredNorm()) &&
         block.strain_rate.allFinite();
}

namespace {

/// Whether the attempt's end can be gone on with: finite, and no block squeezed flat.
bool is_sound(const StepRun& run, const Island& island) {
  const auto sound = [&](int block) { return is_sound(run.work.end[index(block)]); };
  return std::ranges::all_of(island.blocks.slots.block_of_slot, sound) &&
         std::ranges::all_of(run.compiled.prescribed, sound);
}

void attempt_by_other_method(const StepRun& run, Island& island) {
  BlocksAtEnd blocks{run.work.poses, run.work.end};
  run.work.other_method->attempt(sub_step(run, island), island.contacts, island.memory.clock,
                                 blocks, island.attempt);
}

/// The contact that a later part of the step has in the place of `past`: with its key, or the
/// nearest one of its pair. Null: it has none.
Contact* heir(const Contact& past, std::span<Contact> ended) {
  const auto key = [](const Contact& c) { return c.point.key; };
  const auto same = std::ranges::lower_bound(ended, past.point.key, {}, key);
  if (same != ended.end() && same->point.key == past.point.key) return &*same;
  const auto pair = [](const Contact& c) { return std::pair(c.point.key.a, c.point.key.b); };
  const auto of_pair = std::ranges::equal_range(ended, pair(past), {}, pair);
  const auto away = [&](const Contact& c) {
    return (c.point.point_a - past.point.point_a).squaredNorm();
  };
  const auto nearest = std::ranges::min_element(of_pair, {}, away);
  return nearest != of_pair.end() ? &*nearest : nullptr;
}

/// What contacts report of a step in several parts is its mean, handed on where one takes the place
/// of another.
void take_means(Island& island) {
  if (!(island.done > 0.0)) return;
  std::vector<Contact>& ended = island.attempt.contacts;
  const double before = island.done / (island.done + island.length);
  for (Contact& contact : ended) set_force_on_b((1.0 - before) * force_on_b(contact), contact);
  for (const Contact& past : island.history) {
    Contact* now = heir(past, ended);
    if (now != nullptr) set_force_on_b(force_on_b(*now) + before * force_on_b(past), *now);
  }
}

/// In springs of a pair that is set aside, J.
double stored_energy(const StepRun& run, std::span<BodyContact> contacts) {
  if (std::ranges::none_of(contacts, &BodyContact::was_closed)) return 0.0;
  std::vector<double> by_slot(index(run.compiled.slots.count()), 0.0);
  store_at_rest(run.compiled, run.options, run.work.poses.start, contacts, by_slot);
  return std::accumulate(by_slot.begin(), by_slot.end(), 0.0);
}

void attempt_default(const StepRun& run, Island& island) {
  Workspace& work = run.work;
  const SubStep step = sub_step(run, island);
  BlocksAtEnd blocks{work.poses, work.end};
  Attempt& attempt = island.attempt;
  const auto solve = [&](bool strain_waits) {
    island.memory.strain_waits = strain_waits;
    attempt_positions(step, work.last, island.contacts, island.memory, blocks, attempt);
    if (attempt.solved.converged && step.dynamic() && run.options.method != ContactMethod::Springs)
      attempt_velocities(step, island.contacts, island.memory, blocks, attempt);
  };
  solve(true);
  if (attempt.squeezed) {
    OpenCloseResult total = attempt.solved;
    island.memory.solver.allow(run.options.max_iterations);
    solve(false);
    add(attempt.solved, total);
    total.closed = attempt.solved.closed;
    attempt.solved = total;
  }
  for (const PassingPair& pair : island.passing) attempt.energy.scheme_loss += pair.stored;
  for (std::size_t s = 0; s < attempt.hit.size(); ++s)
    work.last.hit[index(island.own()[s])] = attempt.hit[s];
}

/// One round: the island's own blocks alone are written to.
void attempt_once(const StepRun& run, Island& island) {
  run.work.watch.look();
  const bool other = is_paper_method(run.options.method);
  (other ? attempt_by_other_method : attempt_default)(run, island);
  island.missing.reset();
  island.sound = is_sound(run, island);
  for (const int block : island.own())
    if (!island.sound) run.work.end[index(block)] = run.work.now.blocks[index(block)];
  island.memory.clock.charge(&PhaseSeconds::update);
}

/// Of all contacts where the islands stand and where their attempts end, m.
double largest_opening(const StepRun& run) {
  double largest = largest_opening(run.compiled, run.state.contacts);
  for (const auto& island : run.work.islands) {
    if (island->at_rest) continue;
    largest = std::max({largest, largest_opening(run.compiled, island->history),
                        largest_opening(run.compiled, island->attempt.contacts)});
  }
  return largest;
}

/// What the last search found of some islands, the owners, takes the place of what others had found
/// of them in this step. A block moved by a motion has been searched with other islands, too: those
/// points are theirs.
void take_last(Workspace& work) {
  const auto is_searched = [&](int block) {
    const int i = work.island_of_block[index(block)];
    return i >= 0 && work.owners[index(i)] != nullptr && work.owners[index(i)]->sound;
  };
  const auto is_owned = [&](const geometry::ContactPoint& point) {
    const bool of_none = work.island_of_block[index(point.key.a)] < 0 &&
                         work.island_of_block[index(point.key.b)] < 0;
    return of_none || is_searched(point.key.a) || is_searched(point.key.b);
  };
  std::erase_if(work.found_end, is_owned);
  std::erase_if(work.found_last, std::not_fn(is_owned));
  merge(std::span<const geometry::ContactPoint>(work.found_last), work.found_end);
}

/// The contacts at the ends of these islands' attempts: one search for all.
void find_at_end(const StepRun& run, std::span<Island* const> islands) {
  Workspace& work = run.work;
  std::vector<int>& moved = work.moved;
  moved = run.compiled.prescribed;
  for (const Island* island : islands)
    if (island->sound) moved.insert(moved.end(), island->own().begin(), island->own().end());
  if (moved.size() == run.compiled.prescribed.size()) return;  // none is sound
  const SearchedState searched{work.end, largest_opening(run),
                               sub_step(run, *islands.front()).end_time()};
  const Reach reach(run.compiled, run.options, searched, moved, work.known_reaches);
  if (reach.is_new()) work.searched = Searched::AllBlocks;
  const bool all = work.searched == Searched::AllBlocks;
  for (Island* island : islands)
    if (island->found.refers_to(work.found_end)) island->found.exchange(work.found_end);
  if (all) work.found_end.reserve(work.found.size() + work.found.size() / 16);
  const geometry::FindCounts counts = find(run.compiled, searched, reach, moved, work.searched,
                                           work, all ? work.found_end : work.found_last);
  run.report.candidate_pairs += counts.candidates;
  run.report.searched_pairs += counts.searched;
  list_owners(islands, work);
  for (Island* island : islands) island->searched = work.search_epoch;
  if (!all) take_last(work);
  const bool met = share_out(work, work.found_end, all ? Sharing::Referred : Sharing::Copied,
                             &Island::found_end);
  work.islands_met = met;
  for (Island* island : islands) island->reach_end = largest_reach(reach, island->found_end);
}

using Pair = std::pair<int, int>;

/// As a body holds it at the end, where blocks have met that were not laid.
BodyContact missed_contact(const CompiledScene& compiled, const StepPoses& poses,
                           std::span<const geometry::ContactPoint> found,
                           const geometry::ContactPoint& point) {
  BodyContact added = make_body_contact({compiled.scene, compiled.models, poses.end}, point);
  added.state.failed = true;
  const auto points = points_of_pair(found, added.a, added.b);
  double area = 0.0;
  for (const geometry::ContactPoint& p : points) area += p.area;
  added.penalty_share = shared_penalty(points.size(), point.area, area);
  if (added.joint->normal_stiffness > 0.0) {
    const std::size_t a = index(added.a), b = index(added.b);
    const BlockModel &model_a = compiled.models[a], &model_b = compiled.models[b];
    const JointBlocks blocks{model_a, model_b, poses.end[a], poses.end[b]};
    set_spring_areas(blocks, joint_polygon(blocks, added), std::span(&added, 1));
    begin_spring({model_a, model_b, poses.start[a], poses.start[b]}, added);
  }
  return added;
}

/// What the attempt knew, sorted.
struct Known {
  std::vector<std::pair<geometry::ContactKey, std::size_t>> keys;  ///< and which contact
  std::vector<Pair> soft;      ///< pairs that a closed spring holds, but not exactly
  std::vector<Pair> yielding;  ///< pairs that a closed contact holds, nearly
};

Known known_contacts(const Island& island) {
  Known known;
  for (std::size_t i = 0; i < island.contacts.size(); ++i) {
    const BodyContact& contact = island.contacts[i];
    const SolvedContact& c = island.attempt.positions[i];
    known.keys.emplace_back(contact.state.point.key, i);
    if (c.mode == ContactMode::Open) continue;
    if (c.compliant) known.soft.emplace_back(contact.a, contact.b);
    const ContactSolver& solver = island.memory.solver;
    if (solver.yielding() || solver.inexact()) known.yielding.emplace_back(contact.a, contact.b);
  }
  std::ranges::sort(known.keys);
  std::ranges::sort(known.soft);
  std::ranges::sort(known.yielding);
  return known;
}

constexpr std::size_t kUnknown = std::numeric_limits<std::size_t>::max();

/// The contact of the attempt with this key.
std::size_t known_contact(const Known& known, const geometry::ContactKey& key) {
  const auto at =
      std::ranges::lower_bound(known.keys, key, {}, [](const auto& k) { return k.first; });
  return at != known.keys.end() && at->first == key ? at->second : kUnknown;
}

/// Whether the features of a contact overlap by `most` (m) more than its place and normal have it:
/// of edges that were nearly parallel where it was found, and have turned, or a face that strain
/// has tilted. A spring keeps its overlap, which is another along another normal.
bool has_turned(const BodyContact& contact, const SolvedContact& solved, std::span<const Pose> end,
                const geometry::ContactPoint& point, double most) {
  if (solved.compliant) return false;
  const double gap = contact_geometry(contact, end[index(contact.a)], end[index(contact.b)]).gap;
  return point.gap < gap - most;
}

/// The same contact, held where and as it stands at the end. A closed one keeps its anchors: its
/// slip is that of the whole step.
BodyContact turned(const BodyContact& contact, const BodyContact& at_end) {
  BodyContact result = at_end;
  result.state = contact.state;
  result.state.point = at_end.state.point;
  if (!contact.was_closed) {
    result.state.anchor_a = at_end.state.anchor_a;
    result.state.anchor_b = at_end.state.anchor_b;
  }
  result.laid = contact.laid;
  result.was_closed = contact.was_closed;
  return result;
}

/// Does the attempt hold what is there as well as it holds anything?
bool holds(const Known& known, const geometry::ContactPoint& point, double most) {
  const Pair pair(point.key.a, point.key.b);
  return std::ranges::binary_search(known.soft, pair) ||
         (point.gap > -most && std::ranges::binary_search(known.yielding, pair));
}

/// Contacts that overlap at the end of an attempt though it did not hold them: added to the
/// island's contacts as the bodies hold them at the end. True when there are any. `tolerance`: what
/// contacts that yield or have turned may overlap by, of the smaller block.
bool add_missed(const CompiledScene& compiled, const StepPoses& poses, double tolerance,
                Island& island) {
  const std::vector<Pose>& end = poses.end;
  const auto overlaps = [&](const geometry::ContactPoint& point) {
    const int a = point.key.a, b = point.key.b;
    return point.gap < -overlap_limit(pair_size(compiled, a, b)) &&
           point.gap < -passing_limit(island.passing, a, b);
  };
  if (std::ranges::none_of(island.found_end, overlaps)) return false;
  const Known known = known_contacts(island);
  const std::vector<SolvedContact>& positions = island.attempt.positions;
  bool any = false;
  for (const geometry::ContactPoint& point : island.found_end) {
    if (!overlaps(point)) continue;
    const double most = tolerance * pair_size(compiled, point.key.a, point.key.b);
    const std::size_t i = known_contact(known, point.key);
    const bool held = i == kUnknown
                          ? holds(known, point, most)
                          : !has_turned(island.contacts[i], positions[i], end, point, most);
    if (held) continue;
    island.missing = point;
    any = true;
    const BodyContact missed = missed_contact(compiled, poses, island.found_end, point);
    if (i == kUnknown)
      island.contacts.push_back(missed);
    else
      island.contacts[i] = turned(island.contacts[i], missed);
  }
  return any;
}

/// Of the last round: contacts to be held, or not, in another one. True when there are any.
bool change_contacts(const StepRun& run, Island& island) {
  const Workspace& work = run.work;
  const double yielded =
      island.memory.solver.inexact() ? kInexact : crowd_tolerance(run.options.tolerance);
  const bool missed = add_missed(run.compiled, work.poses, yielded, island);
  const bool blocked =
      put_back_blocked(run.compiled, work.end, island.found_end, island.passing, island.contacts);
  // Whatever brought them in: sums go by their order, and it is one on any number of ranks.
  if (missed || blocked) std::ranges::sort(island.contacts, {}, joint_order);
  return missed || blocked;
}

/// Contacts, but for bonds and springs, of a block whose velocity jumps towards the other one are
/// open: they are struck. `change`: of the velocity, m/s.
void part_struck(int block, const Vector3& change, std::span<BodyContact> contacts) {
  for (BodyContact& contact : contacts) {
    if (contact.a != block && contact.b != block) continue;
    const double opening = contact.state.point.normal.dot(contact.b == block ? change : -change);
    if (!(opening < 0.0) || contact.state.bonded || contact.state.spring_area > 0.0) continue;
    contact.was_closed = false;
    contact.state.mode = ContactMode::Open;
    contact.state.anchor_a = contact.arm_a;
    contact.state.anchor_b = contact.arm_b;
  }
}

}  // namespace

void begin(const StepRun& run, Island& island) {
  Workspace& work = run.work;
  set_start(sub_step(run, island), work.poses);
  carry_over({run.compiled.scene, work.poses.start, run.compiled.models, island.reach, work.laid,
              run.options.analysis == Analysis::Dynamic},
             island.found, island.history, island.previous, island.contacts);
  if (run.options.method == ContactMethod::AugmentedLagrangian)
    for (const auto& [block, change] : work.jumps) part_struck(block, change, island.contacts);
  island.memory.clock.charge(&PhaseSeconds::assemble);
}

void attempt(const StepRun& run, std::span<Island* const> islands) {
  Workspace& work = run.work;
  const bool paper = is_paper_method(run.options.method);
  Islands& open = work.open;
  open.assign(islands.begin(), islands.end());
  for (Island* island : islands) {
    island->solved = false;
    island->memory.solver.allow(run.options.max_iterations);
    island->passing.clear();
    if (paper) continue;  // as the source: contacts are found once, before the step
    const double limit = overlap_limit(island->blocks.smallest_size);
    set_aside_passing(sub_step(run, *island), limit, island->contacts, island->passing);
    for (PassingPair& pair : island->passing) pair.stored = stored_energy(run, pair.contacts);
  }
  for (int round = 0; round < kRounds && !open.empty(); ++round) {
    side_by_side(run, open, [&](Island& island) { attempt_once(run, island); });
    find_at_end(run, open);
    std::erase_if(open, [&](Island* island) {
      if (!island->sound || !island->attempt.solved.converged) return true;
      island->solved = paper || !change_contacts(run, *island);
      return island->solved;
    });
    work.clock.charge(&PhaseSeconds::detect);
  }
  const auto key = [](const Contact& contact) { return contact.point.key; };
  for (Island* island : islands) {
    if (run.compiled.has_parts) std::ranges::sort(island->attempt.contacts, {}, key);
    if (!paper) take_means(*island);
  }
  // Contacts that still come and go: a shorter step may tell.
  for (Island* island : open) island->attempt.solved.converged = false;
}

}  // namespace quoin::solver
