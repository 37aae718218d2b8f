/// Pairs of which one solid is a millionth of the other and less: the search in double-double.

#include <quoin/geometry/body.hpp>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/nearest_features.hpp>
#include <vector>

#include "support/catch.hpp"

using namespace quoin::geometry;
using Catch::Matchers::WithinAbs;

namespace {

struct Solid {
  std::vector<std::array<double, 3>> points;
  std::array<double, 12> placement;  ///< linear by rows, translation
};

struct UnevenPair {
  Solid a, b;
  double gap;  ///< by the quadruple precision of other code, m
};

Shape hull_of(const Solid& solid) {
  Points points(3, static_cast<Eigen::Index>(solid.points.size()));
  for (std::size_t v = 0; v < solid.points.size(); ++v)
    points.col(static_cast<Eigen::Index>(v)) = Vector3::Map(solid.points[v].data());
  return make_hull(points).polyhedron;
}

Placement placement_of(const Solid& solid) {
  Placement placement;
  placement.linear =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(solid.placement.data());
  placement.translation = Vector3::Map(solid.placement.data() + 9);
  return placement;
}

// clang-format off
const std::vector<UnevenPair> kPairs{
  {{{{0x1.15b7d14dcfcd3p+0,-0x1.8ccc021422212p-3,0x1.f9dc6ec5d0a19p-1},
      {-0x1.01290cb86b00ap-1,0x1.ce73b83537a3fp-1,-0x1.6e390287f4707p-3},
      {-0x1.02c895b43c944p+0,0x1.e2b3bd7936793p-4,-0x1.a1ff449a0d3b4p+0},
      {0x1.4673ed2531316p-5,0x1.952da2d0fe1afp+0,0x1.85a697ce2069dp+0}},
     {0x1p+0,0x0p+0,0x0p+0,
      0x0p+0,0x1p+0,0x0p+0,
      0x0p+0,0x0p+0,0x1p+0,
      0x0p+0,0x0p+0,0x0p+0}},
    {{{-0x1.2c5707f4dcb28p-39,-0x1.2932b40e08f73p-40,-0x1.f136cdda24138p-39},
      {0x1.412237ff017bfp-39,0x1.9f9f0042e5997p-39,-0x1.0b9a605884cbap-41},
      {-0x1.448a25a8992ep-40,-0x1.76a1df3bc0346p-41,-0x1.254284792e3f3p-41},
      {-0x1.0e8eb7f1c9903p-40,0x1.42981af1c7b26p-43,-0x1.d9d8cff10079fp-41},
      {0x1.375be2ce1083p-44,0x1.4c5416067ec2cp-40,-0x1.28c23a191c8d9p-39},
      {0x1.cd351d956c62bp-39,-0x1.0374540877b1dp-40,-0x1.6e97c978e411ep-41}},
     {-0x1.3aecfb3d9c6ecp-1,0x1.77e2af0d77612p-1,0x1.26746b158af6ep-2,
      -0x1.98be8ecc97f2ap-3,-0x1.fdbf42b52c843p-2,0x1.b022cd28fbefep-1,
      0x1.868aff2f5a90bp-1,0x1.d8d620a94f812p-2,0x1.cf9480ee57cfdp-2,
      -0x1.44ebcbb34a501p-1,0x1.48eafb028afc7p-1,-0x1.018f6fc528b0ep-1}},
    9.9908357162139492e-08},
  {{{{0x0p+0,0x0p+0,0x0p+0},
      {0x0p+0,0x1.970bec11c09b7p+0,0x0p+0},
      {0x1.78807c2325309p+0,0x0p+0,0x0p+0},
      {0x1.78807c2325309p+0,0x1.970bec11c09b7p+0,0x0p+0},
      {0x1.78807c2325309p+0,0x0p+0,0x1.d303191eddd83p-6},
      {0x1.78807c2325309p+0,0x1.970bec11c09b7p+0,0x1.d303191eddd83p-6}},
     {-0x1.feef20ccb53b8p-2,-0x1.ea1aba6281ac4p-2,0x1.71e7c85846acap-1,
      0x1.acb9b0c8d60bep-1,-0x1.eca3fddbae54p-2,0x1.09d1901eb60b7p-2,
      0x1.c962fb17baa24p-3,0x1.780ee2aca497ep-1,0x1.481967d692c44p-1,
      0x0p+0,0x0p+0,0x0p+0}},
    {{{-0x1.e91c3b88fbecbp-40,-0x1.f7fbf227b1c5ap-45,-0x1.5d74b943134aep-33},
      {0x1.e91c3b88fbecbp-40,-0x1.f7fbf227b1c5ap-45,-0x1.5d74b943134aep-33},
      {-0x1.e91c3b88fbecbp-40,0x1.f7fbf227b1c5ap-45,-0x1.5d74b943134aep-33},
      {0x1.e91c3b88fbecbp-40,0x1.f7fbf227b1c5ap-45,-0x1.5d74b943134aep-33},
      {-0x1.e91c3b88fbecbp-40,-0x1.f7fbf227b1c5ap-45,0x1.5d74b943134aep-33},
      {0x1.e91c3b88fbecbp-40,-0x1.f7fbf227b1c5ap-45,0x1.5d74b943134aep-33},
      {-0x1.e91c3b88fbecbp-40,0x1.f7fbf227b1c5ap-45,0x1.5d74b943134aep-33},
      {0x1.e91c3b88fbecbp-40,0x1.f7fbf227b1c5ap-45,0x1.5d74b943134aep-33}},
     {0x1.68ff54681083p-5,0x1.bea136de7cc9ap-1,0x1.f2a017cdd7a89p-2,
      0x1.56d5beb623048p-2,0x1.c90b42191cc5cp-2,-0x1.a8e5b838e09b1p-1,
      -0x1.e1ec9c428c962p-1,0x1.98c673ba82bd7p-3,-0x1.16ec26a5c906ap-2,
      -0x1.16253a7117585p-1,0x1.e325c402d69dfp-1,0x1.0e6e569ec144cp-2}},
    9.999839476763913e-13},
  {{{{0x1.e289ce25f8d48p-1,0x1.565975dbf7184p-2,0x0p+0},
      {-0x1.565975dbf7183p-2,0x1.e289ce25f8d48p-1,0x0p+0},
      {-0x1.e289ce25f8d48p-1,-0x1.565975dbf7182p-2,0x0p+0},
      {0x1.565975dbf7181p-2,-0x1.e289ce25f8d48p-1,0x0p+0},
      {0x1.e289ce25f8d48p-1,0x1.565975dbf7184p-2,0x1.5651707691d8dp-2},
      {-0x1.565975dbf7183p-2,0x1.e289ce25f8d48p-1,0x1.5651707691d8dp-2},
      {-0x1.e289ce25f8d48p-1,-0x1.565975dbf7182p-2,0x1.5651707691d8dp-2},
      {0x1.565975dbf7181p-2,-0x1.e289ce25f8d48p-1,0x1.5651707691d8dp-2}},
     {-0x1.302431644a558p-2,0x1.c126ab41ea283p-1,-0x1.822b8c8d0ba4ap-2,
      -0x1.92427fa0ee431p-1,-0x1.b83755b89p-15,0x1.3cc0360825e7fp-1,
      0x1.15dbe38aceeb8p-1,0x1.eb8edd621ec81p-2,0x1.60e3bd690b6f6p-1,
      0x0p+0,0x0p+0,0x0p+0}},
    {{{-0x1.e6ff220e568edp-30,-0x1.3c37957ad8d42p-33,-0x1.e7744e88e17fap-23},
      {0x1.e6ff220e568edp-30,-0x1.3c37957ad8d42p-33,-0x1.e7744e88e17fap-23},
      {-0x1.e6ff220e568edp-30,0x1.3c37957ad8d42p-33,-0x1.e7744e88e17fap-23},
      {0x1.e6ff220e568edp-30,0x1.3c37957ad8d42p-33,-0x1.e7744e88e17fap-23},
      {-0x1.e6ff220e568edp-30,-0x1.3c37957ad8d42p-33,0x1.e7744e88e17fap-23},
      {0x1.e6ff220e568edp-30,-0x1.3c37957ad8d42p-33,0x1.e7744e88e17fap-23},
      {-0x1.e6ff220e568edp-30,0x1.3c37957ad8d42p-33,0x1.e7744e88e17fap-23},
      {0x1.e6ff220e568edp-30,0x1.3c37957ad8d42p-33,0x1.e7744e88e17fap-23}},
     {0x1.426bc4440211ep-1,-0x1.541c660e8fba1p-1,-0x1.9c5ffd19a7c59p-2,
      0x1.7792ebb8dca6ap-1,0x1.5a00dcf54e36ep-2,0x1.2decc757da1ddp-1,
      -0x1.05c92f036b264p-2,-0x1.5560c7a3dccd8p-1,0x1.666e14d1f8d22p-1,
      0x1.ad278ebfa7dc2p-4,0x1.5c5ab4e762a92p-1,-0x1.1b5414b6c0c23p-1}},
    1.7471683179542319e-11},
};
// clang-format on

}  // namespace

TEST_CASE("A grain beside a boulder is parted from it, and its gap is right") {
  for (const UnevenPair& pair : kPairs) {
    CAPTURE(pair.gap);
    const Shape a = hull_of(pair.a), b = hull_of(pair.b);
    const Body body_a(a, placement_of(pair.a)), body_b(b, placement_of(pair.b));
    for (const bool swapped : {false, true}) {
      const NearestFeatures found =
          swapped ? nearest_features(body_b, body_a) : nearest_features(body_a, body_b);
      CHECK(found.status == PairStatus::Separated);
      const double larger = std::max(a.diameter(), b.diameter());
      CHECK_THAT(found.gap, WithinAbs(pair.gap, 16 * 0x1p-52 * larger + 1e-12 * pair.gap));
    }
  }
}
