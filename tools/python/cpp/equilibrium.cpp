// Static equilibrium of rigid blocks, with its proofs.
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <quoin/solver/equilibrium.hpp>

#include "scenes.hpp"

namespace quoin::python {
namespace {

using solver::Equilibrium;
using solver::EquilibriumProblem;

struct EquilibriumRow {
  std::int32_t a, b;
  bool held;
  double point[3], normal[3], gap, friction, cohesion, tension, force[3];
};

/// An answer with the problem that it is the answer to.
struct Answer {
  EquilibriumProblem problem;
  Equilibrium found;
};

Answer solve(const py::object& scene, const py::object& live, std::optional<double> factor,
             double largest, const std::vector<std::string>& changes, double reach) {
  const solver::Scene dead = scene_file_of(scene, changes).scene;
  std::optional<solver::Scene> varied;
  if (!live.is_none()) varied = scene_file_of(live, changes).scene;
  const py::gil_scoped_release released;
  Answer answer{solver::equilibrium_problem(dead, reach), {}};
  if (varied) {
    const std::vector<solver::Vector6> loads = solver::block_loads(*varied);
    if (loads.size() != dead.blocks.size()) {
      throw geometry::InputError("live: " + std::to_string(loads.size()) +
                                 " blocks, the scene has " + std::to_string(dead.blocks.size()));
    }
    for (std::size_t b = 0; b < loads.size(); ++b) answer.problem.blocks[b].live = loads[b];
  }
  if (!std::isfinite(factor.value_or(0.0)) || !std::isfinite(largest))
    throw geometry::InputError("factor, largest: it is not finite");
  answer.found = varied && !factor ? solver::largest_load_factor(answer.problem, largest)
                                   : solver::find_equilibrium(answer.problem, factor.value_or(0.0));
  return answer;
}

py::array_t<EquilibriumRow> contacts(const Answer& answer) {
  py::array_t<EquilibriumRow> result(static_cast<py::ssize_t>(answer.problem.contacts.size()));
  EquilibriumRow* row = result.mutable_data();
  for (std::size_t i = 0; i < answer.problem.contacts.size(); ++i, ++row) {
    const solver::EquilibriumContact& c = answer.problem.contacts[i];
    *row = {c.a, c.b, c.held, {}, {}, c.gap, c.friction, c.cohesion, c.tension, {}};
    copy(row->point, answer.problem.origin + c.point);
    copy(row->normal, c.normal);
    copy(row->force, i < answer.found.forces.size() ? answer.found.forces[i] : Vector3(0, 0, 0));
  }
  return result;
}

py::array_t<double> velocities(const Answer& answer) {
  py::array_t<double> result(
      std::vector<py::ssize_t>{static_cast<py::ssize_t>(answer.found.velocities.size()), 6});
  double* number = result.mutable_data();
  for (const solver::Vector6& velocity : answer.found.velocities)
    number = std::copy_n(velocity.data(), 6, number);
  return result;
}

template <class Member>
auto found(Member member) {
  return [member](const Answer& answer) { return answer.found.*member; };
}

}  // namespace

void bind_equilibrium(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(EquilibriumRow, a, b, held, point, normal, gap, friction, cohesion, tension,
                       force);
  py::class_<Answer>(module, "Equilibrium", py::is_final(),
                     "Contact forces that balance the loads of rigid blocks, or the mechanism that "
                     "proves that there are none.")
      .def_property_readonly(
          "verdict", [](const Answer& a) { return name(a.found.verdict); },
          "'admissible', 'mechanism' or 'undecided'")
      .def_property_readonly("factor", found(&Equilibrium::factor),
                             "of the live loads: the given, or the largest admissible one")
      .def_property_readonly("limited", found(&Equilibrium::limited),
                             "False: more than `largest` is admissible")
      .def_property_readonly("contacts", &contacts,
                             "One row a contact point: a, b, held, point (m), normal (unit, from a "
                             "to b), gap (m), friction, cohesion (N), tension (N), force (on b, N)")
      .def_property_readonly("velocities", &velocities,
                             "(blocks, 6): of centroids (m/s) and angular (rad/s), world axes")
      .def_property_readonly("unbalance", found(&Equilibrium::unbalance),
                             "largest force that is missing, by the largest load")
      .def_property_readonly("violation", found(&Equilibrium::violation),
                             "farthest that a force lies outside its cone, by the largest load")
      .def_property_readonly("margin", found(&Equilibrium::margin),
                             "least distance of a force from the rim of its cone, by that load")
      .def_property_readonly("incompatibility", found(&Equilibrium::incompatibility),
                             "farthest that a contact closes along `velocities`, m/s")
      .def_property_readonly("power", found(&Equilibrium::power), "of the loads, W")
      .def_property_readonly("dissipation", found(&Equilibrium::dissipation),
                             "most that the contacts take, W")
      .def("__repr__", [](const Answer& a) {
        return py::str("<quoin.Equilibrium: {}, factor {:g}>")
            .format(name(a.found.verdict), a.found.factor);
      });
  module.def("equilibrium", &solve, py::arg("scene"), py::kw_only(), py::arg("live") = py::none(),
             py::arg("factor") = py::none(), py::arg("largest") = 1e6,
             py::arg("changes") = std::vector<std::string>(), py::arg("reach") = 0.0,
             "Whether contact forces within friction balance the loads of a Scene as it stands at "
             "time 0, its blocks rigid: an Equilibrium. live: a Scene of the same blocks whose "
             "weight and loads `factor` multiplies; without `factor`: the largest factor in [0, "
             "largest] that is borne. Contact points up to a gap of `reach`, m; 0: chosen. A "
             "mechanism is a proof whatever the flow rule; forces are an upper bound for Coulomb "
             "friction. Raises InputError for a scene that Simulation refuses.");
}

}  // namespace quoin::python
