#pragma once
/// The SIMD layer: loops over many numbers, built once for each instruction set and chosen when the
/// program starts. All of them give the same bits: sums are written out, nothing is contracted.
///
/// Each set has one file here, compiled with its flags (geometry/CMakeLists.txt), from headers that
/// put all they define into unnamed namespaces. So no function of one file can stand for that of
/// another. What the kernels share with the rest of the library – members of Solid, Eigen,
/// the standard library – must be built into the wide ones as a whole, or the linker might keep the
/// copy that was compiled for wide instructions: their entries are `flatten`, or their file has
/// copies of its own (geometry/CMakeLists.txt); tests/consumer/check_kernels.cmake looks into the
/// object files. Internal.

#include <span>

#include "certify/certificate.hpp"
#include "search/nearest_feature_search.hpp"
#include "shape/support.hpp"

namespace quoin::geometry {

/// The functions of the same names in support.hpp, certificate.hpp, corner_features.hpp,
/// nearest_feature_search.hpp, box_sat.hpp and epa.hpp.
struct Kernels {
  const char* name;  ///< of the instruction set
  Support (*support)(const Solid&, const Vector3&);
  void (*find_vertices_beyond)(const Solid&, const Vector3&, double, VertexSet&);
  Support (*find_top)(const Solid&, const Vector3&, const std::array<double, 2>&, VertexSet&,
                      VertexSet&);
  bool (*carried_alone)(const Solid&, const Vector3&, const Carriers&, Support&);
  Trial (*certify)(const Solid&, const Solid&, const Carrier&, const Carrier&, const Lengths&,
                   const Overlap*, NearestFeatures&);
  Trial (*certify_hint)(const Solid&, const Solid&, const FeatureHint&, const Lengths&,
                        NearestFeatures&);
  Trial (*certify_corners)(const Solid&, const Solid&, const Lengths&, NearestFeatures&);
  SearchResult (*nearest_feature_search)(const Solid&, const Solid&, const Vector3&, double);
  SearchResult (*box_sat)(const Solid&, const Solid&, double);
  SearchResult (*expand_polytope)(const Solid&, const Solid&, const SearchResult&, double);
};

extern const Kernels kPlainKernels, kAvx2Kernels;

/// Those that this machine can run, the widest last: that one is used.
std::span<const Kernels* const> runnable_kernels();

}  // namespace quoin::geometry
