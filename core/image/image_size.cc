#include "core/image/image_size.h"

#include <cstddef>
#include <string>

#include "core/image/gray_image.h"
#include "core/support/file_bytes.h"

namespace burin {
namespace {

// The big-endian number in `count` bytes; 0 where the file has ended.
int NumberAt(const std::string& bytes, std::size_t begin, int count) {
  if (begin + count > bytes.size()) return 0;
  int number = 0;
  for (int i = 0; i < count; ++i) {
    number = 256 * number + static_cast<unsigned char>(bytes[begin + i]);
  }
  return number;
}

// Of the frame header, the first segment C0 to CF that is no table.
cv::Size JpegSize(const std::string& bytes) {
  std::size_t i = 2;
  while (i + 9 < bytes.size()) {
    const int code = NumberAt(bytes, i + 1, 1);
    if (NumberAt(bytes, i, 1) != 0xFF) return {};
    if (code == 0xFF) {  // padding
      ++i;
      continue;
    }
    const bool table = code == 0xC4 || code == 0xC8 || code == 0xCC;
    if (code >= 0xC0 && code <= 0xCF && !table) {
      return {NumberAt(bytes, i + 7, 2), NumberAt(bytes, i + 5, 2)};
    }
    i += 2 + NumberAt(bytes, i + 2, 2);
  }
  return {};
}

}  // namespace

cv::Size ImageSize(const std::filesystem::path& path) {
  cv::Size size;
  {
    const std::string bytes = ReadFileBytes(path);
    if (bytes.compare(0, 4, "\x89PNG") == 0 && bytes.size() >= 24 &&
        bytes.compare(12, 4, "IHDR") == 0 && NumberAt(bytes, 16, 1) < 128 &&
        NumberAt(bytes, 20, 1) < 128) {
      size = {NumberAt(bytes, 16, 4), NumberAt(bytes, 20, 4)};
    } else if (bytes.compare(0, 2, "\xFF\xD8") == 0) {
      size = JpegSize(bytes);
    }
  }
  if (size.width > 0 && size.height > 0) return size;
  return ReadGrayImage(path).size();
}

}  // namespace burin
