#pragma once
/// What Python gives, as the library takes it; one-line messages name the argument.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <atomic>
#include <quoin/geometry/body.hpp>
#include <quoin/geometry/pair_batch.hpp>
#include <string>
#include <vector>

namespace quoin::python {

namespace py = pybind11;
using geometry::Vector3;

inline constexpr int kAny = -1;  ///< a length that the caller chooses

/// Numbers in C order. `shape`: the lengths that are asked for. Throws TypeError for anything but
/// real numbers, ValueError (InputError) for another shape.
py::array_t<double> doubles(py::handle value, const char* name,
                            const std::vector<py::ssize_t>& shape);
/// The same for integers; those that an int does not hold are refused.
py::array_t<std::int64_t> integers(py::handle value, const char* name,
                                   const std::vector<py::ssize_t>& shape);

Vector3 vector3(py::handle value, const char* name);
/// (n, 3) as 3 × n columns.
geometry::Points points(py::handle value, const char* name);
/// Lists of indices, or a rectangular array of them.
std::vector<std::vector<int>> index_lists(py::handle value, const char* name);
std::vector<int> indices(py::handle value, const char* name);
std::vector<geometry::BlockPair> pairs(py::handle value);  ///< (n, 2)

/// None, 4×4, 3×4 or (R, t), checked: finite and with a positive determinant.
geometry::Placement placement(py::handle value);
/// (n, 4, 4) or (n, 3, 4); what they hold the library checks.
std::vector<geometry::Placement> placements(py::handle value);
py::array_t<double> matrix(const geometry::Placement& placement);  ///< 4×4

/// A read-only array on memory of `owner`.
py::array_t<double> view(const std::vector<py::ssize_t>& shape, const double* data,
                         py::handle owner);

/// Held while an object works: another thread, or a callback, that calls it meanwhile is refused.
class Use {
 public:
  Use(std::atomic_flag& busy, const char* what) : busy_(busy) {
    if (busy.test_and_set())
      throw std::runtime_error(std::string(what) + ": another call of it has not returned");
  }
  ~Use() { busy_.clear(); }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;

 private:
  std::atomic_flag& busy_;
};

void bind_shapes(py::module_& module);
void bind_pairs(py::module_& module);
void bind_moving(py::module_& module);  ///< after bind_pairs()
void bind_finder(py::module_& module);
void bind_simulation(py::module_& module);
void bind_equilibrium(py::module_& module);

}  // namespace quoin::python
