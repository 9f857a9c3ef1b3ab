#include "core/image/picture.h"

#include <glog/logging.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/support/atomic_file.h"
#include "core/support/error.h"

namespace burin {
namespace {

cv::Mat3b InColor(const cv::Mat& picture) {
  cv::Mat color = picture;
  if (picture.channels() == 1) cv::cvtColor(picture, color, cv::COLOR_GRAY2BGR);
  CHECK(color.type() == CV_8UC3) << "8-bit grey or colour pictures only";
  return color;
}

}  // namespace

void DrawText(const std::string& text, const cv::Point& left_middle, const cv::Size& size,
              cv::Mat3b* picture) {
  if (text.empty()) return;
  constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
  int below = 0;
  const cv::Size at_one = cv::getTextSize(text, kFont, 1.0, 1, &below);
  const double scale = std::min(static_cast<double>(size.width) / at_one.width,
                                static_cast<double>(size.height) / (at_one.height + below));
  const int thickness = std::max(1, static_cast<int>(scale * 1.6));
  const cv::Point origin(left_middle.x,
                         left_middle.y + static_cast<int>(0.5 * scale * at_one.height));
  cv::putText(*picture, text, origin, kFont, scale, cv::Scalar(30, 30, 30), thickness, cv::LINE_AA);
}

cv::Mat3b SideBySide(const std::vector<cv::Mat>& pictures,
                     const std::vector<std::string>& captions) {
  CHECK(!pictures.empty() && pictures.size() == captions.size());
  int height = pictures[0].rows;
  for (const cv::Mat& picture : pictures) height = std::min(height, picture.rows);
  const int strip = std::max(18, height / 18);  // the captions' height
  const int gap = std::max(4, height / 100);

  std::vector<cv::Mat3b> scaled;
  int width = -gap;
  for (const cv::Mat& picture : pictures) {
    cv::Mat3b color = InColor(picture);
    if (color.rows != height) {
      const int new_width = std::max(
          1, cvRound(static_cast<double>(color.cols) * height / static_cast<double>(color.rows)));
      cv::resize(color, color, cv::Size(new_width, height), 0, 0, cv::INTER_AREA);
    }
    scaled.push_back(color);
    width += color.cols + gap;
  }
  cv::Mat3b all(height + strip, width, cv::Vec3b(255, 255, 255));
  int x = 0;
  for (size_t k = 0; k < scaled.size(); ++k) {
    scaled[k].copyTo(all(cv::Rect(x, strip, scaled[k].cols, height)));
    DrawText(captions[k], cv::Point(x + gap, strip / 2),
             cv::Size(std::max(1, scaled[k].cols - 2 * gap), strip * 6 / 10), &all);
    x += scaled[k].cols + gap;
  }
  return all;
}

void WritePicture(const std::filesystem::path& path, const cv::Mat& picture) {
  // Encoded in memory: imwrite does not notice when the disk is full.
  std::vector<unsigned char> bytes;
  bool encoded = false;
  try {
    encoded = cv::imencode(path.extension().string(), picture, bytes);
  } catch (const cv::Exception&) {
    encoded = false;
  }
  if (!encoded) throw InputError(path, "extension: must be of a picture format, for example .png");
  WriteTextAtomically(path, std::string(bytes.begin(), bytes.end()));
}

}  // namespace burin
