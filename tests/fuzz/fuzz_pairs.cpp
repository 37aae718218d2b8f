/// libFuzzer: solids from bytes, or of a family and then moved by bytes; refused or asked, and
/// judged as every pair is. A failure prints the pair as text for tests/regressions and aborts.

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "referee/pairs/families.hpp"
#include "support/check_pair.hpp"

namespace {

using namespace quoin::tests;
using quoin::geometry::Matrix3;
using quoin::geometry::Placement;
using quoin::geometry::Points;
using quoin::geometry::Vector3;

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

Points points_from(Bytes& bytes) {
  const int control = bytes.take<std::uint8_t>();
  const double scale = (control & 4) != 0 ? std::ldexp(1.0, bytes.take<std::int8_t>() % 30) : 1.0;
  Points points(3, 4 + (control >> 3) % 21);
  for (Eigen::Index i = 0; i < points.size(); ++i)
    points.data()[i] = scale * bytes.coordinate(control);
  return points;
}

Matrix3 rotation_from(Bytes& bytes) {
  const Vector3 axis(1, bytes.take<std::int8_t>() / 64.0, bytes.take<std::int8_t>() / 64.0);
  const double angle = std::ldexp(bytes.take<std::int8_t>(), -7 - bytes.take<std::uint8_t>() % 40);
  return quoin::tests::rotation_about(axis.normalized(), angle);
}

Placement placement_from(Bytes& bytes, int control) {
  Placement place;
  if ((control & 2) != 0) place.linear = rotation_from(bytes);
  if ((control & 4) != 0) {
    const double x = bytes.coordinate(control >> 3), y = bytes.coordinate(control >> 3);
    place.translation = {x, y, bytes.coordinate(control >> 3)};
  }
  return place;
}

/// Of any family, B shifted and perhaps turned.
SolidPair family_pair_from(Bytes& bytes) {
  quoin::tests::Random random(bytes.take<std::uint32_t>());
  SolidPair pair = quoin::tests::make_pair(random);
  const Placement place = placement_from(bytes, bytes.take<std::uint8_t>());
  pair.b = transformed(pair.b, place.linear, place.translation);
  return pair;
}

/// B: another solid, or A again, shifted and perhaps turned, by its points or by a placement.
SolidPair pair_from(Bytes& bytes) {
  if ((bytes.take<std::uint8_t>() & 3) == 3) return family_pair_from(bytes);
  const Points a = points_from(bytes);
  const int control = bytes.take<std::uint8_t>();
  const Points b = (control & 1) != 0 ? a : points_from(bytes);
  const Placement place = placement_from(bytes, control);
  if ((control & 32) != 0) return {"fuzz", a, Solid(b, place)};
  return {"fuzz", a, transformed(Solid(b), place.linear, place.translation)};
}

/// Coordinates of which the sums in the checks do not overflow.
bool reasonable(const Solid& solid) {
  return solid.placed.points.allFinite() && solid.placed.placement.translation.allFinite() &&
         largest_coordinate(solid) < 1e9 && largest_world_coordinate(solid) < 1e9;
}

void fail(const SolidPair& pair, const std::vector<Fault>& faults) {
  for (const Fault& fault : faults)
    std::fprintf(stderr, "# %s: %s\n", fault.kind.c_str(), fault.text.c_str());
  std::fprintf(stderr, "%s", to_text(pair).c_str());
  std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  const SolidPair pair = pair_from(bytes);
  if (!reasonable(pair.a) || !reasonable(pair.b)) return 0;
  quoin::tests::Random random(size);
  const quoin::tests::PairVerdict verdict = quoin::tests::check_pair(pair, random);
  if (!verdict.faults.empty()) fail(pair, verdict.faults);
  return 0;
}
