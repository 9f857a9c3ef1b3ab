// The connected parts of a mesh before it is refined: which of them the cameras see from behind only, what is done
// about these, and whether the mesh is seen at all. Every command that takes scene and mesh begins with it.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/refine/refinement_parts.h"
#include "core/scene/scene.h"
#include "core/support/choices.h"
#include "core/support/options.h"
#include "core/visibility/part_sides.h"

namespace burin {

// What is done about parts that the cameras see from behind.
enum class OrientMesh { kOff, kOn };
inline Choices<OrientMesh> ChoicesOf(OrientMesh) {
  return {{OrientMesh::kOff, "off"}, {OrientMesh::kOn, "on"}};
}

struct MeshOptions {
  OrientMesh orient = OrientMesh::kOn;
  void Describe(OptionSet* set);
};

struct MeshPart {
  int first_vertex = 0;  // its lowest index: a name that outlives the refinement
  int faces = 0;
  double area_share = 0;  // of the mesh
  int64_t front = 0;      // pixels, see PartSides; after turning
  int64_t behind = 0;
  bool turned = false;
  bool inside_out = false;           // and left so
  std::optional<bool> seen_by_pair;  // known after a refinement
};

struct MeshParts {
  std::vector<MeshPart> parts;     // by area, the largest first
  std::vector<std::string> lines;  // to be said
};

// Looks at the parts, turns those that are inside out with mesh.orient on, and throws as CheckMeshIsSeen does.
MeshParts OrientAndCheck(const Scene& scene, const MeshOptions& options,
                         const std::filesystem::path& mesh_path, TriangleMesh* mesh);

// Throws InputError naming the mesh file when no view sees the mesh, or when most of the pixels that hit
// it first hit the back of a facet: the mesh is inside out.
void CheckMeshIsSeen(const Scene& scene, const TriangleMesh& mesh,
                     const std::filesystem::path& mesh_path);

// By vertex of the input, of those that the refined mesh has as they are, or of the first ones of its parts
// (RefinementEnd::part): some pair sees a vertex of the connected part that it is in. `pairs` has by vertex of end.mesh how many
// see it.
std::vector<char> SeenWithPart(const RefinementEnd& end, const std::vector<float>& pairs,
                               size_t input_vertices);

// Sets MeshPart::seen_by_pair of the parts of `input`, `seen` as SeenWithPart gives it.
void MarkSeenByPairs(const TriangleMesh& input, const std::vector<char>& seen, MeshParts* parts);

// `parts` of summary.json: counts, and the largest few one by one.
nlohmann::ordered_json PartsJson(const MeshParts& parts);

}  // namespace burin
