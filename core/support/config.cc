#include "core/support/config.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "core/support/did_you_mean.h"
#include "core/support/error.h"

namespace burin {
namespace {

enum class ValueKind { kBool, kInteger, kReal, kString };

struct Value {
  ValueKind kind = ValueKind::kString;
  std::string text;  // as Option::Set() takes it
};

bool IsBareKeyCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '-';
}

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Appends a code point as UTF-8; false when it is not a Unicode scalar value.
bool AppendUtf8(uint32_t code, std::string* text) {
  if (code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF)) return false;
  if (code < 0x80) {
    *text += static_cast<char>(code);
  } else if (code < 0x800) {
    *text += static_cast<char>(0xC0 | (code >> 6));
    *text += static_cast<char>(0x80 | (code & 0x3F));
  } else if (code < 0x10000) {
    *text += static_cast<char>(0xE0 | (code >> 12));
    *text += static_cast<char>(0x80 | ((code >> 6) & 0x3F));
    *text += static_cast<char>(0x80 | (code & 0x3F));
  } else {
    *text += static_cast<char>(0xF0 | (code >> 18));
    *text += static_cast<char>(0x80 | ((code >> 12) & 0x3F));
    *text += static_cast<char>(0x80 | ((code >> 6) & 0x3F));
    *text += static_cast<char>(0x80 | (code & 0x3F));
  }
  return true;
}

// Strips the separators of 1_000; false when one does not stand between two digits.
bool RemoveUnderscores(std::string* number) {
  for (size_t i = 0; i < number->size(); ++i) {
    if ((*number)[i] != '_') continue;
    if (i == 0 || i + 1 == number->size()) return false;
    if (!IsDigit((*number)[i - 1]) || !IsDigit((*number)[i + 1])) return false;
  }
  number->erase(std::remove(number->begin(), number->end(), '_'), number->end());
  return true;
}

// Recognises TOML's decimal integers and floats and writes them as std::from_chars takes them.
bool ReadNumber(std::string token, Value* value) {
  if (!RemoveUnderscores(&token)) return false;
  if (!token.empty() && token[0] == '+') token.erase(0, 1);
  size_t i = !token.empty() && token[0] == '-' ? 1 : 0;
  const auto digits = [&] {
    const size_t start = i;
    while (i < token.size() && IsDigit(token[i])) ++i;
    return i - start;
  };
  value->text = token;
  value->kind = ValueKind::kReal;
  const size_t whole_start = i;
  if (token.compare(i, std::string::npos, "inf") == 0) return true;
  if (token.compare(i, std::string::npos, "nan") == 0) return true;
  const size_t whole_digits = digits();
  if (whole_digits == 0 || (whole_digits > 1 && token[whole_start] == '0')) return false;
  if (i == token.size()) {
    value->kind = ValueKind::kInteger;
    return true;
  }
  if (token[i] == '.') {
    ++i;
    if (digits() == 0) return false;
  }
  if (i < token.size() && (token[i] == 'e' || token[i] == 'E')) {
    ++i;
    if (i < token.size() && (token[i] == '+' || token[i] == '-')) ++i;
    if (digits() == 0) return false;
  }
  return i == token.size();
}

// A cursor in one line. Every Read... throws InputError at the line with the key it belongs to.
class LineReader {
 public:
  LineReader(std::string_view line, std::string place) : rest_(line), place_(std::move(place)) {}

  [[noreturn]] void Fail(const std::string& key, const std::string& reason) const {
    throw InputError(place_, key.empty() ? reason : key + ": " + reason);
  }

  void SkipSpace() {
    while (!rest_.empty() && (rest_[0] == ' ' || rest_[0] == '\t')) rest_.remove_prefix(1);
  }
  bool AtEnd() {
    SkipSpace();
    return rest_.empty() || rest_[0] == '#';
  }
  bool Take(char c) {
    SkipSpace();
    if (rest_.empty() || rest_[0] != c) return false;
    rest_.remove_prefix(1);
    return true;
  }

