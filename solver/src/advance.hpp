#pragma once
/// One time step.

#include <chrono>
#include <quoin/geometry/contact_finder.hpp>
#include <quoin/solver/simulation.hpp>

#include "compiled_scene.hpp"
#include "contact/contact_jacobian.hpp"
#include "equilibrium_search.hpp"
#include "initial_depths.hpp"
#include "moving/moving_contacts.hpp"
#include "open_close.hpp"
#include "paper_open_close.hpp"
#include "step_flags.hpp"
#include "step_watch.hpp"

namespace quoin::solver {

/// What an attempt at a (sub-)step came to, in numbers.
struct AttemptTotals {
  OpenCloseResult solved;
  double displacement = 0.0;   ///< largest of a vertex, relative to its block's size
  double friction_work = 0.0;  ///< J, >= 0
  double contact_work = 0.0;   ///< by normal forces that no spring stores, J
  double load_work = 0.0;      ///< by loads and prescribed motion, J
  double gravity_work = 0.0;   ///< J
  double scheme_loss = 0.0;    ///< J
  double spring_energy = 0.0;  ///< in penalty contacts at the end of the step, J
  double impact_loss = 0.0;    ///< J
  double unbalance = 0.0;
  double stiffest_omega_dt = 0.0;  ///< of the springs
};

/// And the state it proposes.
struct Attempt : AttemptTotals {
  State end;
  std::vector<BodyContact>
      contacts;  ///< work.contacts with forces and modes at the end of the step
  std::vector<PrescribedMotion> motion;
  std::vector<double> work_on;  ///< by block: of gravity, loads and prescribed neighbours, J
};

/// Memory of the velocity law.
struct VelocityWork {
  std::vector<LinearContact> contacts, tried;
  std::vector<double> bounces, shares, energy, pushed;
  std::vector<int> islands;
  BlockVector free_gain, velocity, force, solution;
};

/// Where the time of a step goes.
class PhaseClock {
 public:
  void start() {
    seconds = {};
    last_ = Clock::now();
  }
  /// The time since the last call is this phase's.
  void charge(double PhaseSeconds::*phase) {
    const Clock::time_point now = Clock::now();
    seconds.*phase += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }
  PhaseSeconds seconds;

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_{};
};

/// Time counted in steps of one length.
struct Counted {
  double start = 0.0, time_step = 0.0, now = 0.0;  ///< s
  long steps = 0;                                  ///< of this length, from `start` to `now`
};

/// What a stopped step goes back to.
struct Before {
  double reach = 0.0;
  Counted counted;
  EnergyScale energy_scale;
  std::vector<char> hit;
  std::string rest;  ///< a checkpoint; empty while no sub-step is accepted
};

/// Memory kept between steps. What the next step depends on, beside the state, is in
/// checkpoint.cpp.
struct Workspace {
  explicit Workspace(const CompiledScene& compiled, int threads);

  geometry::ContactFinder finder;  ///< block b has handle b; absent ones collide with none
  InitialDepths initial_depths;    ///< taken off what is found
  /// By block: what it touches in this step is laid: joints have their peak strength.
  std::vector<char> laid;
  /// At the present state, places in the frames of the reference shapes.
  std::vector<geometry::ContactPoint> found;
  std::vector<geometry::ContactPoint> found_end;  ///< at the end of the attempt
  double reach = 0.0;                             ///< that `found` was made with, m
  std::vector<PrescribedMotion> motion;           ///< of compiled.prescribed, at the present state

  bool still = false;  ///< nothing moved in the last step and no load changes: the next is the same
  StepReport report;   ///< of that step

  Counted counted;
  EquilibriumSearch search;                   ///< of the static analysis that goes on
  std::vector<PrescribedMotion> best_motion;  ///< of the best attempt
  EnergyScale energy_scale;
  double energy_growth = 0.0;                       ///< largest of the step's sub-steps, J
  const geometry::ContactPoint* missing = nullptr;  ///< one of found_end that no attempt held

  double last_time_step = 0.0;  ///< of the last accepted sub-step; 0: none
  BlockVector last_velocity;    ///< at its start, by slot: predicts the next increment

  int iterations_left = 0;  ///< of the attempt's
  double spring = 0.0;      ///< of each contact, N/m; 0: contact is exact
  std::vector<BodyContact> contacts;
  std::vector<char> hit;  ///< by block: an impact passes through it in this step
  StepPoses poses;
  std::vector<LinearContact> linear;
  BlockSystem base;
  std::vector<Matrix12> compliance;  ///< inverse of each diagonal block of base
  BlockVector force, increment, free_increment;
  StepWatch watch;
  OpenClose open_close;
  MovingContacts moving_contacts;
  bool yielding = false;  ///< contacts of this attempt are moving_contacts'
  PaperOpenClose paper_open_close;
  Attempt attempt;
  VelocityWork velocity;
  PhaseClock clock;
  Before before;
};

/// Takes the finder's bodies to where the state has them, also those that no step moves.
void place_bodies(const CompiledScene& compiled, const State& state, Workspace& work);

/// Moves the state by exactly options.time_step, in counted sub-steps where it must.
/// `best`: after a step that did not converge, the best attempt; else untouched.
StepReport advance(const CompiledScene& compiled, const StepOptions& options, State& state,
                   State& best, Workspace& work);

/// Energy in the springs of blocks that overlap at the start, J.
double initial_spring_energy(const CompiledScene& compiled, const StepOptions& options,
                             const State& state, Workspace& work);

/// Finds the contacts of the state at the start of a run.
void detect(const CompiledScene& compiled, const StepOptions& options, const State& state,
            Workspace& work);

}  // namespace quoin::solver
