/// Families that real data is made of: vertices collinear and coplanar within rounding, exact
/// touch, placements far from the origin. tests/README.md says what each draws and why.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <quoin/geometry/build.hpp>

#include "referee/pairs/cut_cell.hpp"
#include "referee/pairs/families.hpp"

namespace quoin::referee {
namespace {

using geometry::Matrix3;
using geometry::Placement;
using geometry::Points;
using geometry::Vector3;

using std::numbers::pi;

// ---- points -----------------------------------------------------------------------------------

Points box(const Vector3& min, const Vector3& max) { return box_cell(min, max).points(); }

Points centred_box(const Vector3& sides) { return box(-0.5 * sides, 0.5 * sides); }

void add(Points& points, const Vector3& x) {
  points.conservativeResize(3, points.cols() + 1);
  points.col(points.cols() - 1) = x;
}

Points moved(const Points& points, const Matrix3& turn, const Vector3& shift) {
  return (turn * points).colwise() + shift;
}
Points moved(const Points& points, const Vector3& shift) { return points.colwise() + shift; }

/// Corners on a circle, none nearer to the next than a tenth of their mean distance.
Points prism(Random& r, int corners, double radius, double height) {
  Points points(3, 2 * corners);
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * pi * (i + r.uniform(0.1, 0.9)) / corners;
    points.col(i) = Vector3(radius * std::cos(angle), radius * std::sin(angle), -0.5 * height);
    points.col(corners + i) = points.col(i) + Vector3(0, 0, height);
  }
  return points;
}

Points random_hull(Random& r, int count, double size) {
  Points points(3, count);
  for (int i = 0; i < count; ++i) points.col(i) = 0.5 * size * r.uniform(0.7, 1) * r.direction();
  return points;
}

Vector3 random_sides(Random& r) {
  return {r.uniform(0.3, 1), r.uniform(0.3, 1), r.uniform(0.3, 1)};
}

/// `steps` ulps up or down.
double bumped(double x, int steps) {
  for (; steps > 0; --steps) x = std::nextafter(x, INFINITY);
  for (; steps < 0; ++steps) x = std::nextafter(x, -INFINITY);
  return x;
}

/// Multiples of 2^-20: sums and differences of a few of them are exact.
double on_fine_grid(double x) { return std::round(std::ldexp(x, 20)) * 0x1p-20; }

Points on_fine_grid(Points points) {
  return points.unaryExpr([](double x) { return on_fine_grid(x); });
}

// ---- placing ----------------------------------------------------------------------------------

Placement random_placement(Random& r) {
  const double distances[] = {0, 1, 10, 1e3, 1e6};
  return {r.rotation(), distances[r.integer(0, 4)] * r.direction()};
}

/// As laid, turned and rounded, or turned by a placement.
SolidPair as_laid_or_turned(const Points& a, const Points& b, Random& r) {
  if (r.chance(0.34)) return {"", a, b};
  if (r.chance(0.5)) {
    const Matrix3 turn = r.rotation();
    const Vector3 shift = r.chance(0.5) ? Vector3::Zero() : r.point(-10, 10);
    return {"", moved(a, turn, shift), moved(b, turn, shift)};
  }
  const Placement placement = random_placement(r);
  return {"", Solid(a, placement), Solid(b, placement)};
}

/// Often none, else of either sign from an ulp to a thousandth.
double small_gap(Random& r) {
  if (r.chance(0.5)) return 0;
  return (r.chance(0.5) ? 1 : -1) * r.log_uniform(1e-16, 1e-3);
}

// ---- vertices collinear and coplanar within rounding -------------------------------------------

/// Bricks with more vertices on the edges of their beds, where bricks above and below have corners.
SolidPair t_junctions(Random& r) {
  const Vector3 sides(1, 0.5, 0.25);
  const auto brick = [&](double bed) {
    Points points = box(Vector3::Zero(), sides);
    for (int k = r.integer(0, 5); k > 0; --k) {
      const double t = r.chance(0.5) ? 0.5 : r.uniform(0.05, 0.95);
      if (r.chance(0.7))
        add(points, {t * sides.x(), r.chance(0.5) ? 0.0 : sides.y(), bed});
      else
        add(points, {r.chance(0.5) ? 0.0 : sides.x(), t * sides.y(), bed});
    }
    return points;
  };
  const double steps[] = {0, 0.25, 0.5, 0.75};
  const Vector3 shift(steps[r.integer(0, 3)], r.chance(0.5) ? 0.0 : 0.25, sides.z() + small_gap(r));
  return as_laid_or_turned(brick(sides.z()), moved(brick(0), shift), r);
}

/// One more vertex on an edge, in a face, or nearly.
SolidPair points_on_edges(Random& r) {
  const auto solid = [&] {
    Points points = random_hull(r, r.integer(4, 6), 1);
    for (int k = r.integer(1, 2); k > 0; --k) {
      const Vector3 p = points.col(0), q = points.col(1), s = points.col(2);
      const double t = r.uniform(0.1, 0.9), u = r.chance(0.5) ? 0.0 : r.uniform(0, 1 - t);
      add(points, p + t * (q - p) + u * (s - p));
    }
    return points;
  };
  const Points a = solid(), b = solid();
  const Vector3 n = r.direction();
  const double lift = (n.transpose() * a).maxCoeff() - (n.transpose() * b).minCoeff();
  return as_laid_or_turned(a, moved(b, (lift + small_gap(r)) * n), r);
}

/// A vertex given twice or more.
SolidPair repeated_points(Random& r) {
  Points a = centred_box(random_sides(r)), b = centred_box(random_sides(r));
  for (int k = r.integer(1, 4); k > 0; --k) {
    Points& points = r.chance(0.5) ? a : b;
    add(points, Vector3(points.col(r.integer(0, 7))));
  }
  const double lift = a.row(2).maxCoeff() - b.row(2).minCoeff() + small_gap(r);
  return as_laid_or_turned(a, moved(b, {r.uniform(-0.2, 0.2), r.uniform(-0.2, 0.2), lift}), r);
}

struct Cut {
  Vector3 normal;
  double offset;
};

/// Through three vertices, two, one or none, as joints and tools run.
Cut random_cut(const Cell& cell, Random& r) {
  const auto vertex = [&]() -> const Vector3& {
    return cell.vertices[static_cast<std::size_t>(
        r.integer(0, static_cast<int>(cell.vertices.size()) - 1))];
  };
  Vector3 middle = Vector3::Zero();
  for (const Vector3& x : cell.vertices) middle += x / static_cast<double>(cell.vertices.size());
  const int through = r.integer(0, 3);
  const Vector3 p = through > 0 ? vertex() : middle + 0.2 * r.point(-1, 1);
  const Vector3 q = through > 1 ? vertex() : p + r.direction();
  const Vector3 s = through > 2 ? vertex() : middle + 0.1 * r.point(-1, 1);
  const Vector3 n = (q - p).cross(s - p);
  if (n.norm() < 1e-3 * (q - p).norm() * (s - p).norm() || n.norm() == 0) {
    const Vector3 any = r.direction();
    return {any, any.dot(middle)};
  }
  return {n.normalized(), n.normalized().dot(p)};
}

double thickness_along(const Cell& cell, const Cut& plane) {
  double low = INFINITY, high = -INFINITY;
  for (const Vector3& x : cell.vertices) {
    low = std::min(low, plane.normal.dot(x) - plane.offset);
    high = std::max(high, plane.normal.dot(x) - plane.offset);
  }
  return std::min(-low, high);
}

/// How many vertices lie on the plane.
int vertices_on(const Cell& cell, const Cut& plane) {
  int count = 0;
  for (const Vector3& x : cell.vertices)
    count += std::abs(plane.normal.dot(x) - plane.offset) < 1e-9 ? 1 : 0;
  return count;
}

/// Cuts a cell further; the part that keeps most of the first cut stays.
Cell cut_further(Cell cell, const Cut& first, int cuts, Random& r) {
  for (; cuts > 0; --cuts) {
    const Cut plane = random_cut(cell, r);
    const double snap = r.chance(0.5) ? 0 : 1e-12;
    const Cell low = cut(cell, plane.normal, plane.offset, snap);
    const Cell high = cut(cell, -plane.normal, -plane.offset, snap);
    if (thickness_along(cell, plane) < 1e-3) continue;
    cell = vertices_on(low, first) >= vertices_on(high, first) ? low : high;
  }
  return cell;
}

/// The two parts of a box cut once, each cut further: 1 to 8 cuts in all.
SolidPair cut_boxes(Random& r) {
  for (;;) {
    const Cell whole = box_cell(Vector3::Constant(-0.5), Vector3::Constant(0.5));
    const Cut first = random_cut(whole, r);
    if (thickness_along(whole, first) < 1e-2) continue;
    const Cell below = cut(whole, first.normal, first.offset, 0);
    const Cell above = cut(whole, -first.normal, -first.offset, 0);
    const int more = r.integer(0, 7), of_these = r.integer(0, more);
    return as_laid_or_turned(cut_further(below, first, of_these, r).points(),
                             cut_further(above, first, more - of_these, r).points(), r);
  }
}

SolidPair voronoi(Random& r) {
  const double jitters[] = {0, 1e-15, 1e-12, 1e-8};
  const double snap = r.chance(0.5) ? 0 : 1e-12;
  for (;;) {
    const std::array<Cell, 2> cells = r.chance(0.25)
                                          ? random_voronoi_cells(snap, r)
                                          : voronoi_cells(jitters[r.integer(0, 3)], snap, r);
    if (cells[0].vertices.size() >= 4 && cells[1].vertices.size() >= 4)
      return as_laid_or_turned(cells[0].points(), cells[1].points(), r);
  }
}

/// Flush boxes with a grid of vertices in the faces that meet, each off by up to three ulps.
SolidPair bumpy_faces(Random& r) {
  const auto solid = [&](double bed, double height) {
    Points points = box({0, 0, bed}, {1, 1, bed + height});
    const int cells = r.integer(1, 4);
    for (int i = 0; i <= cells; ++i) {
      for (int j = 0; j <= cells; ++j)
        if ((i % cells != 0 || j % cells != 0) && r.chance(0.8))
          add(points, {i / static_cast<double>(cells), j / static_cast<double>(cells),
                       bumped(bed, r.integer(-3, 3))});
    }
    for (Eigen::Index v = 0; v < points.cols(); ++v)
      if (points(2, v) == bed) points(2, v) = bumped(bed, r.integer(-3, 3));
    return points;
  };
  const Vector3 shift(r.chance(0.5) ? 0.0 : 0.25 * r.integer(-3, 3), 0.25 * r.integer(0, 3),
                      small_gap(r));
  return as_laid_or_turned(solid(1, -0.7), moved(solid(1, 0.6), shift), r);
}

/// Prisms whose outline holds arcs of corners that are collinear but for 1e-16 to 1e-6.
SolidPair nearly_collinear_arcs(Random& r) {
  const auto solid = [&](double low, double high) {
    const int corners = r.integer(3, 30);
    const double sag = r.chance(0.2) ? 0 : r.log_uniform(1e-16, 1e-6), width = r.uniform(0.5, 1);
    Points points(3, 0);
    for (const double z : {low, high}) {
      add(points, {0, 0, z});
      add(points, {1, 0, z});
      for (int k = 0; k < corners; ++k) {
        const double t = k / (corners - 1.0);
        add(points, {t, width + 4 * sag * t * (1 - t), z});
      }
    }
    return points;
  };
  const Vector3 shift(r.uniform(-0.5, 0.5), r.uniform(-0.5, 0.5), small_gap(r));
  const Matrix3 turn = rotation_about(Vector3::UnitZ(), 0.5 * pi * r.integer(0, 3));
  return as_laid_or_turned(solid(-0.3, 0), moved(solid(0, 0.4), turn, shift), r);
}

/// Faces that tilt, and edges that turn, by about as much as tol allows.
SolidPair tilts_about_tolerance(Random& r) {
  const double factor = r.chance(0.2) ? 1 : r.log_uniform(0.3, 3);
  const bool edges = r.chance(0.4);
  const Matrix3 roof = edges ? rotation_about(Vector3::UnitX(), pi / 4) : Matrix3::Identity();
  const Points lower = moved(centred_box(random_sides(r)), roof, Vector3::Zero());
  Points upper = moved(centred_box(random_sides(r)), roof, Vector3::Zero());
  const double tolerance = 1e-9 * std::min(diameter(lower), diameter(upper));
  const double extent = upper.row(0).maxCoeff() - upper.row(0).minCoeff();
  const double heading = r.chance(0.5) ? 0.5 * pi : r.uniform(0, pi);
  const Vector3 axis =
      edges ? Vector3(Vector3::UnitZ()) : Vector3(std::cos(heading), std::sin(heading), 0);
  upper = moved(upper, rotation_about(axis, factor * tolerance / extent), Vector3::Zero());
  const double gap = r.chance(0.3) ? factor * tolerance * (r.chance(0.5) ? 1 : -1) : small_gap(r);
  const double lift = lower.row(2).maxCoeff() - upper.row(2).minCoeff() + gap;
  const double aside = edges ? 0.0 : r.uniform(-0.2, 0.2);
  return as_laid_or_turned(lower, moved(upper, {r.uniform(-0.2, 0.2), aside, lift}), r);
}

Points in_single_precision(const Points& points) { return points.cast<float>().cast<double>(); }

/// Vertices that went through single precision, as meshes do.
SolidPair single_precision(Random& r) {
  const Points a =
      r.chance(0.5) ? centred_box(random_sides(r)) : prism(r, r.integer(3, 24), 0.5, 0.6);
  const Points b =
      r.chance(0.5) ? centred_box(random_sides(r)) : prism(r, r.integer(3, 24), 0.4, 0.5);
  const double lift = a.row(2).maxCoeff() - b.row(2).minCoeff() + small_gap(r);
  const Matrix3 turn = r.chance(0.3) ? Matrix3(Matrix3::Identity()) : r.rotation();
  const Vector3 aside(r.uniform(-0.2, 0.2), r.uniform(-0.2, 0.2), lift);
  const Points lower = in_single_precision(moved(a, turn, Vector3::Zero()));
  const Points upper = in_single_precision(moved(moved(b, aside), turn, Vector3::Zero()));
  return {"", lower, upper};
}

/// Coordinates of 1e15, where an ulp is 0.125: shapes of some thousand ulps.
SolidPair quadrillions(Random& r) {
  const auto rounded = [](const Points& points) {
    return Points(points.unaryExpr([](double x) { return 1e15 + 0.125 * std::round(8 * x); }));
  };
  const double size = r.log_uniform(100, 1e4);
  const Matrix3 turn = r.chance(0.4) ? Matrix3(Matrix3::Identity()) : r.rotation();
  const Points a = size * centred_box(random_sides(r)), b = size * centred_box(random_sides(r));
  const double lift = a.row(2).maxCoeff() - b.row(2).minCoeff() + size * small_gap(r);
  const Vector3 shift(size * r.uniform(-0.2, 0.2), size * r.uniform(-0.2, 0.2), lift);
  return {"", rounded(moved(a, turn, Vector3::Zero())), rounded(turn * moved(b, shift))};
}

// ---- sizes ------------------------------------------------------------------------------------

/// One solid up to 1e12 times as large as the other, on its face, edge or corner.
SolidPair size_ratios(Random& r) {
  const Points large =
      r.chance(0.5) ? centred_box(random_sides(r)) : random_hull(r, r.integer(4, 12), 1);
  const double share = r.log_uniform(1e-12, 1e-3);
  const Points small =
      share * (r.chance(0.5) ? centred_box(random_sides(r)) : random_hull(r, r.integer(4, 12), 1));
  const Vector3 n = r.chance(0.5) ? Vector3(Vector3::UnitZ()) : r.direction();
  Eigen::Index top = 0, bottom = 0;
  (n.transpose() * large).maxCoeff(&top);
  (n.transpose() * small).minCoeff(&bottom);
  // near the origin the small one keeps its digits: the large one is moved there
  const Vector3 place = large.col(top) + r.uniform(-0.3, 0.3) * (large.col(0) - large.col(top));
  const double height = (n.transpose() * large).maxCoeff() - n.dot(place);
  const Vector3 shift = -place - height * n;
  const Vector3 lift = -n.dot(Vector3(small.col(bottom))) * n + share * small_gap(r) * n;
  return r.chance(0.5) ? SolidPair{"", moved(large, shift), moved(small, lift)}
                       : SolidPair{"", moved(small, lift), moved(large, shift)};
}

/// Plates and needles in shallow contact at any angle.
SolidPair thin_on_thin(Random& r) {
  const auto thin = [&] {
    const double share = r.log_uniform(1e-3, 0.05);
    return r.chance(0.7) ? Vector3(r.uniform(0.3, 1), r.uniform(0.3, 1), share)
                         : Vector3(r.uniform(0.3, 1), share, share * r.uniform(0.5, 2));
  };
  const Matrix3 turn =
      r.chance(0.5) ? r.rotation() : rotation_about(r.direction(), r.log_uniform(1e-6, 0.1));
  const Points a = centred_box(thin()), b = moved(centred_box(thin()), turn, Vector3::Zero());
  const Vector3 n = r.chance(0.5) ? Vector3(Vector3::UnitZ()) : r.direction();
  const double gap = (r.chance(0.5) ? -1 : 1) * r.log_uniform(1e-9, 1e-3);
  const double lift = (n.transpose() * a).maxCoeff() - (n.transpose() * b).minCoeff() + gap;
  const Vector3 shift = lift * n + 0.2 * (Matrix3::Identity() - n * n.transpose()) * r.point(-1, 1);
  return {"", a, moved(b, shift)};
}

/// A solid of 1 m rests on, or sinks into, a ground of up to 2e4 m.
SolidPair on_huge_ground(Random& r) {
  const double half = r.log_uniform(100, 1e4);
  const Points ground = box({-half, -half, -r.uniform(1, 100)}, {half, half, 0});
  Points solid = r.chance(0.5) ? centred_box(random_sides(r))
                               : prism(r, r.integer(3, 12), 0.5, r.uniform(0.2, 1));
  const double tilt = r.chance(0.5) ? 0 : r.log_uniform(1e-12, 1e-2);
  solid = moved(solid, rotation_about(r.direction(), tilt), Vector3::Zero());
  const double lift = -solid.row(2).minCoeff() + small_gap(r);
  const Placement place{
      rotation_about(Vector3::UnitZ(), r.uniform(0, 6)),
      Vector3(0.5 * half * r.uniform(-1, 1), 0.5 * half * r.uniform(-1, 1), lift)};
  return {"", ground, Solid(solid, place)};
}

// ---- bricks' faces on solids that are no bricks -------------------------------------------------

/// A hexahedron with the faces of a brick, of which two are parallel: a stone of an arch. All six
/// are plane, exactly.
Points frustum(Random& r) {
  const auto share = [&] {
    return r.chance(0.3) ? 0 : r.chance(0.5) ? r.uniform(0, 0.6) : r.log_uniform(1e-16, 1e-2);
  };
  const auto aside = [&] { return r.chance(0.5) ? 0 : r.uniform(-0.3, 0.3); };
  Points points = centred_box(random_sides(r));
  const double taper_x = share(), taper_y = share(), aside_x = aside(), aside_y = aside();
  for (Eigen::Index v = 4; v < 8; ++v)
    points.col(v) += Vector3(aside_x - taper_x * points(0, v), aside_y - taper_y * points(1, v), 0);
  return points;
}

/// A frustum with one face on top: of the two that are parallel, exactly, or one that leans.
Points face_up(const Points& frustum, Random& r) {
  const Matrix3 over = Vector3(-1, 1, -1).asDiagonal();
  if (r.chance(0.6)) return r.chance(0.5) ? frustum : Points(over * frustum);
  const int axis = r.integer(0, 1), first = axis == 0 ? 1 : 2;  // the face across it, ahead
  const Vector3 along = frustum.col(3) - frustum.col(first), up = frustum.col(7) - frustum.col(3);
  const Vector3 normal = along.cross(up).normalized() * (axis == 0 ? 1 : -1);
  const Vector3 across = normal.cross(Vector3::UnitZ());
  const double sine = across.norm();
  return moved(frustum, rotation_about(across / sine, std::atan2(sine, normal.z())),
               Vector3::Zero());
}

/// Two of them face to face, leaning on each other by nothing or little, by their points or by
/// their faces.
SolidPair frusta(Random& r) {
  const Matrix3 over = Vector3(-1, 1, -1).asDiagonal();
  const Points a = face_up(r.chance(0.8) ? frustum(r) : centred_box(random_sides(r)), r);
  const double heading = r.chance(0.5) ? 0 : r.uniform(0, 2 * pi);
  const double lean = r.chance(0.5) ? 0 : r.log_uniform(1e-16, 1e-2);
  const Matrix3 turn =
      rotation_about(r.direction(), lean) * rotation_about(Vector3::UnitZ(), heading);
  const Points b = moved(face_up(frustum(r), r), turn * over, Vector3::Zero());
  const double gap = r.chance(0.2) ? -r.log_uniform(1e-3, 0.2) : small_gap(r);
  const double lift = a.row(2).maxCoeff() - b.row(2).minCoeff() + gap;
  const auto aside = [&] { return r.chance(0.3) ? 0 : r.uniform(-0.3, 0.3); };
  const Vector3 shift(aside(), aside(), lift);
  SolidPair pair = as_laid_or_turned(a, moved(b, shift), r);
  const auto faces = geometry::make_box(-Vector3::Ones(), Vector3::Ones()).shared_topology();
  for (Solid* solid : {&pair.a, &pair.b})
    if (r.chance(0.5)) solid->topology = faces;
  return pair;
}

// ---- exact touch and parallels ----------------------------------------------------------------

/// A quarter turn as CAD and planners write it: entries that should be 0 are not quite.
Matrix3 sloppy_quarter_turn(Random& r) {
  const double noise = r.chance(0.3) ? 6.123233995736766e-17 : r.log_uniform(1e-17, 1e-8);
  return rotation_about(Vector3::UnitY(), 0.5 * pi + noise);
}

/// Two prisms between the same two planes, side by side or into each other.
SolidPair coplanar_caps(Random& r) {
  const double height = r.uniform(0.3, 1);
  const Points a = prism(r, r.integer(3, 8), 0.6, height),
               b = prism(r, r.integer(3, 8), 0.6, height);
  const double angle = r.uniform(0, 2 * pi);
  const Vector3 n(std::cos(angle), std::sin(angle), 0);
  const double lift = (n.transpose() * a).maxCoeff() - (n.transpose() * b).minCoeff();
  const double gap = r.chance(0.5) ? -r.log_uniform(1e-6, 0.3) : small_gap(r);
  const Points beside = moved(b, (lift + gap) * n);
  if (r.chance(0.4)) return {"", a, beside};
  const Matrix3 turn = sloppy_quarter_turn(r);
  const Vector3 shift = r.chance(0.5) ? Vector3::Zero() : r.point(-10, 10);
  // one by its placement, the other by its points: the planes coincide but for rounding
  return {"", Solid(a, {turn, shift}), moved(beside, turn, shift)};
}

/// The same rotation, whole faces on each other, apart by 0 or a few ulps.
SolidPair face_kiss(Random& r) {
  const double lengths[] = {0.01, 0.25, 0.5, 10, 1000};
  const double side = lengths[r.integer(0, 4)];
  const double distances[] = {0, 1e-15, -1e-15, 2.5e-16, -2.5e-16, 1e-16, -1e-16};
  const double gap = distances[r.integer(0, 6)] * std::max(1.0, side);
  const Matrix3 turn = r.rotation();
  const Vector3 start = r.chance(0.5) ? Vector3(0, 0, 5 * side) : r.point(-2, 2);
  Vector3 step = Vector3::Zero();
  step[r.integer(0, 2)] = side + gap;
  const Points cube = centred_box(Vector3::Constant(side));
  return {"", Solid(cube, {turn, start}), Solid(cube, {turn, start + turn * step})};
}

/// Stacks nearly aligned: turned against each other by 1e-9 to 1e-2 rad, with noise of 1e-16 to
/// 1e-9.
SolidPair near_aligned_stacks(Random& r) {
  const Vector3 sides = r.chance(0.5) ? Vector3::Constant(0.1) : random_sides(r);
  const auto noisy = [&](Points points) {
    const double noise = r.chance(0.5) ? 0 : r.log_uniform(1e-16, 1e-9);
    for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] += noise * r.uniform(-1, 1);
    return points;
  };
  const Points cube = centred_box(sides);
  const double gap = r.chance(0.5) ? -1e-5 : small_gap(r);
  const Vector3 axis = r.chance(0.3) ? Vector3(1, 0.5, 3).normalized() : r.direction();
  const Placement above{rotation_about(axis, r.log_uniform(1e-9, 1e-2)),
                        Vector3(r.chance(0.5) ? 0.0 : 0.3 * sides.x(), 0, sides.z() + gap)};
  return {"", Solid(noisy(cube), Placement{}), Solid(noisy(cube), above)};
}

