#include "apps/run/intrinsics_output.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/scene/lens_points.h"
#include "core/support/fixed_text.h"
#include "core/support/json_file.h"
#include "core/support/median.h"

namespace burin {
namespace {

using nlohmann::ordered_json;

constexpr size_t kFewCameras = 4;  // a line of each
// Changed far more than others: by so many of their medians, and by so many pixels.
constexpr double kFarOff = 4;
constexpr double kFarPx = 8;

constexpr const char* kCoefficients[] = {"k1", "k2", "p1", "p2", "k3", "measured"};

double Coefficient(const Lens& lens, size_t k) {
  return k < lens.brown.size() ? lens.brown[k] : lens.measured;
}

std::string CameraName(const SharedIntrinsics& shared, const Scene& scene) {
  const View& first = scene.views[shared.views[0]];
  if (shared.views.size() == 1) return first.name;
  if (shared.views.size() == scene.views.size()) return "all photographs";
  if (first.origin.camera_id == kNoId) return "photographs as " + first.name;
  return "camera " + std::to_string(first.origin.camera_id);
}

double CornerMove(const View& view, const Camera& camera, const Lens& lens) {
  const Camera& was = view.camera;
  const double fold = 0.99 * std::min(FoldRadius(view.origin.lens, CornerRadius(was)),
                                      FoldRadius(lens, CornerRadius(was)));
  double farthest = 0;
  for (const double x : {0, was.width}) {
    for (const double y : {0, was.height}) {
      Eigen::Vector2d ray((x - was.cx) / was.fx, (y - was.cy) / was.fy);
      ray *= std::min(1.0, fold / ray.norm());
      const auto shown = [&ray](const Camera& by, const Lens& through) {
        return PhotographedAt(by, through, {ray.x() * by.fx + by.cx, ray.y() * by.fy + by.cy});
      };
      const Eigen::Vector2d moved = shown(camera, lens) - shown(was, view.origin.lens);
      farthest = std::max(farthest, moved.norm());
    }
  }
  return farthest;
}

std::vector<double> CornerMoves(const std::vector<IntrinsicsChange>& changes) {
  std::vector<double> px;
  px.reserve(changes.size());
  for (const IntrinsicsChange& change : changes) px.push_back(change.corner_px);
  return px;
}

// Places of step.bundle.shared, largest change first.
std::vector<size_t> FarOff(const std::vector<IntrinsicsChange>& changes) {
  std::vector<size_t> far;
  if (changes.size() <= kFewCameras) return far;
  const double usual = Median(CornerMoves(changes));
  for (size_t c = 0; c < changes.size(); ++c) {
    if (changes[c].corner_px > std::max(kFarPx, kFarOff * usual)) far.push_back(c);
  }
  std::stable_sort(far.begin(), far.end(),
                   [&](size_t a, size_t b) { return changes[a].corner_px > changes[b].corner_px; });
  return far;
}

std::string Signed(double number, int digits) {
  return (number < 0 ? "" : "+") + Fixed(number, digits);
}

// "1379.7", or "1379.7, 1382.1" where pixels are not square.
std::string FocalLengths(const Camera& camera) {
  return Fixed(camera.fx, 1) + (camera.fx == camera.fy ? "" : ", " + Fixed(camera.fy, 1));
}

std::string Line(const TrackStep& step, const Scene& scene, size_t c,
                 const IntrinsicsChange& change) {
  const SharedIntrinsics& shared = step.bundle.shared[c];
  const std::string name =
      "cameras: " + CameraName(shared, scene) + (step.Kept() ? ": " : ": not taken: ");
  if (!shared.AnyFree()) return name + "intrinsics left as given";
  const int v = shared.views[0];
  const Camera& was = scene.views[v].camera;
  const Camera& now = step.bundle.cameras[v];
  std::string line = name + "focal length " + FocalLengths(was) + " -> " + FocalLengths(now) +
                     " px (" + Signed(100 * (now.fx / was.fx - 1), 2) + " %, " +
                     Fixed(std::abs(change.focal_px), 2) + " px at the edge";
  if (std::isfinite(shared.deviation_px[kFocal])) {
    line += ", standard deviation " + Fixed(shared.deviation_px[kFocal], 2);
  }
  line += ")";
  if (shared.free[kCenter]) {
    line += ", principal point by " + Signed(now.cx - was.cx, 2) + ", " +
            Signed(now.cy - was.cy, 2) + " px; the corners move by " + Fixed(change.corner_px, 2) +
            " px";
  }
  return line;
}

}  // namespace

std::vector<IntrinsicsChange> IntrinsicsChanges(const TrackStep& step, const Scene& scene) {
  std::vector<IntrinsicsChange> changes;
  for (const SharedIntrinsics& shared : step.bundle.shared) {
    const int v = shared.views[0];
    const View& view = scene.views[v];
    const Camera& now = step.bundle.cameras[v];
    const double edge = 0.5 * std::max(now.width, now.height);
    changes.push_back(
        {(now.fx / view.camera.fx - 1) * edge, CornerMove(view, now, step.bundle.lenses[v])});
  }
  return changes;
}

std::vector<std::string> IntrinsicsText(const TrackStep& step, const Scene& scene) {
  std::vector<std::string> lines;
  const std::vector<IntrinsicsChange> changes = IntrinsicsChanges(step, scene);
  if (changes.empty()) return lines;
  if (changes.size() <= kFewCameras) {
    for (size_t c = 0; c < changes.size(); ++c) lines.push_back(Line(step, scene, c, changes[c]));
    return lines;
  }
  if (std::none_of(step.bundle.shared.begin(), step.bundle.shared.end(),
                   [](const SharedIntrinsics& shared) { return shared.AnyFree(); })) {
    return lines;
  }
  lines.push_back("cameras: intrinsics of " + std::to_string(changes.size()) +
                  " cameras: the corners " + (step.Kept() ? "move by " : "would move by ") +
                  Fixed(Median(CornerMoves(changes)), 2) + " px (median)");
  for (const size_t c : FarOff(changes)) {
    lines.push_back(Line(step, scene, c, changes[c]) + ": far more than the others");
  }
  return lines;
}

ordered_json IntrinsicsJson(const TrackStep& step, const Scene& scene) {
  const std::vector<IntrinsicsChange> changes = IntrinsicsChanges(step, scene);
  const std::vector<size_t> far = FarOff(changes);
  ordered_json list = ordered_json::array();
  for (size_t c = 0; c < changes.size(); ++c) {
    const SharedIntrinsics& shared = step.bundle.shared[c];
    const int v = shared.views[0];
    const View& view = scene.views[v];
    const Camera& was = view.camera;
    const Camera& now = step.bundle.cameras[v];
    ordered_json json;
    json["id"] =
        view.origin.camera_id == kNoId ? ordered_json() : ordered_json(view.origin.camera_id);
    json["views"] = ordered_json::array();
    for (const int of : shared.views) json["views"].push_back(scene.views[of].name);
    json["measurements"] = shared.measurements;
    json["refined"] = shared.AnyFree();
    json["corner_px"] = RoundedOrNull(changes[c].corner_px);
    json["far_off"] = std::find(far.begin(), far.end(), c) != far.end();
    json["focal_length"] = {{"before", {was.fx, was.fy}},
                            {"after", {now.fx, now.fy}},
                            {"edge_px", RoundedOrNull(changes[c].focal_px)},
                            {"deviation_px", RoundedOrNull(shared.deviation_px[kFocal])}};
    json["principal_point"] = {{"before", {was.cx, was.cy}},
                               {"after", {now.cx, now.cy}},
                               {"deviation_px",
                                {RoundedOrNull(shared.deviation_px[kCenter]),
                                 RoundedOrNull(shared.deviation_px[kCenter + 1])}}};
    json["distortion"] = ordered_json::object();
    for (size_t k = 0; k < std::size(kCoefficients); ++k) {
      if (!shared.free[kBrown + k]) continue;
      json["distortion"][kCoefficients[k]] = {
          {"before", Coefficient(view.origin.lens, k)},
          {"after", Coefficient(step.bundle.lenses[v], k)},
          {"corner_deviation_px", RoundedOrNull(shared.deviation_px[kBrown + k])}};
    }
    list.push_back(std::move(json));
  }
  return list;
}

}  // namespace burin
