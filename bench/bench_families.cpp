/// The slowest pairs: `bench_families [PAIRS [SEED]]` asks pairs of every family of the tests,
/// cold, with their contact points, each three times of which the least counts, and large hulls
/// that touch exactly.
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/contact_point.hpp>
#include <string>
#include <vector>

#include "guarded_main.hpp"
#include "referee/pairs/families.hpp"

namespace {

namespace geometry = quoin::geometry;
namespace referee = quoin::referee;
using geometry::Points;
using geometry::Vector3;

/// CPU time of this thread, us.
double thread_microseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

struct Answer {
  double microseconds = 0.0;
  std::size_t points = 0;
};

Answer ask(const geometry::Body& a, const geometry::Body& b) {
  std::vector<geometry::ContactPoint> contacts;
  Answer answer{1e300, 0};
  for (int time = 0; time < 3; ++time) {
    contacts.clear();
    const double start = thread_microseconds();
    append_contacts_within_reach({0, 1}, a, b, {}, {}, contacts);
    answer.microseconds = std::min(answer.microseconds, thread_microseconds() - start);
  }
  answer.points = contacts.size();
  return answer;
}

void ask_family(int family, int pairs, std::uint64_t seed) {
  referee::Random random(seed);
  std::vector<double> times;
  long most_vertices = 0, refused = 0;
  for (int i = 0; i < pairs; ++i) {
    const referee::SolidPair pair = referee::make_pair(family, random);
    try {
      const geometry::Shape a = shape_of(pair.a), b = shape_of(pair.b);
      most_vertices = std::max({most_vertices, static_cast<long>(a.vertices().cols()),
                                static_cast<long>(b.vertices().cols())});
      times.push_back(ask({a, pair.a.placed.placement}, {b, pair.b.placed.placement}).microseconds);
    } catch (const geometry::InputError&) {
      ++refused;
    }
  }
  if (times.empty()) return;
  std::sort(times.begin(), times.end());
  const auto at = [&](double share) {
    return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
  };
  std::printf("| %s | %zu | %ld | %.2f | %.1f | %.1f |\n",
              referee::family_names()[static_cast<std::size_t>(family)].c_str(), times.size(),
              most_vertices, at(0.5), at(0.99), at(1.0));
  if (refused > 0) std::fprintf(stderr, "%ld refused as flat\n", refused);
}

/// `count` vertices spread over the unit sphere, the first at its top.
Points sphere(int count) {
  Points points(3, count);
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - 2.0 * i / (count - 0.5),
                 turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
    points.col(i) =
        Vector3(std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z);
  }
  return points;
}

/// `count` vertices on each of the two ends of a drum of radius 1, curved outwards by `bulge`.
Points drum(int count, double bulge) {
  Points points(3, 2 * count);
  for (int i = 0; i < count; ++i) {
    const double r = std::sqrt((i + 0.5) / count),
                 turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const Vector3 place(r * std::cos(turn), r * std::sin(turn), 1 + bulge * (1 - r * r));
    points.col(2 * i) = place;
    points.col(2 * i + 1) = Vector3(place.x(), place.y(), -place.z());
  }
  return points;
}

/// A prism over a polygon of `count` corners on a circle of radius 1.
Points prism(int count) {
  Points points(3, 2 * count);
  for (int i = 0; i < count; ++i) {
    const double turn = 2 * std::numbers::pi * i / count;
    points.col(2 * i) = Vector3(std::cos(turn), std::sin(turn), 0.25);
    points.col(2 * i + 1) = Vector3(std::cos(turn), std::sin(turn), -0.25);
  }
  return points;
}

/// The unit cube and points in its faces, `count` in all.
Points cube(int count, referee::Random& random) {
  Points points(3, count);
  for (int i = 0; i < count; ++i) {
    const auto coordinate = [&](int axis) {
      return i < 8 ? (i >> axis) & 1 : random.uniform(0, 1);
    };
    points.col(i) = Vector3(coordinate(0), coordinate(1), coordinate(2));
    if (i >= 8) points(i % 3, i) = (i / 3) % 2;
  }
  return points;
}

/// A's top and the bottom of B, its mirror image in the origin, meet after the shift.
void ask_touching(const std::string& name, const Points& points, const Vector3& shift) {
  const geometry::Shape a = geometry::make_hull(points).polyhedron;
  const geometry::Shape b = geometry::make_hull(-points).polyhedron;
  const Answer answer = ask({a}, {b, {.translation = shift}});
  std::printf("| %s | %ld | %.1f | %zu |\n", name.c_str(), static_cast<long>(points.cols()),
              answer.microseconds, answer.points);
}

void ask_all(int pairs, std::uint64_t seed) {
  std::printf(
      "| family | pairs | most vertices | median us | 99 %% | slowest "
      "|\n|---|---|---|---|---|---|\n");
  for (std::size_t family = 0; family < referee::family_names().size(); ++family)
    ask_family(static_cast<int>(family), pairs, seed);
  std::printf("\n| two hulls | vertices each | us | points |\n|---|---|---|---|\n");
  for (const int count : {200, 400}) ask_touching("touch at a vertex", sphere(count), {0, 0, 2});
  referee::Random random(seed);
  ask_touching("cube on cube, points in all faces", cube(214, random), {1.3, 1.2, 2});
  for (const int corners : {64, 246, 400}) {
    ask_touching("prism on prism, " + std::to_string(corners) + " corners", prism(corners),
                 {0.1, 0, 0.5});
  }
  ask_touching("drum on drum, flat ends", drum(107, 0.0), {0.3, 0.2, 2});
  ask_touching("drum on drum, ends curved by 1e-9", drum(1500, 1e-9), {0.3, 0.2, 2});
}

}  // namespace

int main(int argc, char** argv) {
  return quoin::bench::guarded("bench_families", [&] {
    ask_all(argc > 1 ? std::atoi(argv[1]) : 1000,
            argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1);
  });
}