/// One box within the slab between two faces of the other, deep inside it.
SolidPair within_slab(Random& r) {
  const Vector3 wide(r.uniform(1, 4), r.uniform(1, 4), r.uniform(0.3, 1));
  const Vector3 flat = wide.cwiseProduct(Vector3(r.uniform(0.2, 1), r.uniform(0.2, 1), 0.1));
  const Vector3 shift(r.uniform(-0.5, 0.5) * wide.x(), r.uniform(-0.5, 0.5) * wide.y(),
                      r.chance(0.3) ? 0.0 : r.uniform(-0.4, 0.4) * wide.z());
  const Placement place{r.chance(0.5) ? Matrix3(Matrix3::Identity()) : sloppy_quarter_turn(r),
                        shift};
  return {"", centred_box(wide), Solid(centred_box(flat), place)};
}

/// Tetrahedra, or hulls of more, that share a corner, an edge or a face to the bit.
SolidPair shared_simplices(Random& r) {
  for (;;) {
    const int shared = r.integer(1, 3);
    Points a(3, 0), b(3, 0);
    const Vector3 n = r.direction();
    const bool in_plane = r.chance(0.3);  // the plane z = 0 exactly parts them
    for (int k = 0; k < shared; ++k) {
      Vector3 x = r.point(-0.5, 0.5);
      if (in_plane) x.z() = 0;
      add(a, x);
      add(b, x);
    }
    const Vector3 up = in_plane || shared < 3
                           ? (in_plane ? Vector3(Vector3::UnitZ()) : n)
                           : Vector3((a.col(1) - a.col(0)).cross(a.col(2) - a.col(0)).normalized());
    const Vector3 base = a.rowwise().mean();
    for (int side = 0; side < 2; ++side) {
      Points& points = side == 0 ? a : b;
      for (int k = 4 - shared + r.integer(0, 4); k > 0; --k) {
        Vector3 x = base + r.point(-0.6, 0.6);
        const double above = up.dot(x - base);
        x += (side == 0 ? -std::abs(above) - 0.05 - above : std::abs(above) + 0.05 - above) * up;
        add(points, x);
      }
    }
    if (a.cols() >= 4 && b.cols() >= 4) return as_laid_or_turned(a, b, r);
  }
}

