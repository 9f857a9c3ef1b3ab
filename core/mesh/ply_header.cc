#include "core/mesh/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <sstream>
#include <utility>

#include "core/support/error.h"

namespace burin {
namespace {

constexpr std::array<PlyType, 16> kTypes = {{{"char", 1, 'i'},
                                             {"int8", 1, 'i'},
                                             {"uchar", 1, 'u'},
                                             {"uint8", 1, 'u'},
                                             {"short", 2, 'i'},
                                             {"int16", 2, 'i'},
                                             {"ushort", 2, 'u'},
                                             {"uint16", 2, 'u'},
                                             {"int", 4, 'i'},
                                             {"int32", 4, 'i'},
                                             {"uint", 4, 'u'},
                                             {"uint32", 4, 'u'},
                                             {"float", 4, 'f'},
                                             {"float32", 4, 'f'},
                                             {"double", 8, 'f'},
                                             {"float64", 8, 'f'}}};

// Null for a name that is none.
const PlyType* FindType(const std::string& name) {
  for (const PlyType& type : kTypes) {
    if (name == type.name) return &type;
  }
  return nullptr;
}

// From the words after "property"; false when they are none.
bool ParseProperty(std::istream* words, PlyProperty* property) {
  std::string type;
  *words >> type;
  if (type == "list") {
    std::string count_type;
    *words >> count_type >> type;
    property->count_type = FindType(count_type);
    if (property->count_type == nullptr || property->count_type->kind == 'f') return false;
  }
  property->type = FindType(type);
  *words >> property->name;
  return property->type != nullptr && !property->name.empty();
}

template <typename T>
double Decode(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

}  // namespace

PlyHeader ReadPlyHeader(const std::filesystem::path& path,
                        const std::function<std::string()>& next_line) {
  const auto fail = [&path](const std::string& reason) { throw InputError(path, reason); };
  PlyHeader header;
  std::string keyword;
  std::istringstream(next_line()) >> keyword;
  if (keyword != "ply") fail("header: not a PLY file, the first line is not 'ply'");
  for (;;) {
    const std::string line = next_line();
    std::istringstream words(line);
    keyword.clear();
    words >> keyword;
    if (keyword == "end_header") break;
    if (keyword == "format") {
      words >> header.format;
      header.ascii = header.format == "ascii";
      header.big_endian = header.format == "binary_big_endian";
      if (!header.ascii && !header.big_endian && header.format != "binary_little_endian") {
        fail("format: \"" + header.format +
             "\", must be ascii, binary_little_endian or binary_big_endian");
      }
    } else if (keyword == "element") {
      PlyElement element;
      std::string count;
      words >> element.name >> count;
      const char* end = count.data() + count.size();
      const auto parsed = std::from_chars(count.data(), end, element.count);
      if (parsed.ec != std::errc() || parsed.ptr != end) {
        fail("element " + element.name + ": count \"" + count +
             "\": the count must be an integer, 0 or more");
      }
      for (const PlyElement& other : header.elements) {
        if (other.name == element.name) fail("element " + element.name + ": occurs twice");
      }
      header.elements.push_back(std::move(element));
    } else if (keyword == "property") {
      if (header.elements.empty()) fail("property: comes before any element");
      PlyProperty property;
      if (!ParseProperty(&words, &property)) {
        fail("property: cannot be understood: \"" + line + "\"");
      }
      header.elements.back().properties.push_back(std::move(property));
    } else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
      fail("header: unknown keyword \"" + keyword + "\"");
    }
  }
  if (header.format.empty()) fail("format: missing in the header");
  return header;
}

std::uint64_t LeastEntryBytes(const PlyElement& element, const PlyHeader& header) {
  std::uint64_t bytes = 0;
  for (const PlyProperty& property : element.properties) {
    const PlyType* first = property.count_type != nullptr ? property.count_type : property.type;
    bytes += static_cast<std::uint64_t>(header.ascii ? 2 : first->size);
  }
  return bytes;
}

double DecodePlyNumber(const char* bytes, const PlyType& type, bool big_endian) {
  constexpr bool kHostIsBig = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;
  std::array<char, 8> native;
  std::copy_n(bytes, type.size, native.begin());
  if (big_endian != kHostIsBig) std::reverse(native.begin(), native.begin() + type.size);
  const char* raw = native.data();
  if (type.kind == 'f') return type.size == 4 ? Decode<float>(raw) : Decode<double>(raw);
  if (type.kind == 'i') {
    return type.size == 1   ? Decode<std::int8_t>(raw)
           : type.size == 2 ? Decode<std::int16_t>(raw)
                            : Decode<std::int32_t>(raw);
  }
  return type.size == 1   ? Decode<std::uint8_t>(raw)
         : type.size == 2 ? Decode<std::uint16_t>(raw)
                          : Decode<std::uint32_t>(raw);
}

}  // namespace burin
