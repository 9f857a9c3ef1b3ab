// What cutting does to mesh, values and texts (apps/run/trim_surface.h).
#include "apps/run/trim_surface.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "core/evidence/trim.h"
#include "tests/test_shapes.h"

namespace burin {
namespace {

TEST(TrimSurface, WhatWouldCutAllCutsNothing) {
  const TriangleMesh whole = Sphere(1, 2);
  TriangleMesh mesh = whole;
  std::vector<VertexScalar> quality = {{"pairs", std::vector<float>(whole.vertices.size(), 0.0F)}};
  const std::vector<CutReason> reasons(whole.faces.size(), CutReason::kUnseen);
  const Trimming trimming = TrimSurface(SurfaceTrim::kUnseen, reasons, &mesh, &quality);
  EXPECT_EQ(mesh.faces, whole.faces);
  EXPECT_EQ(quality[0].values.size(), whole.vertices.size());
  EXPECT_EQ(TrimJson(trimming)["cut"]["unseen"], 0);
  EXPECT_EQ(TrimText(trimming),
            "nothing is cut away: it would be all of the mesh (surface.trim = unseen)");
}

// Whatever windows say.
TEST(TrimSurface, WhatOutlinesPlaceIsCutOnlyWhereItIsRefuted) {
  FacetEvidence facet;
  facet.front = 50;
  EXPECT_EQ(JudgeFacet(SurfaceTrim::kEvidence, facet), CutReason::kUnseen);
  facet.outlined = true;
  for (const SurfaceTrim rule : {SurfaceTrim::kUnseen, SurfaceTrim::kEvidence}) {
    EXPECT_EQ(JudgeFacet(rule, facet), CutReason::kNone);
  }
  facet.outside = 26;
  EXPECT_EQ(JudgeFacet(SurfaceTrim::kEvidence, facet), CutReason::kRefuted);
  EXPECT_EQ(JudgeFacet(SurfaceTrim::kUnseen, facet), CutReason::kNone);
}

}  // namespace
}  // namespace burin
