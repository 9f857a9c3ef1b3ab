#include "core/evidence/offset_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/image/picture.h"
#include "core/support/fixed_text.h"

namespace burin {
namespace {

constexpr double kZoom = 6;   // pixels of the picture to a px
constexpr int kCaption = 34;  // two lines
constexpr int kMargin = 8;
constexpr int kPlotWidth = static_cast<int>(kZoom * (2 * kMatchAlong + 1));
constexpr int kPlotHeight = static_cast<int>(kZoom * (2 * kMatchAcross + 1));
constexpr int kPanelWidth = kPlotWidth + 2 * kMargin;
constexpr int kPanelHeight = kPlotHeight + kCaption + kMargin;
constexpr int kColumns = 4;
const cv::Scalar kPlain(248, 248, 248);
const cv::Scalar kMisfit(225, 225, 255);
const cv::Scalar kAxis(190, 190, 190);
const cv::Scalar kClear(140, 60, 0);
const cv::Scalar kVague(205, 190, 175);
const cv::Scalar kWithMisfit(175, 175, 245);

std::string Figures(const ViewEvidence& view) {
  std::string text = std::to_string(view.evidence.windows) + " windows";
  if (std::isfinite(view.evidence.on_line)) {
    text += "  E " + Fixed(view.evidence.on_line, 2) + "  A " + Fixed(view.evidence.at_place, 2) +
            "  px " + Fixed(view.evidence.noise_px, 2);
  }
  return view.misfit ? text + "  does not fit" : text;
}

}  // namespace

cv::Mat3b OffsetPicture(const SceneVerdict& verdict, const Scene& scene) {
  const auto views = static_cast<int>(scene.views.size());
  const int columns = std::max(1, std::min(kColumns, views));
  cv::Mat3b picture(kPanelHeight * ((views + columns - 1) / columns), kPanelWidth * columns,
                    cv::Vec3b(255, 255, 255));
  const auto plot = [&](int view) {
    return cv::Point(view % columns * kPanelWidth + kMargin,
                     view / columns * kPanelHeight + kCaption);
  };
  const auto at = [&](int view, double along, double across) {
    return plot(view) +
           cv::Point(static_cast<int>(std::lround(kZoom * (along + kMatchAlong + 0.5))),
                     static_cast<int>(std::lround(kZoom * (across + kMatchAcross + 0.5))));
  };
  for (int v = 0; v < views; ++v) {
    const ViewEvidence& view = verdict.views[v];
    const cv::Rect area(plot(v), cv::Size(kPlotWidth, kPlotHeight));
    cv::rectangle(picture, area, view.misfit ? kMisfit : kPlain, cv::FILLED);
    cv::line(picture, at(v, -kMatchAlong, 0), at(v, kMatchAlong, 0), kAxis);
    cv::line(picture, at(v, 0, -kMatchAcross), at(v, 0, kMatchAcross), kAxis);
    const cv::Size line(kPlotWidth, kCaption / 2 - 3);
    DrawText(scene.views[v].name, area.tl() + cv::Point(0, -3 * kCaption / 4), line, &picture);
    DrawText(Figures(view), area.tl() + cv::Point(0, -kCaption / 4), line, &picture);
  }
  for (const bool clear : {false, true}) {
    for (const WindowMatch& match : verdict.matches) {
      if (match.clear != clear) continue;
      const bool other_misfit =
          verdict.views[match.second].misfit && !verdict.views[match.reference].misfit;
      cv::circle(picture, at(match.reference, match.along, match.across), 2,
                 other_misfit ? kWithMisfit
                 : clear      ? kClear
                              : kVague,
                 cv::FILLED, cv::LINE_AA);
    }
  }
  return picture;
}

}  // namespace burin
