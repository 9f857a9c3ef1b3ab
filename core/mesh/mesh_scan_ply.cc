#include <algorithm>
#include <array>
#include <cmath>
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
    for (const PlyElement& element : header_.elements) {
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
    std::ostringstream text;
    text << "ply\nformat " << header_.format << " 1.0\nelement vertex " << vertices->count << "\n";
    for (const char* axis : {"x", "y", "z"}) {
      const auto& type = FindProperty(*vertices, axis)->type;
      text << "property " << type->name << " " << axis << "\n";
    }
    text << "element face " << faces->count << "\nproperty list "
         << OpenMeshCountType(*indices_->count_type) << " " << indices_->type->name
         << " vertex_indices\nend_header\n";
    mesh_.text = text.str() + vertex_text_ + face_text_;
    mesh_.face_count = static_cast<std::int64_t>(faces->count);
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
    std::int64_t length = 1;
    if (property.count_type != nullptr) {
      const double value = Next(*property.count_type, element, index, copy);
      const auto left = static_cast<double>(data_.size() - at_) + 1;
      if (value < 0 || value != std::floor(value)) {
        Fail(Where(element, index) + ": " + property.name + " has a length of " + Text(value));
      }
      if (value * (header_.ascii ? 2 : property.type->size) > left) {
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

  void ScanVertices(const PlyElement& element) {
    std::array<int, 3> order = {-1, -1, -1};
    for (int axis = 0; axis < 3; ++axis) {
      const PlyProperty* property = FindProperty(element, std::string(1, "xyz"[axis]));
      if (property == nullptr || property->count_type != nullptr || property->type->kind != 'f') {
        Fail("element vertex: property " + std::string(1, "xyz"[axis]) +
             " must be there as float or double");
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
          position[a] = Next(*element.properties[p].type, element, v, &copies[a]);
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
