// Cuts away what surface.trim says, and says so.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/evidence/trim.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_io.h"

namespace burin {

struct Trimming {
  SurfaceTrim rule = SurfaceTrim::kEvidence;
  // The mesh before, with its values.
  TriangleMesh whole;
  std::vector<VertexScalar> quality;
  std::vector<CutReason> reasons;  // by facet of `whole`
  double area_share = 0;           // cut away
  bool would_cut_all = false;      // the rule would leave nothing: nothing is cut
};

// Takes the facets with a reason out of mesh and values. Facets beyond `reasons` are patches in free space that were put
// back (apps/run/free_space_output.h); they are cut too.
Trimming TrimSurface(SurfaceTrim rule, std::vector<CutReason> reasons, TriangleMesh* mesh,
                     std::vector<VertexScalar>* quality);

// A line for the log.
std::string TrimText(const Trimming& trimming);

// `trim` of summary.json.
nlohmann::ordered_json TrimJson(const Trimming& trimming);

}  // namespace burin
