#include "core/mesh/point_cloud_io.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>

#include "core/support/atomic_file.h"
#include "core/support/error.h"

namespace burin {
namespace {

enum class Encoding { kAscii, kLittleEndian, kBigEndian };

enum class NumberType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct Property {
  std::string name;
  NumberType type = NumberType::kFloat32;
  bool is_list = false;
  NumberType count_type = NumberType::kUint8;  // lists only
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::kAscii;
  std::vector<Element> elements;
};

bool ParseNumberType(const std::string& name, NumberType* type) {
  static const std::vector<std::pair<std::string, NumberType>> kNames = {
      {"char", NumberType::kInt8},      {"int8", NumberType::kInt8},
      {"uchar", NumberType::kUint8},    {"uint8", NumberType::kUint8},
      {"short", NumberType::kInt16},    {"int16", NumberType::kInt16},
      {"ushort", NumberType::kUint16},  {"uint16", NumberType::kUint16},
      {"int", NumberType::kInt32},      {"int32", NumberType::kInt32},
      {"uint", NumberType::kUint32},    {"uint32", NumberType::kUint32},
      {"float", NumberType::kFloat32},  {"float32", NumberType::kFloat32},
      {"double", NumberType::kFloat64}, {"float64", NumberType::kFloat64}};
  for (const auto& [candidate, value] : kNames) {
    if (candidate == name) {
      *type = value;
      return true;
    }
  }
  return false;
}

int Size(NumberType type) {
  switch (type) {
    case NumberType::kInt8:
    case NumberType::kUint8:
      return 1;
    case NumberType::kInt16:
    case NumberType::kUint16:
      return 2;
    case NumberType::kInt32:
    case NumberType::kUint32:
    case NumberType::kFloat32:
      return 4;
    case NumberType::kFloat64:
      return 8;
  }
  return 0;
}

template <typename T>
double Decode(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(value));
  return static_cast<double>(value);
}

double DecodeNative(const unsigned char* bytes, NumberType type) {
  switch (type) {
    case NumberType::kInt8:
      return Decode<std::int8_t>(bytes);
    case NumberType::kUint8:
      return Decode<std::uint8_t>(bytes);
    case NumberType::kInt16:
      return Decode<std::int16_t>(bytes);
    case NumberType::kUint16:
      return Decode<std::uint16_t>(bytes);
    case NumberType::kInt32:
      return Decode<std::int32_t>(bytes);
    case NumberType::kUint32:
      return Decode<std::uint32_t>(bytes);
    case NumberType::kFloat32:
      return Decode<float>(bytes);
    case NumberType::kFloat64:
      return Decode<double>(bytes);
  }
  return 0;
}

Header ReadHeader(std::istream& file, const std::filesystem::path& path) {
  Header header;
  bool has_format = false;
  std::string line;
  for (int number = 0;; ++number) {
    // A header line is short: a limit keeps a binary file without line ends out of memory.
    line.clear();
    for (int c = file.get(); c != '\n'; c = file.get()) {
      if (c == EOF) throw InputError(path, "header: ends before end_header");
      if (line.size() >= 4096) throw InputError(path, "header: line longer than 4096 bytes");
      line.push_back(static_cast<char>(c));
    }
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (number == 0) {
      if (key != "ply") throw InputError(path, "header: not a PLY file, must start with \"ply\"");
    } else if (key == "format") {
      std::string encoding;
      words >> encoding;
      if (encoding == "ascii") {
        header.encoding = Encoding::kAscii;
      } else if (encoding == "binary_little_endian") {
        header.encoding = Encoding::kLittleEndian;
      } else if (encoding == "binary_big_endian") {
        header.encoding = Encoding::kBigEndian;
      } else {
        throw InputError(path, "format: \"" + encoding +
                                   "\", must be ascii, binary_little_endian or binary_big_endian");
      }
      has_format = true;
    } else if (key == "element") {
      Element element;
      std::string count;
      words >> element.name >> count;
      const auto parsed = std::from_chars(count.data(), count.data() + count.size(), element.count);
      if (parsed.ec != std::errc() || parsed.ptr != count.data() + count.size() || count.empty()) {
        throw InputError(path, "element " + element.name + ": count \"" + count +
                                   "\", must be a whole number >= 0");
      }
      header.elements.push_back(std::move(element));
    } else if (key == "property") {
      if (header.elements.empty()) throw InputError(path, "property: comes before any element");
      Property property;
      std::string type;
      words >> type;
      bool known = true;
      if (type == "list") {
        property.is_list = true;
        std::string count_type;
        words >> count_type >> type;
        known = ParseNumberType(count_type, &property.count_type) &&
                property.count_type != NumberType::kFloat32 &&
                property.count_type != NumberType::kFloat64;
      }
      known = known && ParseNumberType(type, &property.type);
      words >> property.name;
      if (!known || property.name.empty()) {
        throw InputError(path, "property: cannot be understood: \"" + line + "\"");
      }
      header.elements.back().properties.push_back(std::move(property));
    } else if (key == "end_header") {
      if (!has_format) throw InputError(path, "format: missing in the header");
      return header;
    } else if (!key.empty() && key != "comment" && key != "obj_info") {
      throw InputError(path, "header: unknown keyword \"" + key + "\"");
    }
  }
}

// Bytes that `element` takes at least: exact for binary elements without lists; for ascii one digit
// and one separator a number, less the last separator of the file.
std::uint64_t MinimumRowBytes(const Element& element, Encoding encoding) {
  std::uint64_t bytes = 0;
  for (const Property& property : element.properties) {
    bytes += encoding == Encoding::kAscii
                 ? 2
                 : static_cast<std::uint64_t>(
                       Size(property.is_list ? property.count_type : property.type));
  }
  return bytes;
}

class NumberReader {
 public:
  NumberReader(std::istream* file, Encoding encoding) : file_(*file), encoding_(encoding) {
    const std::uint16_t probe = 1;
    unsigned char low_byte;
    std::memcpy(&low_byte, &probe, 1);
    const bool native_is_little = low_byte == 1;
    reverse_ = native_is_little == (encoding == Encoding::kBigEndian);
  }

