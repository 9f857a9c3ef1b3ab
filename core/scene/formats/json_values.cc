#include "core/scene/formats/json_values.h"

#include <cstddef>
#include <fstream>

namespace burin {
namespace {

using nlohmann::json;

// Says no to the parser, which ends it, at the key, and at what has no keys.
class KeyFinder : public nlohmann::json_sax<json> {
 public:
  explicit KeyFinder(const std::string& wanted) : wanted_(wanted) {}
  bool found() const { return found_; }

  bool null() override { return depth_ > 0; }
  bool boolean(bool /*value*/) override { return depth_ > 0; }
  bool number_integer(number_integer_t /*value*/) override { return depth_ > 0; }
  bool number_unsigned(number_unsigned_t /*value*/) override { return depth_ > 0; }
  bool number_float(number_float_t /*value*/, const string_t& /*text*/) override {
    return depth_ > 0;
  }
  bool string(string_t& /*value*/) override { return depth_ > 0; }
  bool binary(binary_t& /*value*/) override { return depth_ > 0; }
  bool start_object(std::size_t /*elements*/) override {
    ++depth_;
    return true;
  }
  bool end_object() override {
    --depth_;
    return true;
  }
  bool start_array(std::size_t /*elements*/) override {
    if (depth_ == 0) in_array_ = true;
    ++depth_;
    return true;
  }
  bool end_array() override {
    --depth_;
    return true;
  }
  bool key(string_t& value) override {
    found_ = depth_ == (in_array_ ? 2 : 1) && value == wanted_;
    return !found_;
  }
  bool parse_error(std::size_t /*position*/, const std::string& /*token*/,
                   const nlohmann::detail::exception& /*error*/) override {
    return false;
  }

 private:
  const std::string& wanted_;
  int depth_ = 0;
  bool in_array_ = false;
  bool found_ = false;
};

}  // namespace

bool HasJsonKey(const std::filesystem::path& path, const std::string& key) {
  std::ifstream file(path, std::ios::binary);
  KeyFinder finder(key);
  return file.good() &&
         (json::sax_parse(file, &finder, json::input_format_t::json, false), finder.found());
}

}  // namespace burin
