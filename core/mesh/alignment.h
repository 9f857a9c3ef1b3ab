// The similarity (core/scene/similarity.h) that best lays a set of surface points onto another surface:
// ground truth and photographs are rarely registered to the last millimetre, and a reconstruction
// without a known length has a scale of its own.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/similarity.h"

namespace burin {

// The mesh after a motion.
TriangleMesh Moved(const TriangleMesh& mesh, const Similarity& motion);

// The similarity T that minimises sum_k |target_k - T(source_k)|^2, in closed form (Umeyama,
// "Least-squares estimation of transformation parameters between two point patterns", 1991, eqs.
// 40-43): with centred patterns X (source) and Y (target), (1/n) Y X^T = U D V^T and sigma_x^2 the
// variance of X,
//     R = U S V^T,  s = tr(D S) / sigma_x^2,  t = mean(target) - s R mean(source),
// S = diag(1, 1, det U det V), so that R is never a reflection. CHECKs that both have the same
// number of points. False with *error when the points, fewer than three or on a line, leave the
// rotation open.
bool FitSimilarity(const std::vector<Eigen::Vector3d>& source,
                   const std::vector<Eigen::Vector3d>& target, Similarity* target_from_source,
                   std::string* error);

// A point's counterpart on the other surface and the unit normal of the plane its distance is
// measured to. False when there is none close enough; a normal of zero length leaves the pair out.
using PlaneOf = std::function<bool(int index, const Eigen::Vector3d& moved_point,
                                   Eigen::Vector3d* counterpart, Eigen::Vector3d* normal)>;

struct AlignmentOptions {
  bool scale = false;          // a similarity instead of a rigid motion
  double keep_fraction = 0.7;  // share of the pairs, those with the smallest residuals, that count
  int max_iterations = 100;
  double min_step = 1e-9;  // stop when no point moves further than this share of the points' extent
  // With scale, the closed form on pairs of points goes first: until it moves no point further than
  // this share of the extent, or this often.
  double point_step = 1e-3;
  int max_point_iterations = 20;
};

struct Alignment {
  Similarity motion;       // maps the points given onto the other surface
  int iterations = 0;      // done
  bool converged = false;  // by min_step; the motion is usable either way
  int pair_count = 0;      // pairs kept in the last iteration
  double rmse = 0;         // of the kept pairs' plane distances before the last step, world units
};

// Trimmed iterative closest point with the point-to-plane error: each iteration moves the points,
// asks plane_of (on several threads) for their counterparts q with normals n, keeps the
// keep_fraction with the smallest |n.(x - q)| and minimises the sum of their squares over small
// motions (Chen and Medioni 1992; trimming as in Chetverikov et al. 2002). Directions of motion
// that the pairs do not constrain (sliding along a plane, turning a sphere, the size of a plane)
// are left alone. Starts at the identity.
//
// With options.scale the first iterations keep the pairs with the smallest |x - q| and apply
// FitSimilarity to them, which takes out a scale and a rotation of any size in reach; the rest are
// those above with the scale as seventh unknown, since pairs of points hold on to each other along
// the surface and approach the solution only linearly.
//
// False with *error when fewer than six pairs (seven with scale) are found.
bool AlignToSurface(const std::vector<Eigen::Vector3d>& points, const PlaneOf& plane_of,
                    const AlignmentOptions& options, Alignment* alignment, std::string* error);

}  // namespace burin
