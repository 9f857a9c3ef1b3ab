#include "core/cameras/intrinsics.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <tuple>

namespace burin {
namespace {

constexpr double kEarlier = 0.98;  // of the radius at which the lens folds back, or of the corner's

// How many of k1, k2, p1, p2 a camera model has.
struct ModelCoefficients {
  const char* name;
  int count;
};
constexpr ModelCoefficients kModels[] = {
    {"SIMPLE_RADIAL", 1},     {"RADIAL", 2},          {"OPENCV", 4}, {"pinhole_radial_k1", 1},
    {"pinhole_radial_k3", 2}, {"pinhole_brown_t2", 4}};

std::array<bool, kIntrinsics> FreeNumbers(const View& view, IntrinsicUnknowns unknowns) {
  std::array<bool, kIntrinsics> free = {};
  const Lens& lens = view.origin.lens;
  if (!lens.IsNone() && view.image_path.empty()) return free;
  free[kFocal] = true;
  if (unknowns == IntrinsicUnknowns::kFocal) return free;
  free[kRatio] = view.camera.fx != view.camera.fy;
  free[kCenter] = free[kCenter + 1] = true;
  if (view.image_path.empty()) return free;
  int had = 0;
  for (const ModelCoefficients& model : kModels) {
    if (view.origin.camera_model == model.name) had = model.count;
  }
  for (int k = 0; k < 5; ++k) {
    free[kBrown + k] = lens.brown[k] != 0 || k < had;
  }
  free[kMeasured] = lens.measured != 0;
  return free;
}

IntrinsicNumbers Units(const Camera& camera) {
  const double focal = std::sqrt(camera.fx * camera.fy);
  const double r = CornerRadius(camera);
  return {2.0 / std::max(camera.width, camera.height),
          2.0 / camera.height,
          1,
          1,
          1 / (focal * std::pow(r, 3)),
          1 / (focal * std::pow(r, 5)),
          1 / (3 * focal * r * r),
          1 / (3 * focal * r * r),
          1 / (focal * std::pow(r, 7)),
          1 / (focal * std::pow(r, 3))};
}

// Pixels of the photograph up to which the lens does not fold back; at most the corner's.
double UnfoldedPx(const Camera& camera, const Lens& lens) {
  return FoldRadius(lens, CornerRadius(camera)) * std::sqrt(camera.fx * camera.fy);
}

}  // namespace

bool SharedIntrinsics::AnyFree() const {
  return std::any_of(free.begin(), free.end(), [](bool one) { return one; });
}

Camera SharedIntrinsics::CameraAt(const IntrinsicNumbers& q) const {
  Camera at = camera;
  at.fx *= 1 + q[kFocal] * unit[kFocal];
  at.fy *= (1 + q[kFocal] * unit[kFocal]) * (1 + q[kRatio] * unit[kRatio]);
  at.cx += q[kCenter] * unit[kCenter];
  at.cy += q[kCenter + 1] * unit[kCenter + 1];
  return at;
}

Lens SharedIntrinsics::LensAt(const IntrinsicNumbers& q) const {
  Lens at = lens;
  for (size_t k = 0; k < lens.brown.size(); ++k) {
    at.brown[k] += q[kBrown + k] * unit[kBrown + k];
  }
  at.measured += q[kMeasured] * unit[kMeasured];
  return at;
}

std::vector<SharedIntrinsics> CamerasSharedIn(const Scene& scene, IntrinsicUnknowns unknowns) {
  std::vector<SharedIntrinsics> shared;
  if (unknowns == IntrinsicUnknowns::kNone) return shared;
  using Key = std::tuple<std::uint64_t, std::string, int, int, double, double, double, double,
                         std::array<double, 5>, double>;
  std::map<Key, size_t> place;
  for (size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    const Camera& camera = view.camera;
    const Origin& origin = view.origin;
    const Key key(origin.camera_id, origin.camera_model, camera.width, camera.height, camera.fx,
                  camera.fy, camera.cx, camera.cy, origin.lens.brown, origin.lens.measured);
    const auto [at, is_new] = place.emplace(key, shared.size());
    if (is_new) {
      SharedIntrinsics& one = shared.emplace_back();
      one.camera = camera;
      one.lens = origin.lens;
      one.unit = Units(camera);
      one.free = FreeNumbers(view, unknowns);
    }
    SharedIntrinsics& one = shared[at->second];
    one.views.push_back(static_cast<int>(v));
    const std::array<bool, kIntrinsics> free = FreeNumbers(view, unknowns);
    for (int k = 0; k < kIntrinsics; ++k) one.free[k] = one.free[k] && free[k];
  }
  return shared;
}

bool FoldsEarlier(const Scene& scene, const std::vector<Camera>& cameras,
                  const std::vector<Lens>& lenses) {
  for (size_t v = 0; v < lenses.size(); ++v) {
    const View& view = scene.views[v];
    const double corner = CornerRadius(cameras[v]) * std::sqrt(cameras[v].fx * cameras[v].fy);
    const double before = std::min(corner, UnfoldedPx(view.camera, view.origin.lens));
    if (UnfoldedPx(cameras[v], lenses[v]) < kEarlier * before) return true;
  }
  return false;
}

}  // namespace burin
