#include "apps/run/measure_closing.h"

#include <algorithm>
#include <utility>

#include "core/refine/facet_texture.h"
#include "core/refine/normalized_world.h"
#include "core/refine/round.h"
#include "core/refine/view_levels.h"
#include "core/support/parallel.h"
#include "core/support/stopwatch.h"
#include "core/visibility/visibility.h"
#include "costs/grey_units.h"
#include "costs/photometric_energy.h"

namespace burin {
namespace {

constexpr int kHalvings = 2;  // more than on the finest level
// Unrelated photographs have a mean ZNCC of 0. docs/guard_figures.md has the errors of vertices by their ZNCC.
constexpr float kUnrelated = 0.1F;
constexpr float kEnoughWindows = 16;
constexpr int kFacetGrain = 256;

// What a mesh with the facets of the refined one is compared by.
struct HeldBack {
  std::vector<LevelView> views;
  std::vector<CameraPair> used;  // those that squares are held back of; else none
  std::vector<CameraPair> pairs;
  double border_px = 0;
  int level = 0;
  const std::vector<char>& boundary;
  PhotometricEnergy* photometric = nullptr;

  std::vector<FacetScore> ScoresOf(const TriangleMesh& mesh) const;
};

// Of a round's context only what scores need: it is never solved.
std::vector<FacetScore> HeldBack::ScoresOf(const TriangleMesh& mesh) const {
  std::vector<Camera> cameras;
  std::vector<cv::Mat> masks;
  for (const LevelView& view : views) {
    cameras.push_back(view.camera);
    masks.push_back(view.mask);
  }
  std::vector<ViewPartners> held_back;
  const std::vector<ViewDomain> domains =
      RayCaster(mesh).Cast(cameras, used, border_px, masks, pairs, &held_back);
  RoundContext context;
  context.views = &views;
  context.domains = &domains;
  context.held_back = &held_back;
  context.mesh = &mesh;
  context.boundary = boundary;
  context.level = level;
  return photometric->FreezeRound(context)->FacetScores(
      mesh.vertices, PhotometricRound::Windows::kHeldBack, /*derivatives=*/false);
}

// One pair of every reference view: enough for squares to be judged by.
std::vector<CameraPair> OnePairEach(const std::vector<CameraPair>& pairs) {
  std::vector<CameraPair> kept;
  for (const CameraPair& pair : pairs) {
    const bool has_one = std::any_of(kept.begin(), kept.end(), [&](const CameraPair& other) {
      return other.reference == pair.reference;
    });
    if (!has_one) kept.push_back(pair);
  }
  return kept;
}

// From small images to those of the finest level, until something can be said.
void Compare(const Scene& scene, const Scene& seen, const TriangleMesh& input,
             const PairSelection& selection, const LevelOptions& level,
             const PhotometricOptions& photo, const RefinementEnd& end, ClosingFigures* figures) {
  const bool squares = selection.held_back.empty();
  figures->judged_by = squares ? "squares" : "pairs";
  const std::vector<CameraPair> used =
      squares ? OnePairEach(selection.pairs) : std::vector<CameraPair>();
  const TriangleMesh start{end.input_position, end.mesh->faces};
  const NormalizedWorld world = NormalizedWorld::Of(seen, input);
  LevelOptions small = level;
  small.count = 1 + kHalvings;
  const ViewLevels levels(seen, input, small);
  for (int at = levels.Coarsest(selection.pairs, selection.held_back); at >= level.finest; --at) {
    const auto scores = [&](const Scene& by, const std::vector<Camera>& cameras,
                            const TriangleMesh& mesh) {
      std::vector<LevelView> views =
          MakeLevelViews(by, cameras, levels.At(at), world.origin, 1 / world.footprint);
      PhotometricEnergy photometric(photo, squares);
      const std::vector<CameraPair> used_here = TakingPart(used, views);
      const std::vector<CameraPair> held_back_here = TakingPart(selection.held_back, views);
      const HeldBack held_back{std::move(views), used_here, held_back_here,
                               level.border_px,  at,        end.context->boundary,
                               &photometric};
      photometric.BeginLevel(held_back.views);
      const Camera& name = NamesLevel(held_back.views).camera;
      figures->width = name.width;
      figures->height = name.height;
      return held_back.ScoresOf(mesh);
    };
    const std::vector<FacetScore> before = scores(scene, CamerasOf(scene), start);
    figures->held_back = CompareScores(before, scores(seen, *end.cameras, *end.mesh));
    if (figures->held_back->Known()) break;
  }
}

// A third of the area of the facets around each vertex.
std::vector<double> VertexAreas(const TriangleMesh& mesh) {
  std::vector<double> areas(mesh.vertices.size(), 0);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const double third = FaceAreaNormal(mesh, static_cast<int>(f)).norm() / 6;
    for (const int v : mesh.faces[f]) areas[v] += third;
  }
  return areas;
}

// Views that show texture above the variance floor in some pixel of the facet; counted up to 2.
std::vector<uint8_t> TexturedViews(const PhotometricOptions& photo, const RoundContext& context) {
  std::vector<uint8_t> textured_views(context.mesh->faces.size(), 0);
  for (size_t i = 0; i < context.domains->size(); ++i) {
    const ViewDomain& domain = (*context.domains)[i];
    if (domain.facet.empty()) continue;
    const LevelView& view = (*context.views)[i];
    const cv::Mat1b textured = TexturedPixels(view.image, UnitsOf(view, photo).unit);
    ParallelFor(static_cast<int>(domain.facet.size()), kFacetGrain, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        uint8_t& views = textured_views[domain.facet[k]];
        if (views == 2) continue;
        for (const ImagePixel pixel : domain.PixelsOf(k)) {
          if (textured(pixel.row, pixel.column) == 0) continue;
          ++views;
          break;
        }
      }
    });
  }
  return textured_views;
}

