// What a run does about facets in free space (core/evidence/free_space.h), and how it says so.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/evidence/free_space.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_io.h"

namespace burin {

// The mesh without the facets of patches, with the same vertices.
TriangleMesh WithoutPatches(const TriangleMesh& mesh, const FreeSpace& free_space);

// The facets of patches of `input`, put back into what became of the mesh without them.
void PutPatchesBack(const TriangleMesh& input, const FreeSpace& free_space, TriangleMesh* refined);

// The same of a mesh that was cut anew: each patch with vertices of its own, as no pair sees them.
void AppendPatches(const TriangleMesh& input, const FreeSpace& free_space, TriangleMesh* refined,
                   std::vector<VertexScalar>* values);

// Takes out the vertices that only patches of `input` had, from the values as well.
void DropPatchVertices(const TriangleMesh& input, const FreeSpace& free_space,
                       TriangleMesh* refined, std::vector<VertexScalar>* values);

// A line for the log; `then`: what is done about them.
std::string FreeSpaceText(const FreeSpace& free_space, const std::string& then);

nlohmann::ordered_json FreeSpaceJson(const FreeSpace& free_space);

}  // namespace burin
