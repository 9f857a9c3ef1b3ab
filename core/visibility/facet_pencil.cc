#include "core/visibility/facet_pencil.h"

#include <Eigen/Geometry>

#include "core/support/parallel.h"

namespace burin {

namespace {

// Of the product of a facet's two sides and its distance; FacetPencil::offset below it is rounding.
constexpr double kFlat = 1e-12;
constexpr int kFacetGrain = 4096;

}  // namespace

ViewRays::ViewRays(const Camera& camera) : center(camera.Center()) {
  Eigen::Matrix3d camera_from_pixel;                              // K^-1
  camera_from_pixel << 1 / camera.fx, 0, -camera.cx / camera.fx,  //
      0, 1 / camera.fy, -camera.cy / camera.fy,                   //
      0, 0, 1;
  ray_from_pixel = camera.rotation.transpose() * camera_from_pixel;
}

FacetPencil MakeFacetPencil(const std::vector<Eigen::Vector3d>& vertices,
                            const Eigen::Vector3i& face, const ViewRays& view) {
  const Eigen::Vector3d a = vertices[face[0]] - view.center;
  const Eigen::Vector3d b = vertices[face[1]] - view.center;
  const Eigen::Vector3d c = vertices[face[2]] - view.center;
  FacetPencil pencil;
  pencil.normal = (b - a).cross(c - a);
  pencil.offset = pencil.normal.dot(a);
  const double scale = 1 / pencil.offset;
  Eigen::Matrix3d inverse;  // rows: u_k = inverse.row(k) . direction
  inverse.row(0) = scale * b.cross(c);
  inverse.row(1) = scale * c.cross(a);
  inverse.row(2) = scale * a.cross(b);
  pencil.coefficients.noalias() = inverse * view.ray_from_pixel;
  return pencil;
}

InverseDepthPlane MakeInverseDepth(const std::vector<Eigen::Vector3d>& vertices,
                                   const Eigen::Vector3i& face, const ViewRays& view) {
  const Eigen::Vector3d a = vertices[face[0]] - view.center;
  const Eigen::Vector3d u = vertices[face[1]] - vertices[face[0]];
  const Eigen::Vector3d v = vertices[face[2]] - vertices[face[0]];
  const Eigen::Vector3d normal = u.cross(v);
  const double scale = 1 / normal.dot(a);
  const Eigen::Vector3d plane = scale * (view.ray_from_pixel.transpose() * normal);
  return {plane[0], plane[1], plane[2]};
}

bool FacesCenter(const std::vector<Eigen::Vector3d>& vertices, const Eigen::Vector3i& face,
                 const Eigen::Vector3d& center) {
  const Eigen::Vector3d a = vertices[face[0]] - center;
  const Eigen::Vector3d u = vertices[face[1]] - center - a;
  const Eigen::Vector3d v = vertices[face[2]] - center - a;
  const double offset = u.cross(v).dot(a);
  return offset < 0 &&
         offset * offset > kFlat * kFlat * u.squaredNorm() * v.squaredNorm() * a.squaredNorm();
}

std::vector<uint8_t> FacingFacets(const TriangleMesh& mesh, const Eigen::Vector3d& center) {
  std::vector<uint8_t> facing(mesh.faces.size());
  ParallelFor(static_cast<int>(facing.size()), kFacetGrain, [&](int begin, int end) {
    for (int f = begin; f < end; ++f) {
      facing[f] = FacesCenter(mesh.vertices, mesh.faces[f], center) ? 1 : 0;
    }
  });
  return facing;
}

}  // namespace burin
