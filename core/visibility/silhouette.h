// Which points of the truth lie near an occlusion boundary: where refinement goes wrong first, and
// what occlusion masks are for.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "core/scene/camera.h"
#include "core/scene/scene.h"

namespace burin {

struct SilhouetteOptions {
  double step_px = 10;  // depths of neighbouring pixels that differ by more pixel footprints (depth
                        // / focal length) are a step; so is the border between surface and none
  double radius_px = 4;   // points that project this near to a step are near a boundary
  double visible_px = 5;  // a view sees a point within this many footprints of its depth map
};

// True for the points that some view sees near a step of its depth map. depth[i] holds view i's
// camera z in world units, 0 = no surface; it may be smaller than the image by a constant factor,
// and lengths in px are then pixels of the map.
std::vector<char> NearSilhouettes(const std::vector<Eigen::Vector3d>& points,
                                  const std::vector<Camera>& cameras,
                                  const std::vector<cv::Mat1f>& depth,
                                  const SilhouetteOptions& options);

// Depth maps of the views of a scene from a folder, for a view called NAME.jpg: NAME.tiff (32-bit
// float, world units; as `burin synth` writes them) or NAME_depth.png (16 bits, times `png_unit`); the
// folders in NAME may be left out where no two views have one file name.
// A view without a map gets an empty one. Throws InputError when there is none at all, or one that
// cannot be read or has another shape than the view's image.
std::vector<cv::Mat1f> ReadDepthMaps(const std::filesystem::path& folder, const Scene& scene,
                                     double png_unit);

}  // namespace burin