/// A solid and its point reflection in one of its corners, in the middle of an edge, or shifted
/// along all three axes: they touch there alone, exactly.
SolidPair exact_touch(Random& r) {
  if (r.chance(0.5)) {
    const Points a = on_fine_grid(centred_box(random_sides(r)));
    Points b = on_fine_grid(centred_box(random_sides(r)));
    const Eigen::Vector3i touch(r.integer(0, 1), r.integer(0, 1), 1);
    for (int k = 0; k < 3; ++k) {
      const double step = touch[k] != 0 ? a.row(k).maxCoeff() - b.row(k).minCoeff()
                                        : on_fine_grid(r.uniform(-0.3, 0.3));
      b.row(k).array() += step;
    }
    return as_laid_or_turned(a, b, r);
  }
  const Points a = on_fine_grid(random_hull(r, r.integer(4, 40), 1));
  const Vector3 n = r.direction();
  Eigen::Index top = 0;
  (n.transpose() * a).maxCoeff(&top);
  const Vector3 corner = a.col(top);
  const Points b = (-a).colwise() + 2 * corner;
  return as_laid_or_turned(a, b, r);
}

/// One shape twice, flush or nearly, turned, at the origin, 1 km and 1000 km off; or deformed.
SolidPair placements(Random& r) {
  const double distances[] = {0, 1e3, 1e6};
  const Vector3 sides = random_sides(r);
  const Points shape =
      r.chance(0.5) ? centred_box(sides) : prism(r, r.integer(3, 12), 0.5, sides.z());
  Placement lower{r.rotation(), distances[r.integer(0, 2)] * r.direction()};
  if (r.chance(0.3)) {  // a deforming block: R (I + eps)
    Matrix3 strain = Matrix3::Zero();
    for (int k = 0; k < 3; ++k) strain(k, k) = r.uniform(-1e-3, 1e-3);
    strain(0, 1) = strain(1, 0) = r.uniform(-1e-3, 1e-3);
    lower.linear = (lower.linear * (Matrix3::Identity() + strain)).eval();
  }
  const Matrix3 spin = rotation_about(Vector3::UnitZ(), r.chance(0.5) ? 0 : r.uniform(0, 6));
  Placement upper = lower;
  upper.linear = (lower.linear * spin).eval();
  const Vector3 step(r.uniform(-0.2, 0.2), r.uniform(-0.2, 0.2), sides.z() + small_gap(r));
  upper.translation += lower.linear * step;
  return {"", Solid(shape, lower), Solid(shape, upper)};
}

