/// libFuzzer: polyhedra from bytes, asked, and every promise checked that needs no reference, then
/// the exact arbiter. A failure prints the pair as text for tests/regressions and aborts.

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <quoin/geometry/build.hpp>

#include "support/check_pair.hpp"

namespace {

using quoin::geometry::make_hull;
using quoin::geometry::Matrix3;
using quoin::geometry::Points;
using quoin::geometry::Polyhedron;
using quoin::geometry::Vector3;
using quoin::tests::Fault;
using quoin::tests::Solid;
using quoin::tests::SolidPair;
using quoin::tests::transformed;

/// Reads numbers off the input; zeros when it ends.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}

  template <class T>
  T take() {
    T value{};
    const std::size_t count = std::min(sizeof value, left_);
    std::memcpy(&value, data_, count);
    data_ += count;
    left_ -= count;
    return value;
  }

  /// A coordinate, m: on a coarse grid, a fine one, almost on the coarse one, or any double.
  double coordinate(int encoding) {
    switch (encoding & 3) {
      case 0:
        return take<std::int8_t>() * 0.25;
      case 1:
        return take<std::int16_t>() * 0x1p-12;
      case 2: {
        const double coarse = take<std::int8_t>() * 0.25;
        return coarse + std::ldexp(take<std::int8_t>(), -8 - take<std::uint8_t>() % 50);
      }
      default:
        return take<double>();
    }
  }

  bool empty() const { return left_ == 0; }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

Polyhedron solid_from(Bytes& bytes) {
  const int control = bytes.take<std::uint8_t>();
  const double scale = (control & 4) != 0 ? std::ldexp(1.0, bytes.take<std::int8_t>() % 30) : 1.0;
  Points points(3, 4 + (control >> 3) % 21);
  for (Eigen::Index i = 0; i < points.size(); ++i) {
    points.data()[i] = scale * bytes.coordinate(control);
  }
  return make_hull(points).polyhedron;
}

/// B: another solid, or A again, shifted and perhaps turned.
SolidPair pair_from(Bytes& bytes) {
  Polyhedron a = solid_from(bytes);
  const int control = bytes.take<std::uint8_t>();
  Polyhedron b = (control & 1) != 0 ? a : solid_from(bytes);
  if ((control & 2) != 0) {
    const Vector3 axis(1, bytes.take<std::int8_t>() / 64.0, bytes.take<std::int8_t>() / 64.0);
    const double angle =
        std::ldexp(bytes.take<std::int8_t>(), -7 - bytes.take<std::uint8_t>() % 40);
    b = transformed(b, 1.0, quoin::tests::rotation_about(axis.normalized(), angle),
                    Vector3::Zero());
  }
  if ((control & 4) != 0) {
    const double x = bytes.coordinate(control >> 3), y = bytes.coordinate(control >> 3);
    b = transformed(b, 1.0, Matrix3::Identity(), {x, y, bytes.coordinate(control >> 3)});
  }
  return {"fuzz", a, b};
}

/// What the library takes as coordinates: set_vertices does not check, build does.
bool reasonable(const Solid& solid) {
  const Points& points = solid.placed.points;
  return points.allFinite() && points.cwiseAbs().maxCoeff() < 1e9;
}

void fail(const SolidPair& pair, const std::vector<Fault>& faults) {
  for (const Fault& fault : faults) {
    std::fprintf(stderr, "# %s: %s\n", fault.kind.c_str(), fault.text.c_str());
  }
  std::fprintf(stderr, "%s", to_text(pair).c_str());
  std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  try {
    const SolidPair pair = pair_from(bytes);
    if (!reasonable(pair.a) || !reasonable(pair.b)) {
      return 0;
    }
    quoin::tests::Random random(size);
    const quoin::tests::PairVerdict verdict = check_pair(pair, random);
    if (!verdict.faults.empty()) {
      fail(pair, verdict.faults);
    }
  } catch (const quoin::geometry::InputError&) {
    // refused on the way in
  }
  return 0;
}
