#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

#include "core/mesh/mesh_scan.h"
#include "core/mesh/ply_header.h"
#include "core/support/error.h"

namespace burin {
namespace {

// A name of the same size that OpenMesh takes for the type of a list's length.
const char* OpenMeshCountType(const PlyType& type) {
  return type.size == 1 ? "uchar" : type.size == 2 ? "uint16" : "int";
}

class PlyScanner {
 public:
  PlyScanner(const std::filesystem::path& path, const std::string& data)
      : path_(path), data_(data) {}

  ScannedMesh Scan() {
    header_ = ReadPlyHeader(path_, [this] { return HeaderLine(); });
    const PlyElement* vertices = nullptr;
    const PlyElement* faces = nullptr;
    bool strips = false;
    for (const PlyElement& element : header_.elements) {
      CheckFits(element);
      if (element.name == "vertex") {
        ScanVertices(element);
        vertices = &element;
      } else if (element.name == "face" && element.count > 0) {
        ScanFaces(element);
        faces = &element;
      } else if (element.name == "tristrips" && faces == nullptr) {
        ScanStrips(element);
        strips = true;
      } else {
        SkipElement(element);
      }
    }
    if (vertices == nullptr || vertices->count == 0) Fail("element vertex: the mesh has none");
    if (faces == nullptr && mesh_.face_count == 0) Fail("element face: the mesh has none");
    const size_t end = data_.find_first_not_of(std::string(" \t\r\n\0", 5), at_);
    if (end != std::string::npos) {
      Fail("end of file: " + std::to_string(data_.size() - at_) +
           " bytes follow the last element, the header's counts do not match the data");
    }
    std::ostringstream text;
    text << "ply\nformat " << header_.format << " 1.0\nelement vertex " << vertices->count << "\n";
    for (const char* axis : {"x", "y", "z"}) {
      const auto& type = FindProperty(*vertices, axis)->type;
      text << "property " << (type->kind == 'f' ? type->name : "float") << " " << axis << "\n";
    }
    if (faces != nullptr) mesh_.face_count = static_cast<std::int64_t>(faces->count);
    text << "element face " << mesh_.face_count << "\nproperty list "
         << (strips ? "uchar" : OpenMeshCountType(*indices_->count_type)) << " "
         << (strips ? "int" : indices_->type->name) << " vertex_indices\nend_header\n";
    mesh_.text = text.str() + vertex_text_ + face_text_;
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void Fail(const std::string& reason) const { throw InputError(path_, reason); }

  std::string HeaderLine() {
    const size_t end = data_.find('\n', at_);
    if (end == std::string::npos) Fail("header: ends before end_header");
    std::string line = data_.substr(at_, end - at_);
    at_ = end + 1;
    return line;
  }

  static const PlyProperty* FindProperty(const PlyElement& element, const std::string& name) {
    for (const PlyProperty& property : element.properties) {
      if (property.name == name) return &property;
    }
    return nullptr;
  }

  // The least room that the element's entries take is there; after this, count is safe to allocate.
  void CheckFits(const PlyElement& element) const {
    const std::uint64_t bytes = LeastEntryBytes(element, header_);
    const std::uint64_t left = data_.size() - at_ + (header_.ascii ? 1 : 0);
    if (bytes > 0 && element.count > left / bytes) {
      Fail("element " + element.name + ": the header announces " + std::to_string(element.count) +
           ", the file is truncated after " + std::to_string(left / bytes) + " or fewer");
    }
  }

  std::string Where(const PlyElement& element, std::uint64_t index) const {
    return element.name + " " + std::to_string(index);
  }

  // The next value; its bytes (or its digits and a space) are appended to *copy unless that is
  // null.
  double Next(const PlyType& type, const PlyElement& element, std::uint64_t index,
              std::string* copy) {
    if (header_.ascii) {
      const size_t begin = std::min(data_.find_first_not_of(" \t\r\n", at_), data_.size());
      if (begin == data_.size()) Fail(Where(element, index) + ": the file is truncated here");
      const size_t end = std::min(data_.find_first_of(" \t\r\n", begin), data_.size());
      const std::string_view token(data_.data() + begin, end - begin);
      double value = 0;
      if (!ParseNumber(token, &value)) {
        // Of fields that do not matter programs write "-nan(ind)" and the like.
        if (copy == nullptr && type.kind == 'f')
          value = std::numeric_limits<double>::quiet_NaN();
        else
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
    const char* bytes = data_.data() + at_;
    if (copy != nullptr) copy->append(bytes, type.size);
    at_ += type.size;
    return DecodePlyNumber(bytes, type, header_.big_endian);
  }

  // Walks over a property, scalar or list.
  void Skip(const PlyProperty& property, const PlyElement& element, std::uint64_t index,
            std::string* copy) {
    const std::int64_t length =
        property.count_type != nullptr ? Length(property, element, index, copy) : 1;
    for (std::int64_t i = 0; i < length; ++i) Next(*property.type, element, index, copy);
  }

  // Of a list, which the rest of the file has room for.
  std::int64_t Length(const PlyProperty& property, const PlyElement& element, std::uint64_t index,
                      std::string* copy) {
    const double value = Next(*property.count_type, element, index, copy);
    const auto left = static_cast<double>(data_.size() - at_) + 1;
    if (value < 0 || value != std::floor(value)) {
      Fail(Where(element, index) + ": " + property.name + " has a length of " + Text(value));
    }
    if (value * (header_.ascii ? 2 : property.type->size) > left) {
      Fail(Where(element, index) + ": the file is truncated here, " + property.name +
           " has a length of " + Text(value));
    }
    return static_cast<std::int64_t>(value);
  }

  static std::string Text(double value) {
    std::ostringstream text;
    text << value;
    return text.str();
  }

  void ScanVertices(const PlyElement& element) {
    std::array<int, 3> order = {-1, -1, -1};
    for (int axis = 0; axis < 3; ++axis) {
      const PlyProperty* property = FindProperty(element, std::string(1, "xyz"[axis]));
      if (property == nullptr || property->count_type != nullptr) {
        Fail("element vertex: property " + std::string(1, "xyz"[axis]) +
             " must be there as a number");
      }
      order[axis] = static_cast<int>(property - element.properties.data());
    }
    mesh_.positions.reserve(element.count);
    for (std::uint64_t v = 0; v < element.count; ++v) {
      Eigen::Vector3d position;
      std::array<std::string, 3> copies;
      for (size_t p = 0; p < element.properties.size(); ++p) {
        const auto axis = std::find(order.begin(), order.end(), static_cast<int>(p));
        if (axis == order.end()) {
          Skip(element.properties[p], element, v, nullptr);
        } else {
          const auto a = axis - order.begin();
          const PlyType& type = *element.properties[p].type;
          if (type.kind == 'f') {
            position[a] = Next(type, element, v, &copies[a]);
          } else {  // OpenMesh, whose positions are not used, gets zeros as float
            position[a] = Next(type, element, v, nullptr);
            copies[a] = header_.ascii ? "0 " : std::string(sizeof(float), '\0');
          }
        }
      }
      CheckPosition(path_, static_cast<std::int64_t>(v), position);
      mesh_.positions.push_back(position);
      for (const std::string& copy : copies) vertex_text_ += copy;
    }
  }

  void ScanFaces(const PlyElement& element) {
    for (const char* name : {"vertex_indices", "vertex_index"}) {
      const PlyProperty* property = FindProperty(element, name);
      if (property != nullptr && property->count_type != nullptr) indices_ = property;
    }
    if (indices_ == nullptr || indices_->type->kind == 'f') {
      Fail("element face: property vertex_indices must be there as a list of integers");
    }
    for (std::uint64_t f = 0; f < element.count; ++f) {
      for (const PlyProperty& property : element.properties) {
        Skip(property, element, f, &property == indices_ ? &face_text_ : nullptr);
      }
    }
  }

  // Triangle strips: each vertex makes a triangle with the two before it, every other one turned; -1 begins anew.
  void ScanStrips(const PlyElement& element) {
    const PlyProperty* strip = FindProperty(element, "vertex_indices");
    if (strip == nullptr) strip = FindProperty(element, "vertex_index");
    if (strip == nullptr || strip->count_type == nullptr || strip->type->kind == 'f') {
      Fail("element tristrips: property vertex_indices must be there as a list of integers");
    }
    for (std::uint64_t s = 0; s < element.count; ++s) {
      for (const PlyProperty& property : element.properties) {
        if (&property == strip) {
          AddStrip(property, element, s);
        } else {
          Skip(property, element, s, nullptr);
        }
      }
    }
  }

  void AddStrip(const PlyProperty& property, const PlyElement& element, std::uint64_t index) {
    const std::int64_t length = Length(property, element, index, nullptr);
    std::array<std::int32_t, 2> before = {-1, -1};
    std::int64_t run = 0;
    for (std::int64_t i = 0; i < length; ++i) {
      const auto vertex = static_cast<std::int32_t>(Next(*property.type, element, index, nullptr));
      run = vertex < 0 ? 0 : run + 1;
      if (run >= 3 && before[0] != before[1] && before[1] != vertex && before[0] != vertex) {
        const bool turned = run % 2 == 0;
        AddTriangle(before[turned ? 1 : 0], before[turned ? 0 : 1], vertex);
      }
      before = {before[1], vertex};
    }
  }

  void AddTriangle(std::int32_t a, std::int32_t b, std::int32_t c) {
    ++mesh_.face_count;
    if (header_.ascii) {
      for (const std::int32_t number : {3, a, b, c}) face_text_ += std::to_string(number) + " ";
      return;
    }
    face_text_.push_back(3);
    for (const std::int32_t number : {a, b, c}) {
      for (int byte = 0; byte < 4; ++byte) {
        const int shift = 8 * (header_.big_endian ? 3 - byte : byte);
        face_text_.push_back(static_cast<char>(static_cast<std::uint32_t>(number) >> shift));
      }
    }
  }

  void SkipElement(const PlyElement& element) {
    if (element.properties.empty()) return;
    for (std::uint64_t i = 0; i < element.count; ++i) {
      for (const PlyProperty& property : element.properties) Skip(property, element, i, nullptr);
    }
  }

  const std::filesystem::path& path_;
  const std::string& data_;
  size_t at_ = 0;  // of the next byte to read
  PlyHeader header_;
  const PlyProperty* indices_ = nullptr;
  std::string vertex_text_, face_text_;
  ScannedMesh mesh_;
};

}  // namespace

ScannedMesh ScanPly(const std::filesystem::path& path, const std::string& data) {
  return PlyScanner(path, data).Scan();
}

}  // namespace burin
