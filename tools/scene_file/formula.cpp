#include "scene_file/formula.hpp"

#include <muParser.h>

#include <algorithm>
#include <numbers>
#include <stdexcept>

#include "scene_file/printable.hpp"

namespace quoin::scene_file {

struct Formula::Parsed {
  Parsed(const std::string& expression, const Parameters& parameters, Clock clock) {
    parser.DefineConst("pi", std::numbers::pi);
    parser.DefineConst("deg", std::numbers::pi / 180);
    parser.DefineConst("g", 9.81);
    for (const auto& [name, value] : parameters) parser.DefineConst(name, value);
    if (clock != Clock::None) parser.DefineVar("t", &time);
    if (clock == Clock::RunAndStage) parser.DefineVar("stage_time", &stage_time);
    for (int axis = 0; axis < 3 && clock == Clock::RunAndPlace; ++axis)
      parser.DefineVar(std::string(1, static_cast<char>('x' + axis)), &place[axis]);
    parser.SetExpr(expression);
  }
  double time = 0.0, stage_time = 0.0;
  geometry::Vector3 place = geometry::Vector3::Zero();
  mu::Parser parser;
};

namespace {

/// muParser assigns to variables and takes lists; a formula is one value.
bool assigns(const std::string& text) {
  for (std::size_t i = text.find('='); i != std::string::npos; i = text.find('=', i + 1)) {
    const bool compares = (i > 0 && std::string("<>!=").find(text[i - 1]) != std::string::npos) ||
                          (i + 1 < text.size() && text[i + 1] == '=');
    if (!compares) return true;
  }
  return false;
}

std::string refusal(const std::string& expression, const std::string& why) {
  return shown(expression) + ": " + printable(why, 120);
}

}  // namespace

bool Formula::may_name(const std::string& parameter) {
  mu::Parser known;
  if (parameter.empty() || parameter.size() > 64 || parameter == "pi" || parameter == "deg" ||
      parameter == "t" || parameter == "stage_time" || known.GetFunDef().contains(parameter))
    return false;
  const auto letter = [](char c) {
    return c == '_' || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  };
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  return letter(parameter[0]) && std::all_of(parameter.begin(), parameter.end(),
                                             [&](char c) { return letter(c) || digit(c); });
}

Formula::Formula(std::string expression, const Parameters& parameters, Clock clock)
    : expression_(std::move(expression)), parameters_(parameters), clock_(clock) {
  constexpr std::size_t kMost = 4000;  // characters: a longer one is no formula, but costs time
  if (expression_.size() > kMost) {
    throw std::invalid_argument(
        refusal(expression_, "it has " + std::to_string(expression_.size()) +
                                 " characters, the limit is " + std::to_string(kMost)));
  }
  if (assigns(expression_))
    throw std::invalid_argument(refusal(expression_, "it can't assign (=)"));
  try {
    parsed_ = std::make_unique<Parsed>(expression_, parameters_, clock_);
    parsed_->parser.Eval();
  } catch (const mu::Parser::exception_type& error) {
    throw std::invalid_argument(refusal(expression_, error.GetMsg()));
  }
  if (parsed_->parser.GetNumResults() != 1)
    throw std::invalid_argument(refusal(expression_, "it must give one value"));
}

// A parser points at its own `time`, so a copy parses again.
Formula::Formula(const Formula& other)
    : Formula(other.expression_, other.parameters_, other.clock_) {}

Formula& Formula::operator=(const Formula& other) { return *this = Formula(other); }

Formula::Formula(Formula&&) noexcept = default;
Formula& Formula::operator=(Formula&&) noexcept = default;
Formula::~Formula() = default;

double Formula::at(double time, double stage_time) const {
  parsed_->time = time;
  parsed_->stage_time = stage_time;
  return parsed_->parser.Eval();
}

double Formula::at(const geometry::Vector3& place, double time) const {
  parsed_->time = time;
  parsed_->place = place;
  return parsed_->parser.Eval();
}

bool Formula::names_time() const { return parsed_->parser.GetUsedVar().contains("t"); }

}  // namespace quoin::scene_file