const Family kHardFamilies[] = {{"t_junctions", t_junctions, 60},
                                {"points_on_edges", points_on_edges, 40},
                                {"repeated_points", repeated_points, 20},
                                {"cut_boxes", cut_boxes, 60},
                                {"voronoi", voronoi, 40},
                                {"bumpy_faces", bumpy_faces, 40},
                                {"nearly_collinear_arcs", nearly_collinear_arcs, 20},
                                {"tilts_about_tolerance", tilts_about_tolerance, 60},
                                {"single_precision", single_precision, 40},
                                {"quadrillions", quadrillions, 40},
                                {"size_ratios", size_ratios, 40},
                                {"thin_on_thin", thin_on_thin, 40},
                                {"on_huge_ground", on_huge_ground, 40},
                                {"coplanar_caps", coplanar_caps, 40},
                                {"face_kiss", face_kiss, 40},
                                {"near_aligned_stacks", near_aligned_stacks, 40},
                                {"within_slab", within_slab, 40},
                                {"shared_simplices", shared_simplices, 40},
                                {"exact_touch", exact_touch, 40},
                                {"placements", placements, 60},
                                {"frusta", frusta, 60}};

}  // namespace

std::span<const Family> hard_families() { return kHardFamilies; }

}  // namespace quoin::referee