  // a.b.c with optional space around the dots.
  std::string ReadKey() {
    std::string key;
    do {
      SkipSpace();
      if (!rest_.empty() && (rest_[0] == '"' || rest_[0] == '\'')) {
        Fail(key, "keys in quotes are not supported");
      }
      size_t length = 0;
      while (length < rest_.size() && IsBareKeyCharacter(rest_[length])) ++length;
      if (length == 0) Fail(key, "must be a comment, [group] or key = value");
      if (!key.empty()) key += '.';
      key += rest_.substr(0, length);
      rest_.remove_prefix(length);
    } while (Take('.'));
    return key;
  }

  Value ReadValue(const std::string& key) {
    if (AtEnd()) Fail(key, "has no value");
    Value value;
    if (rest_[0] == '"' || rest_[0] == '\'') {
      value.text = rest_[0] == '"' ? ReadBasicString(key) : ReadLiteralString(key);
    } else if (rest_[0] == '[' || rest_[0] == '{') {
      Fail(key, "arrays and inline tables are not supported");
    } else {
      size_t length = 0;
      while (length < rest_.size() && std::strchr(" \t#", rest_[length]) == nullptr) ++length;
      value.text = rest_.substr(0, length);
      rest_.remove_prefix(length);
      if (value.text == "true" || value.text == "false") {
        value.kind = ValueKind::kBool;
      } else if (const std::string token = value.text; !ReadNumber(token, &value)) {
        Fail(key, token + " is not a TOML value (text needs quotes)");
      }
    }
    if (!AtEnd()) Fail(key, "has something after its value: " + std::string(rest_));
    return value;
  }

 private:
  std::string ReadBasicString(const std::string& key) {
    if (rest_.substr(0, 3) == "\"\"\"") Fail(key, "multi-line strings are not supported");
    std::string text;
    for (size_t i = 1; i < rest_.size(); ++i) {
      const char c = rest_[i];
      if (c == '"') {
        rest_.remove_prefix(i + 1);
        return text;
      }
      if (c != '\\') {
        text += c;
        continue;
      }
      if (++i == rest_.size()) break;
      static constexpr std::string_view kNames = "btnfr\"\\";
      static constexpr std::string_view kMeanings = "\b\t\n\f\r\"\\";
      const size_t known = kNames.find(rest_[i]);
      if (known != std::string_view::npos) {
        text += kMeanings[known];
      } else if (rest_[i] == 'u' || rest_[i] == 'U') {
        const size_t digits = rest_[i] == 'u' ? 4 : 8;
        if (!AppendCodePoint(rest_.substr(i + 1, digits), digits, &text)) {
          Fail(key, "has a \\u escape that is no character");
        }
        i += digits;
      } else {
        Fail(key, std::string("has an unknown escape \\") + rest_[i]);
      }
    }
    Fail(key, "has no closing quote");
  }

  std::string ReadLiteralString(const std::string& key) {
    if (rest_.substr(0, 3) == "'''") Fail(key, "multi-line strings are not supported");
    const size_t end = rest_.find('\'', 1);
    if (end == std::string_view::npos) Fail(key, "has no closing quote");
    std::string text(rest_.substr(1, end - 1));
    rest_.remove_prefix(end + 1);
    return text;
  }

  static bool AppendCodePoint(std::string_view hex, size_t digits, std::string* text) {
    if (hex.size() != digits) return false;
    uint32_t code = 0;
    for (const char c : hex) {
      static constexpr std::string_view kDigits = "0123456789abcdef";
      const size_t digit = kDigits.find(c >= 'A' && c <= 'F' ? static_cast<char>(c + 32) : c);
      if (digit == std::string_view::npos) return false;
      code = code * 16 + static_cast<uint32_t>(digit);
    }
    return AppendUtf8(code, text);
  }

  std::string_view rest_;
  std::string place_;
};

// The kind that the option takes is the kind that was written.
bool KindFits(const Option& option, ValueKind kind) {
  if (std::holds_alternative<bool*>(option.value)) return kind == ValueKind::kBool;
  if (std::holds_alternative<int*>(option.value)) return kind == ValueKind::kInteger;
  if (option.IsText()) return kind == ValueKind::kString;
  return kind == ValueKind::kInteger || kind == ValueKind::kReal;
}

