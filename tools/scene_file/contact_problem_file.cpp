#include "scene_file/contact_problem_file.hpp"

#include <charconv>
#include <cmath>
#include <istream>
#include <ostream>

namespace quoin::scene_file {
namespace {

using solver::ContactProblem;

constexpr const char* kTitle = "quoin contact problem 1";

/// The shortest text that is read back to the same bits.
std::string text_of(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

template <typename Values>
void put_all(std::ostream& out, const char* word, const Values& values) {
  out << word;
  for (const double value : values.reshaped()) out << ' ' << text_of(value);
  out << '\n';
}

/// Reads word by word and says in which one of which object something is wrong.
class ProblemReader {
 public:
  explicit ProblemReader(std::istream& in) : in_(in) {}

  void at(const char* object, int number) {
    place_ = std::string(object) + " " + std::to_string(number) + ": ";
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw solver::InputError("contact problem: " + place_ + what);
  }
  void expect(const char* wanted) {
    std::string word;
    if (!(in_ >> word) || word != wanted) fail("'" + std::string(wanted) + "' is missing");
  }
  double number() {
    std::string word;
    double value = 0.0;
    in_ >> word;
    const char* end = word.data() + word.size();
    const std::from_chars_result result = std::from_chars(word.data(), end, value);
    if (word.empty() || result.ptr != end || result.ec != std::errc() || !std::isfinite(value))
      fail("'" + word + "' is no finite number");
    return value;
  }
  int integer(int low, int high) {
    const double value = number();
    if (value != std::floor(value) || value < low || value > high) {
      fail("a whole number from " + std::to_string(low) + " to " + std::to_string(high) +
           " is expected, not " + std::to_string(value));
    }
    return static_cast<int>(value);
  }
  template <typename Values>
  void take_all(const char* word, Values& values) {
    expect(word);
    for (double& value : values.reshaped()) value = number();
  }

 private:
  std::istream& in_;
  std::string place_;
};

ContactProblem::Block read_block(ProblemReader& reader) {
  ContactProblem::Block block;
  const int unknowns = reader.integer(6, 12);
  if (unknowns != 6 && unknowns != 12) reader.fail("6 or 12 unknowns are expected");
  block.length = reader.number();
  block.matrix.resize(unknowns, unknowns);
  block.force.resize(unknowns);
  block.guess.resize(unknowns);
  reader.take_all("M", block.matrix);
  reader.take_all("f", block.force);
  reader.take_all("v", block.guess);
  return block;
}

ContactProblem::Contact read_contact(ProblemReader& reader, const ContactProblem& problem) {
  ContactProblem::Contact contact;
  const int last = static_cast<int>(problem.blocks.size()) - 1;
  contact.a = reader.integer(-1, last);
  contact.b = reader.integer(-1, last);
  contact.friction = reader.number();
  reader.take_all("w", contact.offset);
  reader.take_all("r", contact.force);
  const auto take_rows = [&](const char* word, int block, ContactProblem::Matrix& rows) {
    if (block < 0) return;
    rows.resize(3, problem.blocks[static_cast<std::size_t>(block)].force.size());
    reader.take_all(word, rows);
  };
  take_rows("Ha", contact.a, contact.rows_a);
  take_rows("Hb", contact.b, contact.rows_b);
  return contact;
}

}  // namespace

void write(std::ostream& out, const ContactProblem& problem) {
  out << kTitle << "\nblocks " << problem.blocks.size() << '\n';
  for (const ContactProblem::Block& block : problem.blocks) {
    out << block.force.size() << ' ' << text_of(block.length) << '\n';
    put_all(out, "M", block.matrix);
    put_all(out, "f", block.force);
    put_all(out, "v", block.guess);
  }
  out << "contacts " << problem.contacts.size() << '\n';
  for (const ContactProblem::Contact& contact : problem.contacts) {
    out << contact.a << ' ' << contact.b << ' ' << text_of(contact.friction) << '\n';
    put_all(out, "w", contact.offset);
    put_all(out, "r", contact.force);
    if (contact.a >= 0) put_all(out, "Ha", contact.rows_a);
    if (contact.b >= 0) put_all(out, "Hb", contact.rows_b);
  }
}

ContactProblem read_contact_problem(std::istream& in) {
  constexpr int kMost = 1000000;
  ContactProblem problem;
  ProblemReader reader(in);
  std::string title;
  std::getline(in, title);
  if (title != kTitle) reader.fail("the first line must be '" + std::string(kTitle) + "'");
  reader.expect("blocks");
  const int blocks = reader.integer(0, kMost);
  for (int i = 0; i < blocks; ++i) {
    reader.at("block", i);
    problem.blocks.push_back(read_block(reader));
  }
  reader.expect("contacts");
  const int contacts = reader.integer(0, kMost);
  for (int i = 0; i < contacts; ++i) {
    reader.at("contact", i);
    problem.contacts.push_back(read_contact(reader, problem));
  }
  return problem;
}

}  // namespace quoin::scene_file
