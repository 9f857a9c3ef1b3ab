#include "reconstruct/start_mesh.h"

#include <ctime>
#include <utility>

#include "core/support/error.h"
#include "core/support/stopwatch.h"
#include "reconstruct/cut_surface.h"
#include "reconstruct/dense_points.h"
#include "reconstruct/minimum_cut.h"
#include "reconstruct/sight_costs.h"
#include "reconstruct/sighted_points.h"
#include "reconstruct/stereo_views.h"
#include "reconstruct/triangulation.h"

namespace burin {
namespace {

// Of sparse and of dense points.
constexpr double kSigmaSpacing[2] = {0.25, 0.5};
constexpr double kSparseMaxEdgeFootprints = 100;
constexpr double kDenseMaxEdgeSpacings = 4;

double ProcessorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Runs the stages one after the other, with their times.
class Stages {
 public:
  Stages(const StartObservers& observers, std::vector<StartStage>* stages)
      : observers_(observers), stages_(stages) {}

  template <typename Work>
  auto Run(const std::string& name, double share_before, const Work& work) {
    Tell(share_before, name);
    const Stopwatch watch;
    const double processor = ProcessorSeconds();
    auto result = work();
    stages_->push_back({name, watch.Seconds(), ProcessorSeconds() - processor});
    return result;
  }

  // Between pieces of a stage.
  void Tell(double share, const std::string& name) const {
    if (observers_.check_stop) observers_.check_stop();
    if (observers_.on_progress) observers_.on_progress(share, name);
  }

  void Line(const std::string& line) const {
    if (observers_.on_line) observers_.on_line(line);
  }

 private:
  const StartObservers& observers_;
  std::vector<StartStage>* stages_;
};

double Or(double value, double otherwise) { return value > 0 ? value : otherwise; }

}  // namespace

StartMesh MakeStartMesh(const Scene& scene, const StartOptions& options,
                        const StartObservers& observers) {
  RequireTriangulation();
  StartMesh start;
  Stages stages(observers, &start.stages);
  SightedPoints points = stages.Run("points", 0, [&] {
    SparseReport report;
    const SightedPoints sparse = SparsePoints(scene, options, &report);
    stages.Line(report.Text());
    return sparse;
  });
  start.sparse_points = points.Count();
  if (options.points == StartPoints::kDense) {
    const StereoViews stereo = stages.Run("stereo", 0.02, [&] {
      StereoViewsRules rules;
      rules.pairs.partners = options.partners;
      rules.pairs.min_angle_deg = options.min_stereo_angle_deg;
      rules.pairs.max_angle_deg = options.max_stereo_angle_deg;
      rules.agreeing_pairs = options.agreeing_pairs;
      rules.folder = observers.depth_folder;
      return MatchViews(scene, rules,
                        [&](double share) { stages.Tell(0.02 + 0.5 * share, "stereo"); });
    });
    stages.Run("dense points", 0.52, [&] {
      AddDensePoints(scene, stereo.depths, {options.spacing_px, options.confirming_views}, &points);
      return 0;
    });
    start.dense_points = points.Count() - start.sparse_points;
    stages.Line(std::to_string(start.dense_points) + " dense points from the depth of " +
                std::to_string(stereo.matched) + " of " + std::to_string(scene.views.size()) +
                " views" +
                (stereo.read > 0 ? ", " + std::to_string(stereo.read) + " read again" : ""));
  }
  const bool dense = start.dense_points > start.sparse_points;
  points = stages.Run("merging", 0.55, [&] { return Merged(points, options.merge_footprints); });
  start.points = points.Count();
  const Tetrahedra tetrahedra =
      stages.Run("tetrahedra", 0.6, [&] { return Triangulate(points.positions); });
  start.cells = tetrahedra.CellCount();
  SightCosts sights = stages.Run("lines of sight", 0.65, [&] {
    start.spacing = PointSpacing(points.positions, tetrahedra);
    std::vector<Eigen::Vector3d> centers;
    for (const View& view : scene.views) centers.push_back(view.camera.Center());
    return CostsOfSights(points, tetrahedra, centers,
                         Or(options.sigma_spacing, kSigmaSpacing[dense ? 1 : 0]) * start.spacing,
                         options.quality);
  });
  start.lines = sights.lines;
  start.lost_lines = sights.lost;
  stages.Line(std::to_string(start.points) + " points, " + std::to_string(start.cells) +
              " tetrahedra, " + std::to_string(start.lines) + " lines of sight");
  const std::vector<char> inside =
      stages.Run("cut", 0.8, [&] { return MinimumCut(tetrahedra, sights.costs); });
  CutSurface surface = stages.Run("surface", 0.97, [&] {
    return SurfaceOfCut(
        points, tetrahedra, inside,
        {Or(options.max_edge_footprints,
            dense ? kDenseMaxEdgeSpacings * options.spacing_px : kSparseMaxEdgeFootprints),
         options.min_part_facets});
  });
  start.long_facets = surface.long_facets;
  start.small_parts = surface.small_parts;
  if (surface.mesh.faces.empty()) {
    throw InputError("the " + std::to_string(start.points) +
                     " points make no surface: " + std::to_string(surface.long_facets) +
                     " facets have too long an edge (start.max_edge_footprints), " +
                     std::to_string(surface.small_part_facets) +
                     " are in too small parts (start.min_part_facets)");
  }
  start.mesh = std::move(surface.mesh);
  for (const int point : surface.points) {
    start.sights.push_back(static_cast<float>(points.SightCount(point)));
  }
  return start;
}

}  // namespace burin
