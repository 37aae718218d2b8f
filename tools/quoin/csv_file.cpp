#include "csv_file.hpp"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <limits>

#include "scene_file/printable.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::commands {

using scene_file::csv_field;

CsvFile::CsvFile(const std::filesystem::path& path, const std::string& head)
    : path_(path), out_(path, std::ios::binary) {
  out_ << head << '\n';
  flush();
}

CsvFile::CsvFile(const std::filesystem::path& path, std::uintmax_t length) : path_(path) {
  std::error_code error;
  std::filesystem::resize_file(path, length, error);
  out_.open(path, std::ios::binary | std::ios::app);
  if (error || !out_) throw scene_file::FileError(path.string() + ": can't be gone on with");
}

void CsvFile::separate() {
  if (!at_start_) out_ << ',';
  at_start_ = false;
}

CsvFile& CsvFile::text(std::string_view value) {
  separate();
  out_ << csv_field(value);
  return *this;
}

CsvFile& CsvFile::number(double value) {
  separate();
  char digits[32];
  const double shown = std::isnan(value) ? std::numeric_limits<double>::quiet_NaN() : value;
  out_.write(digits, std::to_chars(digits, digits + sizeof digits, shown).ptr - digits);
  return *this;
}

CsvFile& CsvFile::number(long value) {
  separate();
  out_ << value;
  return *this;
}

CsvFile& CsvFile::numbers(const Eigen::Ref<const Eigen::VectorXd>& values) {
  for (const double value : values) number(value);
  return *this;
}

void CsvFile::end_line() {
  out_ << '\n';
  at_start_ = true;
}

void CsvFile::flush() {
  if (out_.flush()) return;
  out_.clear();  // it may have failed long ago: once more, for the reason
  errno = 0;
  out_.flush();
  throw scene_file::unwritable(path_.string());
}

std::uintmax_t CsvFile::length() {
  flush();
  return std::filesystem::file_size(path_);
}

}  // namespace quoin::commands
