// One pair, and batches of the caller's own pairs.
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <optional>
#include <quoin/geometry/contact_finder.hpp>
#include <quoin/geometry/pair_batch.hpp>
#include <quoin/geometry/worker_pool.hpp>

#include "arrays.hpp"
#include "rows.hpp"
#include "shapes.hpp"

namespace quoin::python {
namespace {

using geometry::NearestFeatures;
using geometry::PairContact;

/// Bodies in a row, for batches.
class Bodies {
 public:
  Bodies(const py::object& shapes, const py::object& at, const py::object& shape_of_body) {
    if (py::isinstance<geometry::Shape>(shapes))
      shapes_.push_back(shapes.cast<ShapePointer>());
    else
      for (const py::handle shape : shapes) shapes_.push_back(shape.cast<ShapePointer>());
    const std::vector<geometry::Placement> places = placements(at);
    const std::vector<int> which = shape_indices(shape_of_body, places.size());
    bodies_.reserve(places.size());
    for (std::size_t i = 0; i < places.size(); ++i)
      bodies_.emplace_back(*shapes_[static_cast<std::size_t>(which[i])], places[i]);
  }

  void move(const py::object& at, const py::object& indices_or_none) {
    const std::vector<geometry::Placement> places = placements(at);
    const std::vector<int> which =
        indices_or_none.is_none() ? every(bodies_.size()) : indices(indices_or_none, "indices");
    if (which.size() != places.size()) {
      throw geometry::InputError("placements: " + std::to_string(places.size()) + " for " +
                                 std::to_string(which.size()) + " bodies");
    }
    require_below(which, bodies_.size(), "indices", "bodies");
    const Use use(busy, "Bodies");
    for (std::size_t i = 0; i < which.size(); ++i)
      bodies_[static_cast<std::size_t>(which[i])].move(places[i]);
  }

  std::span<const geometry::Body> all() const { return bodies_; }
  std::size_t size() const { return bodies_.size(); }

  py::array_t<double> bounds() const {
    py::array_t<double> result(
        std::vector<py::ssize_t>{static_cast<py::ssize_t>(bodies_.size()), 2, 3});
    double* number = result.mutable_data();
    for (const geometry::Body& body : bodies_) {
      const geometry::Box box = body.box();
      number = std::copy_n(box.max.data(), 3, std::copy_n(box.min.data(), 3, number));
    }
    return result;
  }

  std::atomic_flag busy{};

 private:
  static std::vector<int> every(std::size_t count) {
    std::vector<int> result(count);
    for (std::size_t i = 0; i < count; ++i) result[i] = static_cast<int>(i);
    return result;
  }
  static void require_below(const std::vector<int>& which, std::size_t count, const char* name,
                            const char* what) {
    for (const int i : which) {
      if (i >= 0 && static_cast<std::size_t>(i) < count) continue;
      throw geometry::InputError(std::string(name) + ": " + std::to_string(i) + ", there are " +
                                 std::to_string(count) + " " + what);
    }
  }
  /// One shape for all, one for each, or the shape of each by its index.
  std::vector<int> shape_indices(const py::object& given, std::size_t count) const {
    for (const ShapePointer& shape : shapes_)
      if (!shape) throw geometry::InputError("shapes: None is no shape");
    std::vector<int> which;
    if (!given.is_none())
      which = indices(given, "shape_of_body");
    else if (shapes_.size() == 1)
      which.assign(count, 0);
    else
      which = every(shapes_.size());
    if (which.size() != count) {
      throw geometry::InputError("placements: " + std::to_string(count) + " for " +
                                 std::to_string(which.size()) + " shapes");
    }
    require_below(which, shapes_.size(), "shape_of_body", "shapes");
    return which;
  }

  std::vector<ShapePointer> shapes_;
  std::vector<geometry::Body> bodies_;
};

class Batch {
 public:
  Batch(double reach, double tolerance, int threads, double coordinate_rounding)
      : batch_(
            {.tolerance = tolerance, .reach = reach, .coordinate_rounding = coordinate_rounding}),
        tolerance_(tolerance) {
    if (threads > geometry::kMostThreads) {
      throw geometry::InputError("threads: " + std::to_string(threads) + ", at most " +
                                 std::to_string(geometry::kMostThreads));
    }
    pool_.emplace(threads);
  }

