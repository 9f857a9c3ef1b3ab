// The terms of the pair energies, on configurations whose answer can be written down.
#include "selection/pair_terms.h"

#include <gtest/gtest.h>

#include <cmath>

#include "selection/pair_survey.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

// Centre `distance` away from the origin, `degrees` from the z axis in the x-z plane.
Eigen::Vector3d OnArc(double degrees, double distance = 5) {
  const double angle = degrees * M_PI / 180;
  return distance * Eigen::Vector3d(std::sin(angle), 0, std::cos(angle));
}

Camera CameraAt(const Eigen::Vector3d& center, double focal_px = 1000) {
  return test::LookAt(center, Eigen::Vector3d::Zero(), 200, 200, focal_px);
}

const Eigen::Vector3d kOrigin = Eigen::Vector3d::Zero();
const Eigen::Vector3d kNormal = Eigen::Vector3d::UnitZ();

PointSight SightFrom(const Camera& camera) {
  return {camera.Center(), FocalPx(camera), kOrigin, kNormal};
}

PointSight SightFrom(const Eigen::Vector3d& center, const Eigen::Vector3d& normal = kNormal) {
  return {center, 1000, kOrigin, normal};
}

double Symmetry(double degrees_i, double degrees_j, bool printed = false) {
  return OrientedAngleDifferenceDeg(SightFrom(OnArc(degrees_i)), SightFrom(OnArc(degrees_j)),
                                    printed);
}

TEST(Parallax, IsTheAngleBetweenTheRays) {
  EXPECT_NEAR(ParallaxDeg(SightFrom(OnArc(-10)), SightFrom(OnArc(25))), 35, 1e-9);
  EXPECT_NEAR(ParallaxDeg(SightFrom(OnArc(-10, 2)), SightFrom(OnArc(25, 90))), 35, 1e-9);
  EXPECT_NEAR(ParallaxDeg(SightFrom(OnArc(20)), SightFrom(OnArc(20, 8))), 0, 1e-6);
  EXPECT_NEAR(ParallaxDeg(SightFrom(OnArc(90)), SightFrom(OnArc(-90))), 180, 1e-9);
}

// The paper's figure: C_ref at 40 degrees; C_1 across the normal and C_2 on the same side.
TEST(Symmetry, TellsThePapersFigureApart) {
  EXPECT_NEAR(Symmetry(40, -40), 0, 1e-9);
  EXPECT_NEAR(Symmetry(40, -30), 5, 1e-9);
  EXPECT_NEAR(Symmetry(40, 70), 55, 1e-9);
  EXPECT_NEAR(Symmetry(0, 30), 15, 1e-9);
  EXPECT_NEAR(Symmetry(30, 0), 15, 1e-9);
}

// As printed, two cameras side by side are as symmetric as can be.
TEST(Symmetry, ThePrintedFormDoesNotTellSideBySideFromSymmetric) {
  EXPECT_NEAR(Symmetry(40, 38, true), 1, 1e-9);
  EXPECT_NEAR(Symmetry(40, -38, true), -1, 1e-9);
  EXPECT_NEAR(Symmetry(40, 38), 39, 1e-9);
  EXPECT_NEAR(Symmetry(40, -38), 1, 1e-9);
}