// What a vertex with windows on which photographs do not agree is.
enum class Disagreement : char { kNone, kAgainst, kFeatureless };

// By vertex.
std::vector<Disagreement> Disagreements(const PhotometricOptions& photo,
                                        const RoundContext& context, const VertexQuality& quality) {
  const std::vector<uint8_t> textured_views = TexturedViews(photo, context);
  std::vector<Disagreement> found(quality.zncc.size(), Disagreement::kNone);
  for (size_t v = 0; v < found.size(); ++v) {
    if (quality.windows[v] < kEnoughWindows || quality.zncc[v] >= kUnrelated) continue;
    const auto at = static_cast<int>(v);
    const bool textured = std::any_of(context.faces.Begin(at), context.faces.End(at),
                                      [&](int f) { return textured_views[f] == 2; });
    found[v] = textured ? Disagreement::kAgainst : Disagreement::kFeatureless;
  }
  return found;
}

}  // namespace

ClosingFigures MeasureClosing(const Scene& scene, const Scene& seen, const TriangleMesh& input,
                              const PairSelection& selection, const LevelOptions& level,
                              const PhotometricOptions& photo, bool squares_were_left_out,
                              const RefinementEnd& end, const VertexQuality& quality) {
  const Stopwatch watch;
  ClosingFigures figures;
  figures.moved = end.mesh->vertices != end.input_position;
  if (!selection.held_back.empty() || squares_were_left_out) {
    Compare(scene, seen, input, selection, level, photo, end, &figures);
  }
  const std::vector<double> areas = VertexAreas(*end.mesh);
  double whole = 0;
  double unseen = 0;
  double against = 0;
  double featureless = 0;
  const std::vector<Disagreement> found = Disagreements(photo, *end.context, quality);
  for (size_t v = 0; v < areas.size(); ++v) {
    whole += areas[v];
    if (end.context->seen[v] == 0) unseen += areas[v];
    if (found[v] == Disagreement::kAgainst) against += areas[v];
    if (found[v] == Disagreement::kFeatureless) featureless += areas[v];
  }
  if (whole > 0) {
    figures.unseen = unseen / whole;
    figures.against = against / whole;
    figures.featureless = featureless / whole;
  }
  figures.seconds = watch.Seconds();
  return figures;
}

}  // namespace burin
