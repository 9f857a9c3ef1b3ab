#include "core/scene/formats/black_borders.h"

#include <map>
#include <opencv2/imgproc.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "core/support/fixed_text.h"

namespace burin {
namespace {

constexpr size_t kLeastViews = 3;
constexpr double kLeastShare = 1e-3;

using CameraKey = std::tuple<std::uint64_t, int, int, double, double, double, double>;

CameraKey KeyOf(const View& view) {
  const Camera& camera = view.camera;
  if (view.origin.camera_id != kNoId) {
    return {view.origin.camera_id, camera.width, camera.height, 0, 0, 0, 0};
  }
  return {kNoId, camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy};
}

// 255 where `black` is and hangs together with the picture's border.
cv::Mat ConnectedWithBorder(const cv::Mat& black) {
  cv::Mat framed;
  cv::copyMakeBorder(black, framed, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(255));
  constexpr int kReached = 128;
  cv::floodFill(framed, cv::Point(0, 0), cv::Scalar(kReached));
  return framed(cv::Rect(1, 1, black.cols, black.rows)) == kReached;
}

cv::Mat BlackInAll(const std::vector<View*>& views) {
  cv::Mat black = views[0]->gray == 0;
  for (const View* view : views) black &= view->gray == 0;
  return ConnectedWithBorder(black);
}

}  // namespace

void MaskBlackBorders(Scene* scene) {
  std::map<CameraKey, std::vector<View*>> cameras;
  for (View& view : scene->views) {
    if (view.origin.lens.IsNone()) cameras[KeyOf(view)].push_back(&view);
  }
  size_t masked = 0;
  double share = 0;
  std::string first;
  for (const auto& [key, views] : cameras) {
    if (views.size() < kLeastViews) continue;
    const cv::Mat black = BlackInAll(views);
    const double part = cv::countNonZero(black) / static_cast<double>(black.total());
    if (part <= kLeastShare || part == 1) continue;
    if (masked == 0) {
      first = views[0]->name;
      share = part;
    }
    masked += views.size();
    for (View* view : views) {
      view->mask = view->mask.empty() ? cv::Mat(black == 0) : cv::Mat(view->mask & (black == 0));
    }
  }
  if (masked == 0) return;
  scene->notes.push_back(first +
                         (masked > 1 ? " and " + std::to_string(masked - 1) + " more" : "") + ": " +
                         Fixed(100 * share, 1) +
                         " % of the picture is 0 along its border in all photographs of the camera "
                         "(left by an undistortion): these pixels are not used");
}

}  // namespace burin
