#include "apps/run/free_space_output.h"

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "core/support/fixed_text.h"

namespace burin {
namespace {

constexpr size_t kViewsNamed = 3;

size_t FacetCount(const FreeSpace& free_space) {
  return static_cast<size_t>(std::count(free_space.facet.begin(), free_space.facet.end(), 1));
}

}  // namespace

TriangleMesh WithoutPatches(const TriangleMesh& mesh, const FreeSpace& free_space) {
  TriangleMesh without;
  without.vertices = mesh.vertices;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    if (free_space.facet[f] == 0) without.faces.push_back(mesh.faces[f]);
  }
  return without;
}

void PutPatchesBack(const TriangleMesh& input, const FreeSpace& free_space, TriangleMesh* refined) {
  for (const FreeSpacePatch& patch : free_space.patches) {
    for (const int f : patch.facets) refined->faces.push_back(input.faces[f]);
  }
}

void AppendPatches(const TriangleMesh& input, const FreeSpace& free_space, TriangleMesh* refined,
                   std::vector<VertexScalar>* values) {
  for (const FreeSpacePatch& patch : free_space.patches) {
    std::map<int, int> index;
    for (const int f : patch.facets) {
      Eigen::Vector3i face;
      for (int c = 0; c < 3; ++c) {
        const int v = input.faces[f][c];
        const auto [at, is_new] = index.emplace(v, static_cast<int>(refined->vertices.size()));
        if (is_new) refined->vertices.push_back(input.vertices[v]);
        face[c] = at->second;
      }
      refined->faces.push_back(face);
    }
  }
  for (VertexScalar& scalar : *values) {
    const bool has_none = scalar.name == "zncc" || scalar.name == "sd_px";
    scalar.values.resize(refined->vertices.size(),
                         has_none ? std::numeric_limits<float>::quiet_NaN() : 0);
  }
}

void DropPatchVertices(const TriangleMesh& input, const FreeSpace& free_space,
                       TriangleMesh* refined, std::vector<VertexScalar>* values) {
  std::vector<char> drop(refined->vertices.size(), 0);
  for (const FreeSpacePatch& patch : free_space.patches) {
    for (const int f : patch.facets) {
      for (int c = 0; c < 3; ++c) drop[input.faces[f][c]] = 1;
    }
  }
  for (const Eigen::Vector3i& face : refined->faces) {
    for (int c = 0; c < 3; ++c) drop[face[c]] = 0;
  }
  std::vector<int> index(drop.size(), -1);
  int kept = 0;
  for (size_t v = 0; v < drop.size(); ++v) {
    if (drop[v] != 0) continue;
    index[v] = kept;
    refined->vertices[kept] = refined->vertices[v];
    for (VertexScalar& scalar : *values) scalar.values[kept] = scalar.values[v];
    ++kept;
  }
  refined->vertices.resize(kept);
  for (VertexScalar& scalar : *values) scalar.values.resize(kept);
  for (Eigen::Vector3i& face : refined->faces) {
    for (int c = 0; c < 3; ++c) face[c] = index[face[c]];
  }
}

std::string FreeSpaceText(const FreeSpace& free_space, const std::string& then) {
  std::string text = std::to_string(FacetCount(free_space)) + " facets of the mesh, in " +
                     std::to_string(free_space.patches.size()) +
                     (free_space.patches.size() == 1 ? " patch" : " patches") +
                     ", stand in free space: photographs see through them";
  const size_t named = std::min(kViewsNamed, free_space.hidden.size());
  for (size_t k = 0; k < named; ++k) {
    const HiddenView& hidden = free_space.hidden[k];
    text +=
        (k == 0 ? "; they hide " : ", ") + Fixed(100 * hidden.share, 1) + " % of " + hidden.view;
  }
  if (free_space.hidden.size() > named) {
    text += " and less of " + std::to_string(free_space.hidden.size() - named) + " more views";
  }
  return text + "; " + then;
}

nlohmann::ordered_json FreeSpaceJson(const FreeSpace& free_space) {
  nlohmann::ordered_json patches = nlohmann::ordered_json::array();
  for (const FreeSpacePatch& patch : free_space.patches) {
    patches.push_back({{"facets", patch.facets.size()},
                       {"votes_against", patch.votes_against},
                       {"votes_for", patch.votes_for}});
  }
  nlohmann::ordered_json views = nlohmann::ordered_json::array();
  for (const HiddenView& hidden : free_space.hidden) {
    views.push_back({{"view", hidden.view}, {"hidden_share", hidden.share}});
  }
  return {{"facets", FacetCount(free_space)}, {"patches", patches}, {"views", views}};
}

}  // namespace burin
