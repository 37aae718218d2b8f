#pragma once
/// Catch2 2.13 or 3, whichever is installed. Compare by WithinAbs and WithinRel.

#if __has_include(<catch2/catch_test_macros.hpp>)
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
namespace quoin::tests {
using Catch::Matchers::ContainsSubstring;
}
#else
#include <catch2/catch.hpp>
namespace quoin::tests {
inline auto ContainsSubstring(const std::string& text) { return Catch::Matchers::Contains(text); }
}  // namespace quoin::tests
#endif

namespace quoin::tests {
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
}  // namespace quoin::tests
