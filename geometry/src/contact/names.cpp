#include <array>
#include <quoin/geometry/contact_type.hpp>

namespace quoin::geometry {
namespace {

template <class Kind, std::size_t kCount>
std::string_view pick(const std::array<std::string_view, kCount>& names, Kind kind) {
  const auto place = static_cast<std::size_t>(kind);
  return place < kCount ? names[place] : std::string_view();
}

}  // namespace

std::string_view name(ContactType type) {
  return pick(std::array<std::string_view, 7>{"vertex-vertex", "vertex-edge", "vertex-face",
                                              "edge-edge-crossing", "edge-edge-parallel",
                                              "edge-face", "face-face"},
              type);
}

std::string_view name(FeatureKind kind) {
  return pick(std::array<std::string_view, 3>{"vertex", "edge", "face"}, kind);
}

std::string_view name(PairStatus status) {
  return pick(
      std::array<std::string_view, 4>{"separated", "touching", "overlapping", "not-converged"},
      status);
}

std::string_view name(PlaneRule rule) {
  return pick(std::array<std::string_view, 4>{"unique", "shortest-line", "least-overlap",
                                              "middle-of-planes"},
              rule);
}

}  // namespace quoin::geometry
