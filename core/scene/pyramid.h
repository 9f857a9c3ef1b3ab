// The views of a scene at one level of the coarse-to-fine loop.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "core/scene/camera.h"
#include "core/scene/scene.h"

namespace burin {

// What a level makes of a view.
struct ViewAtLevel {
  int halvings = 0;        // of its photograph
  bool takes_part = true;  // no pair uses a view that does not
  bool coarse = false;     // its pixels are, so that it is halved less than others on coarse levels
};

// A view at one level of the pyramid, in the normalised world (see core/refine/refinement.h).
struct LevelView {
  ViewAtLevel at;
  Camera camera;
  cv::Mat image;           // grey levels 0..255, CV_8UC1 or CV_32FC1
  cv::Mat mask;            // CV_8UC1, 0 = not to be used; empty = all pixels are
  cv::Mat1f object;        // View::object, 0 to 1; empty = not known
  cv::Mat1b photographed;  // 0 where that is made of pixels outside the photograph; empty = nowhere
  double noise_sigma = 0;  // of this level's image, in grey levels (core/image/grey_statistics.h)
  // Of the photographs in full, in grey levels, the same at all levels.
  double contrast = 0;           // of all views together
  double photo_noise_sigma = 0;  // of this view

  // The image in single precision; a copy unless it is already.
  cv::Mat1f FloatImage() const {
    cv::Mat1f result;
    image.convertTo(result, CV_32F);
    return result;
  }
};

// Images area-averaged to 2^-halvings of their size (at least 16 pixels a side) with matching cameras,
// in the world mapped by X -> scale * (X - origin). No halving keeps the size. A pixel of a level is
// used when the mask allows every pixel that it is made of, and those around them. Pixels of a level
// that are made of masked ones hold their surroundings carried on instead of what was photographed:
// a masked pixel's grey level has no weight at all in a spline's sample, nor in contrast and noise.
// `cameras`: of the views, in place of the scene's.
std::vector<LevelView> MakeLevelViews(const Scene& scene, const std::vector<Camera>& cameras,
                                      const std::vector<ViewAtLevel>& level,
                                      const Eigen::Vector3d& origin, double scale);
// All of them halved `level` times, and take part.
std::vector<LevelView> MakeLevelViews(const Scene& scene, int level, const Eigen::Vector3d& origin,
                                      double scale);

// The view whose size names the level: the first that takes part and is not coarse, or else the first.
const LevelView& NamesLevel(const std::vector<LevelView>& views);

}  // namespace burin