std::vector<std::string> Names(const OptionSet& set) {
  std::vector<std::string> names;
  for (const Option& option : set.options()) names.push_back(option.name);
  return names;
}

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    static constexpr std::string_view kNames = "btnfr\"\\";
    static constexpr std::string_view kMeanings = "\b\t\n\f\r\"\\";
    const size_t known = kMeanings.find(c);
    if (known != std::string_view::npos) {
      quoted += '\\';
      quoted += kNames[known];
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      static constexpr char kDigits[] = "0123456789ABCDEF";
      quoted += "\\u00";
      quoted += kDigits[(c >> 4) & 0xF];
      quoted += kDigits[c & 0xF];
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

}  // namespace

void ReadConfig(const std::filesystem::path& path, OptionSet* set) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    throw InputError(path, "is a folder, not a config file");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path, std::string("cannot be read: ") + std::strerror(errno));
  std::ostringstream text;
  text << file.rdbuf();
  if (file.bad()) throw InputError(path, "cannot be read");
  ParseConfig(text.str(), path.string(), set);
}

void ParseConfig(const std::string& text, const std::string& name, OptionSet* set) {
  std::istringstream lines(text);
  std::string line;
  std::string group;
  std::map<std::string, int> line_of_key;
  std::map<std::string, int> line_of_group;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    LineReader reader(line, name + ":" + std::to_string(number));
    if (std::any_of(line.begin(), line.end(), [](char c) {
          return (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7F;
        })) {
      reader.Fail("", "has a control character; this is not a TOML file");
    }
    if (reader.AtEnd()) continue;
    if (reader.Take('[')) {
      if (reader.Take('[')) reader.Fail("", "arrays of tables are not supported");
      group = reader.ReadKey();
      if (!reader.Take(']') || !reader.AtEnd()) reader.Fail(group, "must be a line [group]");
      const auto [first, is_new] = line_of_group.emplace(group, number);
      if (!is_new) reader.Fail(group, "group is also on line " + std::to_string(first->second));
      continue;
    }
    std::string key = reader.ReadKey();
    if (!group.empty()) key = group + "." + key;
    if (!reader.Take('=')) reader.Fail(key, "must be followed by = and a value");
    const Value value = reader.ReadValue(key);
    Option* option = set->Find(key);
    if (option == nullptr) reader.Fail(key, "unknown option" + DidYouMean(key, Names(*set)));
    const auto [first, is_new] = line_of_key.emplace(key, number);
    if (!is_new) reader.Fail(key, "is also set on line " + std::to_string(first->second));
    const bool is_text = value.kind == ValueKind::kString;
    const std::string shown = is_text ? Quoted(value.text) : value.text;
    std::string ignored;
    if (!KindFits(*option, value.kind) || !option->Set(value.text, &ignored)) {
      reader.Fail(key, "must be " + option->Constraint() + ", not " + shown);
    }
  }
}

std::string ConfigText(const OptionSet& set) {
  // Grouped by the part before the last dot, groups in order of first appearance; keys without a
  // group come first, since TOML has no way back out of a table.
  std::vector<std::string> groups = {""};
  const auto group_of = [](const Option& option) {
    const size_t dot = option.name.rfind('.');
    return dot == std::string::npos ? std::string() : option.name.substr(0, dot);
  };
  for (const Option& option : set.options()) {
    const std::string group = group_of(option);
    if (std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
  }
  std::string text;
  for (const std::string& group : groups) {
    if (!group.empty()) text += (text.empty() ? "[" : "\n[") + group + "]\n";
    for (const Option& option : set.options()) {
      if (group_of(option) != group) continue;
      const bool is_text = option.IsText();
      text += "# " + option.help + " (" + option.Constraint() + ")\n";
      text += group.empty() ? option.name : option.name.substr(group.size() + 1);
      text += " = " + (is_text ? Quoted(option.Text()) : option.Text()) + "\n";
    }
  }
  return text;
}

}  // namespace burin
