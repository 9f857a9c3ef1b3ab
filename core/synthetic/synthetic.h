// Synthetic scenes with exact truth. A scene has photographs of a known surface, rendered with the
// flaws of real ones (noise, exposure, quantisation), a coarse mesh to start from, and the surface that
// a refiner should find. Tests, the demo and `burin synth` use the same code.
//
// Scenes:
//   relief     a smoothly curved patch, 2 units wide, with fine relief; views on an arc of 60
//              degrees. The initial mesh is the smooth base: the refiner has to find all the relief.
//   occluders  spheres, ellipsoids, a box and bars in front of a bumpy wall and of each other; two
//              staggered rows of views. The initial mesh has one coarse component per body, without
//              bumps, and a little too large or too small.
//   scan       a given mesh, moved into the unit sphere; upright views around it at two heights.
//              The initial mesh is the scan decimated and smoothed.
//   boulder    the same with a body of its own: a lump with fine relief.
//   rods       thin closed rods, two each of 1, 1.5, 2 and 3 px diameter, in front of nothing; views
//              on an arc of 72 degrees. The initial rods are 0.7 px thicker all around and bent by
//              1 px; their facets are an eighth of init_edge_px long.
//   plates     two flat closed plates, gap_px thick and gap_px apart; the first half of the views
//              in front, the others behind. The initial plates bulge by up to a quarter of the gap.
//   membrane   relief; the initial mesh has an open sheet besides, right before view number views / 2
//              (rounded down), that hides the left third of it.
//   sky        a tower on the ground before a bright sky without texture. The initial mesh has a
//              curtain besides, from behind the tower outwards, more than half of it before the sky.
//
// "px" below are pixel footprints: the width that one pixel covers at the distance of the scene's
// centre (SyntheticScene::footprint). All sizes follow it, so a small image shows a smaller number
// of the same details.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/scene.h"
#include "core/support/options.h"
#include "core/synthetic/synthetic_stress.h"

namespace burin {

enum class SyntheticKind { kRelief, kOccluders, kScan, kRods, kPlates, kMembrane, kSky, kBoulder };
inline Choices<SyntheticKind> ChoicesOf(SyntheticKind) {
  return {{SyntheticKind::kRelief, "relief"}, {SyntheticKind::kOccluders, "occluders"},
          {SyntheticKind::kScan, "scan"},     {SyntheticKind::kRods, "rods"},
          {SyntheticKind::kPlates, "plates"}, {SyntheticKind::kMembrane, "membrane"},
          {SyntheticKind::kSky, "sky"},       {SyntheticKind::kBoulder, "boulder"}};
}

enum class SignedAxis { kX, kMinusX, kY, kMinusY, kZ, kMinusZ };
inline Choices<SignedAxis> ChoicesOf(SignedAxis) {
  return {{SignedAxis::kX, "x"},       {SignedAxis::kMinusX, "-x"}, {SignedAxis::kY, "y"},
          {SignedAxis::kMinusY, "-y"}, {SignedAxis::kZ, "z"},       {SignedAxis::kMinusZ, "-z"}};
}

// kUneven: views crowd on one side, every third is 1.7 times as far.
enum class RigSpacing { kEven, kUneven };
inline Choices<RigSpacing> ChoicesOf(RigSpacing) {
  return {{RigSpacing::kEven, "even"}, {RigSpacing::kUneven, "uneven"}};
}

struct SyntheticOptions {
  SyntheticKind scene = SyntheticKind::kRelief;
  std::string mesh_path;                // of the scan; only recorded here, the caller reads it
  SignedAxis scan_up = SignedAxis::kY;  // axis of the scan that points up
  int seed = 1;
  // 0 = the scene's own number: relief and membrane 7, occluders and sky 8, scan and boulder 24, rods 9,
  // plates 10.
  int views = 0;
  RigSpacing rig = RigSpacing::kEven;
  int width = 640;
  int height = 480;
  int samples_per_axis = 3;  // rays per pixel and axis
  double texture_px = 2.5;   // finest wavelength of the texture
  double shading = 0.5;      // 0 = albedo only, 1 = full shading by a light fixed to the world
  double relief_px = 5;      // RMS height of relief; occluders, boulder and sky's ground a third
  double gap_px = 4;         // between the plates
  double noise_sigma = 1.5;  // grey levels
  double exposure_spread = 0.05;  // standard deviation over the views of the gain
  StressKind stress = StressKind::kNone;
  // Errors of the cameras as the scene gives them, standard deviations.
  double pose_noise_px = 0;             // WithPoseNoise
  double focal_noise = 0;               // WithIntrinsicsNoise: share of the focal length
  double principal_point_noise_px = 0;  // and of each coordinate
  // All views are of one camera: the intrinsics have one error, and the model says so.
  bool one_camera = false;
  double init_edge_px = 40;        // edge length of the initial mesh
  double init_noise_px = 0.5;      // of its vertices along their normals; rods, plates: part of it
  int point_count = 2000;          // sparse points
  double point_noise_px = 0.3;     // standard deviation of each coordinate of a sparse point
  double track_noise_px = 0;       // of each coordinate of where a photograph shows it
  int truth_point_count = 200000;  // on the whole surface; those seen from < 2 views are dropped

  void Describe(OptionSet* set);
};

struct SyntheticScene {
  SyntheticOptions options;  // as given, with `views` filled in
  // CV_8UC1 images; image_path is empty; measurements are where the photographs show the points, without
  // point_noise_px.
  Scene scene;
  std::vector<Camera> true_cameras;  // that took the photographs, one per view
  TriangleMesh truth;  // about a footprint between vertices, wall and ground 1.5, plates 4
  TriangleMesh init;
  std::vector<Eigen::Vector3d> truth_points;   // evenly by area on the truth seen from >= 2 views
  std::vector<Eigen::Vector3d> truth_normals;  // unit, outward, one per truth point
  std::vector<cv::Mat1f> depth;                // per view: camera z at pixel centres, 0 = none
  double footprint = 0;                        // world units per px
};

// Builds a scene; `scan` is used by SyntheticKind::kScan only. The same options give the same
// bytes for any thread count (across machines: as far as their sqrt, log, cos and tanh agree).
// Throws InputError for options out of range and for an unusable scan (no faces, no extent).
SyntheticScene MakeSyntheticScene(const SyntheticOptions& options, const TriangleMesh& scan = {});

// Writes beside a COLMAP workspace what that format has no place for, into an existing folder; the
// two meshes are WriteMesh's (init.ply, truth.ply by custom).
//   truth_points.ply      truth_points with truth_normals
//   depth/STEM.tiff       per view, 32-bit float, camera z in world units, 0 = no surface
//   true_cameras/sparse/  the model with the cameras that took the photographs, COLMAP text
//   synth.json            every option as used, and the footprint
// Throws InputError when a file cannot be written.
void WriteSyntheticTruth(const SyntheticScene& synthetic, const std::filesystem::path& folder);

}  // namespace burin
