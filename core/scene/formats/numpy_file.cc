#include "core/scene/formats/numpy_file.h"

#include <zip.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <regex>
#include <utility>

#include "core/scene/formats/folder_files.h"
#include "core/support/error.h"
#include "core/support/file_bytes.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

constexpr char kMagic[] = "\x93NUMPY";
constexpr size_t kMagicSize = 6;
constexpr size_t kMostIndices = 8;
constexpr size_t kMostHeader = 1024;            // std::regex takes stack by the character
constexpr size_t kMostBytes = size_t{1} << 20;  // of an array in an archive

[[noreturn]] void Fail(const fs::path& file, const std::string& element,
                       const std::string& reason) {
  throw InputError(file, element + (element.empty() ? "" : ": ") + reason);
}

template <typename T>
std::vector<double> Values(const char* data, size_t count) {
  std::vector<double> values(count);
  for (size_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, data + i * sizeof(T), sizeof(T));
    values[i] = static_cast<double>(value);
  }
  return values;
}

struct Kind {
  const char* descr;
  size_t size;
  std::vector<double> (*values)(const char* data, size_t count);
};

constexpr Kind kKinds[] = {{"<f8", 8, Values<double>},   {"<f4", 4, Values<float>},
                           {"<i8", 8, Values<int64_t>},  {"<i4", 4, Values<int32_t>},
                           {"<i2", 2, Values<int16_t>},  {"|i1", 1, Values<int8_t>},
                           {"<u8", 8, Values<uint64_t>}, {"<u4", 4, Values<uint32_t>},
                           {"<u2", 2, Values<uint16_t>}, {"|u1", 1, Values<uint8_t>}};

// The length of the header and where it begins.
size_t HeaderLength(const std::string& bytes, size_t* begin) {
  size_t length = 0;
  const size_t bytes_of_length = bytes[kMagicSize] == 1 ? 2 : 4;
  *begin = kMagicSize + 2 + bytes_of_length;
  if (bytes.size() < *begin) return bytes.size();
  for (size_t k = 0; k < bytes_of_length; ++k) {
    length |= static_cast<size_t>(static_cast<unsigned char>(bytes[kMagicSize + 2 + k])) << (8 * k);
  }
  return length;
}

// From the first index running fastest to the last one doing so.
void TurnOrder(NumpyArray* array) {
  if (array->shape.size() != 2) return;
  const size_t rows = array->shape[0];
  const size_t columns = array->shape[1];
  std::vector<double> turned(array->values.size());
  for (size_t r = 0; r < rows; ++r) {
    for (size_t c = 0; c < columns; ++c) {
      turned[r * columns + c] = array->values[c * rows + r];
    }
  }
  array->values = std::move(turned);
}

}  // namespace

Eigen::MatrixXd NumpyArray::Matrix() const {
  if (shape.size() != 2) return {};
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      values.data(), static_cast<Eigen::Index>(shape[0]), static_cast<Eigen::Index>(shape[1]));
}

NumpyArray ParseNumpy(const std::string& bytes, const fs::path& file, const std::string& element) {
  if (bytes.size() < kMagicSize + 4 || bytes.compare(0, kMagicSize, kMagic) != 0) {
    Fail(file, element, "is no array of NumPy");
  }
  size_t begin = 0;
  const size_t length = HeaderLength(bytes, &begin);
  if (length > bytes.size() - std::min(begin, bytes.size())) {
    Fail(file, element, "the header is truncated");
  }
  if (length > kMostHeader) Fail(file, element, "the header is longer than NumPy's are");
  const std::string header = bytes.substr(begin, length);
  std::smatch found;
  if (!std::regex_search(header, found, std::regex("'descr': *'([^']*)'"))) {
    Fail(file, element, "descr is missing");
  }
  const std::string descr = found[1];
  const Kind* kind = nullptr;
  for (const Kind& each : kKinds) {
    if (descr == each.descr) kind = &each;
  }
  if (kind == nullptr) Fail(file, element, "descr '" + descr + "' is not supported");
  if (!std::regex_search(header, found, std::regex("'shape': *\\(([0-9, ]*)\\)"))) {
    Fail(file, element, "shape is missing");
  }
  NumpyArray array;
  const std::string shape = found[1];
  const std::regex number("[0-9]{1,18}");
  size_t count = 1;
  const size_t most = bytes.size() - begin - length;  // numbers that can follow
  for (std::sregex_iterator it(shape.begin(), shape.end(), number), end; it != end; ++it) {
    array.shape.push_back(std::stoull(it->str()));
    if (array.shape.back() > most || array.shape.size() > kMostIndices ||
        (array.shape.back() > 0 && count > most / array.shape.back())) {
      Fail(file, element, "shape (" + shape + "): the file has no room for it");
    }
    count *= array.shape.back();
  }
  if (count * kind->size > most) Fail(file, element, "the array is truncated");
  array.values = kind->values(bytes.data() + begin + length, count);
  for (const double value : array.values) {
    if (!std::isfinite(value)) Fail(file, element, "has a number that is not finite");
  }
  if (header.find("'fortran_order': True") != std::string::npos) TurnOrder(&array);
  return array;
}

std::map<std::string, NumpyArray> ReadNumpyArchive(const fs::path& file,
                                                   bool (*wanted)(const std::string& name)) {
  int error = 0;
  const std::unique_ptr<zip_t, void (*)(zip_t*)> archive(zip_open(file.c_str(), ZIP_RDONLY, &error),
                                                         zip_discard);
  if (archive == nullptr) throw InputError(file, "is no archive of NumPy (zip)");
  std::map<std::string, NumpyArray> arrays;
  const zip_int64_t entries = zip_get_num_entries(archive.get(), 0);
  for (zip_int64_t i = 0; i < entries; ++i) {
    zip_stat_t stat;
    if (zip_stat_index(archive.get(), i, 0, &stat) != 0 ||
        (stat.valid & (ZIP_STAT_NAME | ZIP_STAT_SIZE)) != (ZIP_STAT_NAME | ZIP_STAT_SIZE)) {
      continue;
    }
    std::string name = stat.name;
    if (!EndsIn(name, ".npy")) continue;
    name.resize(name.size() - 4);
    if (!wanted(name)) continue;
    if (stat.size > kMostBytes) Fail(file, name, "is too large for a camera");
    const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> entry(
        zip_fopen_index(archive.get(), i, 0), zip_fclose);
    std::string bytes(stat.size, '\0');
    if (entry == nullptr ||
        zip_fread(entry.get(), bytes.data(), stat.size) != static_cast<zip_int64_t>(stat.size)) {
      Fail(file, name, "cannot be unpacked");
    }
    arrays[name] = ParseNumpy(bytes, file, name);
  }
  return arrays;
}

}  // namespace burin
