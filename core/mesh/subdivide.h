// Splits the faces that the photographs resolve into more than a few pixels, and no others, so that
// the mesh is as fine as the images everywhere: far and flat parts are not blown up.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"

namespace burin {

struct SubdivisionOptions {
  double max_facet_px = 16;                  // px^2: largest projected area of a face left unsplit
  std::int64_t max_face_count = 50'000'000;  // splitting stops here; SubdivisionReport says so
  double max_edge_px = 0;  // longest edge left unsplit, in pixel footprints; 0 = any length
  // A face that is too large is split for its own sake only where this says so of its three corners, if it is
  // given. It is asked by several threads.
  std::function<bool(const Eigen::Vector3d&, const Eigen::Vector3d&, const Eigen::Vector3d&)>
      is_worth_it;
};

struct SubdivisionReport {
  int input_face_count = 0;
  int face_count = 0;
  int new_vertex_count = 0;
  // No face that is worth it is above the bounds. False: the face count stopped it, or an edge too short to have a middle.
  bool reached_bound = false;
  // Vertices of which OpenMesh's half-edge structure needed further copies to hold a non-manifold
  // mesh. The copies are gone from the result.
  int copied_vertex_count = 0;
  int kept_face_count = 0;  // faces that repeat a vertex index, handed through as they are
  // New vertex input_vertex_count + k is the midpoint of these two, which precede it.
  std::vector<std::array<int, 2>> new_vertex_parents;
  std::vector<int> face_origin;  // per face of the result, the input face it is part of
};

// Splits until no face's area in its sharpest view exceeds max_facet_px. A view counts for a face
// when the camera is on the outer side of it, some of the face is inside the image, and, where
// `face_visible_in_view` is given ([input face][camera], nonzero = visible), the input face that it
// is part of is visible there.
//
// A face seen obliquely has a small area in every view however long it is, and a mesh that bridges a
// depth step by such faces cannot bend to the step. With max_edge_px a face is split too while its
// longest edge is longer than that many pixel footprints (depth / focal length, at its furthest
// vertex, of the view where that is smallest among those that count and have some of it inside).
//
// Longest-edge bisection in 3D lengths (Rivara 1984): a face is split at the midpoint of its
// longest edge, after its neighbours across that edge have been split so that it is their longest
// too. So the mesh stays conforming, angles stay above half the smallest input angle however often
// a face is split, and the surface does not change. Lengths are in space, not projected, because
// only a metric common to all views gives that bound. Ties are broken by vertex index: the same
// input gives the same result for any thread count.
//
// Vertices keep their indices, new ones follow in order of creation. Non-manifold edges are split
// in all their faces at one common vertex.
SubdivisionReport SplitLargeFaces(
    TriangleMesh* mesh, const std::vector<Camera>& cameras, const SubdivisionOptions& options,
    const std::vector<std::vector<char>>* face_visible_in_view = nullptr);

}  // namespace burin
