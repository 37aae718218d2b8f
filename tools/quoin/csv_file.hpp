#pragma once
/// CSV as it goes on: lines that spreadsheets and programs read alike, whatever names hold.

#include <filesystem>
#include <fstream>
#include <quoin/solver/state.hpp>
#include <string>
#include <string_view>

namespace quoin::commands {

/// Throws FileError when it can't be written: at the latest in flush().
class CsvFile {
 public:
  /// A new file with this head line (already quoted).
  CsvFile(const std::filesystem::path& path, const std::string& head);
  /// To go on with the first `length` bytes of an earlier one.
  CsvFile(const std::filesystem::path& path, std::uintmax_t length);

  CsvFile& text(std::string_view value);  ///< quoted where it must be
  CsvFile& number(double value);          ///< in the shortest form that reads back to the same
  CsvFile& number(long value);
  CsvFile& numbers(const Eigen::Ref<const Eigen::VectorXd>& values);
  void end_line();

  void flush();
  std::uintmax_t length();  ///< bytes so far, all of them in the file

 private:
  void separate();

  std::filesystem::path path_;
  std::ofstream out_;
  bool at_start_ = true;
};

}  // namespace quoin::commands