  py::array_t<ContactRow> find(Bodies& bodies, const py::object& list) {
    const std::vector<geometry::BlockPair> asked = python::pairs(list);
    const Use use(busy_, "PairBatch"), bodies_use(bodies.busy, "Bodies");
    {
      py::gil_scoped_release released;
      batch_.find(bodies.all(), asked, contacts_, &*pool_);
    }
    return rows(contacts_);
  }

  py::array_t<NearestRow> nearest(Bodies& bodies, const py::object& list) {
    const std::vector<geometry::BlockPair> asked = python::pairs(list);
    const Use use(busy_, "PairBatch"), bodies_use(bodies.busy, "Bodies");
    {
      py::gil_scoped_release released;
      answers_.resize(asked.size());
      update_nearest_features(bodies.all(), asked, answers_, {.tolerance = tolerance_}, &*pool_);
    }
    return rows(answers_);
  }

  py::array_t<PairRow> pairs() {
    const Use use(busy_, "PairBatch");
    return rows(batch_.pairs());
  }

 private:
  geometry::PairBatch batch_;
  double tolerance_;
  std::optional<geometry::WorkerPool> pool_;
  std::vector<geometry::ContactPoint> contacts_;
  std::vector<NearestFeatures> answers_;
  std::atomic_flag busy_{};
};

py::tuple feature(const geometry::Feature& f) { return py::make_tuple(name(f.kind), f.index); }

PairContact pair_contact(const HeldBody& a, const HeldBody& b, double reach, double tolerance,
                         double coordinate_rounding) {
  PairContact contact;
  update_pair_contact(
      a.body, b.body,
      {.tolerance = tolerance, .reach = reach, .coordinate_rounding = coordinate_rounding},
      contact);
  return contact;
}

py::array_t<double> polygon(const PairContact& contact) {
  py::array_t<double> result(
      std::vector<py::ssize_t>{static_cast<py::ssize_t>(contact.polygon.size()), 3});
  double* number = result.mutable_data();
  for (const Vector3& corner : contact.polygon) number = std::copy_n(corner.data(), 3, number);
  return result;
}

template <class Record, class Value>
auto named(Value Record::*member) {
  return [member](const Record& record) { return name(record.*member); };
}
auto featured(geometry::Feature NearestFeatures::*member) {
  return [member](const NearestFeatures& nearest) { return feature(nearest.*member); };
}

void bind_nearest(py::module_& module) {
  py::class_<NearestFeatures>(
      module, "NearestFeatures", py::is_final(),
      "Nearest features of two bodies. gap > 0: distance, m; gap < 0: minus the least translation "
      "that parts them. The normal is a unit vector from a to b.")
      .def_property_readonly("status", named(&NearestFeatures::status),
                             "'separated', 'touching', 'overlapping' or 'not-converged'")
      .def_property_readonly("rule", named(&NearestFeatures::rule),
                             "how the contact plane was chosen")
      .def_readonly("gap", &NearestFeatures::gap, "m")
      .def_readonly("normal", &NearestFeatures::normal, "(3,), unit, from a to b")
      .def_readonly("point_a", &NearestFeatures::point_a, "(3,), witness on a, m")
      .def_readonly("point_b", &NearestFeatures::point_b, "(3,), witness on b, m")
      .def_property_readonly("feature_a", featured(&NearestFeatures::feature_a),
                             "('vertex' | 'edge' | 'face', index)")
      .def_property_readonly("feature_b", featured(&NearestFeatures::feature_b),
                             "('vertex' | 'edge' | 'face', index)")
      .def_readonly("residual_a", &NearestFeatures::residual_a,
                    "certificate: how far a reaches beyond point_a along the normal, m")
      .def_readonly("residual_b", &NearestFeatures::residual_b,
                    "certificate: how far b reaches beyond point_b against the normal, m")
      .def_readonly("iterations", &NearestFeatures::iterations)
      .def_readonly("indeterminate", &NearestFeatures::indeterminate,
                    "the normal is one choice of several")
      .def("__repr__", [](const NearestFeatures& n) {
        return py::str("<quoin.NearestFeatures: {}, gap {:g} m>").format(name(n.status), n.gap);
      });
  module.def(
      "nearest",
      [](const HeldBody& a, const HeldBody& b, double tolerance) {
        return nearest_features(a.body, b.body, {.tolerance = tolerance});
      },
      py::arg("a"), py::arg("b"), py::arg("tolerance") = 0.0,
      "Nearest features of two bodies. tolerance: contact length, m; 0: chosen.");
}

void bind_contacts(py::module_& module) {
  py::class_<PairContact>(module, "PairContact", py::is_final(),
                          "All there is to know about one pair.")
      .def_property_readonly("nearest", [](const PairContact& c) { return c.nearest; })
      .def_property_readonly("type", named(&PairContact::type), "'vertex-vertex' …")
      .def_property_readonly(
          "points", [](const PairContact& c) { return rows(c.points); },
          "contact points, a structured array as of contacts()")
      .def_property_readonly("polygon", &polygon,
                             "(n, 3), m: face-face: the contact polygon, counter-clockwise seen "
                             "against the normal; edges: the ends of the segment")
      .def_readonly("area", &PairContact::area, "of the polygon, m2; 0 unless face-face");
  module.def(
      "pair_contact", &pair_contact, py::arg("a"), py::arg("b"), py::arg("reach") = 0.0,
      py::arg("tolerance") = 0.0, py::arg("coordinate_rounding") = 0.0,
      "Nearest features, contact type, polygon and points of two bodies. Points are listed "
      "up to `reach` (m) above the least gap. coordinate_rounding: to which vertices are known, "
      "m.");
  module.def(
      "contacts",
      [](const HeldBody& a, const HeldBody& b, double reach, double tolerance,
         double coordinate_rounding) {
        std::vector<geometry::ContactPoint> contacts;
        append_contacts_within_reach(
            {0, 1}, a.body, b.body,
            {.tolerance = tolerance, .reach = reach, .coordinate_rounding = coordinate_rounding},
            {}, contacts);
        return rows(contacts);
      },
      py::arg("a"), py::arg("b"), py::arg("reach") = 0.0, py::arg("tolerance") = 0.0,
      py::arg("coordinate_rounding") = 0.0,
      "Contact points of two bodies up to a gap of `reach`, m, those of touching and overlapping "
      "bodies always: a structured array, a row each, sorted by key, with a = 0, b = 1. Fields: "
      "type (index in CONTACT_TYPES), kind_a and kind_b (in FEATURE_KINDS), feature_a, feature_b, "
      "indeterminate, previous, point (middle of point_a and point_b, m), normal (unit, from a to "
      "b), gap (m, negative: overlap), area (share of the contact polygon, m2).");
}

void bind_batches(py::module_& module) {
  py::class_<Bodies>(
      module, "Bodies", py::is_final(),
      "Bodies in a row, for batches: placements (n, 4, 4) or (n, 3, 4); `shapes` one shape for "
      "all, a list of one for each, or those that `shape_of_body` (n,) counts.")
      .def(py::init<const py::object&, const py::object&, const py::object&>(), py::arg("shapes"),
           py::arg("placements"), py::arg("shape_of_body") = py::none())
      .def("move", &Bodies::move, py::arg("placements"), py::arg("indices") = py::none(),
           "Other placements, of all bodies or of those that `indices` names.")
      .def_property_readonly("bounds", &Bodies::bounds,
                             "(n, 2, 3): least and largest coordinates in the world, m")
      .def("__len__", &Bodies::size);
  py::class_<Batch>(
      module, "PairBatch", py::is_final(),
      "Answers lists of pairs (n, 2) of the caller's own and remembers where each search ended: "
      "that changes the speed, never the answer. Lengths in m. The answers are the same for any "
      "number of threads; the GIL is released.")
      .def(py::init<double, double, int, double>(), py::kw_only(), py::arg("reach") = 0.0,
           py::arg("tolerance") = 0.0, py::arg("threads") = 1, py::arg("coordinate_rounding") = 0.0)
      .def("find", &Batch::find, py::arg("bodies"), py::arg("pairs"),
           "Contact points of all pairs, a < b: fields as of contacts(), a and b the indices of "
           "the bodies, previous the row of the same contact in the last call, -1: new.")
      .def("nearest", &Batch::nearest, py::arg("bodies"), py::arg("pairs"),
           "Nearest features of each pair, a row each: status (index in PAIR_STATUSES), gap, "
           "normal, point_a, point_b, kinds and features, residuals. The search starts from the "
           "row of the last call.")
      .def("pairs", &Batch::pairs,
           "Pairs in contact after the last find() and those that it ended: event (index in "
           "PAIR_EVENTS), status, type, gap, normal, area, first and count of their points.");
}

}  // namespace

void bind_pairs(py::module_& module) {
  register_rows();
  bind_nearest(module);
  bind_contacts(module);
  bind_batches(module);
}

}  // namespace quoin::python
