// Bundle adjustment over tracks, by Ceres: poses that put the windows of core/cameras/mesh_tracks.h where they
// were matched.
//
//   sum over measurements  rho( | pi_v(X) - x |^2 / s_v^2 )
//   + sum over views       1/2 | W_v (pose_v - pose_v at the start) |^2
//   + sum over cameras     1/2 | q / kPriorPx |^2
//
// X: the track's point, free. s_v: pixels of the photograph to one of the image searched, of sparse points times how much
// larger the median of their residuals is than that of windows. rho: Cauchy's, its scale from 1.5 medians of the residuals down to half a pixel of the
// images that were searched. W_v: a prior of kPriorPx pixels at the surface for rotation
// and centre each, so that weak modes do not run away. Views of no group (core/cameras/view_groups.h) stay. Every group has
// a world of its own: to put them into the input's frame is the caller's.
//
// q: what is refined of the intrinsics, each in pixels (core/cameras/intrinsics.h). Residuals of photographs whose intrinsics are refined
// are in the photograph, through its lens (core/cameras/lens_reprojection.h): the measurements, found in the image that the lens of the
// scene undistorts, are taken there. A camera with less than kFewestForIntrinsics measurements keeps its intrinsics.
//
// Every fifth track is kept out. What the cameras are worth is how well these agree before and after, each
// triangulated anew by either cameras.
//
// Held constant: intrinsics that are not refined, measurements. One thread: the same bytes on any number of them.
#pragma once

#include <vector>

#include "core/cameras/intrinsics.h"
#include "core/cameras/mesh_tracks.h"
#include "core/scene/camera.h"
#include "core/scene/scene.h"

namespace burin {

constexpr double kPriorPx = 30;
constexpr double kFinestLossPx = 0.5;  // of the images searched

// Of tracks that were kept out: the mean over their measurements of the loss, in pixels of the images searched: 1/2 r^2 for small r.
struct TrackAgreement {
  double before = 0;
  double after = 0;
  double standard_error = 0;  // of after - before
  int tracks = 0;
  bool Known() const { return tracks >= 8; }
  bool Better() const { return Known() && before - after > 2 * standard_error; }
  bool Worse() const { return Known() && after - before > 2 * standard_error; }
};

struct Bundle {
  std::vector<Camera> cameras;           // of the scene's views
  std::vector<Lens> lenses;              // likewise; empty: no intrinsics are refined
  std::vector<SharedIntrinsics> shared;  // likewise
  int tracks = 0;                        // used
  int measurements = 0;
  std::vector<int> measured;  // of every view, those used
  double median_before =
      0;  // distance of a window's measurement from its point, pixels of the photograph
  double median_after = 0;
  double sparse_scale = 1;  // MeshTracks::sparse_scale
  // Of a window's coordinate after, pixels of the images searched: robust, for what the unknowns leave free.
  double sigma = 0;
};

// Square roots of what the prior weighs, by radian of rotation and world unit of centre, for a view at a mean depth.
struct PriorWeights {
  double rotation = 0;
  double center = 0;
};
PriorWeights PriorOf(const Camera& camera, double depth);

Bundle AdjustBundle(const Scene& scene, const MeshTracks& tracks,
                    IntrinsicUnknowns unknowns = IntrinsicUnknowns::kNone);

// Of the tracks of a group that AdjustBundle() does not use, by the cameras before and after, whose images have them at
// `tracks_before` and `tracks_after`.
TrackAgreement CompareKeptOut(int group, const MeshTracks& tracks_before,
                              const std::vector<Camera>& before, const MeshTracks& tracks_after,
                              const std::vector<Camera>& after);

// The point that a track's measurements make with these cameras, starting from the rays' nearest; robust as
// above. False when it is behind a camera or not finite.
bool Triangulate(const std::vector<Camera>& cameras, const Tracks::Range& track,
                 const std::vector<double>& pixel, double loss_px, Eigen::Vector3d* point);

}  // namespace burin
