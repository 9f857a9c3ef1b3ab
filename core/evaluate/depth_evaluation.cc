#include "core/evaluate/depth_evaluation.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "core/support/error.h"
#include "core/visibility/ray_render.h"

namespace burin {

void StrechaOptions::Describe(OptionSet* set) {
  set->Add("strecha.run", &run, "Compare depth maps in the views of the scene too (needs --scene)");
  set->Add("strecha.sigma", &sigma,
           "Standard deviation of the truth for the histogram, in unit; 0 = no histogram", 0, 1e12);
}

double DepthErrors::CoveredShare() const {
  return truth_pixels > 0 ? static_cast<double>(covered_pixels) / static_cast<double>(truth_pixels)
                          : 0;
}

double DepthErrors::Mae() const {
  return covered_pixels > 0 ? sum_of_sizes / static_cast<double>(covered_pixels) : 0;
}

double DepthErrors::Rmse() const {
  return covered_pixels > 0 ? std::sqrt(sum_of_squares / static_cast<double>(covered_pixels)) : 0;
}

void DepthErrors::Add(const DepthErrors& other) {
  truth_pixels += other.truth_pixels;
  covered_pixels += other.covered_pixels;
  sum_of_sizes += other.sum_of_sizes;
  sum_of_squares += other.sum_of_squares;
  for (size_t k = 0; k < within_sigmas.size(); ++k) within_sigmas[k] += other.within_sigmas[k];
  beyond_sigmas += other.beyond_sigmas;
}

DepthErrors CompareDepth(const cv::Mat1f& mesh_depth, const cv::Mat1f& truth_depth, double sigma) {
  CHECK(mesh_depth.size() == truth_depth.size());
  const auto has_depth = [](float depth) { return depth > 0 && std::isfinite(depth); };
  DepthErrors errors;
  for (int row = 0; row < truth_depth.rows; ++row) {
    for (int col = 0; col < truth_depth.cols; ++col) {
      if (!has_depth(truth_depth(row, col))) continue;
      ++errors.truth_pixels;
      if (!has_depth(mesh_depth(row, col))) continue;
      ++errors.covered_pixels;
      const double size =
          std::abs(static_cast<double>(mesh_depth(row, col)) - truth_depth(row, col));
      errors.sum_of_sizes += size;
      errors.sum_of_squares += size * size;
      if (!(sigma > 0)) continue;
      const double bin = std::max(1.0, std::ceil(size / sigma));
      if (bin <= static_cast<double>(errors.within_sigmas.size())) {
        ++errors.within_sigmas[static_cast<size_t>(bin) - 1];
      } else {
        ++errors.beyond_sigmas;
      }
    }
  }
  return errors;
}

DepthEvaluation EvaluateDepth(const TriangleMesh& mesh, const Scene& scene,
                              const TruthDepth& truth_depth, double sigma) {
  DepthEvaluation evaluation;
  evaluation.sigma = sigma;
  const MeshRays rays(mesh);
  for (size_t i = 0; i < scene.views.size(); ++i) {
    const cv::Mat1f truth = truth_depth(static_cast<int>(i));
    if (truth.empty()) continue;
    const Camera camera = scene.views[i].camera.Resized(truth.cols, truth.rows);
    const DepthErrors errors = CompareDepth(RenderDepth(rays, camera), truth, sigma);
    if (errors.truth_pixels == 0) continue;
    evaluation.names.push_back(scene.views[i].name);
    evaluation.views.push_back(errors);
    evaluation.total.Add(errors);
  }
  if (evaluation.total.truth_pixels == 0) {
    throw InputError("strecha: no pixel of the " + std::to_string(scene.views.size()) +
                     " views has a true depth: are scene and truth in the same frame?");
  }
  return evaluation;
}

}  // namespace burin
