#include "cases.hpp"

#include <array>
#include <exception>

namespace quoin::validation {

std::span<const Case> cases() {
  static constexpr std::array kCases{
      Case{"V01", "block sliding down a plane (paper 5.1)", v01_sliding_down_a_plane,
           v01_converges},
      Case{"V02", "block at rest on a plane: forces and no creep", v02_at_rest_on_a_plane},
      Case{"V03", "block pushed by two forces (paper 5.2)", v03_pushed_by_two_forces,
           v03_converges},
      Case{"V04", "block stopping by friction", v04_stopping_by_friction, v04_converges},
      Case{"V05", "curved sliding: direction of friction", v05_curved_sliding, v05_converges},
      Case{"V06", "two blocks, one dragged by friction", v06_dragged_by_friction},
      Case{"V07", "Coulomb joint with cohesion", v07_cohesion},
      Case{"V08", "tetrahedral wedge on two joints", v08_wedge},
      Case{"V09", "sliding / toppling chart", v09_sliding_and_toppling},
      Case{"V10", "Housner rocking block", v10_rocking, v10_converges},
      Case{"V11", "torque-free tumbling of a box", v11_tumbling, v11_converges},
      Case{"V12", "volume and strain of a spinning box", v12_spinning, v12_converges},
      Case{"V13", "column under its own weight", v13_column, v13_converges},
      Case{"V14", "the time scheme to round-off", v14_time_scheme, v14_converges},
      Case{"V15", "algorithmic damping as a function of dt", v15_algorithmic_damping,
           v15_converges},
      Case{"V16", "overhanging stack", v16_overhang},
      Case{"V17", "semicircular arch: least thickness", v17_arch},
      Case{"V17B", "falling arch of E 1e10", v17_soft_arch},
      Case{"V18", "block on a shaking table", v18_shaking_table, v18_converges},
      Case{"V19", "central impact of two deformable blocks", v19_central_impact, v19_converges},
      Case{"V20", "block on an elastic foundation", v20_elastic_foundation},
      Case{"V21", "invariances", v21_invariances},
      Case{"V22", "angular momentum in a free impact", v22_angular_momentum, v22_converges},
      Case{"S30", "stack of 30 cubes: force at each interface", stack_of_30},
      Case{"P53", "falling block (paper 5.3)", paper_falling_block},
      Case{"P54", "five blocks (paper 5.4)", paper_five_blocks},
      Case{"G01", "the published local search misses the contact", g01_local_search},
      Case{"G02", "crossed edges", g02_crossed_edges},
      Case{"G03", "face on face, turned", g03_turned_faces},
      Case{"G04", "nearly parallel edges", g04_nearly_parallel_edges},
      Case{"G05", "vertex to vertex", g05_vertex_to_vertex},
      Case{"G06", "slivers", g06_slivers},
      Case{"G07", "far from the origin", g07_far_from_the_origin},
      Case{"G08", "depth in general position", g08_depth},
  };
  return kCases;
}

std::vector<Row> run(const Case& which) {
  Report report{std::string(which.name)};
  try {
    which.run(report);
  } catch (const std::exception& error) {
    report.failed(error.what());
  }
  return report.rows();
}

std::vector<Series> converge(const Case& which) {
  Convergence convergence{std::string(which.name)};
  if (which.converge != nullptr) which.converge(convergence);
  return convergence.series();
}

}  // namespace quoin::validation
