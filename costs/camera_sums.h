// Derivatives of the photometric energy by cameras, and what an evaluation leaves of them.
//
// Pixel y of view i sees the point c_i + t ray on the plane of its facet, n the facet's area normal; it is X_j in the
// frame of camera j and Y = t r in that of camera i, where r is y's ray and N = R_i n. With
//
//   m = dW/dX_j,   f = R_i R_j^T m,   k = f.r / N.r,   b = f - k N        (b.r = 0: what stays of f in the plane)
//
// W(y) changes with the motions (w, dc) of both cameras (core/scene/camera_pose.h) and the facet's vertices by
//
//   dW = -(Y x b).w_i + R_i^T b.dc_i + (X_j x m).w_j - R_i^T f.dc_j + sum_v phi_v k n.dV_v  =:  a.(w_i, dc_i, w_j, dc_j, dV)
//
// as camera i carries its rays along the plane. Summed over the pixels of a pair with the kernel's dE/dW and w
// (costs/pair_kernel.h):
//
//   gradient = sum dE/dW a,   curvature = sum w a a^T
//
// so the whole matrix of vertices and cameras is a sum of w a a^T, positive semi-definite, and has the seven
// motions of the world in its null space. Vertices of a patch with beta > 1 (costs/patch_system.h) have more curvature
// than this, which leaves it semi-definite.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/scene/camera.h"
#include "core/solve/camera_coupling.h"
#include "core/solve/energy_term.h"
#include "core/visibility/facet_pencil.h"
#include "core/visibility/view_domain.h"
#include "costs/frozen_windows.h"
#include "costs/pair_kernel.h"

namespace burin {

struct CameraSums {
  struct Pair {
    int first = 0;  // views
    int second = 0;
    Eigen::Matrix<double, 12, 1> gradient;  // by the motions of both
    Eigen::Matrix<double, 12, 12> curvature;
  };
  std::vector<Pair> pairs;      // by reference view, partners in their order
  std::vector<int> first_pair;  // of each reference view
  CameraCoupling coupling;      // unscaled

  // The pairs and blocks that there are, from what a round holds constant.
  void MakePattern(const RoundContext& context, const PairSample& sample);
  void Clear(bool in_double);
};

// Per facet of a view and partner: 1 where some pixel of the facet is in Omega_ij.
std::vector<char> FacetsInPairs(const ViewDomain& domain, const PartnerBits& pixels);

class PairRows;

// Sums over the pixels of one reference view, a pair at a time. To be used again for the next view.
template <typename T>
class CameraGather {
 public:
  struct View {
    const RoundContext* context;
    int view;
    const std::vector<Camera>* cameras;  // current
    const std::vector<FacetPencil>* pencils;
    const T* inverse_depth;
  };
  void BeginView(const View& view);
  // Adds to the sums of pair `number` and to the coupling of the view's vertices with both cameras; and to
  // `vertices` (null = none) what these are in the pair.
  void AddPair(const PairFields<T>& fields, const PartnerPixels& pixels, int number,
               CameraSums* sums, PairRows* vertices);

 private:
  struct Geometry;
  // Adds to `sums` and sets the facet's rows. False when no pixel counts; they are then left as they are.
  bool AddFacet(const Geometry& geometry, const PairFields<T>& fields, const PartnerPixels& pixels,
                int k, CameraSums::Pair* sums);
  // The n-th of the view's vertices.
  void AddVertex(int n, const Eigen::Matrix3d& world_from_first, const CameraSums::Pair& pair,
                 CameraCoupling* coupling) const;
  void AddVertex(int n, const Eigen::Matrix3d& world_from_first, int pair,
                 PairRows* vertices) const;

  View view_ = {};
  std::vector<int> vertices_;  // of the view's facets
  Adjacency corners_;       // of each of these: 3 k + c where it is corner c of the view's facet k
  std::vector<int> order_;  // of each vertex of the mesh among these, or -1
  std::vector<char> in_pair_;  // of each facet of the view: it has rows of the pair in work
  // Of each facet of the view: 3 vertices x 12, in the frame of the view's camera; along the vertices' normals, or,
  // where they move freely, to be multiplied by the facet's.
  std::vector<T> rows_;
  // Likewise, 3 vertices x 2: what multiplies n n^T for a curvature of the vertex alone (costs/pair_rows.h), and n for
  // its gradient.
  std::vector<T> own_;
};

extern template class CameraGather<float>;
extern template class CameraGather<double>;

}  // namespace burin
