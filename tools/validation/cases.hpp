#pragma once
/// The validation cases: scenes with exact answers, built and measured through the public headers.
/// Each states its exact values by closed form, or as constants with their derivation beside them.

#include <span>
#include <string_view>

#include "convergence.hpp"
#include "report.hpp"

namespace quoin::validation {

struct Case {
  std::string_view name;  ///< "V01"
  std::string_view title;
  void (*run)(Report& report);
  void (*converge)(Convergence& convergence) = nullptr;  ///< null: its answers have no step in them
};

/// All cases, by name.
std::span<const Case> cases();

/// Runs one case; a run that breaks off becomes a row that is not ok. Throws nothing of its own.
std::vector<Row> run(const Case& which);

/// Its errors against time step and penalty; empty where it has no such series. Throws nothing.
std::vector<Series> converge(const Case& which);

void v01_sliding_down_a_plane(Report& report);
void v02_at_rest_on_a_plane(Report& report);
void v03_pushed_by_two_forces(Report& report);
void v04_stopping_by_friction(Report& report);
void v05_curved_sliding(Report& report);
void v06_dragged_by_friction(Report& report);
void v07_cohesion(Report& report);
void v08_wedge(Report& report);
void v09_sliding_and_toppling(Report& report);
void v10_rocking(Report& report);
void v11_tumbling(Report& report);
void v12_spinning(Report& report);
void v13_column(Report& report);
void v14_time_scheme(Report& report);
void v15_algorithmic_damping(Report& report);
void v16_overhang(Report& report);
void v17_arch(Report& report);
void v17_soft_arch(Report& report);
void v18_shaking_table(Report& report);
void v19_central_impact(Report& report);
void v20_elastic_foundation(Report& report);
void v21_invariances(Report& report);
void v22_angular_momentum(Report& report);
void stack_of_30(Report& report);
void paper_falling_block(Report& report);
void paper_five_blocks(Report& report);
void v01_converges(Convergence& convergence);
void v03_converges(Convergence& convergence);
void v04_converges(Convergence& convergence);
void v05_converges(Convergence& convergence);
void v10_converges(Convergence& convergence);
void v11_converges(Convergence& convergence);
void v12_converges(Convergence& convergence);
void v13_converges(Convergence& convergence);
void v14_converges(Convergence& convergence);
void v15_converges(Convergence& convergence);
void v18_converges(Convergence& convergence);
void v19_converges(Convergence& convergence);
void v22_converges(Convergence& convergence);
void g01_local_search(Report& report);
void g02_crossed_edges(Report& report);
void g03_turned_faces(Report& report);
void g04_nearly_parallel_edges(Report& report);
void g05_vertex_to_vertex(Report& report);
void g06_slivers(Report& report);
void g07_far_from_the_origin(Report& report);
void g08_depth(Report& report);

}  // namespace quoin::validation
