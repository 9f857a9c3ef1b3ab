#include "apps/run/trim_surface.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/mesh/smooth_rims.h"
#include "core/mesh/submesh.h"
#include "core/support/fixed_text.h"

namespace burin {
namespace {

// What the log says of the facets of a reason.
const char* Words(CutReason reason) {
  switch (reason) {
    case CutReason::kNone:
      return "kept";
    case CutReason::kUnseen:
      return "seen by no pair";
    case CutReason::kUnclear:
      return "seen by fewer than two pairs clear of depth steps";
    case CutReason::kGrazing:
      return "seen at a grazing angle only";
    case CutReason::kUncertain:
      return "uncertain by more than 3 px";
    case CutReason::kDisagrees:
      return "without correlation";
    case CutReason::kRefuted:
      return "thin, and seen from behind or outside masks";
    case CutReason::kFreeSpace:
      return "in free space";
    case CutReason::kSpeck:
      return "specks among these";
  }
  return "";
}

// Of `vertices` of the mesh: 1 for those that are not at its own border.
std::vector<char> InnerVertices(const TriangleMesh& mesh, const std::vector<int>& vertices) {
  const std::vector<char> boundary = BoundaryVertices(mesh, VertexFaces(mesh));
  std::vector<char> inner;
  inner.reserve(vertices.size());
  for (const int v : vertices) inner.push_back(boundary[v] == 0 ? 1 : 0);
  return inner;
}

int64_t Count(const Trimming& trimming, CutReason reason) {
  return std::count(trimming.reasons.begin(), trimming.reasons.end(), reason);
}

}  // namespace

Trimming TrimSurface(SurfaceTrim rule, std::vector<CutReason> reasons, TriangleMesh* mesh,
                     std::vector<VertexScalar>* quality) {
  Trimming trimming;
  trimming.rule = rule;
  trimming.reasons = std::move(reasons);
  trimming.reasons.resize(mesh->faces.size(), CutReason::kFreeSpace);
  trimming.would_cut_all = Count(trimming, CutReason::kNone) == 0 && !trimming.reasons.empty();
  if (trimming.would_cut_all) {
    std::fill(trimming.reasons.begin(), trimming.reasons.end(), CutReason::kNone);
    trimming.whole = *mesh;
    trimming.quality = *quality;
    return trimming;
  }
  std::vector<char> cut;
  double whole = 0;
  for (size_t f = 0; f < trimming.reasons.size(); ++f) {
    cut.push_back(trimming.reasons[f] != CutReason::kNone ? 1 : 0);
    const double area = FaceAreaNormal(*mesh, static_cast<int>(f)).norm();
    whole += area;
    if (cut.back() != 0) trimming.area_share += area;
  }
  if (whole > 0) trimming.area_share /= whole;
  std::vector<int> vertices;
  TriangleMesh left = WithoutFacets(*mesh, cut, &vertices);
  SmoothRims(InnerVertices(*mesh, vertices), &left);
  trimming.whole = std::exchange(*mesh, std::move(left));
  trimming.quality = *quality;
  for (VertexScalar& scalar : *quality) {
    for (size_t k = 0; k < vertices.size(); ++k) scalar.values[k] = scalar.values[vertices[k]];
    scalar.values.resize(vertices.size());
  }
  return trimming;
}

std::string TrimText(const Trimming& trimming) {
  if (trimming.would_cut_all) {
    return "nothing is cut away: it would be all of the mesh (surface.trim = " +
           std::string(NameOf(trimming.rule)) + ")";
  }
  const auto facets = static_cast<int64_t>(trimming.reasons.size());
  std::string text = std::to_string(facets - Count(trimming, CutReason::kNone)) + " of " +
                     std::to_string(facets) + " facets cut away, " +
                     Fixed(100 * trimming.area_share, 1) +
                     " % of the area (surface.trim = " + NameOf(trimming.rule) + ")";
  std::string separator = ": ";
  for (const auto& [reason, name] : ChoicesOf(CutReason())) {
    const int64_t count = Count(trimming, reason);
    if (reason == CutReason::kNone || count == 0) continue;
    text += std::exchange(separator, ", ") + std::to_string(count) + " " + Words(reason);
  }
  return text;
}

nlohmann::ordered_json TrimJson(const Trimming& trimming) {
  nlohmann::ordered_json cut = nlohmann::ordered_json::object();
  for (const auto& [reason, name] : ChoicesOf(CutReason())) {
    if (reason != CutReason::kNone) cut[name] = Count(trimming, reason);
  }
  return {{"rule", NameOf(trimming.rule)},
          {"vertices", trimming.whole.vertices.size()},
          {"faces", trimming.whole.faces.size()},
          {"area_share", trimming.area_share},
          {"cut", cut}};
}

}  // namespace burin
