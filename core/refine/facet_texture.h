// Whether photographs show anything on a facet: what decides that it is worth splitting, and that a low ZNCC on it
// says something.
//
// Sky, and other background without texture, holds no window that says where a surface is. A surface that a
// start has there all the same would be cut into as many facets as the photographs have pixels of it.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/pyramid.h"
#include "core/visibility/mesh_rays.h"

namespace burin {

// 255 at the middle of 5x5 windows with texture, grey levels of a standard deviation of at least `least_deviation`; 0
// elsewhere and where the window leaves the image.
cv::Mat1b TexturedPixels(const cv::Mat& image, double least_deviation);

class FacetTexture {
 public:
  // Keeps a reference to the views. Texture is 1.5 times the view's noise and 2 % of the photographs' contrast.
  FacetTexture(const std::vector<LevelView>& views, const TriangleMesh& mesh);

  // Some point of triangle abc, a piece of the mesh, drawn twice as large about its middle, has in two views that see
  // it texture. Points are a window apart in the sharpest view. Twice as large, because what lies
  // beside texture follows it.
  bool InTwoViews(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                  const Eigen::Vector3d& c) const;

 private:
  bool IsTextured(int view, const Eigen::Vector3d& point) const;

  const std::vector<LevelView>& views_;
  const MeshRays rays_;
  std::vector<Eigen::Vector3d> centers_;
  std::vector<cv::Mat1b> textured_;  // by view; empty: it takes no part
};

}  // namespace burin
