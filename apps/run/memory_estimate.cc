#include "apps/run/memory_estimate.h"

#include <algorithm>
#include <cmath>

#include "core/cameras/intrinsics.h"
#include "core/refine/view_levels.h"
#include "core/support/parallel.h"
#include "core/visibility/facet_pencil.h"
#include "core/visibility/partner_bits.h"
#include "costs/facet_blocks.h"
#include "costs/pair_rows.h"
#include "costs/patch_cost.h"
#include "costs/photometric_energy.h"
#include "costs/stencil_cost.h"

namespace burin {
namespace {

constexpr double kMib = 1024.0 * 1024.0;
constexpr double kRing = 7;      // vertices of a patch: a vertex and, on average, six neighbours
constexpr double kFacetsOf = 6;  // facets of a vertex
constexpr double kFacetCorners = 3;
constexpr double kFacetsAVertex = 2;  // of the mesh
constexpr double kAllocation = 16;    // header and rounding of a small allocation (glibc)
constexpr double kPointer = 8;

// What burin keeps, in bytes. Correct this table when burin keeps more or less.
struct Costs {
  // The program with its libraries, thread pools and Embree's device, nothing loaded.
  double base = 62 * kMib;

  // --- a pixel of a level, in every view
  double level_image = 4;  // float; level 0 shares the photograph instead
  double pixel_list = 3;   // ViewDomain: 2, or 4 in views that see a large facet; of covered pixels
  double mask_entry = 5;   // WindowMasks: column 4, thin 1; its words are added by the window
  double mask_word = 8;
  // Of covered pixels: windows with a mask, of the default window (0.004 to 0.19 measured). Others by
  // 1 - (1 - mask_share)^((radius / 2)^1.5), the growth on fountain-P11 of windows from 3 to 31.
  double mask_share = 0.15;
  double mask_growth = 1.5;
  // --- a pixel of the largest view, of the view in work
  // cost, share, slope, curvature, inverse depth (fields, added by precision), reference image as float 4
  double view_fields = 4;

  // --- a thread: the rows of PairKernel, 20 fields of 5 rows of a 512-pixel tile and stack
  double thread = 1 * kMib;

  // --- a facet visible in a view, in ViewDomain: its index 4, start 12, box 4
  double visible_facet = 20;
  // --- a visible facet of the view in work: FacetPencil
  double facet_pencil = sizeof(FacetPencil);

  // --- a facet of the mesh
  double facet_mesh = 2 * sizeof(Eigen::Vector3i);  // the mesh and the input it came from
  // The corners' sums are added by precision; the facet's normal, its scores at a level's start and end
  double facet_sums = sizeof(Eigen::Vector3d) + 2 * sizeof(FacetScore);
  // FacetBlocks: vertices, start, facet, facets at its edges
  double facet_block = 3 * 4 + 4 + 4 + 3;

  // --- a vertex of the mesh
  // positions: mesh, solver's, last evaluated, input; RoundContext: normal, boundary and supported,
  // neighbours and faces with their starts
  double vertex_mesh = 4 * sizeof(Eigen::Vector3d) + sizeof(Eigen::Vector3d) + 2 +
                       4 * (kFacetsOf + 1) + 4 * (kFacetsOf + 1);
  // FacetBlocks: PatchScale; RoundEnergy: constant, manifold and LineAlongNormal
  double vertex_block = sizeof(PatchScale) + 1 + kPointer + 32;
  // StencilBlocks: start and rest; by size vertex and coefficient
  double stencil = 4 + sizeof(Eigen::Vector3d);
  double stencil_entry = 4 + 8;
  // Of the problem for Ceres. PatchCost: object, vertices, parameter sizes; factor added by unknowns
  double patch_cost = sizeof(PatchCost) + sizeof(PatchFactor) + 2 * kRing * 4 + 4 * kAllocation;
  // Where cameras move, of a vertex in a pair: VertexInPairCost with its parameter sizes and pointer, and its place; the values of
  // PairRows are added by unknowns.
  double pair_vertex = 80 + 3 * 4 + 2 * kPointer + 2 * kAllocation + 4;
  // StencilCost: object, and by size coefficient and parameter size
  double stencil_cost = sizeof(StencilCost) + 3 * kAllocation;
  double stencil_cost_entry = 8 + 4;
  // ceres::Problem. A residual block: object 32, its pointer in two programs, node of the map that
  // counts cost functions 48; added by size the pointers to parameter blocks.
  double residual_block = 32 + 2 * kPointer + 48 + 3 * kAllocation;
  // A parameter block: object 104, plus-Jacobian 24, manifold 40, node of the map from pointers 48,
  // pointers in two programs.
  double parameter_block = 104 + 24 + 40 + 48 + 2 * kPointer + 4 * kAllocation;
  // State, candidate, step, gradient, scaling, ... of Ceres: about four vectors in coordinates and
  // ten in unknowns.
  double vertex_state = 4 * 24;
  double unknown_state = 10 * 8;

