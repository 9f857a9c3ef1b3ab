// Text files read line by line and number by number, with errors that name file, line and field.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

#include "core/support/error.h"
#include "core/support/file_bytes.h"

namespace burin {

// Lines of a text file, with errors that say which.
class TextLines {
 public:
  static constexpr std::string_view kBlank = " \t\r";

  explicit TextLines(const std::filesystem::path& path) : path_(path), text_(ReadFileBytes(path)) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (text_.compare(0, kByteOrderMark.size(), kByteOrderMark) == 0)
      begin_ = kByteOrderMark.size();
  }

  // Moves to the next line; false at the end of the file.
  bool Next() {
    if (begin_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find('\n', begin_), text_.size());
    line_ = std::string_view(text_).substr(begin_, end - begin_);
    begin_ = end + 1;
    ++number_;
    return true;
  }

  // The same, past comments and blank lines.
  bool NextElement() {
    while (Next()) {
      const std::size_t first = line_.find_first_not_of(kBlank);
      if (first != std::string_view::npos && line_[first] != '#') return true;
    }
    return false;
  }

  // The line after the current one, which stays the current one; nothing at the end of the file.
  std::string_view Following() const {
    if (begin_ >= text_.size()) return {};
    return std::string_view(text_).substr(begin_, text_.find('\n', begin_) - begin_);
  }

  bool AtEndOfLine() const { return line_.find_first_not_of(kBlank) == std::string_view::npos; }

  std::string_view Word(const char* field) {
    const std::size_t first = line_.find_first_not_of(kBlank);
    if (first == std::string_view::npos) Fail(field, "is missing");
    line_.remove_prefix(first);
    const std::size_t end = std::min(line_.find_first_of(kBlank), line_.size());
    const std::string_view word = line_.substr(0, end);
    line_.remove_prefix(end);
    return word;
  }

  // Up to `separator`, which is passed over, or the end of the line; blanks are part of it.
  std::string_view WordUntil(char separator) {
    const std::size_t end = std::min(line_.find(separator), line_.size());
    const std::string_view word = line_.substr(0, end);
    line_.remove_prefix(std::min(end + 1, line_.size()));
    return word;
  }

  // Integers must fit T; numbers with a fraction must be finite.
  template <typename T>
  T Number(const char* field) {
    const std::string_view word = Word(field);
    const T value = Parsed<T>(field, word);
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::isfinite(value)) Fail(field, "'" + std::string(word) + "' is not finite");
    }
    return value;
  }

  Eigen::Vector3d Vector3(const char* x, const char* y, const char* z) {
    Eigen::Vector3d vector;
    vector.x() = Number<double>(x);
    vector.y() = Number<double>(y);
    vector.z() = Number<double>(z);
    return vector;
  }

  // The same, of which numbers may be not finite.
  Eigen::Vector3d Point(const char* x, const char* y, const char* z) {
    Eigen::Vector3d point;
    int axis = 0;
    for (const char* field : {x, y, z}) point[axis++] = Parsed<double>(field, Word(field));
    return point;
  }

  // A matrix, a line a row.
  template <int kRows, int kColumns>
  Eigen::Matrix<double, kRows, kColumns> Rows(const char* field) {
    Eigen::Matrix<double, kRows, kColumns> matrix;
    for (int r = 0; r < kRows; ++r) {
      if (!NextElement()) Fail(field, "the file ends");
      for (int c = 0; c < kColumns; ++c) matrix(r, c) = Number<double>(field);
      ExpectEndOfLine();
    }
    return matrix;
  }

  // What is left of the line, without blanks around it.
  std::string Rest(const char* field) {
    if (AtEndOfLine()) Fail(field, "is missing");
    const std::size_t first = line_.find_first_not_of(kBlank);
    return std::string(line_.substr(first, line_.find_last_not_of(kBlank) - first + 1));
  }

  void ExpectEndOfLine() {
    if (!AtEndOfLine()) Fail("end of line", "'" + Rest("") + "' follows the last field");
  }

  [[noreturn]] void Fail(const std::string& field, const std::string& reason) const {
    throw InputError(path_, "line " + std::to_string(number_) + ": " + field + ": " + reason);
  }

 private:
  template <typename T>
  T Parsed(const char* field, std::string_view word) const {
    std::string_view digits = word;
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
    T value{};
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool all = end == digits.data() + digits.size();
    if (std::is_floating_point_v<T> && all && IsTooSmall(error, digits)) return 0;
    if (error != std::errc() || !all) {
      Fail(field, "'" + std::string(word) + "' is not " +
                      (std::is_floating_point_v<T> ? "a number" : "an integer in range"));
    }
    return value;
  }

  // Of a number out of a double's range: whether it is so on the small side.
  static bool IsTooSmall(std::errc error, std::string_view digits) {
    return error == std::errc::result_out_of_range &&
           std::abs(std::strtod(std::string(digits).c_str(), nullptr)) < 1;
  }

  std::filesystem::path path_;
  std::string text_;
  std::size_t begin_ = 0;  // of the line after line_
  std::string_view line_;  // what is unread of the current line
  int number_ = 0;         // of the current line, from 1
};

}  // namespace burin
