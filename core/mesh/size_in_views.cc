#include "core/mesh/size_in_views.h"

#include <algorithm>
#include <utility>

#include "core/mesh/projected_area.h"
#include "core/support/parallel.h"

namespace burin {

SizeInViews::SizeInViews(const TriangleMesh& mesh, const std::vector<Camera>& cameras,
                         double max_facet_px, double max_edge_px,
                         const std::vector<std::vector<char>>* face_visible_in_view)
    : mesh_(mesh), cameras_(cameras), max_facet_px_(max_facet_px), max_edge_px_(max_edge_px) {
  for (const Camera& camera : cameras) projections_.push_back(camera.ProjectionMatrix());
  views_.resize(mesh_.faces.size());
  ParallelFor(static_cast<int>(mesh_.faces.size()), 256, [&](int begin, int end) {
    std::vector<std::pair<double, int>> sized;
    for (int f = begin; f < end; ++f) {
      sized.clear();
      for (size_t i = 0; i < cameras_.size(); ++i) {
        if (face_visible_in_view != nullptr && !(*face_visible_in_view)[f][i]) continue;
        if (!FacesCamera(mesh_, f, cameras_[i])) continue;
        const double area = AreaInView(static_cast<int>(i), mesh_.faces[f]);
        if (area > 0) sized.emplace_back(-area, static_cast<int>(i));
      }
      std::sort(sized.begin(), sized.end());
      for (const auto& [negative_area, i] : sized) views_[f].push_back(i);
    }
  });
}

bool SizeInViews::IsTooLarge(int face, const Eigen::Vector3i& corners) const {
  double edge = 0;
  for (int c = 0; c < 3; ++c) {
    edge =
        std::max(edge, (mesh_.vertices[corners[c]] - mesh_.vertices[corners[(c + 1) % 3]]).norm());
  }
  for (int i : views_[face]) {
    const double area = AreaInView(i, corners);
    if (area > max_facet_px_) return true;
    if (max_edge_px_ > 0 && area > 0 && edge > max_edge_px_ * LargestFootprint(i, corners)) {
      return true;
    }
  }
  return false;
}

double SizeInViews::AreaInView(int i, const Eigen::Vector3i& corners) const {
  return ProjectedArea(projections_[i], cameras_[i].width, cameras_[i].height,
                       cameras_[i].near_depth, mesh_.vertices[corners[0]],
                       mesh_.vertices[corners[1]], mesh_.vertices[corners[2]]);
}

double SizeInViews::LargestFootprint(int i, const Eigen::Vector3i& corners) const {
  double largest = 0;
  for (int c = 0; c < 3; ++c) {
    largest = std::max(largest, cameras_[i].Footprint(mesh_.vertices[corners[c]]));
  }
  return largest;
}

}  // namespace burin