TEST(Symmetry, DoesNotChangeWithARotationOfTheWorld) {
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(0.9, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  for (const bool printed : {false, true}) {
    EXPECT_NEAR(
        OrientedAngleDifferenceDeg(SightFrom(rotation * OnArc(25), rotation * kNormal),
                                   SightFrom(rotation * OnArc(-60), rotation * kNormal), printed),
        Symmetry(25, -60, printed), 1e-9);
  }
}

TEST(Resolution, ACameraAtTwiceTheDistanceDiffersByOne) {
  const PointSight near = SightFrom(CameraAt(OnArc(0, 5)));
  const PointSight far = SightFrom(CameraAt(OnArc(30, 10)));
  EXPECT_NEAR(ResolutionDiscrepancy(near, far, false), 1, 1e-12);
  EXPECT_NEAR(ResolutionDiscrepancy(far, near, false), 0.5, 1e-12);
  // Twice the focal length makes up for it.
  EXPECT_NEAR(ResolutionDiscrepancy(near, SightFrom(CameraAt(OnArc(30, 10), 2000)), false), 0,
              1e-12);
}

// |5/1000 - 10/1000| / 5: with focal lengths in pixels E_r is -1 whatever the cameras do.
TEST(Resolution, ThePrintedFormIsInert) {
  const double printed = ResolutionDiscrepancy(SightFrom(CameraAt(OnArc(0, 5))),
                                               SightFrom(CameraAt(OnArc(0, 10))), true);
  EXPECT_NEAR(printed, 1e-3, 1e-12);
  EXPECT_NEAR(GaussianEnergy(printed, 0, 0.25), -1, 1e-5);
  EXPECT_NEAR(GaussianEnergy(1, 0, 0.25), -std::exp(-8), 1e-12);
}

TEST(PairEnergies, AreTheGaussiansOfTheMeansAndTheirWeightedSum) {
  PairMeasure measure;
  measure.area = 0.3;
  measure.parallax_deg = 50 + 45;
  measure.symmetry_deg[0][0] = 45;
  measure.symmetry_deg[0][1] = -22.5;
  measure.symmetry_deg[1][0] = 95;
  measure.symmetry_deg[1][1] = 90;
  measure.resolution = 0.5;
  measure.resolution_printed = 0;
  BpvOptions options;
  PairEnergies energies = EvaluatePair(measure, 0.4, options);
  EXPECT_NEAR(energies.parallax, -std::exp(-0.5), 1e-12);
  EXPECT_NEAR(energies.symmetry, -std::exp(-0.5), 1e-12);
  EXPECT_NEAR(energies.resolution, -std::exp(-2), 1e-12);
  EXPECT_NEAR(energies.overlap, -0.75, 1e-12);
  EXPECT_NEAR(energies.total, -0.75 * std::exp(-0.5) - 0.25 * std::exp(-2) - 0.25 * 0.75, 1e-12);
  options.signed_symmetry = true;
  EXPECT_NEAR(EvaluatePair(measure, 0.4, options).symmetry, -std::exp(-0.125), 1e-12);
  options.overlap_of_image = options.printed_symmetry = options.printed_resolution = true;
  energies = EvaluatePair(measure, 0.4, options);
  EXPECT_NEAR(energies.overlap, -0.3, 1e-12);
  EXPECT_NEAR(energies.symmetry, -std::exp(-2), 1e-12);
  EXPECT_NEAR(energies.resolution, -1, 1e-12);
}

TEST(PairEnergies, EachSwitchRemovesItsTerm) {
  PairMeasure measure;
  measure.area = 0.3;
  measure.parallax_deg = 20;
  measure.symmetry_deg[0][0] = 10;
  measure.resolution = 0.1;
  const BpvOptions all;
  const PairEnergies energies = EvaluatePair(measure, 0.5, all);
  const auto without = [&](bool BpvOptions::*use) {
    BpvOptions options;
    options.*use = false;
    return EvaluatePair(measure, 0.5, options).total;
  };
  EXPECT_NEAR(without(&BpvOptions::use_parallax), energies.total - 0.25 * energies.parallax, 1e-12);
  EXPECT_NEAR(without(&BpvOptions::use_overlap), energies.total - 0.25 * energies.overlap, 1e-12);
  EXPECT_NEAR(without(&BpvOptions::use_symmetry), energies.total - 0.5 * energies.symmetry, 1e-12);
  EXPECT_NEAR(without(&BpvOptions::use_resolution), energies.total - 0.25 * energies.resolution,
              1e-12);
}

TEST(PairEnergies, APairThatSharesNothingHasNone) {
  EXPECT_EQ(EvaluatePair(PairMeasure(), 0.5, BpvOptions()).total, 0);
}

// Cameras over the plane z = 0 and what a survey of it must find.
struct Rig {
  Scene scene;
  TriangleMesh mesh;
  void Add(const Camera& camera) {
    View view;
    view.name = "view" + std::to_string(scene.views.size());
    view.camera = camera;
    scene.views.push_back(view);
  }
};

Rig PlaneRig(double half) {
  Rig rig;
  test::AppendGrid(&rig.mesh, 10, 0, 0, half, [](double, double) { return 0.0; });
  return rig;
}

SurveyOptions Fine() {
  SurveyOptions options;
  options.resolution_px = 400;
  options.parallax = {20, 40};
  return options;
}

// A plane so small that all its points see the cameras under the angles of its middle.
TEST(PairSurvey, MeansOverASmallPlaneAreThoseOfItsMiddle) {
  Rig rig = PlaneRig(0.01);
  for (const double degrees : {0.0, 30.0, -30.0}) {
    rig.Add(test::LookAt(OnArc(degrees), kOrigin, 200, 200, 40000));
  }
  rig.Add(test::LookAt(OnArc(45, 10), kOrigin, 200, 200, 40000));
  const PairSurvey survey = SurveyPairs(rig.scene, rig.mesh, Fine());
  EXPECT_NEAR(survey.At(0, 1).parallax_deg, 30, 0.1);
  EXPECT_NEAR(survey.At(1, 2).parallax_deg, 60, 0.1);
  EXPECT_NEAR(survey.At(0, 1).symmetry_deg[0][0], 15, 0.1);
  EXPECT_NEAR(survey.At(1, 2).symmetry_deg[0][0], 0, 0.1);
  EXPECT_NEAR(survey.At(1, 3).symmetry_deg[0][0], 37.5, 0.1);
  EXPECT_NEAR(survey.At(1, 3).symmetry_deg[0][1], 37.5, 0.1);
  EXPECT_NEAR(survey.At(1, 3).symmetry_deg[1][1], -7.5, 0.1);
  // View 0 looks along the normal: s is -1 on one half of the plane and 1 on the other, and the
  // mean of signed differences says "symmetric" of any partner.
  EXPECT_NEAR(survey.At(0, 1).symmetry_deg[0][1], 0, 0.2);
  EXPECT_NEAR(survey.At(1, 3).resolution, 1, 0.01);
  EXPECT_NEAR(survey.At(3, 1).resolution, 0.5, 0.01);
  // 0.02 x 0.02 at 5 with 40 000 px: 160 x 160 of 200 x 200 px, less the cosine seen obliquely.
  EXPECT_NEAR(survey.seen[0], 0.64, 0.01);
  EXPECT_NEAR(survey.At(0, 1).area, 0.64, 0.01);
  EXPECT_NEAR(survey.At(1, 0).area, 0.64 * std::cos(M_PI / 6), 0.01);
  EXPECT_NEAR(survey.At(0, 1).area_in_range, survey.At(0, 1).area, 1e-12);
  EXPECT_EQ(survey.At(1, 2).area_in_range, 0);  // 60 degrees
}

// Two cameras that look straight down, `baseline` apart, at height h over a plane wider than what
// they see: they share 1 - baseline / (width of the image on the plane).
TEST(PairSurvey, OverlapIsThatOfTwoImageRectangles) {
  Rig rig = PlaneRig(8);
  for (const double x : {0.0, 1.0, 3.9, 4.5}) {
    rig.Add(test::LookAt({x, 0, 5}, {x, 0, 0}, 200, 200, 250));  // 4 x 4 on the plane
  }
  const PairSurvey survey = SurveyPairs(rig.scene, rig.mesh, Fine());
  EXPECT_NEAR(survey.At(0, 1).area, 0.75, 0.006);
  EXPECT_NEAR(survey.At(0, 2).area, 0.025, 0.006);
  EXPECT_EQ(survey.At(0, 3).area, 0);  // no overlap
  EXPECT_EQ(EvaluatePair(survey.At(0, 3), survey.seen[0], BpvOptions()).total, 0);
  EXPECT_NEAR(survey.seen[0], 1, 1e-12);
}

TEST(PairSurvey, IsNotSymmetric) {
  Rig rig = PlaneRig(8);
  rig.Add(test::LookAt({0, 0, 5}, kOrigin, 200, 200, 1000));   // 1 x 1 on the plane
  rig.Add(test::LookAt({0, 0, 10}, kOrigin, 200, 200, 1000));  // 2 x 2
  const PairSurvey survey = SurveyPairs(rig.scene, rig.mesh, Fine());
  EXPECT_NEAR(survey.At(0, 1).area, 1, 1e-12);
  EXPECT_NEAR(survey.At(1, 0).area, 0.25, 0.01);
  EXPECT_NEAR(survey.At(0, 1).resolution, 1, 0.01);
  EXPECT_NEAR(survey.At(1, 0).resolution, 0.5, 0.005);
}

TEST(PairSurvey, BackSidesAndHiddenFacetsDoNotCount) {
  Rig rig = PlaneRig(0.1);
  for (const double degrees : {0.0, 30.0, 180.0}) {
    rig.Add(test::LookAt(OnArc(degrees), kOrigin, 100, 100, 1000));
  }
  const PairSurvey open = SurveyPairs(rig.scene, rig.mesh, Fine());
  EXPECT_EQ(open.seen[2], 0);
  EXPECT_EQ(open.At(0, 2).area, 0);
  EXPECT_EQ(open.At(2, 0).area, 0);
  // A lid close in front, twice as wide: only it is seen.
  test::AppendGrid(&rig.mesh, 1, 0, 0, 0.2, [](double, double) { return 0.05; });
  const PairSurvey lidded = SurveyPairs(rig.scene, rig.mesh, Fine());
  EXPECT_NEAR(lidded.At(0, 1).area, open.At(0, 1).area * 4 * std::pow(5 / 4.95, 2), 0.02);
  EXPECT_FALSE(lidded.facets.Contains(0, 0));
  EXPECT_TRUE(lidded.facets.Contains(0, static_cast<int>(rig.mesh.faces.size()) - 1));
}

TEST(PairSurvey, ALowerResolutionChangesLittle) {
  Rig rig;
  rig.mesh = test::OccluderMesh();
  for (const LevelView& view : test::RandomViews(320, 240)) rig.Add(view.camera);
  SurveyOptions full;
  full.resolution_px = 320;
  SurveyOptions coarse;
  coarse.resolution_px = 80;
  const PairSurvey exact = SurveyPairs(rig.scene, rig.mesh, full);
  const PairSurvey quick = SurveyPairs(rig.scene, rig.mesh, coarse);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      EXPECT_NEAR(quick.At(i, j).area, exact.At(i, j).area, 0.01);
      EXPECT_NEAR(quick.At(i, j).parallax_deg, exact.At(i, j).parallax_deg, 0.1);
      EXPECT_NEAR(quick.At(i, j).symmetry_deg[0][0], exact.At(i, j).symmetry_deg[0][0], 0.3);
      EXPECT_NEAR(quick.At(i, j).resolution, exact.At(i, j).resolution, 0.003);
    }
  }
}

}  // namespace
}  // namespace burin
