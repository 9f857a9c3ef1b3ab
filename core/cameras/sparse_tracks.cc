#include "core/cameras/sparse_tracks.h"

#include <glog/logging.h>

#include <algorithm>
#include <numeric>

namespace burin {
namespace {

std::vector<Measurement> FirstOfEachView(const Tracks::Range& track) {
  std::vector<Measurement> firsts;
  for (const Measurement& measured : track) {
    const bool known = std::any_of(firsts.begin(), firsts.end(), [&](const Measurement& other) {
      return other.view == measured.view;
    });
    if (!known) firsts.push_back(measured);
  }
  return firsts;
}

}  // namespace

void AppendSparseTracks(const Scene& scene, std::vector<Eigen::Vector3d>* points, Tracks* tracks) {
  CHECK(scene.tracks.PointCount() == 0 || scene.tracks.PointCount() == scene.points.size());
  std::vector<int> order(scene.tracks.PointCount());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return scene.tracks.Of(a).size() > scene.tracks.Of(b).size();
  });
  std::vector<int> count(scene.views.size(), 0);
  for (const int p : order) {
    const std::vector<Measurement> track = FirstOfEachView(scene.tracks.Of(p));
    if (track.size() < 2) continue;
    const bool wanted = std::any_of(track.begin(), track.end(), [&](const Measurement& measured) {
      return count[measured.view] < kSparseTracks;
    });
    if (!wanted) continue;
    points->push_back(scene.points[p].position);
    tracks->BeginPoint();
    for (const Measurement& measured : track) {
      tracks->Add(measured);
      ++count[measured.view];
    }
  }
}

}  // namespace burin
