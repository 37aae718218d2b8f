#include "shapes.hpp"

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/geometry/queries.hpp>
#include <quoin/geometry/split.hpp>
#include <quoin/geometry/time_of_impact.hpp>

#include "arrays.hpp"

namespace quoin::python {
namespace {

using geometry::Shape;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

ShapePointer shared(Shape&& shape) { return std::make_shared<Shape>(std::move(shape)); }

py::array_t<int> int_array(std::span<const int> values) {
  return py::array_t<int>(static_cast<py::ssize_t>(values.size()), values.data());
}

py::list faces(const Shape& shape) {
  py::list result;
  for (int f = 0; f < shape.topology().face_count(); ++f)
    result.append(int_array(shape.topology().face(f)));
  return result;
}

py::array_t<int> edges(const Shape& shape) {
  py::array_t<int> result(std::vector<py::ssize_t>{shape.topology().edge_count(), 2});
  for (int e = 0; e < shape.topology().edge_count(); ++e)
    std::copy_n(shape.topology().edge(e).data(), 2, result.mutable_data(e));
  return result;
}

py::array_t<double> box_array(const geometry::Box& box) {
  py::array_t<double> result(std::vector<py::ssize_t>{2, 3});
  std::copy_n(box.min.data(), 3, result.mutable_data(0));
  std::copy_n(box.max.data(), 3, result.mutable_data(1));
  return result;
}

py::array_t<double> rows_of(const geometry::Points& points) {
  return py::array_t<double>(std::vector<py::ssize_t>{points.cols(), 3}, points.data());
}

struct HitRow {
  bool hit;
  std::int32_t face;
  double s, point[3], normal[3];
};

HitRow row(const std::optional<geometry::RayHit>& hit) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (!hit) return {false, -1, kInfinity, {kNone, kNone, kNone}, {kNone, kNone, kNone}};
  const Vector3 &p = hit->point, &n = hit->normal;
  return {true, hit->face, hit->s, {p.x(), p.y(), p.z()}, {n.x(), n.y(), n.z()}};
}

py::object ray(const HeldBody& held, const py::object& origin, const py::object& direction,
               double length) {
  if (py::array(origin).ndim() < 2) {
    const geometry::Ray one{vector3(origin, "origin"), vector3(direction, "direction"), length};
    return py::cast(first_hit(held.body, one));
  }
  const geometry::Points origins = points(origin, "origin");
  const geometry::Points directions = points(direction, "direction");
  if (origins.cols() != directions.cols()) {
    throw geometry::InputError("direction: " + std::to_string(directions.cols()) + " rows for " +
                               std::to_string(origins.cols()) + " origins");
  }
  py::array_t<HitRow> result(origins.cols());
  HitRow* rows = result.mutable_data();
  py::gil_scoped_release released;
  for (Eigen::Index i = 0; i < origins.cols(); ++i)
    rows[i] = row(first_hit(held.body, {origins.col(i), directions.col(i), length}));
  return result;
}

py::object contains(const HeldBody& held, const py::object& point, double tolerance) {
  if (py::array(point).ndim() < 2)
    return py::bool_(geometry::contains(held.body, vector3(point, "point"), tolerance));
  const geometry::Points all = points(point, "point");
  py::array_t<bool> result(all.cols());
  bool* inside = result.mutable_data();
  py::gil_scoped_release released;
  for (Eigen::Index i = 0; i < all.cols(); ++i)
    inside[i] = geometry::contains(held.body, all.col(i), tolerance);
  return result;
}

/// Of numbers that a shape holds, three a row.
auto view_of(const geometry::Points& (Shape::*numbers)() const) {
  return [numbers](const py::object& self) {
    const geometry::Points& v = (self.cast<const Shape&>().*numbers)();
    return view({v.cols(), 3}, v.data(), self);
  };
}

void bind_shape(py::module_& module) {
  py::class_<Shape, ShapePointer>(
      module, "Shape", py::is_final(),
      "Convex polyhedron in a frame of its own, immutable. Shape(points): the exact convex hull of "
      "points, (n, 3), m. Throws InputError naming point, value and limit.")
      .def(py::init([](const py::object& given) {
             const geometry::Points p = points(given, "points");
             py::gil_scoped_release released;
             return shared(std::move(geometry::make_hull(p).polyhedron));
           }),
           py::arg("points"))
      .def_static(
          "box",
          [](const py::object& min, const py::object& max) {
            return shared(geometry::make_box(vector3(min, "min"), vector3(max, "max")));
          },
          py::arg("min"), py::arg("max"), "Axis-aligned box between two corners, (3,), m.")
      .def_static(
          "prism",
          [](const py::object& polygon, const py::object& sweep) {
            return shared(
                geometry::make_prism(points(polygon, "polygon"), vector3(sweep, "sweep")));
          },
          py::arg("polygon"), py::arg("sweep"),
          "Convex planar polygon (n, 3), m, swept along `sweep` (3,), m.")
      .def_static(
          "from_faces",
          [](const py::object& vertices, const py::object& polygons, double rounding) {
            return shared(geometry::make_shape(points(vertices, "vertices"),
                                               index_lists(polygons, "faces"),
                                               {.coordinate_rounding = rounding}));
          },
          py::arg("vertices"), py::arg("faces"), py::kw_only(),
          py::arg("coordinate_rounding") = 0.0,
          "Vertices (n, 3), m, and faces: polygons or triangles, lists of vertex indices, either "
          "orientation. Closed, convex and planar within 1e-6 of the diameter, or what coordinates "
          "that are off by up to coordinate_rounding, m, leave open; or InputError.")
      .def_property_readonly("vertices", view_of(&Shape::vertices), "(n, 3), m; a read-only view")
      .def_property_readonly("face_normals", view_of(&Shape::face_normals),
                             "(faces, 3), unit, outward; a read-only view")
      .def_property_readonly("faces", &faces,
                             "vertex indices of each, counter-clockwise from outside")
      .def_property_readonly("edges", &edges, "(edges, 2): vertex indices, first < second")
      .def_property_readonly(
          "bounds", [](const Shape& s) { return box_array(s.box()); },
          "(2, 3): least and largest coordinates, m")
      .def_property_readonly("diameter", &Shape::diameter,
                             "twice the largest distance of a vertex from the middle of the box, m")
      .def_property_readonly(
          "volume", [](const Shape& s) { return mass_properties(s).volume; }, "m3")
      .def_property_readonly(
          "centroid", [](const Shape& s) { return mass_properties(s).centroid; }, "(3,), m")
      .def_property_readonly(
          "second_moment", [](const Shape& s) { return mass_properties(s).second_moment; },
          "(3, 3): integral of (x-c)(x-c)^T over the volume about the centroid, m5")
      .def("__repr__", [](const Shape& s) {
        return "<quoin.Shape: " + std::to_string(s.vertex_count()) + " vertices, " +
               std::to_string(s.topology().face_count()) + " faces>";
      });
}

void bind_body(py::module_& module) {
  py::class_<HeldBody>(
      module, "Body", py::is_final(),
      "A shape under a placement x = t + A X: None (identity), 4x4, 3x4 or (R, t); t in m, det A > "
      "0, A a rotation or that of a deformed block. Functions of two bodies take shapes, too.")
      .def(py::init([](const ShapePointer& shape, const py::object& at) {
             return HeldBody(shape, placement(at));
           }),
           py::arg("shape").none(false), py::arg("placement") = py::none())
      .def(
          "move", [](HeldBody& held, const py::object& at) { held.body.move(placement(at)); },
          py::arg("placement"), "Another placement.")
      .def_property_readonly("shape", [](const HeldBody& held) { return held.shape; })
      .def_property_readonly(
          "placement", [](const HeldBody& held) { return matrix(held.body.placement()); }, "(4, 4)")
      .def_property_readonly(
          "vertices", [](const HeldBody& held) { return rows_of(held.body.vertices()); },
          "(n, 3) in the world, m")
      .def_property_readonly(
          "bounds", [](const HeldBody& held) { return box_array(held.body.box()); },
          "(2, 3) in the world, m")
      .def_property_readonly(
          "volume", [](const HeldBody& held) { return mass_properties(held.body).volume; }, "m3")
      .def_property_readonly(
          "centroid", [](const HeldBody& held) { return mass_properties(held.body).centroid; },
          "(3,) in the world, m")
      .def_property_readonly(
          "second_moment",
          [](const HeldBody& held) { return mass_properties(held.body).second_moment; },
          "(3, 3) in the world, about the centroid, m5");
  py::implicitly_convertible<Shape, HeldBody>();
}

py::object part(const std::optional<geometry::SplitPart>& side) {
  if (!side) return py::none();
  return py::make_tuple(std::make_shared<Shape>(side->shape), int_array(side->old_faces));
}

geometry::Motion motion(const py::object& given, const HeldBody& held, const char* name) {
  geometry::Motion result{.centre = mass_properties(held.body).centroid};
  if (given.is_none()) return result;
  if (!PySequence_Check(given.ptr()) || PySequence_Size(given.ptr()) != 2)
    throw py::type_error(std::string(name) + ": (translation, rotation vector) is expected");
  const auto parts = py::reinterpret_borrow<py::sequence>(given);
  result.translation = vector3(parts[0], name);
  result.rotation = vector3(parts[1], name);
  return result;
}

void bind_cuts(py::module_& module) {
  module.def(
      "split",
      [](const Shape& shape, const py::object& point, const py::object& normal) {
        const geometry::Split parts =
            geometry::split(shape, {vector3(point, "point"), vector3(normal, "normal")});
        return py::make_tuple(part(parts.below), part(parts.above));
      },
      py::arg("shape"), py::arg("point"), py::arg("normal"),
      "Cuts a shape, in its own frame, by the plane normal . (x - point) = 0: (below, above), "
      "above "
      "where the normal points, each (Shape, old face of each face or -1: in the plane), or None "
      "where there is nothing. Raises InputError for a plane that is not finite or without "
      "normal.");
  module.def(
      "shape_faults",
      [](const py::object& vertices, const py::object& polygons, double rounding) {
        py::list result;
        for (const geometry::ShapeFault& fault :
             geometry::shape_faults(points(vertices, "vertices"), index_lists(polygons, "faces"),
                                    {.coordinate_rounding = rounding})) {
          result.append(py::make_tuple(fault.text, fault.refused));
        }
        return result;
      },
      py::arg("vertices"), py::arg("faces"), py::kw_only(), py::arg("coordinate_rounding") = 0.0,
      "All that is wrong with vertices and faces as Shape.from_faces takes them: (text, refused) "
      "of "
      "each fault; refused: by from_faces.");
}

void bind_impact(py::module_& module) {
  py::class_<geometry::Impact>(module, "Impact", py::is_final(), "When two moving bodies meet.")
      .def_property_readonly(
          "status",
          [](const geometry::Impact& i) {
            constexpr const char* kNames[] = {"impact", "apart", "not-converged"};
            return kNames[static_cast<std::size_t>(i.status)];
          },
          "'impact', 'apart' or 'not-converged': beyond s it is not known")
      .def_readonly("s", &geometry::Impact::s, "part of the step, 0 to 1; before it they are apart")
      .def_readonly("nearest", &geometry::Impact::nearest, "NearestFeatures at s")
      .def_readonly("iterations", &geometry::Impact::iterations);
  module.def(
      "time_of_impact",
      [](const HeldBody& a, const py::object& motion_a, const HeldBody& b,
         const py::object& motion_b, double length, int max_iterations) {
        return geometry::time_of_impact(a.body, motion(motion_a, a, "motion_a"), b.body,
                                        motion(motion_b, b, "motion_b"),
                                        {.length = length, .max_iterations = max_iterations});
      },
      py::arg("a"), py::arg("motion_a"), py::arg("b"), py::arg("motion_b"), py::arg("length") = 0.0,
      py::arg("max_iterations") = 1000,
      "When bodies that move through a step meet, never late: an Impact. Before its s the gap is "
      "above length / 2 (m), at it at most `length`. Motions: (translation, m, rotation vector "
      "about the centroid, rad) of the whole step, None: it stands still. Raises InputError for "
      "what is not finite or negative.");
}

void bind_queries(py::module_& module) {
  py::class_<geometry::RayHit>(module, "RayHit", py::is_final(), "Where a ray enters a body.")
      .def_readonly("s", &geometry::RayHit::s, "in units of the direction; 0: it starts inside")
      .def_readonly("point", &geometry::RayHit::point, "(3,), m")
      .def_readonly("normal", &geometry::RayHit::normal, "(3,), outward; zero: starts inside")
      .def_readonly("face", &geometry::RayHit::face, "index; -1: starts inside");
  module.def("ray", &ray, py::arg("body"), py::arg("origin"), py::arg("direction"),
             py::arg("length") = kInfinity,
             "Where the ray origin + s direction, 0 <= s <= length, enters the body: a RayHit or "
             "None. origin and direction (n, 3): a structured array with hit, face, s (inf: none), "
             "point, normal. Throws InputError for a direction that is zero or not finite.");
  module.def("contains", &contains, py::arg("body"), py::arg("point"), py::arg("tolerance") = 0.0,
             "Whether a point (3,), m, lies in the body or within `tolerance` (m) of its planes; "
             "of points (n, 3) an array of bool.");
  module.def(
      "overlap",
      [](const HeldBody& a, const HeldBody& b) { return geometry::overlap(a.body, b.body); },
      py::arg("a"), py::arg("b"), "Whether two bodies have a point in common (gap <= 0).");
  module.def(
      "distance",
      [](const HeldBody& a, const HeldBody& b, double cut_off) {
        const auto nearest = nearest_features_within(a.body, b.body, cut_off);
        return nearest ? std::max(nearest->gap, 0.0) : kInfinity;
      },
      py::arg("a"), py::arg("b"), py::arg("cut_off") = kInfinity,
      "Distance of two bodies, m; 0: they touch or overlap; inf: farther apart than `cut_off`, m.");
}

}  // namespace

void bind_moving(py::module_& module) { bind_impact(module); }

void bind_shapes(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(HitRow, hit, face, s, point, normal);
  bind_shape(module);
  bind_body(module);
  bind_queries(module);
  bind_cuts(module);
}

}  // namespace quoin::python
