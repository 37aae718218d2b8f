#pragma once
/// One attempt at one (sub-)step: equilibrium of positions, then the velocity law.

#include "advance.hpp"

namespace quoin::solver {

/// Solves for the increments of [time, time + dt] with contacts work.contacts; the outcome is
/// work.attempt.
void attempt_step(const CompiledScene& compiled, const StepOptions& options, const State& state,
                  double time_step, Workspace& work);

/// Velocities at the end of the step: restitution at closing contacts, rest at sticking ones.
/// [Moreau 1988]; the impulses replace the contact forces of the step, so that momentum is kept.
void apply_velocity_law(const CompiledScene& compiled, const StepOptions& options,
                        const State& start, double time_step, Workspace& work);

/// Forces of linearised contacts, of positions or velocities, by the iteration that `options` name.
/// An attempt whose contacts have once yielded goes on so (work.yielding).
OpenCloseResult solve_contacts(const StepOptions& options, const BlockVector& force,
                               std::span<LinearContact> contacts, const OpenCloseOptions& tuning,
                               BlockVector& increment, Workspace& work);

/// The contacts of all bodies, sorted by key.
void list_contacts(std::span<const BodyContact> bodies, std::vector<Contact>& contacts);

/// Forces of all held points, as linearised and solved.
void record_held(std::span<const LinearContact> held, State& end);

/// `end` as `state`, but for what the step gives anew: contacts, and blocks that move.
void start_end(const State& state, State& end);

/// Time that a step takes, s: a static one none.
double duration(const StepOptions& options, double time_step);

/// The largest LinearContact::rounding, m.
double gap_rounding(std::span<const LinearContact> contacts);

/// Energy in the springs of work.contacts as they lie, J.
double spring_energy_at_rest(const CompiledScene& compiled, const StepOptions& options,
                             Workspace& work);

/// Spring of a contact, N/m: the user's, or one that fits the blocks; 0 where contact is exact.
double contact_spring(const CompiledScene& compiled, const StepOptions& options);

}  // namespace quoin::solver
