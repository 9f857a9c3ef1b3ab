// Mesh files: PLY (text and binary, either byte order), OBJ and OFF, told apart by the extension.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/mesh_check.h"

namespace burin {

// Reads through OpenMesh into plain arrays, so that no face is lost to a half-edge structure that
// cannot hold it (non-manifold edges, flipped neighbours); coordinates keep double precision.
// Polygons are cut into triangles (core/mesh/polygon_cut.h); faces that repeat a vertex index or an earlier
// face are dropped; seams are welded (core/mesh/weld.h); neighbours that disagree are turned
// (OrientConsistently). *report (may be null) counts it all.
//
// Throws InputError "path: element: reason" for a file that is missing, empty, truncated or of
// another format; for no vertices or no faces; for coordinates that are not finite; for vertex
// indices out of range; for header counts that the file cannot hold (before allocating anything).
TriangleMesh ReadMesh(const std::filesystem::path& path, MeshReport* report = nullptr);

// A number per vertex, under a name that is a word.
struct VertexScalar {
  std::string name;
  std::vector<float> values;
};

// Writes by extension, atomically. `vertex_colors` (may be null): red, green, blue in [0, 1], one
// per vertex. PLY is binary little endian with coordinates of type double, OBJ and OFF print the
// shortest decimals that read back the same, so that every format returns the same bits even for
// georeferenced coordinates. (OpenMesh 9 would write float: half a metre at a UTM northing.)
// `scalars` become properties of the vertices in PLY; the other formats have no place for them.
// Throws InputError for another extension and when the file cannot be written.
void WriteMesh(const std::filesystem::path& path, const TriangleMesh& mesh,
               const std::vector<Eigen::Vector3f>* vertex_colors = nullptr,
               const std::vector<VertexScalar>& scalars = {});

}  // namespace burin
