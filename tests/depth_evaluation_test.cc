// Depth errors of planes in front of a camera, and the maps they come from.
#include "core/evaluate/depth_evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/evaluate/evaluation_report.h"
#include "core/support/error.h"
#include "core/visibility/ray_render.h"
#include "tests/test_scene.h"
#include "tests/test_shapes.h"

namespace burin {
namespace {

using testing::HasSubstr;

// Two views from z = 5 straight down onto planes that fill them.
struct DownwardViews {
  DownwardViews() {
    for (const char* name : {"a.jpg", "b.jpg"}) {
      View view;
      view.name = name;
      view.camera = test::LookAt({0, 0, 5}, {0, 0, 0}, 40, 30, 40);
      scene.views.push_back(view);
    }
  }
  static TriangleMesh PlaneAt(double z, double half = 10) {
    TriangleMesh mesh;
    test::AppendGrid(&mesh, 2, 0, 0, half, [z](double, double) { return z; });
    return mesh;
  }
  TruthDepth TruthOf(const TriangleMesh& mesh) const {
    return [this, mesh](int view) { return RenderDepth(MeshRays(mesh), scene.views[view].camera); };
  }
  Scene scene;
};

TEST(DepthEvaluation, PlaneOffsetByKSigmasIsInBinK) {
  const DownwardViews views;
  const double sigma = 0.01;
  for (int k = 1; k <= 12; ++k) {
    for (const int sign : {-1, 1}) {
      const double offset = sign * (k - 0.5) * sigma;
      const DepthEvaluation evaluation =
          EvaluateDepth(DownwardViews::PlaneAt(offset), views.scene,
                        views.TruthOf(DownwardViews::PlaneAt(0)), sigma);
      const DepthErrors& total = evaluation.total;
      EXPECT_EQ(total.truth_pixels, 2 * 40 * 30);
      EXPECT_EQ(total.CoveredShare(), 1);
      EXPECT_NEAR(total.Mae(), std::abs(offset), 1e-6);
      EXPECT_NEAR(total.Rmse(), std::abs(offset), 1e-6);
      for (int bin = 1; bin <= 10; ++bin) {
        EXPECT_EQ(total.within_sigmas[bin - 1], bin == k ? total.truth_pixels : 0) << k;
      }
      EXPECT_EQ(total.beyond_sigmas, k > 10 ? total.truth_pixels : 0);
      EXPECT_EQ(total.MissingPixels(), 0);
    }
  }
}

TEST(DepthEvaluation, TruthPixelsWithoutMeshAreMissing) {
  const DownwardViews views;
  // From depth 5 the square of half width 1 covers 16 x 16 pixels of each view.
  const DepthEvaluation evaluation = EvaluateDepth(DownwardViews::PlaneAt(0, 1), views.scene,
                                                   views.TruthOf(DownwardViews::PlaneAt(0)), 0.01);
  EXPECT_EQ(evaluation.total.covered_pixels, 2 * 16 * 16);
  EXPECT_EQ(evaluation.total.MissingPixels(), 2 * (40 * 30 - 16 * 16));
  EXPECT_EQ(evaluation.total.within_sigmas[0], 2 * 16 * 16);
  EXPECT_EQ(evaluation.names, (std::vector<std::string>{"a.jpg", "b.jpg"}));
  // The other way round the mesh's excess does not count.
  const DepthEvaluation reverse = EvaluateDepth(DownwardViews::PlaneAt(0), views.scene,
                                                views.TruthOf(DownwardViews::PlaneAt(0, 1)), 0.01);
  EXPECT_EQ(reverse.total.truth_pixels, 2 * 16 * 16);
  EXPECT_EQ(reverse.total.CoveredShare(), 1);
}

TEST(CompareDepth, MaeAndRmseOfTwoErrors) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const cv::Mat1f truth = (cv::Mat1f(2, 4) << 2, 2, 2, 2, 0, nan, 2, 2);
  const cv::Mat1f mesh = (cv::Mat1f(2, 4) << 2.25, 2.25, 1.25, 1.25, 2, 2, 0, 2);
  const DepthErrors errors = CompareDepth(mesh, truth, 0.25);
  EXPECT_EQ(errors.truth_pixels, 6);
  EXPECT_EQ(errors.covered_pixels, 5);
  EXPECT_DOUBLE_EQ(errors.Mae(), (2 * 0.25 + 2 * 0.75) / 5);
  EXPECT_DOUBLE_EQ(errors.Rmse(), std::sqrt((2 * 0.0625 + 2 * 0.5625) / 5));
  EXPECT_EQ(errors.within_sigmas[0], 3);  // 0, and 0.25 = 1 sigma itself
  EXPECT_EQ(errors.within_sigmas[2], 2);
  EXPECT_EQ(errors.MissingPixels(), 1);
  EXPECT_EQ(CompareDepth(mesh, truth, 0).within_sigmas[0], 0);
}

TEST(DepthEvaluation, MapsMayBeSmallerThanTheImageOrMissing) {
  const DownwardViews views;
  const TruthDepth half_size = [](int view) {
    return view == 0 ? cv::Mat1f(15, 20, 5.0F) : cv::Mat1f();
  };
  const DepthEvaluation evaluation =
      EvaluateDepth(DownwardViews::PlaneAt(0.5), views.scene, half_size, 0);
  EXPECT_EQ(evaluation.total.truth_pixels, 15 * 20);
  EXPECT_NEAR(evaluation.total.Mae(), 0.5, 1e-6);
  EXPECT_EQ(evaluation.views.size(), 1u);
}

TEST(DepthEvaluation, NoTruthInAnyViewIsRefused) {
  const DownwardViews views;
  EXPECT_THROW(EvaluateDepth(DownwardViews::PlaneAt(0), views.scene,
                             views.TruthOf(DownwardViews::PlaneAt(9)), 0.01),
               InputError);
}

TEST(DepthEvaluation, ReportAndJsonSayTheSame) {
  const DownwardViews views;
  const DepthEvaluation evaluation = EvaluateDepth(DownwardViews::PlaneAt(0.025, 1), views.scene,
                                                   views.TruthOf(DownwardViews::PlaneAt(0)), 0.01);
  const std::string report = DepthReport(evaluation, 0.001);
  EXPECT_THAT(report, HasSubstr("a.jpg"));
  EXPECT_THAT(report, HasSubstr("sigma = 10 "));
  const nlohmann::json json = ToJson(evaluation);
  EXPECT_NEAR(json["mae"].get<double>(), 0.025, 1e-6);
  EXPECT_EQ(json["histogram"]["within_sigmas"][2].get<std::int64_t>(),
            evaluation.total.covered_pixels);
  EXPECT_EQ(json["histogram"]["missing"].get<std::int64_t>(), evaluation.total.MissingPixels());
  EXPECT_EQ(json["views"][1]["name"], "b.jpg");
  const nlohmann::json without = ToJson(EvaluateDepth(DownwardViews::PlaneAt(0), views.scene,
                                                      views.TruthOf(DownwardViews::PlaneAt(0)), 0));
  EXPECT_TRUE(without["histogram"].is_null());
}

}  // namespace
}  // namespace burin
