#pragma once
/// What a refusal says.

#include <quoin/geometry/types.hpp>
#include <string>

namespace quoin::tests {

/// What the Error says that `call` throws; empty: it throws none.
template <class Error = geometry::InputError>
std::string message(const auto& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace quoin::tests
