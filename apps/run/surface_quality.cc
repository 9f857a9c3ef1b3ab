#include "apps/run/surface_quality.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/refine/thin_parts.h"
#include "core/support/parallel.h"
#include "costs/surface_evidence.h"

namespace burin {
namespace {

constexpr int kVertexGrain = 1024;
// Wider parts have pixels clear of their own outline on both sides, and some to spare.
constexpr double kThinPx = 2 * kClearPx + 2;

// A pixel of the sharpest view, full resolution, by vertex; infinite where no image shows it.
std::vector<double> Footprints(const TriangleMesh& mesh, const std::vector<LevelView>& views) {
  const auto count = static_cast<int>(mesh.vertices.size());
  std::vector<double> footprints(count, std::numeric_limits<double>::infinity());
  ParallelFor(count, kVertexGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const Eigen::Vector3d& vertex = mesh.vertices[v];
      for (const LevelView& view : views) {
        if (view.camera.Depth(vertex) <= 0 || !view.camera.Contains(view.camera.Project(vertex))) {
          continue;
        }
        footprints[v] =
            std::min(footprints[v], std::ldexp(view.camera.Footprint(vertex), -view.at.halvings));
      }
    }
  });
  return footprints;
}

std::vector<VertexScalar> Scalars(const RefinementEnd& reached, const VertexQuality& quality,
                                  const SurfaceEvidence& evidence,
                                  const std::vector<double>& footprints) {
  const auto count = static_cast<int>(footprints.size());
  std::vector<VertexScalar> scalars;
  for (const char* name : {"pairs", "zncc", "displacement_px", "sd_px", "cosine", "step_px"}) {
    scalars.push_back({name, std::vector<float>(count)});
  }
  ParallelFor(count, kVertexGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const double pixels = std::isfinite(footprints[v]) ? 1 / footprints[v] : std::nan("");
      const double moved = (reached.mesh->vertices[v] - reached.input_position[v]).norm();
      const int k = reached.index[v];
      scalars[0].values[k] = quality.pairs[v];
      scalars[1].values[k] = quality.zncc[v];
      scalars[2].values[k] = static_cast<float>(moved * pixels);
      scalars[3].values[k] = quality.sd[v] * static_cast<float>(pixels);
      scalars[4].values[k] = evidence.cosine[v];
      scalars[5].values[k] = evidence.step_px[v];
    }
  });
  return scalars;
}

// The mean of the values that are numbers; NaN where none is.
float MeanOfKnown(const Eigen::Vector3f& values) {
  float sum = 0;
  float count = 0;
  for (const float value : values) {
    if (std::isnan(value)) continue;
    sum += value;
    ++count;
  }
  return sum / count;
}

// What the evidence leaves to whoever knows vertices.
void AddVertexValues(const RefinementEnd& reached, const VertexQuality& quality,
                     const std::vector<double>& footprints, std::vector<FacetEvidence>* facets) {
  std::vector<double> width(footprints.size());
  for (size_t v = 0; v < width.size(); ++v) {
    const double pixel = std::isfinite(footprints[v]) ? footprints[v] : 0;
    width[v] = std::ldexp(kThinPx * pixel, reached.level);
  }
  const TriangleMesh& mesh = *reached.mesh;
  const std::vector<char>& free = reached.context->free;
  const std::vector<char> thin =
      ThinVertices(mesh, VertexNormals(mesh, reached.context->faces), width);
  for (size_t f = 0; f < facets->size(); ++f) {
    FacetEvidence& facet = (*facets)[f];
    Eigen::Vector3f sd;
    Eigen::Vector3f zncc;
    int thin_vertices = 0;
    bool outlined = false;
    for (int c = 0; c < 3; ++c) {
      const int v = mesh.faces[f][c];
      sd[c] = static_cast<float>(quality.sd[v] / footprints[v]);
      zncc[c] = quality.zncc[v];
      thin_vertices += thin[v];
      outlined |= free[v] != 0;
    }
    facet.sd_px = MeanOfKnown(sd);
    facet.zncc = MeanOfKnown(zncc);
    facet.thin = thin_vertices >= 2;
    facet.outlined = outlined;
  }
}

// In square pixels. What no image shows is taken as seen at the usual distance (core/refine/normalized_world.h).
std::vector<double> AreasPx(const TriangleMesh& mesh, const std::vector<double>& footprints) {
  std::vector<double> areas;
  areas.reserve(mesh.faces.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    double pixel = std::numeric_limits<double>::infinity();
    for (const int v : mesh.faces[f]) pixel = std::min(pixel, footprints[v]);
    if (!std::isfinite(pixel)) pixel = 1;
    areas.push_back(FaceAreaNormal(mesh, static_cast<int>(f)).norm() / 2 / (pixel * pixel));
  }
  return areas;
}

}  // namespace

SurfaceQuality MeasureSurface(const RefinementEnd& reached, const VertexQuality& quality,
                              SurfaceTrim rule) {
  const RoundContext& context = *reached.context;
  const TriangleMesh& mesh = *reached.mesh;
  SurfaceEvidence evidence = MeasureSurfaceEvidence(
      {mesh, context.faces, context.boundary, *context.views, *context.domains});
  const std::vector<double> footprints = Footprints(mesh, *context.views);
  SurfaceQuality surface;
  surface.scalars = Scalars(reached, quality, evidence, footprints);
  surface.reasons.assign(mesh.faces.size(), CutReason::kNone);
  if (rule == SurfaceTrim::kNone) return surface;
  AddVertexValues(reached, quality, footprints, &evidence.facets);
  const std::vector<CutReason> reasons =
      FacetsToCut(rule, mesh, evidence.facets, AreasPx(mesh, footprints));
  for (size_t f = 0; f < reasons.size(); ++f) surface.reasons[reached.face_index[f]] = reasons[f];
  return surface;
}

}  // namespace burin
