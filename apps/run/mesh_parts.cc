#include "apps/run/mesh_parts.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "apps/run/single_precision.h"
#include "apps/run/turned_axes.h"
#include "core/support/error.h"
#include "core/support/fixed_text.h"

namespace burin {
namespace {

constexpr size_t kListed = 8;  // in summary.json

// "; ..." where it would be seen with other axes; without photographs nobody can tell.
std::string OtherAxes(const Scene& scene, const TriangleMesh& mesh) {
  if (scene.views.empty() || scene.views[0].gray.empty()) return "";
  const std::string turned = TurnedAxes(scene, mesh, PairsOptions());
  return turned.empty() ? "" : "; " + turned;
}

void CheckSides(const std::vector<PartSides>& parts, const Scene& scene, const TriangleMesh& mesh,
                const std::filesystem::path& mesh_path) {
  int64_t front = 0;
  int64_t seen = 0;
  for (const PartSides& part : parts) {
    front += part.front;
    seen += part.front + part.behind;
  }
  if (seen == 0) {
    throw InputError(mesh_path, "vertices: none of the " + std::to_string(scene.views.size()) +
                                    " views sees the mesh; mesh and cameras are not in the same "
                                    "coordinate frame" +
                                    OtherAxes(scene, mesh));
  }
  const double share = static_cast<double>(front) / static_cast<double>(seen);
  if (share < 0.5) {
    throw InputError(mesh_path, "faces: only " + Fixed(100 * share, 0) +
                                    " % of what the cameras see of the mesh is its front; it is "
                                    "inside out (reverse the order of each face's vertices)" +
                                    OtherAxes(scene, mesh));
  }
}

// "2 of 5 parts, 12 % of the area," of those that `which` picks; empty when there is none.
template <typename Which>
std::string Share(const MeshParts& parts, const Which& which) {
  int count = 0;
  double area = 0;
  for (const MeshPart& part : parts.parts) {
    if (!which(part)) continue;
    ++count;
    area += part.area_share;
  }
  if (count == 0) return "";
  return std::to_string(count) + " of " + std::to_string(parts.parts.size()) +
         (parts.parts.size() == 1 ? " part, " : " parts, ") + PercentText(area) + " of the area,";
}

nlohmann::ordered_json PartJson(const MeshPart& part) {
  return {
      {"first_vertex", part.first_vertex},
      {"faces", part.faces},
      {"area_share", part.area_share},
      {"pixels_front", part.front},
      {"pixels_behind", part.behind},
      {"turned", part.turned},
      {"inside_out", part.inside_out},
      {"seen_by_pair", part.seen_by_pair.has_value() ? nlohmann::ordered_json(*part.seen_by_pair)
                                                     : nlohmann::ordered_json()}};
}

}  // namespace

void MeshOptions::Describe(OptionSet* set) {
  set->Add("mesh.orient", &orient,
           "Connected parts of the mesh that the cameras see from behind: on = their faces are "
           "turned, and a line says so; off = a line says so, and they take no part");
}

MeshParts OrientAndCheck(const Scene& scene, const MeshOptions& options,
                         const std::filesystem::path& mesh_path, TriangleMesh* mesh) {
  std::vector<PartSides> sides = LookAtParts(CamerasOf(scene), *mesh);
  std::vector<int> turned;
  if (options.orient == OrientMesh::kOn) turned = TurnPartsInsideOut(&sides, mesh);
  CheckSides(sides, scene, *mesh, mesh_path);
  MeshParts found;
  const double area =
      std::accumulate(sides.begin(), sides.end(), 0.0,
                      [](double sum, const PartSides& part) { return sum + part.area; });
  for (const PartSides& side : sides) {
    MeshPart part;
    part.first_vertex = static_cast<int>(mesh->vertices.size());
    for (const int f : side.faces) {
      part.first_vertex = std::min(part.first_vertex, mesh->faces[f].minCoeff());
    }
    part.faces = static_cast<int>(side.faces.size());
    part.area_share = area > 0 ? side.area / area : 0;
    part.front = side.front;
    part.behind = side.behind;
    part.inside_out = side.InsideOut();
    found.parts.push_back(part);
  }
  for (const int p : turned) found.parts[p].turned = true;
  std::stable_sort(
      found.parts.begin(), found.parts.end(),
      [](const MeshPart& a, const MeshPart& b) { return a.area_share > b.area_share; });
  const std::string were_turned = Share(found, [](const MeshPart& part) { return part.turned; });
  if (!were_turned.empty()) {
    found.lines.push_back("mesh: " + were_turned +
                          " seen from behind only: their faces are turned (mesh.orient)");
  }
  const std::string left = Share(found, [](const MeshPart& part) { return part.inside_out; });
  if (!left.empty()) {
    found.lines.push_back(
        "mesh: " + left +
        " seen from behind only: they take no part (mesh.orient = on turns their faces)");
  }
  for (const std::string& line : {MeshPrecisionLine(scene, *mesh), StrayPartLine(scene, *mesh)}) {
    if (!line.empty()) found.lines.push_back(line);
  }
  return found;
}

void CheckMeshIsSeen(const Scene& scene, const TriangleMesh& mesh,
                     const std::filesystem::path& mesh_path) {
  CheckSides(LookAtParts(CamerasOf(scene), mesh), scene, mesh, mesh_path);
}

std::vector<char> SeenWithPart(const RefinementEnd& end, const std::vector<float>& pairs,
                               size_t input_vertices) {
  std::vector<char> seen(input_vertices, 0);
  const std::vector<int>& input_vertex = end.part.empty() ? end.index : end.part;
  for (const std::vector<int>& faces : ConnectedComponents(*end.mesh)) {
    const bool any = std::any_of(faces.begin(), faces.end(), [&](int f) {
      const Eigen::Vector3i& face = end.mesh->faces[f];
      return pairs[face[0]] > 0 || pairs[face[1]] > 0 || pairs[face[2]] > 0;
    });
    if (!any) continue;
    for (const int f : faces) {
      for (const int v : end.mesh->faces[f]) {
        if (static_cast<size_t>(input_vertex[v]) < input_vertices) seen[input_vertex[v]] = 1;
      }
    }
  }
  return seen;
}

void MarkSeenByPairs(const TriangleMesh& input, const std::vector<char>& seen, MeshParts* parts) {
  std::map<int, bool> by_first;  // vertex
  for (const std::vector<int>& faces : ConnectedComponents(input)) {
    int first = static_cast<int>(input.vertices.size());
    bool any = false;
    for (const int f : faces) {
      for (const int v : input.faces[f]) {
        first = std::min(first, v);
        any |= seen[v] != 0;
      }
    }
    by_first[first] = any;
  }
  for (MeshPart& part : parts->parts) part.seen_by_pair = by_first.at(part.first_vertex);
}

nlohmann::ordered_json PartsJson(const MeshParts& parts) {
  const auto count = [&](const auto& which) {
    return std::count_if(parts.parts.begin(), parts.parts.end(), which);
  };
  nlohmann::ordered_json json;
  json["count"] = parts.parts.size();
  json["turned"] = count([](const MeshPart& part) { return part.turned; });
  json["inside_out"] = count([](const MeshPart& part) { return part.inside_out; });
  json["largest"] = nlohmann::ordered_json::array();
  for (size_t k = 0; k < std::min(kListed, parts.parts.size()); ++k) {
    json["largest"].push_back(PartJson(parts.parts[k]));
  }
  return json;
}

}  // namespace burin
