// Points spread evenly over the area of a mesh, the same for the same input: what the accuracy of a
// mesh is measured at, so that the score depends on the surface and not on how it is cut in facets.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"

namespace burin {

struct SurfaceSamples {
  std::vector<Eigen::Vector3d> points;   // world units
  std::vector<Eigen::Vector3d> normals;  // unit normal of the sample's face
  std::vector<int> faces;                // ascending
};

// Total area of the faces, world units squared.
double SurfaceArea(const TriangleMesh& mesh);

// `count` samples, area-uniform: sample k takes the face that holds the share (k + o)/count of the
// area summed in face order (a face of area A gets count*A/total samples, rounded down or up), and
// a place in it from the two-dimensional low-discrepancy sequence frac(s + k/g), frac(t + k/g^2), g
// the plastic number, folded into the triangle. The offsets o, s, t in [0, 1) come from `seed`.
// Empty when the mesh has no area.
SurfaceSamples SampleSurface(const TriangleMesh& mesh, int count, std::uint64_t seed = 0);

}  // namespace burin