  // False at the end of the file or where an ascii word is not a number.
  bool Read(NumberType type, double* value) {
    if (encoding_ == Encoding::kAscii) {
      if (!(file_ >> word_)) return false;
      const char* begin = word_.data() + (word_[0] == '+' ? 1 : 0);
      const char* end = word_.data() + word_.size();
      const auto parsed = std::from_chars(begin, end, *value);
      return parsed.ec == std::errc() && parsed.ptr == end;
    }
    std::array<unsigned char, 8> bytes;
    const int size = Size(type);
    if (!file_.read(reinterpret_cast<char*>(bytes.data()), size)) return false;
    if (reverse_) std::reverse(bytes.begin(), bytes.begin() + size);
    *value = DecodeNative(bytes.data(), type);
    return true;
  }

 private:
  std::istream& file_;
  Encoding encoding_;
  bool reverse_ = false;
  std::string word_;
};

}  // namespace

PointCloud ReadPointCloud(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(path, "no such file");
  const std::uint64_t file_bytes = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file) throw InputError(path, "cannot be read");
  const Header header = ReadHeader(file, path);
  const std::uint64_t body_bytes = file_bytes - static_cast<std::uint64_t>(file.tellg());

  NumberReader numbers(&file, header.encoding);
  for (const Element& element : header.elements) {
    const std::uint64_t row_bytes = MinimumRowBytes(element, header.encoding);
    // Rows without properties take no bytes and give nothing to read.
    if (row_bytes > 0 && element.count > (body_bytes + 1) / row_bytes) {
      throw InputError(path, "element " + element.name + ": count " +
                                 std::to_string(element.count) + " needs more than the " +
                                 std::to_string(body_bytes) + " bytes after the header");
    }
    const bool is_vertex = element.name == "vertex";
    static const std::array<std::string, 6> kNames = {"x", "y", "z", "nx", "ny", "nz"};
    std::vector<int> slot(element.properties.size(), -1);  // into `row` below, -1 = skipped
    std::array<bool, 6> has{};
    for (size_t p = 0; is_vertex && p < element.properties.size(); ++p) {
      const auto name = std::find(kNames.begin(), kNames.end(), element.properties[p].name);
      if (name == kNames.end() || element.properties[p].is_list) continue;
      slot[p] = static_cast<int>(name - kNames.begin());
      has[slot[p]] = true;
    }
    for (int axis = 0; is_vertex && axis < 3; ++axis) {
      if (!has[axis])
        throw InputError(path, "element vertex: property " + kNames[axis] + " missing");
    }
    const bool has_normals = has[3] && has[4] && has[5];

    PointCloud cloud;
    if (is_vertex) {
      cloud.points.reserve(element.count);
      if (has_normals) cloud.normals.reserve(element.count);
    }
    for (std::uint64_t index = 0; row_bytes > 0 && index < element.count; ++index) {
      std::array<double, 6> row{};
      bool complete = true;
      bool finite = true;
      for (size_t p = 0; complete && p < element.properties.size(); ++p) {
        const Property& property = element.properties[p];
        double value = 0;
        if (property.is_list) {
          double count = 0;
          complete = numbers.Read(property.count_type, &count) && count >= 0;
          for (double k = 0; complete && k < count; ++k) {
            complete = numbers.Read(property.type, &value);
          }
          continue;
        }
        complete = numbers.Read(property.type, &value);
        if (slot[p] < 0 || (slot[p] >= 3 && !has_normals)) continue;
        row[slot[p]] = value;
        finite = finite && std::isfinite(value);
      }
      const auto fail = [&](const std::string& reason) {
        throw InputError(path, element.name + " " + std::to_string(index) + ": " + reason);
      };
      if (!complete) fail("cut off or not a number");
      if (!is_vertex) continue;
      if (!finite) fail("not finite");
      cloud.points.emplace_back(row[0], row[1], row[2]);
      if (has_normals) cloud.normals.emplace_back(row[3], row[4], row[5]);
    }
    if (is_vertex) return cloud;
  }
  throw InputError(path, "element vertex: missing in the header");
}

void WritePointCloud(const std::filesystem::path& path, const PointCloud& cloud) {
  const bool has_normals = !cloud.normals.empty();
  CHECK(!has_normals || cloud.normals.size() == cloud.points.size());
  WriteAtomically(path, [&](const std::filesystem::path& temporary) {
    std::ofstream file(temporary, std::ios::binary);
    file << "ply\nformat binary_little_endian 1.0\nelement vertex " << cloud.points.size()
         << "\nproperty float x\nproperty float y\nproperty float z\n";
    if (has_normals) file << "property float nx\nproperty float ny\nproperty float nz\n";
    file << "end_header\n";
    const auto put = [&](const Eigen::Vector3d& vector) {
      for (int axis = 0; axis < 3; ++axis) {
        const auto value = static_cast<float>(vector[axis]);
        std::uint32_t bits;
        std::memcpy(&bits, &value, sizeof(bits));
        for (int shift = 0; shift < 32; shift += 8) {
          file.put(static_cast<char>((bits >> shift) & 0xFF));
        }
      }
    };
    for (size_t p = 0; p < cloud.points.size(); ++p) {
      put(cloud.points[p]);
      if (has_normals) put(cloud.normals[p]);
    }
    file.close();
    if (!file) throw InputError(path, "cannot be written");
  });
}

}  // namespace burin
