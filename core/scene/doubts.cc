#include "core/scene/doubts.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/scene/track_errors.h"
#include "core/support/fixed_text.h"

namespace burin {
namespace {

constexpr double kFarFromMiddle = 0.1;  // of the side; real cameras' lie within .081
constexpr double kLeastAspect = 0.8;    // fx / fy
constexpr double kMostAspect = 1.25;
constexpr size_t kNamed = 3;

double OffMiddle(double center, int side) { return std::abs(center / side - 0.5); }

// What is doubtful about a camera in one respect; empty when nothing is.
using Doubt = std::function<std::string(const Camera&)>;

std::string PrincipalPoint(const Camera& camera) {
  const double off_x = OffMiddle(camera.cx, camera.width);
  const double off_y = OffMiddle(camera.cy, camera.height);
  if (std::max(off_x, off_y) <= kFarFromMiddle) return {};
  return "principal point = (" + Fixed(camera.cx, 1) + ", " + Fixed(camera.cy, 1) +
         ") of a picture " + std::to_string(camera.width) + "x" + std::to_string(camera.height) +
         ": " + Fixed(std::max(off_x, off_y), 2) + " of the " +
         (off_x >= off_y ? "width" : "height") +
         " from the middle, which only cropped pictures have (is it of a picture of another size?)";
}

std::string Aspect(const Camera& camera) {
  const double aspect = camera.fx / camera.fy;
  if (aspect >= kLeastAspect && aspect <= kMostAspect) return {};
  return "focal lengths = " + Fixed(camera.fx, 1) + ", " + Fixed(camera.fy, 1) +
         ": fx / fy = " + Fixed(aspect, 2) +
         ", no usual camera's (of a picture that was stretched?)";
}

}  // namespace

std::vector<std::string> DoubtsAbout(const Scene& scene) {
  std::vector<std::string> lines = scene.notes;
  for (const Doubt& doubt : {Doubt(PrincipalPoint), Doubt(Aspect)}) {
    std::string first;
    const View* named = nullptr;
    int more = 0;
    for (const View& view : scene.views) {
      const std::string text = doubt(view.camera);
      if (text.empty()) continue;
      if (named == nullptr) {
        named = &view;
        first = text;
      } else {
        ++more;
      }
    }
    if (named == nullptr) continue;
    lines.push_back(named->name + (more > 0 ? " and " + std::to_string(more) + " more" : "") +
                    ": " + first);
  }
  if (const std::string errors = TrackErrorText(scene); !errors.empty()) {
    lines.push_back("sparse points are not where they were measured: " + errors + " (median)");
  }
  return lines;
}

std::string TrackErrorText(const Scene& scene) {
  const TrackErrors errors = MeasureTrackErrors(scene);
  std::string text;
  for (size_t k = 0; k < std::min(kNamed, errors.off.size()); ++k) {
    const double px = errors.median_px[errors.off[k]];
    text += (k > 0 ? ", " : "") + scene.views[errors.off[k]].name + " " +
            (std::isfinite(px) ? Fixed(px, 1) + " px" : "behind the camera");
  }
  if (errors.off.size() > kNamed) {
    text += " and " + std::to_string(errors.off.size() - kNamed) + " more";
  }
  return text;
}

}  // namespace burin
