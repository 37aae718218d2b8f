#pragma once
/// What was found to be wrong with an answer.

#include <ostream>
#include <sstream>
#include <string>
#include <vector>

namespace quoin::referee {

/// Something that does not hold. Kinds are counted; the text has the numbers.
struct Fault {
  std::string kind, text;
};
inline std::ostream& operator<<(std::ostream& out, const Fault& fault) {
  return out << fault.kind << ": " << fault.text;
}

class Faults {
 public:
  template <class... Parts>
  void expect(bool holds, const char* kind, const Parts&... parts) {
    if (!holds) {
      std::ostringstream out;
      out.precision(17);
      (out << ... << parts);
      list.push_back({kind, out.str()});
    }
  }
  std::vector<Fault> list;
};

}  // namespace quoin::referee
