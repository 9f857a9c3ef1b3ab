#include "core/refinement.h"

#include <glog/logging.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "core/hidden_folds.h"
#include "core/mesh_order.h"
#include "core/pyramid.h"
#include "core/round.h"
#include "core/stopwatch.h"
#include "core/subdivide.h"

namespace burin {
namespace {

// Enough for folds of some tens of vertices across; each round adds its own.
constexpr int kRelaxSweeps = 100;

// Median over vertices of the smallest footprint among the views they project into; 0 when none
// does.
double MedianFootprint(const Scene& scene, const TriangleMesh& mesh) {
  std::vector<double> footprints;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    double smallest = 0;
    for (const View& view : scene.views) {
      if (view.camera.Depth(vertex) <= 0 || !view.camera.Contains(view.camera.Project(vertex))) {
        continue;
      }
      const double footprint = view.camera.Footprint(vertex);
      if (smallest == 0 || footprint < smallest) smallest = footprint;
    }
    if (smallest > 0) footprints.push_back(smallest);
  }
  if (footprints.empty()) return 0;
  std::nth_element(footprints.begin(),
                   footprints.begin() + static_cast<long>(footprints.size() / 2), footprints.end());
  return footprints[footprints.size() / 2];
}

// The coarsest of the levels asked for whose images all have min_side_px, or else the finest.
int CoarsestLevel(const Scene& scene, const LevelOptions& options) {
  int smallest = scene.views[0].camera.width;
  for (const View& view : scene.views) {
    smallest = std::min({smallest, view.camera.width, view.camera.height});
  }
  int level = options.finest + options.count - 1;
  while (level > options.finest && std::ldexp(smallest, -level) < options.min_side_px) --level;
  return level;
}

// A round frees millions of small blocks (residuals, Jacobian cells) that the next level's large arrays
// cannot use; give their pages back instead of carrying them through the run.
void ReturnFreeMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace

void LevelOptions::Describe(OptionSet* set) {
  set->Add("level.count", &count, "Levels of the image pyramid, each half the size of the next", 1,
           12);
  set->Add("level.min_side_px", &min_side_px,
           "Coarser levels whose images have a smaller side than this are left out", 1, 1000000);
  set->Add("level.finest", &finest, "Finest level used: 0 = full resolution, 1 = half, ...", 0, 11);
  set->Add("level.rounds", &rounds,
           "Rounds of freezing visibility and solving, on the finest level", 1, 1000);
  set->Add("level.extra_rounds", &extra_rounds,
           "Rounds more on every level than on the next finer one", 0, 1000);
  set->Add("level.coarse_tolerance", &coarse_tolerance,
           "solver.function_tolerance on every coarser level", 0, 1);
  set->Add("level.max_facet_px", &max_facet_px,
           "Facets are split to this area in their sharpest view, square pixels of the level", 0.5,
           1e9);
  set->Add("level.max_edge_px", &max_edge_px,
           "Facets with a longer edge are split too, pixel footprints of the level: those seen "
           "obliquely, as on depth steps; 0 = any length",
           0, 1e9);
  set->Add("level.border_px", &border_px,
           "Surface points projecting nearer to the second image's border are left out, pixels", 0,
           1000);
}

void RefinementOptions::Describe(OptionSet* set) {
  level.Describe(set);
  solver.Describe(set);
  set->Add("motion.type", &motion, "How vertices move: along their normal of the round, or freely",
           {"normal", "free"});
  set->Add("motion.hidden", &hidden,
           "Vertices that a pair saw in an earlier round and none sees now: drawn together after "
           "each round, or keep their shape as those never seen do",
           {"relax", "keep"});
}

TriangleMesh Refine(const Scene& scene, const TriangleMesh& input,
                    const std::vector<CameraPair>& pairs, const RefinementOptions& options,
                    const std::vector<EnergyTerm*>& terms, const RefinementHooks& hooks,
                    RefinementSummary* summary) {
  const Stopwatch total;
  CHECK(!input.vertices.empty());
  const Eigen::Vector3d origin = BoundingBox(input).center();
  const double footprint = MedianFootprint(scene, input);
  if (footprint <= 0) {
    throw InputError("no vertex of the mesh projects into any of the " +
                     std::to_string(scene.views.size()) +
                     " views: mesh and cameras are not in the same coordinate frame");
  }
  summary->footprint = footprint;
  // As the caller knows it: input vertices first, then new ones as they are made.
  TriangleMesh result = input;
  for (Eigen::Vector3d& vertex : result.vertices) vertex = (vertex - origin) / footprint;
  const Motion motion = options.motion == "free" ? Motion::kFree : Motion::kNormal;

  // Work is proportional to pixels: level l has 4^-l of them.
  double work_total = 0;
  double work_done = 0;
  const int last = options.level.finest;
  const int first = CoarsestLevel(scene, options.level);
  const auto rounds_of = [&](int level) {
    return options.level.rounds + (level - last) * options.level.extra_rounds;
  };
  for (int level = first; level >= last; --level) {
    work_total += rounds_of(level) * std::ldexp(1.0, -2 * level);
  }
  const bool relax_hidden = options.hidden == "relax";
  // Of the vertices of `result`: some pair has seen a facet of theirs.
  std::vector<char> was_supported(result.vertices.size(), 0);
  bool stopped = false;
  for (int level = first; level >= last && !stopped; --level) {
    ReturnFreeMemory();
    LevelSummary level_summary;
    level_summary.level = level;
    Stopwatch image_watch;
    const std::vector<LevelView> views = MakeLevelViews(scene, level, origin, 1 / footprint);
    for (EnergyTerm* term : terms) term->BeginLevel(views);
    level_summary.image_seconds = image_watch.Seconds();
    Stopwatch subdivide_watch;
    std::vector<Camera> cameras;
    cameras.reserve(views.size());
    for (const LevelView& view : views) cameras.push_back(view.camera);
    SubdivisionOptions subdivision;
    subdivision.max_facet_px = options.level.max_facet_px;
    subdivision.max_edge_px = options.level.max_edge_px;
    const SubdivisionReport split = SplitLargeFaces(&result, cameras, subdivision);
    for (const std::array<int, 2>& parents : split.new_vertex_parents) {
      was_supported.push_back(
          static_cast<char>(was_supported[parents[0]] & was_supported[parents[1]]));
    }
    const MeshOrder order = OrderAlongCurve(result);
    TriangleMesh mesh = Ordered(result, order);
    level_summary.subdivide_seconds = subdivide_watch.Seconds();
    level_summary.width = views[0].camera.width;
    level_summary.height = views[0].camera.height;
    level_summary.vertices = static_cast<int>(mesh.vertices.size());
    level_summary.faces = static_cast<int>(mesh.faces.size());

    SolverOptions solver = options.solver;
    if (level > last) solver.function_tolerance = options.level.coarse_tolerance;
    for (int r = 0; r < rounds_of(level) && !stopped; ++r) {
      RoundSummary round_summary;
      round_summary.round = r;
      Stopwatch visibility_watch;
      std::vector<ViewDomain> domains;
      RoundContext context =
          FreezeRound(views, pairs, mesh, motion, options.level.border_px, &domains);
      if (relax_hidden) {
        for (size_t v = 0; v < order.vertex.size(); ++v) {
          char& was = was_supported[order.vertex[v]];
          was = static_cast<char>(was | context.supported[v]);
          context.was_supported[v] = was;
        }
      }
      context.first_level = level == first;
      round_summary.visibility_seconds = visibility_watch.Seconds();
      for (const ViewDomain& domain : domains) {
        for (int64_t pixels : domain.pair_pixels) round_summary.pair_pixels += pixels;
      }
      round_summary.supported_vertices =
          static_cast<int>(std::count(context.supported.begin(), context.supported.end(), 1));
      if (round_summary.pair_pixels == 0) {
        throw InputError("no camera pair sees a common part of the mesh at level " +
                         std::to_string(level) +
                         ": every facet is out of view, hidden or seen from behind");
      }
      Stopwatch build_watch;
      for (EnergyTerm* term : terms) term->BeginRound(context);
      std::vector<Eigen::Vector3d> positions = mesh.vertices;
      RoundProblem round(terms, context, &positions);
      round_summary.build_seconds = build_watch.Seconds();

      const int unknowns = round.Unknowns();
      round.task.pixel = std::ldexp(1.0, level);
      const double round_work = std::ldexp(1.0, -2 * level);
      round.task.on_iteration = [&](const IterationRecord& record) {
        if (!hooks.on_iteration) return true;
        RefinementEvent event;
        event.level = level;
        event.round = r;
        const double share =
            solver.max_iterations > 0
                ? std::min(1.0, static_cast<double>(record.iteration) / solver.max_iterations)
                : 1.0;
        event.done = (work_done + share * round_work) / work_total;
        event.iteration = record;
        if (!hooks.on_iteration(event)) stopped = true;
        return !stopped;
      };
      Stopwatch solve_watch;
      if (hooks.solve_round) {
        FrozenRound frozen;
        frozen.level = level;
        frozen.round = r;
        frozen.unknowns = unknowns;
        frozen.context = &context;
        frozen.world_mesh = [&](const std::vector<Eigen::Vector3d>& now) {
          TriangleMesh moved = result;
          RestoreVertices({now, {}}, order, &moved);
          for (Eigen::Vector3d& vertex : moved.vertices) vertex = vertex * footprint + origin;
          return moved;
        };
        frozen.solve = [&](const std::string& name, const auto& on_iteration) {
          return round.Try(StrategyFor(name, unknowns, solver), solver, mesh.vertices,
                           on_iteration);
        };
        const RoundTrial trial = hooks.solve_round(frozen);
        round_summary.energy_initial = trial.energy_initial;
        round_summary.solve = trial.solve;
        round_summary.energy_final = trial.energy_final;
        round_summary.solve_seconds = trial.seconds;
        positions = trial.vertices;
      } else {
        const Strategy& strategy = StrategyFor(solver.type, unknowns, solver);
        round_summary.energy_initial = round.EnergyByTerm();
        round_summary.solve = strategy.solve(round.task, solver);
        round_summary.solve.strategy = strategy.name;
        round_summary.energy_final = round.EnergyByTerm();
        round_summary.solve_seconds = solve_watch.Seconds();
      }
      if (round_summary.solve.usable) mesh.vertices = positions;
      if (relax_hidden) {
        round_summary.relaxed_vertices = RelaxHiddenFolds(context, kRelaxSweeps, &mesh);
      }
      for (EnergyTerm* term : terms) round_summary.terms[term->Name()] = term->RoundReport();
      if (hooks.on_round) hooks.on_round(context, mesh, round_summary);
      level_summary.rounds.push_back(std::move(round_summary));
      work_done += round_work;
    }
    RestoreVertices(mesh, order, &result);
    summary->levels.push_back(std::move(level_summary));
  }
  for (Eigen::Vector3d& vertex : result.vertices) vertex = vertex * footprint + origin;
  summary->seconds = total.Seconds();
  return result;
}

}  // namespace burin
