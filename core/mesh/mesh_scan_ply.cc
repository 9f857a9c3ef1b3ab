#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <sstream>

#include "core/mesh/mesh_scan.h"
#include "core/support/error.h"

namespace burin {
namespace {

struct ScalarType {
  const char* name;
  int size;              // bytes in a binary file
  char kind;             // i: signed, u: unsigned, f: floating point
  const char* as_count;  // a name of the same size that OpenMesh takes for the length of a list
};

constexpr std::array<ScalarType, 16> kScalarTypes = {{{"char", 1, 'i', "uchar"},
                                                      {"int8", 1, 'i', "uchar"},
                                                      {"uchar", 1, 'u', "uchar"},
                                                      {"uint8", 1, 'u', "uchar"},
                                                      {"short", 2, 'i', "uint16"},
                                                      {"int16", 2, 'i', "uint16"},
                                                      {"ushort", 2, 'u', "uint16"},
                                                      {"uint16", 2, 'u', "uint16"},
                                                      {"int", 4, 'i', "int"},
                                                      {"int32", 4, 'i', "int"},
                                                      {"uint", 4, 'u', "int"},
                                                      {"uint32", 4, 'u', "int"},
                                                      {"float", 4, 'f', ""},
                                                      {"float32", 4, 'f', ""},
                                                      {"double", 8, 'f', ""},
                                                      {"float64", 8, 'f', ""}}};

const ScalarType* FindType(const std::string& name) {
  for (const ScalarType& type : kScalarTypes) {
    if (name == type.name) return &type;
  }
  return nullptr;
}

struct Property {
  std::string name;
  const ScalarType* type = nullptr;
  const ScalarType* count_type = nullptr;  // of a list; null otherwise
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

template <typename T>
double Decode(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

class PlyScanner {
 public:
  PlyScanner(const std::filesystem::path& path, const std::string& data)
      : path_(path), data_(data) {}

  ScannedMesh Scan() {
    ReadHeader();
    const Element* vertices = nullptr;
    const Element* faces = nullptr;
    for (const Element& element : elements_) {
      CheckFits(element);
      if (element.name == "vertex") {
        ScanVertices(element);
        vertices = &element;
      } else if (element.name == "face") {
        ScanFaces(element);
        faces = &element;
      } else {
        SkipElement(element);
      }
    }
    if (vertices == nullptr || vertices->count == 0) Fail("element vertex: the mesh has none");
    if (faces == nullptr || faces->count == 0) Fail("element face: the mesh has none");
    const size_t end = data_.find_first_not_of(std::string(" \t\r\n\0", 5), at_);
    if (end != std::string::npos) {
      Fail("end of file: " + std::to_string(data_.size() - at_) +
           " bytes follow the last element, the header's counts do not match the data");
    }
    std::ostringstream header;
    header << "ply\nformat " << format_ << " 1.0\nelement vertex " << vertices->count << "\n";
    for (const char* axis : {"x", "y", "z"}) {
      const auto& type = FindProperty(*vertices, axis)->type;
      header << "property " << type->name << " " << axis << "\n";
    }
    header << "element face " << faces->count << "\nproperty list "
           << indices_->count_type->as_count << " " << indices_->type->name
           << " vertex_indices\nend_header\n";
    mesh_.text = header.str() + vertex_text_ + face_text_;
    mesh_.face_count = faces->count;
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void Fail(const std::string& reason) const { throw InputError(path_, reason); }

  std::string HeaderLine() {
    const size_t end = data_.find('\n', at_);
    if (end == std::string::npos) Fail("header: ends before end_header");
    std::string line = data_.substr(at_, end - at_);
    at_ = end + 1;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    return line;
  }

  const ScalarType* HeaderType(const std::string& name, const std::string& line) const {
    const ScalarType* type = FindType(name);
    if (type == nullptr) Fail("header: '" + line + "': unknown type '" + name + "'");
    return type;
  }

  void ReadHeader() {
    if (HeaderLine() != "ply") Fail("header: the first line is not 'ply'");
    for (;;) {
      const std::string line = HeaderLine();
      std::istringstream words(line);
      std::string keyword;
      words >> keyword;
      if (keyword == "end_header") break;
      if (keyword == "format") {
        words >> format_;
      } else if (keyword == "element") {
        Element element;
        std::string count;
        words >> element.name >> count;
        if (!ParseInteger(count, &element.count) || element.count < 0) {
          Fail("header: '" + line + "': the count must be an integer, 0 or more");
        }
        for (const Element& other : elements_) {
          if (other.name == element.name) Fail("header: '" + line + "': occurs twice");
        }
        elements_.push_back(element);
      } else if (keyword == "property") {
        if (elements_.empty()) Fail("header: '" + line + "': comes before any element");
        Property property;
        std::string type;
        words >> type;
        if (type == "list") {
          std::string count_type;
          words >> count_type >> type;
          property.count_type = HeaderType(count_type, line);
          if (property.count_type->kind == 'f') {
            Fail("header: '" + line + "': the length of a list must be an integer");
          }
        }
        property.type = HeaderType(type, line);
        words >> property.name;
        elements_.back().properties.push_back(property);
      } else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
        Fail("header: '" + line + "': unknown keyword");
      }
    }
    if (format_ != "ascii" && format_ != "binary_little_endian" && format_ != "binary_big_endian") {
      Fail("header: format '" + format_ +
           "' must be ascii, binary_little_endian or binary_big_endian");
    }
    ascii_ = format_ == "ascii";
    big_endian_ = format_ == "binary_big_endian";
  }

  static const Property* FindProperty(const Element& element, const std::string& name) {
    for (const Property& property : element.properties) {
      if (property.name == name) return &property;
    }
    return nullptr;
  }

  // The least room that the element's entries take is there; after this, count is safe to allocate.
  void CheckFits(const Element& element) const {
    std::int64_t bytes = 0;
    for (const Property& property : element.properties) {
      // A number in text takes a digit and a separator; the last one needs no separator.
      bytes += ascii_ ? 2 : (property.count_type ? property.count_type : property.type)->size;
    }
    const auto left = static_cast<std::int64_t>(data_.size() - at_) + (ascii_ ? 1 : 0);
    if (bytes > 0 && element.count > left / bytes) {
      Fail("element " + element.name + ": the header announces " + std::to_string(element.count) +
           ", the file is truncated after " + std::to_string(left / bytes) + " or fewer");
    }
  }

  std::string Where(const Element& element, std::int64_t index) const {
    return element.name + " " + std::to_string(index);
  }

  // The next value; its bytes (or its digits and a space) are appended to *copy unless that is
  // null.
  double Next(const ScalarType& type, const Element& element, std::int64_t index,
              std::string* copy) {
    if (ascii_) {
      const size_t begin = std::min(data_.find_first_not_of(" \t\r\n", at_), data_.size());
      if (begin == data_.size()) Fail(Where(element, index) + ": the file is truncated here");
      const size_t end = std::min(data_.find_first_of(" \t\r\n", begin), data_.size());
      const std::string_view token(data_.data() + begin, end - begin);
      double value = 0;
      if (!ParseNumber(token, &value)) {
        Fail(Where(element, index) + ": '" + std::string(token) + "' is not a number");
      }
      at_ = end;
      if (copy != nullptr && type.kind != 'f') {
        if (value != std::floor(value) || std::abs(value) > 2147483647) {
          Fail(Where(element, index) + ": '" + std::string(token) + "' is not an integer");
        }
        copy->append(std::to_string(static_cast<std::int64_t>(value))).push_back(' ');
      } else if (copy != nullptr) {
        copy->append(token).push_back(' ');
      }
      return value;
    }
    if (data_.size() - at_ < static_cast<size_t>(type.size)) {
      Fail(Where(element, index) + ": the file is truncated here");
    }
    char bytes[8];
    std::memcpy(bytes, data_.data() + at_, type.size);
    if (copy != nullptr) copy->append(bytes, type.size);
    at_ += type.size;
    if (big_endian_) std::reverse(bytes, bytes + type.size);
    if (type.kind == 'f') return type.size == 4 ? Decode<float>(bytes) : Decode<double>(bytes);
    if (type.kind == 'i') {
      return type.size == 1   ? Decode<std::int8_t>(bytes)
             : type.size == 2 ? Decode<std::int16_t>(bytes)
                              : Decode<std::int32_t>(bytes);
    }
    return type.size == 1   ? Decode<std::uint8_t>(bytes)
           : type.size == 2 ? Decode<std::uint16_t>(bytes)
                            : Decode<std::uint32_t>(bytes);
  }

  // Walks over a property, scalar or list.
  void Skip(const Property& property, const Element& element, std::int64_t index,
            std::string* copy) {
    std::int64_t length = 1;
    if (property.count_type != nullptr) {
      const double value = Next(*property.count_type, element, index, copy);
      const auto left = static_cast<double>(data_.size() - at_) + 1;
      if (value < 0 || value != std::floor(value)) {
        Fail(Where(element, index) + ": " + property.name + " has a length of " + Text(value));
      }
      if (value * (ascii_ ? 2 : property.type->size) > left) {
        Fail(Where(element, index) + ": the file is truncated here, " + property.name +
             " has a length of " + Text(value));
      }
      length = static_cast<std::int64_t>(value);
    }
    for (std::int64_t i = 0; i < length; ++i) Next(*property.type, element, index, copy);
  }

  static std::string Text(double value) {
    std::ostringstream text;
    text << value;
    return text.str();
  }

  void ScanVertices(const Element& element) {
    std::array<int, 3> order = {-1, -1, -1};
    for (int axis = 0; axis < 3; ++axis) {
      const Property* property = FindProperty(element, std::string(1, "xyz"[axis]));
      if (property == nullptr || property->count_type != nullptr || property->type->kind != 'f') {
        Fail("element vertex: property " + std::string(1, "xyz"[axis]) +
             " must be there as float or double");
      }
      order[axis] = static_cast<int>(property - element.properties.data());
    }
    mesh_.positions.reserve(element.count);
    for (std::int64_t v = 0; v < element.count; ++v) {
      Eigen::Vector3d position;
      std::array<std::string, 3> copies;
      for (size_t p = 0; p < element.properties.size(); ++p) {
        const auto axis = std::find(order.begin(), order.end(), static_cast<int>(p));
        if (axis == order.end()) {
          Skip(element.properties[p], element, v, nullptr);
        } else {
          const auto a = axis - order.begin();
          position[a] = Next(*element.properties[p].type, element, v, &copies[a]);
        }
      }
      CheckPosition(path_, v, position);
      mesh_.positions.push_back(position);
      for (const std::string& copy : copies) vertex_text_ += copy;
    }
  }

  void ScanFaces(const Element& element) {
    for (const char* name : {"vertex_indices", "vertex_index"}) {
      const Property* property = FindProperty(element, name);
      if (property != nullptr && property->count_type != nullptr) indices_ = property;
    }
    if (indices_ == nullptr || indices_->type->kind == 'f') {
      Fail("element face: property vertex_indices must be there as a list of integers");
    }
    for (std::int64_t f = 0; f < element.count; ++f) {
      for (const Property& property : element.properties) {
        Skip(property, element, f, &property == indices_ ? &face_text_ : nullptr);
      }
    }
  }

  void SkipElement(const Element& element) {
    if (element.properties.empty()) return;
    for (std::int64_t i = 0; i < element.count; ++i) {
      for (const Property& property : element.properties) Skip(property, element, i, nullptr);
    }
  }

  const std::filesystem::path& path_;
  const std::string& data_;
  size_t at_ = 0;  // of the next byte to read
  std::string format_;
  bool ascii_ = false;
  bool big_endian_ = false;
  std::vector<Element> elements_;
  const Property* indices_ = nullptr;
  std::string vertex_text_, face_text_;
  ScannedMesh mesh_;
};

}  // namespace

ScannedMesh ScanPly(const std::filesystem::path& path, const std::string& data) {
  return PlyScanner(path, data).Scan();
}

}  // namespace burin
