// What the grey levels of photographs say about themselves. All of it scales with the grey levels: an
// image times a factor has its contrast and noise times that factor.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace burin {

// Windows of a photograph on a grid, some 16 000 of them.
struct GreySample {
  std::vector<float> levels;  // at the centres of the windows
  // The standard deviations s of the 5x5 windows, each weighted by itself: sum s^2 / sum s. Windows
  // without texture have no say, so that it is the same whether an object fills the image or stands
  // before black. 0 when nothing is left, or nothing varies.
  double texture = 0;
};

// `mask` (CV_8UC1, 0 = not to be used) may be empty; windows with a masked pixel are left out.
GreySample SampleGreys(const cv::Mat1f& image, const cv::Mat& mask);

// Contrast of a scene's photographs in grey levels: the geometric mean of the range that their levels
// span together (from .1 to 99.9 % of them) and of their texture (the median photograph's).
double Contrast(const std::vector<GreySample>& photographs);

// Standard deviation of an image's noise in grey levels. The noise-only response of the mask
// [1 -2 1; -2 4 -2; 1 -2 1] has 6 times the noise's standard deviation (Immerkaer, "Fast noise
// variance estimation", 1996); taken as the 20th percentile over 16x16 blocks, so that texture does
// not count as noise. Blocks that are constant, or that come within 1/254 of the image's own range to
// its darkest or brightest level (they may be clipped there), or have a pixel that `mask` (as above)
// leaves out, are left out; of a large image about a
// thousand blocks are looked at. 0 when there is no such block.
double EstimateNoise(const cv::Mat1f& image, const cv::Mat& mask);

}  // namespace burin
