#include "core/image/mask_image.h"

#include <opencv2/imgcodecs.hpp>
#include <string>

#include "core/image/gray_image.h"
#include "core/support/error.h"
#include "core/support/file_bytes.h"

namespace burin {
namespace {

// Edges of a cut-out are blended with what is behind; lossy formats leave opaque pixels a little below 255.
constexpr int kOpaque = 250;

// Only these formats have alpha: others need not be decoded.
bool MayHaveAlpha(const std::string& bytes) {
  if (bytes.compare(0, 4, "\x89PNG") == 0 && bytes.size() > 25) {
    constexpr char kGrayAlpha = 4, kColorAlpha = 6;
    return bytes[25] == kGrayAlpha || bytes[25] == kColorAlpha ||
           bytes.find("tRNS") != std::string::npos;
  }
  const bool tiff = bytes.compare(0, 4, std::string("II*\0", 4)) == 0 ||
                    bytes.compare(0, 4, std::string("MM\0*", 4)) == 0;
  return tiff || (bytes.compare(0, 4, "RIFF") == 0 && bytes.compare(8, 4, "WEBP") == 0);
}

}  // namespace

cv::Mat ReadAlpha(const std::filesystem::path& path) {
  std::string bytes = ReadFileBytes(path);
  if (!MayHaveAlpha(bytes)) return {};
  cv::Mat image;
  try {
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1, bytes.data());
    image = cv::imdecode(encoded, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    throw InputError(path, "image: cannot be decoded (" + error.err + ")");
  }
  if (image.channels() != 4) return {};
  cv::Mat alpha;
  cv::extractChannel(image, alpha, 3);
  if (alpha.depth() == CV_16U) alpha.convertTo(alpha, CV_8U, 1 / 257.0);
  if (alpha.depth() != CV_8U || cv::countNonZero(alpha < kOpaque) == 0) return {};
  return alpha;
}

cv::Mat ReadMask(const std::filesystem::path& path) {
  cv::Mat alpha = ReadAlpha(path);
  return alpha.empty() ? ReadGrayImage(path) : alpha;
}

cv::Mat ReadUsedPixels(const std::filesystem::path& path) {
  const cv::Mat alpha = ReadAlpha(path);
  if (!alpha.empty()) return alpha >= kOpaque;
  return ReadGrayImage(path) != 0;
}

}  // namespace burin
