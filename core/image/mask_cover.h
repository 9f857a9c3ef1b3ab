// Image masks at other sizes.
#pragma once

#include <opencv2/core.hpp>

namespace burin {

// How much of each pixel of a picture of `size` a mask (CV_8UC1, 0 = not to be used) allows: 0 to 255.
cv::Mat1f MaskCover(const cv::Mat& mask, const cv::Size& size);

constexpr float kWholePixel =
    254.9F;  // the cover of a pixel that is allowed as a whole is above it
constexpr float kHalfPixel = 127.5F;

}  // namespace burin
