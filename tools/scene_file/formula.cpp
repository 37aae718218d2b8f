#include "scene_file/formula.hpp"

#include <muParser.h>

#include <numbers>
#include <stdexcept>

namespace quoin::scene_file {

struct Formula::Parsed {
  Parsed(const std::string& expression, const Parameters& parameters) {
    parser.DefineConst("pi", std::numbers::pi);
    parser.DefineConst("deg", std::numbers::pi / 180);
    parser.DefineConst("g", 9.81);
    for (const auto& [name, value] : parameters) {
      parser.DefineConst(name, value);
    }
    parser.DefineVar("t", &time);
    parser.SetExpr(expression);
  }
  double time = 0.0;
  mu::Parser parser;
};

Formula::Formula(std::string expression, const Parameters& parameters)
    : expression_(std::move(expression)), parameters_(parameters) {
  try {
    parsed_ = std::make_unique<Parsed>(expression_, parameters_);
    parsed_->parser.Eval();
  } catch (const mu::Parser::exception_type& error) {
    throw std::invalid_argument("\"" + expression_ + "\": " + error.GetMsg());
  }
}

// A parser points at its own `time`, so a copy parses again.
Formula::Formula(const Formula& other) : Formula(other.expression_, other.parameters_) {}

Formula& Formula::operator=(const Formula& other) { return *this = Formula(other); }

Formula::Formula(Formula&&) noexcept = default;
Formula& Formula::operator=(Formula&&) noexcept = default;
Formula::~Formula() = default;

double Formula::at(double time) const {
  parsed_->time = time;
  return parsed_->parser.Eval();
}

}  // namespace quoin::scene_file
