// Rays of a view against a facet: the affine functions behind warping, depth and derivatives.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"

namespace burin {

// 1/t at image point (x, y) of the plane of a facet.
struct InverseDepthPlane {
  double slope_x;
  double slope_y;
  double at_origin;
  double At(double x, double y) const { return slope_x * x + slope_y * y + at_origin; }
};

// The barycentric coordinates of the pixels of one facet in one view, divided by depth:
//   u_k(x, y) = phi_k / t = row k of `coefficients` times (x, y, 1),   1/t = u_0 + u_1 + u_2,
// for the surface point c + t * Ray(x, y). They are affine in the pixel, which is what makes
// warping and differentiating cheap: with n the facet's area normal and offset = n . (V_0 - c),
//   d(1/t)/dV_k = -u_k * n^T / offset.
struct FacetPencil {
  Eigen::Matrix3d coefficients;
  double offset = 0;       // n . (V_0 - c); negative for a front-facing facet
  Eigen::Vector3d normal;  // area normal n

  InverseDepthPlane InverseDepth() const {
    const Eigen::RowVector3d sum = coefficients.colwise().sum();
    return {sum[0], sum[1], sum[2]};
  }
};

// What pencils need of a camera, computed once a view.
struct ViewRays {
  explicit ViewRays(const Camera& camera);
  Eigen::Vector3d center;
  Eigen::Matrix3d ray_from_pixel;  // Ray(x, y) = ray_from_pixel * (x, y, 1)

  // Where the ray through image point (x, y) meets the plane.
  Eigen::Vector3d SurfacePoint(double x, double y, const InverseDepthPlane& plane) const {
    return center + ray_from_pixel * Eigen::Vector3d(x, y, 1) / plane.At(x, y);
  }
};

// Where FacesCenter() holds of the view's centre the pencil is finite.
FacetPencil MakeFacetPencil(const std::vector<Eigen::Vector3d>& vertices,
                            const Eigen::Vector3i& face, const ViewRays& view);

// The pencil's InverseDepth() alone.
InverseDepthPlane MakeInverseDepth(const std::vector<Eigen::Vector3d>& vertices,
                                   const Eigen::Vector3i& face, const ViewRays& view);

// `center` is on the outer side of the facet and sees its plane at more than rounding: false for facets
// edge-on, of no area, or not finite.
bool FacesCenter(const std::vector<Eigen::Vector3d>& vertices, const Eigen::Vector3i& face,
                 const Eigen::Vector3d& center);

// Per facet: 1 where it FacesCenter().
std::vector<uint8_t> FacingFacets(const TriangleMesh& mesh, const Eigen::Vector3d& center);

}  // namespace burin