  // --- Ceres' Jacobian: values by size; a row block 8, the vector of its cells 24, layout pointer 8;
  // a cell 8 and its place in the layout 4
  double row_block = 8 + 24 + 8 + 2 * kAllocation;
  double cell = 8 + 4;

  // --- Cholesky: J^T J by its list of products (block row, block column, index: 12, in a vector that
  // doubles: a third more on average, offset 4) and its entries (8, index 4, and a copy for CHOLMOD);
  // the factor has fill * log2(n) numbers an unknown and block (nested dissection of a plane mesh:
  // n log n), with indices
  double product = 12 * 4.0 / 3 + 4;
  double normal_entry = 2 * (8 + 4);
  // NormalEquations. An entry of H: value, column, half of its place below the diagonal; the place of a block's entry;
  // a contribution; a block's place and cost; of a vertex MovingBlock, plus Jacobian, indices, two RowTasks, a state
  // that is kept; starts of rows.
  double equation_entry = 8 + 4 + 1;
  double equation_slot = 2;
  double equation_contribution = 8;
  double equation_block = 8 + 8;
  double equation_vertex = 48 + 24 + 3 * 4 + 2 * 16 + 2 * 24;
  double equation_row = 8 + 8 + 4;
  double equation_batch = 4096;  // blocks whose gradients and matrices are held at a time
  // Entries of H against those of a regular mesh: 28 of 19 on fountain-P11, whose split facets have vertices of
  // four to eight neighbours.
  double irregular = 1.45;
  double fill = 4.5;
  double factor_entry = 8 + 1;

  // Freed arrays that the allocator keeps, of what is not the program: those below 32 MiB, so that they do not grow
  // with large runs.
  double gaps = 0.14;
  double largest_gaps = 80 * kMib;

