// Pictures of meshes from calibrated cameras: what a person looks at before believing a number.
// Pictures are the same bytes for any number of threads.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"

namespace burin {

struct RenderOptions {
  int supersampling = 2;                   // rays per pixel and axis, averaged
  bool smooth = false;                     // interpolated vertex normals; false shows every facet
  cv::Vec3b background = {255, 255, 255};  // blue, green, red
};

// Grey clay under a headlight, a key light from the upper left and some ambient light. Facets seen
// from behind are reddish, so that holes and flipped facets show.
cv::Mat3b RenderShaded(const TriangleMesh& mesh, const Camera& camera,
                       const RenderOptions& options = {});

// How numbers become colours, and the colour bar that says so.
struct ColorScale {
  double min = 0;  // values are clamped to [min, max]
  double max = 1;
  double unit = 1;    // the bar shows value / unit ...
  std::string label;  // ... under this heading, for example "error [mm]" (ASCII)
};

// Colour of a value, (blue, green, red). Scales with min < 0 < max go from blue through light grey
// to red (linear in CIE Lab on both sides; give min = -max, the middle of the scale is the grey),
// others through viridis. NaN is mid grey.
cv::Vec3b ScaleColor(const ColorScale& scale, double value);

// The picture with a bar of the scale's colours, five numbers and the heading on its right.
cv::Mat3b WithColorBar(const cv::Mat3b& picture, const ColorScale& scale);

// The mesh coloured by one value per vertex, interpolated over the facets and slightly shaded, with
// a colour bar attached on the right: the picture is wider than the camera's image. Facets with a
// NaN corner are mid grey. CHECKs that there are as many values as vertices and min < max.
cv::Mat3b RenderVertexScalar(const TriangleMesh& mesh, const Camera& camera,
                             const std::vector<double>& values, const ColorScale& scale,
                             const RenderOptions& options = {});

// The same with one value per facet, constant over it. CHECKs that there are as many values as
// facets.
cv::Mat3b RenderFaceScalar(const TriangleMesh& mesh, const Camera& camera,
                           const std::vector<double>& values, const ColorScale& scale,
                           const RenderOptions& options = {});

}  // namespace burin
