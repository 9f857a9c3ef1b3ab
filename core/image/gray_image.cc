#include "core/image/gray_image.h"

#include <algorithm>
#include <cctype>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/support/atomic_file.h"
#include "core/support/error.h"
#include "core/support/file_bytes.h"

namespace burin {
namespace {

unsigned char ByteAt(const std::string& bytes, std::size_t i) {
  return static_cast<unsigned char>(bytes[i]);
}

// The end-of-image marker of the image itself is there; an embedded thumbnail has one of its own,
// so segments are walked. Scans of entropy-coded data end at the next marker that is neither a
// stuffed zero nor a restart.
bool IsCompleteJpeg(const std::string& bytes) {
  constexpr unsigned char kEndOfImage = 0xD9, kStartOfImage = 0xD8, kTemporary = 0x01;
  std::size_t i = 2;
  while (i + 1 < bytes.size()) {
    const unsigned char code = ByteAt(bytes, i + 1);
    const bool is_marker = ByteAt(bytes, i) == 0xFF && code != 0x00 && code != 0xFF;
    const bool has_no_length = (code >= 0xD0 && code <= kStartOfImage) || code == kTemporary;
    if (!is_marker) {
      ++i;
    } else if (code == kEndOfImage) {
      return true;
    } else if (has_no_length) {
      i += 2;
    } else {
      if (i + 3 >= bytes.size()) return false;
      i += 2 + 256 * std::size_t{ByteAt(bytes, i + 2)} + ByteAt(bytes, i + 3);
    }
  }
  return false;
}

// Every chunk up to IEND lies in the file.
bool IsCompletePng(const std::string& bytes) {
  std::size_t i = 8;
  while (i + 12 <= bytes.size()) {
    std::size_t length = 0;
    for (int b = 0; b < 4; ++b) length = 256 * length + ByteAt(bytes, i + b);
    if (length > bytes.size() - i - 12) return false;
    if (bytes.compare(i + 4, 4, "IEND") == 0) return true;
    i += 12 + length;
  }
  return false;
}

}  // namespace

std::string WritableExtension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".png" && extension != ".jpg" && extension != ".jpeg") {
    throw InputError(path, "extension: must be .png, .jpg or .jpeg to be written");
  }
  return extension;
}

cv::Mat ReadGrayImage(const std::filesystem::path& path) {
  std::string bytes = ReadFileBytes(path);
  if (bytes.empty()) throw InputError(path, "image: the file is empty");
  const bool is_jpeg = bytes.compare(0, 2, "\xFF\xD8") == 0;
  const bool is_png = bytes.compare(0, 4, "\x89PNG") == 0;
  if ((is_jpeg && !IsCompleteJpeg(bytes)) || (is_png && !IsCompletePng(bytes))) {
    throw InputError(path, "image: the file is truncated");
  }
  cv::Mat image;
  try {
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1, bytes.data());
    image = cv::imdecode(
        encoded, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& error) {
    throw InputError(path, "image: cannot be decoded (" + error.err + ")");
  }
  if (image.empty()) throw InputError(path, "image: cannot be decoded");
  if (image.type() == CV_16UC1) {
    cv::Mat levels;
    image.convertTo(levels, CV_32F, 255.0 / 65535.0);
    return levels;
  }
  if (image.type() != CV_8UC1) throw InputError(path, "image: must have 8 or 16 bits a channel");
  return image;
}

void WriteGrayImage(const cv::Mat& gray, const std::filesystem::path& path) {
  const std::string extension = WritableExtension(path);
  cv::Mat levels;
  gray.convertTo(levels, CV_8U);
  std::vector<unsigned char> bytes;
  const std::vector<int> settings =
      extension == ".png" ? std::vector<int>{} : std::vector<int>{cv::IMWRITE_JPEG_QUALITY, 95};
  try {
    cv::imencode(extension, levels, bytes, settings);
  } catch (const cv::Exception& error) {
    throw InputError(path, "image: cannot be encoded (" + error.err + ")");
  }
  WriteTextAtomically(path, std::string(bytes.begin(), bytes.end()));
}

}  // namespace burin
