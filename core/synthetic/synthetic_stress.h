// Does to synthetic photographs what goes wrong with real ones: `synth.stress`.
//
//   none
//   exposure      the views' gains step from 0.6 to 1.5, offsets from -20 to 20 grey levels
//   saturated     a third of every third view is overexposed six times
//   mover         a textured disc, a quarter of the image high, is in front of everything in two views,
//                 in different places
//   textureless   patches of about 80 px without any texture, half of the surface
//   repeated      the texture of a cube of 20 px, again and again
//   pose          the calibration of one view is rotated so that its image is off by 3 px
#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/scene/camera.h"

namespace burin {

const std::vector<std::string>& StressNames();

struct Exposure {
  double gain = 1;
  double offset = 0;  // grey levels
};

class Stress {
 public:
  // `name` is one of StressNames(); `footprint` in world units per px.
  Stress(std::string name, double footprint) : name_(std::move(name)), footprint_(footprint) {}

  // Albedo at a point, from the texture without stress.
  double Albedo(const std::function<double(const Eigen::Vector3d&)>& texture,
                const Eigen::Vector3d& point) const;
  // `usual` is that without stress.
  Exposure ExposureOf(int view, const Exposure& usual) const;
  // Of `count` views: what comes between the surface and the sensor. `texture` is that of the scene.
  void ChangeRadiance(int view, int count,
                      const std::function<double(const Eigen::Vector3d&)>& texture,
                      cv::Mat1f* radiance) const;
  // The calibration that the scene gives for a camera.
  Camera Calibration(int view, int count, const Camera& truth) const;

 private:
  std::string name_;
  double footprint_;
};

}  // namespace burin
