// Throughput of one evaluation of the photometric energy, in valid windows (pixels times pairs) per
// second.
//
// The scene is the folder that BURIN_BENCH_SCENE names (a COLMAP workspace with init.ply), else the
// embedded relief. The mesh is the initial one, split to the pixels of level 0. Arguments:
// derivatives (0, 1), threads and occlusion masks (0 = none, 1 = the default mode).
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "core/mesh/mesh_io.h"
#include "core/mesh/mesh_order.h"
#include "core/mesh/subdivide.h"
#include "core/refine/round.h"
#include "core/scene/formats/colmap.h"
#include "core/scene/formats/scene_loader.h"
#include "core/scene/pyramid.h"
#include "core/support/parallel.h"
#include "core/synthetic/synthetic.h"
#include "core/visibility/facet_map.h"
#include "core/visibility/visibility.h"
#include "costs/photometric_energy.h"
#include "selection/pair_selection.h"

namespace burin {
namespace {

struct Frozen {
  Scene scene;
  TriangleMesh mesh;
  std::vector<LevelView> views;
  std::vector<CameraPair> pairs;
  std::vector<ViewDomain> domains;
  RoundContext context;
  std::unique_ptr<PhotometricEnergy> energies[2];  // without and with masks
};

Frozen& TheFrozen() {
  static auto* frozen = [] {
    auto* made = new Frozen;
    if (const char* folder = std::getenv("BURIN_BENCH_SCENE")) {
      made->scene = LoadScene({folder, {}, {}});
      made->mesh = ReadMesh(std::filesystem::path(folder) / "init.ply");
    } else {
      SyntheticScene synthetic = MakeSyntheticScene(SyntheticOptions());
      made->scene = std::move(synthetic.scene);
      made->mesh = std::move(synthetic.init);
    }
    made->pairs = SelectPairs(made->scene, made->mesh, PairsOptions()).pairs;
    made->views = MakeLevelViews(made->scene, 0, Eigen::Vector3d::Zero(), 1);
    std::vector<Camera> cameras;
    for (const LevelView& view : made->views) cameras.push_back(view.camera);
    SplitLargeFaces(&made->mesh, cameras, SubdivisionOptions());
    made->mesh = Ordered(made->mesh, OrderAlongCurve(made->mesh));  // as a run does
    made->context =
        FreezeRound(made->views, made->pairs, made->mesh, Motion::kNormal, 3, &made->domains);
    PhotometricOptions masked;
    PhotometricOptions full;
    full.mask.mode = MaskMode::kNone;
    made->energies[0] = std::make_unique<PhotometricEnergy>(full);
    made->energies[1] = std::make_unique<PhotometricEnergy>(masked);
    for (auto& energy : made->energies) energy->BeginLevel(made->views);
    return made;
  }();
  return *frozen;
}

void Evaluation(benchmark::State& state) {
  Frozen& frozen = TheFrozen();
  const ThreadScope threads(static_cast<int>(state.range(1)));
  const std::unique_ptr<PhotometricRound> round =
      frozen.energies[state.range(2)]->FreezeRound(frozen.context);
  round->FinishFreeze();
  int64_t windows = 0;
  for (auto _ : state) {
    round->Forget();  // the cached evaluation
    benchmark::DoNotOptimize(round->Evaluate(frozen.mesh.vertices, state.range(0) != 0));
    windows += round->WindowCount();
  }
  state.counters["valid_windows_per_s"] =
      benchmark::Counter(static_cast<double>(windows), benchmark::Counter::kIsRate);
  const nlohmann::json report = round->Report();
  state.counters["masked_share"] = report["masked_window_share"].get<double>();
  state.counters["mask_seconds"] = report["mask_seconds"].get<double>();
  state.counters["faces"] = static_cast<double>(frozen.mesh.faces.size());
  state.counters["pairs"] = static_cast<double>(frozen.pairs.size());
}
BENCHMARK(Evaluation)
    ->ArgNames({"derivatives", "threads", "masks"})
    ->Args({0, 1, 0})
    ->Args({0, 1, 1})
    ->Args({1, 1, 0})
    ->Args({1, 1, 1})
    ->Args({1, 2, 0})
    ->Args({1, 2, 1})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// What a round freezes: facet maps, regions of all pairs, and what is told of vertices.
void Visibility(benchmark::State& state) {
  Frozen& frozen = TheFrozen();
  const ThreadScope threads(static_cast<int>(state.range(0)));
  std::vector<ViewDomain> domains;
  for (auto _ : state) {
    FreezeRound(frozen.views, frozen.pairs, frozen.mesh, Motion::kNormal, 3, &domains);
  }
  int64_t pixels = 0;
  for (const ViewDomain& domain : domains) {
    for (const int64_t of_pair : domain.pair_pixels) pixels += of_pair;
  }
  state.counters["pair_pixels_per_s"] = benchmark::Counter(
      static_cast<double>(pixels), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["faces"] = static_cast<double>(frozen.mesh.faces.size());
}
BENCHMARK(Visibility)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// The facet maps alone, of all views.
void FacetMaps(benchmark::State& state) {
  Frozen& frozen = TheFrozen();
  const ThreadScope threads(1);
  int64_t pixels = 0;
  for (auto _ : state) {
    for (const LevelView& view : frozen.views) {
      const CornerMap map(frozen.mesh, view.camera);
      pixels += static_cast<int64_t>(map.width) * map.height;
    }
  }
  state.counters["pixels_per_s"] =
      benchmark::Counter(static_cast<double>(pixels), benchmark::Counter::kIsRate);
}
BENCHMARK(FacetMaps)->Unit(benchmark::kMillisecond);

// Embree's tree over the facets, for the points that need a ray.
void RayTree(benchmark::State& state) {
  Frozen& frozen = TheFrozen();
  const ThreadScope threads(1);
  for (auto _ : state) benchmark::DoNotOptimize(RayCaster(frozen.mesh));
}
BENCHMARK(RayTree)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace burin

BENCHMARK_MAIN();
