#include "arrays.hpp"

#include <Eigen/LU>
#include <limits>

namespace quoin::python {
namespace {

using geometry::InputError;

template <class Numbers>
std::string text(const Numbers& lengths) {
  std::string shape = "(";
  for (const py::ssize_t length : lengths)
    shape += (shape.size() > 1 ? ", " : "") + (length == kAny ? "n" : std::to_string(length));
  return shape + (lengths.size() == 1 ? ",)" : ")");
}

/// As numpy.asarray, of the kinds (numpy's letters) that are wanted.
py::array numbers(py::handle value, const char* name, const char* kinds, const char* what) {
  const py::array array(py::reinterpret_borrow<py::object>(value));
  if (array.size() > 0 && std::string(kinds).find(array.dtype().kind()) == std::string::npos) {
    throw py::type_error(std::string(name) + ": dtype " +
                         py::str(array.dtype()).cast<std::string>() + ", expected " + what);
  }
  return array;
}

void require_shape(const py::array& array, const char* name,
                   const std::vector<py::ssize_t>& expected) {
  const std::vector<py::ssize_t> shape(array.shape(), array.shape() + array.ndim());
  bool same = shape.size() == expected.size();
  for (std::size_t i = 0; same && i < shape.size(); ++i)
    same = expected[i] == kAny || shape[i] == expected[i];
  if (!same)
    throw InputError(std::string(name) + ": shape " + text(shape) + ", expected " + text(expected));
}

/// Rows 0 to 2 of 4×4 or 3×4 numbers.
geometry::Placement placement_at(const double* m) {
  using Rows = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
  const Eigen::Map<const Rows> rows(m);
  return {.linear = rows.leftCols<3>(), .translation = rows.col(3)};
}

void require_last_row(const double* m, const std::string& name) {
  if (m[12] == 0.0 && m[13] == 0.0 && m[14] == 0.0 && m[15] == 1.0) return;
  throw InputError(name + ": the last row of a 4x4 matrix must be 0, 0, 0, 1");
}

geometry::Placement require_placement(const geometry::Placement& placement) {
  if (!placement.linear.allFinite() || !placement.translation.allFinite())
    throw InputError("placement: a number is not finite");
  const double largest =
      std::max(placement.linear.cwiseAbs().maxCoeff(), placement.translation.cwiseAbs().maxCoeff());
  if (largest > geometry::kLargestCoordinate)
    throw InputError("placement: a number is " + std::to_string(largest) + ", at most 1e30");
  const double determinant = placement.linear.determinant();
  if (!(determinant > 0.0)) {
    throw InputError("placement: its determinant is " + std::to_string(determinant) +
                     ", must be positive");
  }
  return placement;
}

/// Two things of which the first is a matrix.
bool is_rotation_and_translation(py::handle value) {
  if (py::isinstance<py::array>(value) || !PySequence_Check(value.ptr()) ||
      PySequence_Size(value.ptr()) != 2) {
    PyErr_Clear();
    return false;
  }
  return true;
}

}  // namespace

py::array_t<double> doubles(py::handle value, const char* name,
                            const std::vector<py::ssize_t>& shape) {
  const py::array array = numbers(value, name, "fiu", "real numbers");
  require_shape(array, name, shape);
  return py::array_t<double, py::array::c_style | py::array::forcecast>(array);
}

py::array_t<std::int64_t> integers(py::handle value, const char* name,
                                   const std::vector<py::ssize_t>& shape) {
  const py::array array = numbers(value, name, "iu", "integers");
  require_shape(array, name, shape);
  py::array_t<std::int64_t, py::array::c_style | py::array::forcecast> result(array);
  for (py::ssize_t i = 0; i < result.size(); ++i) {
    const std::int64_t number = result.data()[i];
    if (number < std::numeric_limits<int>::min() || number > std::numeric_limits<int>::max())
      throw InputError(std::string(name) + ": " + std::to_string(number) + " is out of range");
  }
  return result;
}

Vector3 vector3(py::handle value, const char* name) {
  const py::array_t<double> numbers = doubles(value, name, {3});
  return {numbers.at(0), numbers.at(1), numbers.at(2)};
}

geometry::Points points(py::handle value, const char* name) {
  const py::array_t<double> rows = doubles(value, name, {kAny, 3});
  return Eigen::Map<const geometry::Points>(rows.data(), 3, rows.shape(0));
}

std::vector<int> indices(py::handle value, const char* name) {
  const py::array_t<std::int64_t> numbers = integers(value, name, {kAny});
  std::vector<int> result(static_cast<std::size_t>(numbers.size()));
  std::transform(numbers.data(), numbers.data() + numbers.size(), result.begin(),
                 [](std::int64_t i) { return static_cast<int>(i); });
  return result;
}

std::vector<std::vector<int>> index_lists(py::handle value, const char* name) {
  std::vector<std::vector<int>> lists;
  for (const py::handle list : value) lists.push_back(indices(list, name));
  return lists;
}

std::vector<geometry::BlockPair> pairs(py::handle value) {
  const py::array_t<std::int64_t> numbers = integers(value, "pairs", {kAny, 2});
  std::vector<geometry::BlockPair> result(static_cast<std::size_t>(numbers.shape(0)));
  const std::int64_t* number = numbers.data();
  for (geometry::BlockPair& pair : result) {
    pair = {.a = static_cast<int>(number[0]), .b = static_cast<int>(number[1])};
    number += 2;
  }
  return result;
}

geometry::Placement placement(py::handle value) {
  if (value.is_none()) return {};
  if (is_rotation_and_translation(value)) {
    const auto parts = py::reinterpret_borrow<py::sequence>(value);
    const py::array_t<double> linear = doubles(parts[0], "placement[0]", {3, 3});
    using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    return require_placement({.linear = Eigen::Map<const Rows>(linear.data()),
                              .translation = vector3(parts[1], "placement[1]")});
  }
  const py::array given(py::reinterpret_borrow<py::object>(value));
  const bool square = given.ndim() > 0 && given.shape(0) == 4;
  const py::array_t<double> m = doubles(given, "placement", {square ? 4 : 3, 4});
  if (square) require_last_row(m.data(), "placement");
  return require_placement(placement_at(m.data()));
}

std::vector<geometry::Placement> placements(py::handle value) {
  const py::array given(py::reinterpret_borrow<py::object>(value));
  const py::ssize_t rows = given.ndim() > 1 && given.shape(1) == 4 ? 4 : 3;
  const py::array_t<double> m = doubles(given, "placements", {kAny, rows, 4});
  std::vector<geometry::Placement> result(static_cast<std::size_t>(m.shape(0)));
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double* at = m.data() + static_cast<py::ssize_t>(i) * rows * 4;
    if (rows == 4) require_last_row(at, "placements[" + std::to_string(i) + "]");
    result[i] = placement_at(at);
  }
  return result;
}

py::array_t<double> matrix(const geometry::Placement& placement) {
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = placement.linear;
  m.topRightCorner<3, 1>() = placement.translation;
  return py::array_t<double>(std::vector<py::ssize_t>{4, 4}, m.data());
}

py::array_t<double> view(const std::vector<py::ssize_t>& shape, const double* data,
                         py::handle owner) {
  py::array_t<double> result(shape, data, owner);
  result.attr("setflags")(py::arg("write") = false);
  return result;
}

}  // namespace quoin::python
