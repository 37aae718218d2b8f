#pragma once

namespace quoin::tests {

/// The program is slowed tenfold or more by a sanitizer, which looks at memory and at each
/// operation: long runs may be cut short, as what they look for is tested without it.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// How many steps or cases.
constexpr int unless_sanitized(int whole, int sanitized) { return kSanitized ? sanitized : whole; }

}  // namespace quoin::tests