  double point = sizeof(ScenePoint) + 4 * 8 + 8 + 4 * 24;  // of the scene, views and tracks
};
constexpr Costs kCost;

// Pieces that level.max_edge_px and the growth of moved surfaces add: 1.4 seen on fountain-P11, which
// bridges depth steps, 1.1 on scenes that do not, with the defaults. Facets of less area seldom have longer edges.
constexpr double kLongEdges = 0.25;
double LongEdges(const LevelOptions& levels) {
  if (levels.max_edge_px <= 0) return 1;
  const LevelOptions defaults;
  const double ratio = (levels.max_facet_px / defaults.max_facet_px) /
                       std::pow(levels.max_edge_px / defaults.max_edge_px, 2);
  return 1 + kLongEdges * std::min(1.0, ratio);
}

// What the view that sees most sees, of the mean.
constexpr double kLargestView = 1.5;

// Bytes of the masks of one covered pixel: the words, and the rest.
struct MaskBytes {
  double words = 0;
  double rest = 0;
};
MaskBytes MaskOfPixel(double window) {
  const double radius = std::floor(window / 2);
  const double share = 1 - std::pow(1 - kCost.mask_share, std::pow(radius / 2, kCost.mask_growth));
  const double side = 2 * radius + 1;
  return {share * std::ceil(side * side / 64) * kCost.mask_word, share * kCost.mask_entry};
}

// Vertices that share a residual with a vertex, itself included, when residuals are on `stencil`
// vertices: k rings of a regular mesh have 1 + 3 k (k + 1) vertices, two residuals' reach twice that.
double CoupledVertices(double stencil) {
  const double rings = (std::sqrt(1 + 4 * (stencil - 1) / 3) - 1) / 2;
  return 1 + 3 * (2 * rings) * (2 * rings + 1);
}

// What a strategy keeps beside the round's energy.
struct SolverCost {
  const char* name;
  bool ceres;      // CeresProblem
  bool jacobian;   // Ceres' own
  bool equations;  // NormalEquations
  bool factor;
  double vectors;  // of unknowns
};
constexpr SolverCost kSolverCosts[] = {
    {"gradient_descent", true, false, false, false, 8},
    {"steepest_descent", true, false, false, false, 2},
    {"ncg", true, false, false, false, 2},
    {"bfgs", true, false, false, false, 2},        // and its matrix
    {"lbfgs", true, false, false, false, 2 * 20},  // Ceres' default rank
    {"lbfgs_sobolev", false, false, true, true, 2 * 20},
    {"lbfgs_h", false, false, true, true, 2 * 20},
    {"lm_cgnr", true, true, false, false, 6},
    {"lm_pcg", false, false, true, false, 8},
    {"lm_cholesky", true, true, false, true, 2},
    {"dogleg", true, true, false, true, 6},
};
constexpr double kBfgsMaxUnknowns = 8000;  // larger ones are refused by Refine

SolverCost CostOf(const std::string& solver) {
  for (const SolverCost& cost : kSolverCosts) {
    if (solver == cost.name) return cost;
  }
  return {"", true, true, true, true, 2 * 20};
}

}  // namespace

double MemoryEstimate::Mib() const {
  double total = 0;
  for (const auto& part : parts) total += part.second;
  return total;
}

MemoryEstimate EstimateLevel(const LevelLoad& load) {
  const SolverCost solver = CostOf(load.solver);
  const double n = load.unknowns_per_vertex;
  const double unknowns = n * load.vertices;
  const double patch_unknowns = n * kRing;
  const double fields = load.field_bytes;
  const double spline = load.level_pixels * fields * 1.05;  // with a border of 8 pixels
  const double images = load.scene_bytes + load.points * kCost.point + spline +
                        (load.level > 0 ? load.level_pixels * kCost.level_image : 0);
  const MaskBytes mask = load.masks ? MaskOfPixel(load.window) : MaskBytes();
  double pixels = load.domain_bytes +
                  load.covered_pixels * (kCost.pixel_list + mask.words + mask.rest) +
                  load.largest_view * (kCost.view_fields + 5 * fields) +
                  load.visible_facets * kCost.visible_facet +
                  load.view_facets * kCost.facet_pencil + load.threads * kCost.thread;
  const double mesh = load.faces * kCost.facet_mesh + load.vertices * kCost.vertex_mesh;
  const double corner_sums =
      3 * static_cast<double>(CornerSumsList::BytesPerCorner(/*in_double=*/fields > 4));
  const double energy =
      load.faces * (corner_sums + kCost.facet_sums + kCost.facet_block) +
      load.vertices * (kCost.vertex_block +
                       (load.stencil > 0 ? kCost.stencil + load.stencil * kCost.stencil_entry : 0));
  const double residual_blocks = load.stencil > 0 ? 2 : 1;
  double problem = unknowns * 8 * solver.vectors;
  if (solver.ceres) {
    const double factor_of_patch =
        8 * (patch_unknowns + 1 + patch_unknowns * (patch_unknowns + 1) / 2);
    problem +=
        load.vertices *
            (kCost.patch_cost + factor_of_patch +
             (load.stencil > 0 ? kCost.stencil_cost + load.stencil * kCost.stencil_cost_entry : 0) +
             residual_blocks * kCost.residual_block + (kRing + load.stencil) * kPointer +
             kCost.parameter_block + kCost.vertex_state) +
        unknowns * kCost.unknown_state;
  }
  double jacobian = 0;
  if (solver.jacobian) {
    // A patch has one row more than unknowns, a stencil three.
    jacobian =
        load.vertices * (8 * ((patch_unknowns + 1) * patch_unknowns + 3 * n * load.stencil) +
                         residual_blocks * kCost.row_block + (kRing + load.stencil) * kCost.cell);
  }
  if (solver.ceres && load.joint_partners > 0) {
    // Instead of patches, and often more: every vertex in every pair that sees it (costs/pair_rows.h).
    const double in_pairs = load.visible_facets / 2 * load.joint_partners;
    const double of_block = kCost.pair_vertex + 8 * n * (n + 1 + PairRows::kCameras) +
                            kCost.residual_block + 3 * kPointer;
    problem += in_pairs * of_block;
    if (solver.jacobian) {
      jacobian += in_pairs * (8 * n * (n + PairRows::kCameras) + kCost.row_block + 3 * kCost.cell);
    }
  }
  double linear = 0;
  const auto pairs = [](double blocks) { return blocks * (blocks + 1) / 2; };
  const double coupled = CoupledVertices(std::max(kRing, load.stencil));
  if (solver.equations) {
    linear += load.vertices *
              (n * n * kCost.irregular * coupled * kCost.equation_entry +
               (pairs(kFacetCorners) * kFacetsAVertex + pairs(load.stencil)) * kCost.equation_slot +
               (kFacetCorners * kFacetsAVertex + load.stencil) * kCost.equation_contribution +
               (kFacetsAVertex + 1) * kCost.equation_block + kCost.equation_vertex +
               n * kCost.equation_row);
    const double block = n * std::max(kFacetCorners, load.stencil);
    linear += 8 * std::min(kCost.equation_batch, load.vertices) * block * (block + 1);
  }
  if (solver.factor) {
    // Wider rows of the matrix fill the factor more; measured with the bi-Laplacian.
    const double fill = kCost.fill * std::sqrt(coupled / CoupledVertices(kRing));
    linear +=
        load.vertices * (pairs(kRing) + pairs(load.stencil)) * kCost.product +
        load.vertices * n * n * (coupled + 1) / 2 * kCost.normal_entry +
        load.vertices * n * n * fill * std::log2(std::max(2.0, load.vertices)) * kCost.factor_entry;
  }
  if (load.solver == "bfgs") linear = 8 * std::pow(std::min(unknowns, kBfgsMaxUnknowns), 2);
  // Masks are made by rows, which are kept until a view has all: of as many views as threads. The solver's
  // arrays come after that, in the same place.
  const double mask_rows =
      std::min(load.covered_pixels, load.threads * load.largest_view) * mask.words;
  pixels += std::max(0.0, mask_rows - (energy + problem + jacobian + linear));
  MemoryEstimate estimate;
  estimate.level = load.level;
  estimate.vertices = static_cast<int64_t>(load.vertices);
  estimate.faces = static_cast<int64_t>(load.faces);
  estimate.parts = {{"program", kCost.base / kMib},  {"held", load.held_bytes / kMib},
                    {"images", images / kMib},       {"pixels", pixels / kMib},
                    {"mesh", mesh / kMib},           {"energy", energy / kMib},
                    {"solver", problem / kMib},      {"jacobian", jacobian / kMib},
                    {"linear_solver", linear / kMib}};
  const double kept = kCost.gaps * (estimate.Mib() - kCost.base / kMib);
  estimate.parts.emplace_back("gaps", std::min(kept, kCost.largest_gaps / kMib));
  return estimate;
}

MemoryEstimate EstimateMemory(const Scene& scene, const TriangleMesh& mesh,
                              const SurfaceInViews& surface, const PipelineOptions& options,
                              double held_bytes) {
  LevelLoad load;
  load.held_bytes = held_bytes;
  const LevelOptions& levels = options.refinement.level;
  const PairsRecipe recipe = Resolve(options.pairs);
  const auto others = static_cast<double>(scene.views.size());
  const double partners =
      recipe.method == PairsMethod::kAll ? others : std::min<double>(recipe.per_camera, others);
  std::vector<double> full_pixels;  // by view
  const bool lenses = IntrinsicsOf(options.refinement.cameras.refine) != IntrinsicUnknowns::kNone;
  for (const View& view : scene.views) {
    full_pixels.push_back(static_cast<double>(view.camera.width) * view.camera.height);
    load.scene_bytes += full_pixels.back();
    // Photograph and mask that a refined lens undistorts again.
    if (lenses && !view.origin.lens.IsNone()) load.held_bytes += 2 * full_pixels.back();
  }
  // 8 bits unless the images are here and have more.
  if (!scene.views.empty() && !scene.views[0].gray.empty()) {
    load.scene_bytes *= static_cast<double>(scene.views[0].gray.elemSize());
  }
  load.points = static_cast<double>(scene.points.size());
  load.threads = ThreadsFor(options.threads);
  load.field_bytes = options.photo.double_precision ? 8 : 4;
  load.unknowns_per_vertex = options.refinement.motion == Motion::kFree ? 3 : 1;
  load.masks = options.photo.mask.mode != MaskMode::kNone;
  load.window = options.photo.window;
  if (options.smooth.type == SmoothnessType::kNone || options.smooth.weight == 0) {
    load.stencil = 0;
  } else if (options.smooth.type == SmoothnessType::kBilaplacian) {
    load.stencil = 19;  // two rings
  }
  // Omega_ij; one more partner is held back.
  const double planes = static_cast<double>(PartnerBits::BytesPerPixel(
                            static_cast<size_t>(std::max(1.0, partners)))) +
                        (options.refinement.guard.levels ? 1 : 0);
  // Beside depth steps, what is used of it: from the second level on.
  const bool band = options.photo.mask.mode == MaskMode::kPlane && options.photo.mask.band_px > 0;
  const ViewLevels view_levels(scene, mesh, levels);
  MemoryEstimate peak;
  const int coarsest = levels.finest + levels.count - 1;
  for (int level = levels.finest; level <= coarsest; ++level) {
    load.level = level;
    load.level_pixels = load.covered_pixels = load.largest_view = 0;
    const std::vector<ViewAtLevel> views = view_levels.At(level);
    for (size_t v = 0; v < views.size(); ++v) {
      const double pixels = std::ldexp(full_pixels[v], -2 * views[v].halvings);
      load.level_pixels += pixels;
      load.covered_pixels += std::ldexp(surface.covered[v], -2 * views[v].halvings);
      load.largest_view = std::max(load.largest_view, pixels);
    }
    const CamerasOptions& cameras = options.refinement.cameras;
    load.joint_partners =
        cameras.Jointly() && level <= cameras.coarsest_joint && level >= cameras.finest_joint
            ? partners
            : 0;
    load.domain_bytes = load.level_pixels * planes * (band && level < coarsest ? 2 : 1);
    load.faces =
        static_cast<double>(ExpectedFaces(surface, levels.max_facet_px, level)) * LongEdges(levels);
    // Each bisection of an edge adds a vertex and, inside the surface, two faces.
    load.vertices = static_cast<double>(mesh.vertices.size()) +
                    (load.faces - static_cast<double>(mesh.faces.size())) / 2;
    load.visible_facets = load.faces * surface.views_per_area;
    load.view_facets =
        std::min(load.faces, kLargestView * load.visible_facets /
                                 std::max(1.0, static_cast<double>(scene.views.size())));
    const auto unknowns = static_cast<int>(std::min(2e9, load.vertices * load.unknowns_per_vertex));
    const Strategy* strategy =
        FindStrategy(options.refinement.solver.type, unknowns, options.refinement.solver);
    load.solver = strategy != nullptr ? strategy->name : options.refinement.solver.type;
    // A matrix that is refused is not made.
    if (load.solver == "bfgs" && unknowns > kBfgsMaxUnknowns) load.solver = "ncg";
    const MemoryEstimate estimate = EstimateLevel(load);
    if (peak.parts.empty() || estimate.Mib() > peak.Mib()) peak = estimate;
  }
  return peak;
}

}  // namespace burin
