#include "core/image/mask_cover.h"

#include <opencv2/imgproc.hpp>

namespace burin {

cv::Mat1f MaskCover(const cv::Mat& mask, const cv::Size& size) {
  const cv::Mat1f used(mask != 0);  // 0 or 255
  cv::Mat1f cover;
  cv::resize(used, cover, size, 0, 0, cv::INTER_AREA);
  return cover;
}

}  // namespace burin
