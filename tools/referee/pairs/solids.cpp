#include "referee/pairs/solids.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <quoin/geometry/build.hpp>
#include <sstream>
#include <stdexcept>

namespace quoin::referee {
namespace {

using geometry::Matrix3;
using geometry::Placement;
using geometry::Points;
using geometry::Shape;
using geometry::Vector3;

std::string hex(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%a", value);
  return text;
}

/// A random order of the numbers below `count`.
std::vector<int> shuffled(int count, Random& random) {
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  for (int i = count - 1; i > 0; --i) {
    std::swap(order[static_cast<std::size_t>(i)],
              order[static_cast<std::size_t>(random.integer(0, i))]);
  }
  return order;
}

Points reordered(const Points& points, const std::vector<int>& order) {
  Points result(3, points.cols());
  for (Eigen::Index v = 0; v < points.cols(); ++v)
    result.col(order[static_cast<std::size_t>(v)]) = points.col(v);
  return result;
}

/// The vertices that are no corners, renamed by `order`.
std::vector<geometry::HostedVertex> hosted(const geometry::Topology& topology,
                                           const std::vector<int>& order) {
  std::vector<geometry::HostedVertex> list = topology.hosted_vertices();
  const auto rename = [&](int& v) { v = v >= 0 ? order[static_cast<std::size_t>(v)] : v; };
  for (geometry::HostedVertex& at : list) {
    rename(at.vertex);
    rename(at.corners[0]);
    rename(at.corners[1]);
  }
  return list;
}

/// The twelve numbers: translation, then the rows of the linear part.
std::array<double, 12> numbers_of(const Placement& placement) {
  std::array<double, 12> list{};
  Eigen::Map<Vector3>(list.data()) = placement.translation;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(list.data() + 3) = placement.linear;
  return list;
}

Placement placement_of(const std::array<double, 12>& list) {
  Placement placement;
  placement.translation = Eigen::Map<const Vector3>(list.data());
  placement.linear =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(list.data() + 3);
  return placement;
}

/// What is written: the points as given, their faces if they have any, their place if they have
/// one.
std::string code_of(const Solid& solid, const std::string& name) {
  std::ostringstream out;
  const Points& points = solid.placed.points;
  out << "  Points points_" << name << "(3, " << points.cols() << ");\n";
  for (Eigen::Index v = 0; v < points.cols(); ++v) {
    out << "  points_" << name << ".col(" << v << ") << " << hex(points(0, v)) << ", "
        << hex(points(1, v)) << ", " << hex(points(2, v)) << ";\n";
  }
  if (!solid.topology) {
    out << "  const Shape " << name << " = make_hull(points_" << name << ").polyhedron;\n";
  } else {
    out << "  const Shape " << name << "(std::make_shared<Topology>(" << points.cols()
        << ", std::vector<std::vector<int>>{";
    for (int f = 0; f < solid.topology->face_count(); ++f) {
      out << (f == 0 ? "{" : ", {");
      for (std::size_t i = 0; i < solid.topology->face(f).size(); ++i)
        out << (i == 0 ? "" : ", ") << solid.topology->face(f)[i];
      out << "}";
    }
    out << "}, std::vector<HostedVertex>{";
    for (const geometry::HostedVertex& at : solid.topology->hosted_vertices()) {
      out << "{" << at.vertex << ", {" << at.corners[0] << ", " << at.corners[1] << "}, " << at.face
          << "}, ";
    }
    out << "}), points_" << name << ");\n";
  }
  if (!stands_in_own_frame(solid)) {
    const std::array<double, 12> x = numbers_of(solid.placed.placement);
    out << "  Placement place_" << name << ";\n  place_" << name << ".translation << " << hex(x[0])
        << ", " << hex(x[1]) << ", " << hex(x[2]) << ";\n  place_" << name << ".linear << ";
    for (std::size_t i = 3; i < 12; ++i) out << hex(x[i]) << (i == 11 ? ";\n" : ", ");
    out << "  const Body body_" << name << "(" << name << ", place_" << name << ");\n";
  }
  return out.str();
}

void write_solid(std::ostream& out, const Solid& solid) {
  const Points& points = solid.placed.points;
  out << points.cols() << ' ' << (solid.topology ? solid.topology->face_count() : 0) << ' ';
  for (Eigen::Index v = 0; v < points.cols(); ++v)
    out << hex(points(0, v)) << ' ' << hex(points(1, v)) << ' ' << hex(points(2, v)) << ' ';
  for (int f = 0; solid.topology && f < solid.topology->face_count(); ++f) {
    out << solid.topology->face(f).size();
    for (int v : solid.topology->face(f)) out << ' ' << v;
    out << ' ';
  }
  const std::vector<geometry::HostedVertex> no_corners =
      solid.topology ? solid.topology->hosted_vertices() : std::vector<geometry::HostedVertex>{};
  if (!no_corners.empty()) out << "hosted " << no_corners.size() << ' ';
  for (const geometry::HostedVertex& at : no_corners)
    out << at.vertex << ' ' << at.corners[0] << ' ' << at.corners[1] << ' ' << at.face << ' ';
  if (!stands_in_own_frame(solid)) {
    out << "placed";
    for (const double x : numbers_of(solid.placed.placement)) out << ' ' << hex(x);
    out << ' ';
  }
}

double read_number(std::istream& in) {
  std::string number;  // istream does not read hexadecimal floats
  in >> number;
  return std::strtod(number.c_str(), nullptr);
}

/// None where no such line follows.
std::vector<geometry::HostedVertex> read_hosted(std::istream& in) {
  std::vector<geometry::HostedVertex> list;
  in >> std::ws;
  if (in.peek() != 'h') return list;
  std::string word;
  std::size_t count = 0;
  in >> word >> count;
  list.resize(count);
  for (geometry::HostedVertex& at : list)
    in >> at.vertex >> at.corners[0] >> at.corners[1] >> at.face;
  if (!in) throw std::runtime_error("pair: the text ends early");
  return list;
}

Solid read_solid(std::istream& in) {
  int vertex_count = 0, face_count = 0;
  in >> vertex_count >> face_count;
  Points points(3, vertex_count);
  for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = read_number(in);
  std::vector<std::vector<int>> faces(static_cast<std::size_t>(face_count));
  for (std::vector<int>& face : faces) {
    std::size_t corners = 0;
    in >> corners;
    face.resize(corners);
    for (int& v : face) in >> v;
  }
  if (!in) throw std::runtime_error("pair: the text ends early");
  const std::vector<geometry::HostedVertex> no_corners = read_hosted(in);
  Solid solid(points);
  if (!faces.empty())
    solid.topology = std::make_shared<geometry::Topology>(vertex_count, faces, no_corners);
  in >> std::ws;
  if (in.peek() == 'p') {
    std::string word;
    in >> word;
    std::array<double, 12> numbers{};
    for (double& x : numbers) x = read_number(in);
    solid.placed.placement = placement_of(numbers);
  }
  return solid;
}

}  // namespace

bool stands_in_own_frame(const Solid& solid) {
  return solid.placed.placement.linear == Matrix3::Identity() &&
         solid.placed.placement.translation == Vector3::Zero();
}

Shape shape_of(const Solid& solid) {
  return solid.topology ? Shape(solid.topology, solid.placed.points)
                        : geometry::make_hull(solid.placed.points).polyhedron;
}

Shape polyhedron_of(const Solid& solid) {
  const Shape shape = shape_of(solid);
  return stands_in_own_frame(solid) ? shape
                                    : transformed(shape, 1.0, solid.placed.placement.linear,
                                                  solid.placed.placement.translation);
}

SolidPair moved_on(const SolidPair& pair, double amount, Random& random) {
  const Placement& place = pair.b.placed.placement;
  const Vector3 centre =
      place.translation + place.linear * Vector3(pair.b.placed.points.rowwise().mean());
  const Matrix3 turn = rotation_about(random.direction(), amount * random.uniform());
  const Vector3 shift =
      centre - turn * centre + amount * diameter(pair.b) * random.uniform() * random.direction();
  return {pair.family, pair.a, transformed(pair.b, turn, shift)};
}

Shape transformed(const Shape& polyhedron, double scale, const Matrix3& rotation,
                  const Vector3& shift) {
  const Points points = ((scale * rotation) * polyhedron.vertices()).colwise() + shift;
  return {polyhedron.shared_topology(), points};
}

Solid transformed(const Solid& solid, const Matrix3& rotation, const Vector3& shift) {
  Solid moved = solid;
  if (stands_in_own_frame(solid)) {
    moved.placed.points = (rotation * solid.placed.points).colwise() + shift;
  } else {
    Placement& place = moved.placed.placement;
    place.linear = (rotation * solid.placed.placement.linear).eval();
    place.translation = rotation * solid.placed.placement.translation + shift;
  }
  return moved;
}

Solid scaled(const Solid& solid, double power_of_two) {
  Solid result = solid;
  result.placed.points *= power_of_two;
  result.placed.placement.translation *= power_of_two;
  return result;
}

Solid mirrored(const Solid& solid, int axis) {
  Solid result = solid;
  result.placed.points.row(axis) *= -1;
  Placement& place = result.placed.placement;
  place.translation[axis] *= -1;
  place.linear.row(axis) *= -1;
  place.linear.col(axis) *= -1;
  if (solid.topology) {
    std::vector<std::vector<int>> faces;
    for (int f = 0; f < solid.topology->face_count(); ++f)
      faces.emplace_back(solid.topology->face(f).rbegin(), solid.topology->face(f).rend());
    result.topology = std::make_shared<geometry::Topology>(solid.topology->vertex_count(), faces,
                                                           solid.topology->hosted_vertices());
  }
  return result;
}

Shape renumbered(const Shape& polyhedron, Random& random) {
  return shape_of(renumbered(Solid(polyhedron), random));
}

Solid renumbered(const Solid& solid, Random& random) {
  const int count = static_cast<int>(solid.placed.points.cols());
  const std::vector<int> order = shuffled(count, random);
  Solid result(reordered(solid.placed.points, order), solid.placed.placement);
  if (!solid.topology) return result;
  std::vector<std::vector<int>> faces;
  for (int f = solid.topology->face_count() - 1; f >= 0; --f) {
    std::vector<int> face;
    for (int v : solid.topology->face(f)) face.push_back(order[static_cast<std::size_t>(v)]);
    std::rotate(face.begin(), face.begin() + random.integer(0, static_cast<int>(face.size()) - 1),
                face.end());
    faces.push_back(face);
  }
  std::vector<geometry::HostedVertex> no_corners = hosted(*solid.topology, order);
  for (geometry::HostedVertex& at : no_corners)  // the faces come the other way round
    if (at.face >= 0) at.face = solid.topology->face_count() - 1 - at.face;
  result.topology = std::make_shared<geometry::Topology>(count, faces, no_corners);
  return result;
}

std::string rebuild_code(const SolidPair& pair) {
  return "  // family " + pair.family + "\n" + code_of(pair.a, "a") + code_of(pair.b, "b");
}

std::string to_text(const SolidPair& pair) {
  std::ostringstream out;
  out << pair.family << ' ';
  write_solid(out, pair.a);
  write_solid(out, pair.b);
  out << '\n';
  return out.str();
}

SolidPair from_text(const std::string& text) {
  std::istringstream in(text);
  std::string family;
  in >> family;
  Solid a = read_solid(in);
  Solid b = read_solid(in);
  return {family, std::move(a), std::move(b)};
}

double diameter(const Points& points) {
  double squared = 0.0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    squared =
        std::max(squared, (points.colwise() - points.col(i)).colwise().squaredNorm().maxCoeff());
  }
  return std::sqrt(squared);
}

double diameter(const Shape& polyhedron) { return diameter(polyhedron.vertices()); }
double diameter(const Solid& solid) { return diameter(solid.placed.points); }

double largest_coordinate(const Solid& solid) { return solid.placed.points.cwiseAbs().maxCoeff(); }

double largest_world_coordinate(const Solid& solid) {
  const Placement& place = solid.placed.placement;
  const Points points = (place.linear * solid.placed.points).colwise() + place.translation;
  return points.cwiseAbs().maxCoeff();
}

}  // namespace quoin::referee
