// Building blocks of the synthetic scenes: parametric surfaces at any sampling distance, and the
// operations that turn an exact surface into a coarse one.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

#include "core/mesh/mesh.h"

namespace burin {

// Height field over [-half_width, half_width] x [-half_height, half_height], z = height(x, y),
// outward along +z, vertices at most `edge` apart in x and y (at least 2 cells per axis).
TriangleMesh HeightFieldMesh(double half_width, double half_height, double edge,
                             const std::function<double(double x, double y)>& height);

// A closed body around the origin.
struct BodyShape {
  Eigen::Vector3d half_extent = Eigen::Vector3d::Ones();
  double rounding = 0;     // radius of the edges of a box, <= smallest half extent
  bool ellipsoid = false;  // half_extent are then the semi-axes and rounding is ignored
};

// The body sampled at about `edge`, each point moved along the outward unit normal by
// offset(point). Sampling is a cube's surface grid, at least 2 cells per axis.
TriangleMesh BodyMesh(const BodyShape& shape, double edge,
                      const std::function<double(const Eigen::Vector3d& point)>& offset);

// Adds the part's vertices and faces, mapped by X -> rotation * X + translation.
void AppendMesh(const TriangleMesh& part, const Eigen::Matrix3d& rotation,
                const Eigen::Vector3d& translation, TriangleMesh* mesh);

// Decimates by quadric error to the number of faces that equilateral triangles with the given edge
// length need for the mesh's area, then smooths: `smoothing_steps` steps of Taubin's filter
// (lambda 0.5, mu -0.53; boundary vertices stay). Faces that would make an edge non-manifold are
// left out, and so are vertices without faces. Never refines.
TriangleMesh CoarsenedMesh(const TriangleMesh& mesh, double edge, int smoothing_steps);

// Moves each vertex along its normal by a normal deviate times sigma (world units).
void PerturbAlongNormals(std::uint64_t seed, double sigma, TriangleMesh* mesh);

}  // namespace burin
