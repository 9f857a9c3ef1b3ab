// How far matches of an evaluation reach, and what must not depend on it.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdlib>
#include <filesystem>

#include "core/evaluate/evaluation.h"
#include "core/evaluate/truth.h"
#include "core/mesh/mesh_io.h"
#include "core/support/error.h"
#include "tests/test_shapes.h"
#include "tests/test_truths.h"

namespace burin {
namespace {

// Ramps over a plane: distances from 0 to far beyond the matching distance, on a truth of either kind.
TEST(MatchingDistance, NothingDependsOnWhichThresholdsAreListed) {
  const TriangleMesh ramp = Grid(4, 1.0, [](double x, double) { return 0.1 * x; });
  const Truth truths[] = {MeshTruth(Plane(0)), CloudTruth(Plane(0), 20000, true)};
  for (const Truth& truth : truths) {
    for (const UnmatchedSamples unmatched : {UnmatchedSamples::kCount, UnmatchedSamples::kDrop}) {
      EvaluationOptions options = Options("0.005", 5000);
      options.unmatched = unmatched;
      options.align = AlignmentKind::kRigid;
      const Evaluation one = EvaluateMesh(ramp, truth, options);
      EXPECT_NEAR(one.max_distance, DiameterOf(truth) / 64, 1e-15);
      for (const char* tau : {"0.005,0.01", "0.001,0.005,0.02", "0.005,0.5"}) {
        options.tau = tau;
        const Evaluation more = EvaluateMesh(ramp, truth, options);
        EXPECT_EQ(more.max_distance, one.max_distance) << tau;
        EXPECT_EQ(more.accuracy.mean, one.accuracy.mean) << tau;
        EXPECT_EQ(more.accuracy.matched, one.accuracy.matched) << tau;
        EXPECT_EQ(more.completeness.mean, one.completeness.mean) << tau;
        EXPECT_EQ(more.other_accuracy.mean, one.other_accuracy.mean) << tau;
        EXPECT_EQ(more.truth_from_mesh.translation, one.truth_from_mesh.translation) << tau;
        for (const ThresholdScore& score : more.scores) {
          if (score.tau != one.scores[0].tau) continue;
          EXPECT_EQ(score.precision, one.scores[0].precision) << tau;
          EXPECT_EQ(score.recall, one.scores[0].recall) << tau;
        }
      }
    }
  }
}

TEST(MatchingDistance, ThresholdsBeyondTheMatchingDistanceCountAllThatIsCloser) {
  const Truth truths[] = {MeshTruth(Plane(0)), CloudTruth(Plane(0), 20000, true)};
  for (const Truth& truth : truths) {
    for (const UnmatchedSamples unmatched : {UnmatchedSamples::kCount, UnmatchedSamples::kDrop}) {
      EvaluationOptions options = Options("0.01,0.04", 2000);
      options.unmatched = unmatched;
      options.max_distance = 0.02;
      const Evaluation evaluation = EvaluateMesh(Plane(0.03), truth, options);
      EXPECT_EQ(evaluation.accuracy.matched, 0);
      EXPECT_EQ(evaluation.scores[0].f1, 0);
      EXPECT_EQ(evaluation.scores[1].f1, 1);
    }
  }
}

TEST(MatchingDistance, DiameterFollowsTheTruthAndNotItsStrays) {
  const Truth sphere = MeshTruth(Sphere(1.0, 4));
  EXPECT_NEAR(DiameterOf(sphere), 2, 0.01);
  const double diameter = DiameterOf(MeshTruth(Relief(20)));
  Similarity motion;
  motion.scale = 7;
  motion.rotation =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  motion.translation = {100, -20, 3};
  EXPECT_NEAR(DiameterOf(MeshTruth(Moved(Relief(20), motion))), 7 * diameter, 1e-9 * diameter);
  Truth cloud = CloudTruth(Relief(20), 20000, false);
  EXPECT_NEAR(DiameterOf(cloud), diameter, 1e-3 * diameter);
  for (int k = 0; k < 200; ++k) cloud.cloud.points.emplace_back(1000 + k, -500, 30);
  EXPECT_NEAR(DiameterOf(cloud), diameter, 0.03 * diameter);
  Truth point;
  point.cloud.points = {{1, 2, 3}};
  EXPECT_EQ(DiameterOf(point), 0);
  EXPECT_THROW(EvaluateMesh(Plane(0), point, Options("1")), InputError);
}

// The first row of README's tables of fountain-P11, to the last digit printed there, by the options of
// README's command: its rows differ by .001. With `unmatched` = drop these are the scores that the mesh
// is published with, to theirs.
TEST(Evaluation, ReproducesTheFountainsPublishedScores) {
  const char* data = std::getenv("BURIN_SHARED_DATA");
  const std::filesystem::path folder = std::filesystem::path(data ? data : "") / "fountain-p11";
  if (data == nullptr || !std::filesystem::exists(folder / "truth/points_10mm.ply")) {
    GTEST_SKIP() << "BURIN_SHARED_DATA does not hold fountain-p11";
  }
  const TriangleMesh mesh = ReadMesh(folder / "init.ply");
  const Truth truth = ReadTruth(folder / "truth/points_10mm.ply");
  EvaluationOptions options;  // --tau 5,10,20 --unit 0.001 are the defaults
  options.align = AlignmentKind::kRigid;
  const Evaluation evaluation = EvaluateMesh(mesh, truth, options);
  const double readme_precision[] = {0.376, 0.565, 0.707};
  const double readme_recall[] = {0.268, 0.412, 0.520};
  const double readme_f1[] = {0.313, 0.476, 0.599};
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(evaluation.scores[k].precision, readme_precision[k], 0.0005);
    EXPECT_NEAR(evaluation.scores[k].recall, readme_recall[k], 0.0005);
    EXPECT_NEAR(evaluation.scores[k].f1, readme_f1[k], 0.0005);
  }
  EXPECT_NEAR(evaluation.max_distance, 0.1994, 0.0001);  // published: 0.2
  EXPECT_NEAR(evaluation.accuracy.median, 0.0077, 0.00005);
  EXPECT_NEAR(evaluation.accuracy.mean, 0.0216, 0.0001);

  options.unmatched = UnmatchedSamples::kDrop;
  const Evaluation published = EvaluateMesh(mesh, truth, options);
  const double precision[] = {0.38, 0.57, 0.71};
  const double f1[] = {0.31, 0.48, 0.60};
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(published.scores[k].precision, precision[k], 0.005);
    EXPECT_NEAR(published.scores[k].f1, f1[k], 0.005);
  }
}

}  // namespace
}  // namespace burin
