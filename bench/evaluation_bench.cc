// Throughput of one evaluation of the photometric energy, in valid windows (pixels times pairs) a
// second.
//
// The scene is the folder in BURIN_BENCH_SCENE (a COLMAP workspace with init.ply), else the
// embedded relief. The mesh is the initial one split to the pixels of level 0. Arguments:
// derivatives (0, 1) and threads.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "core/colmap.h"
#include "core/mesh_io.h"
#include "core/parallel.h"
#include "core/pyramid.h"
#include "core/round.h"
#include "core/subdivide.h"
#include "core/synthetic.h"
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
  std::unique_ptr<PhotometricEnergy> energy;
};

Frozen& TheFrozen() {
  static auto* frozen = [] {
    auto* made = new Frozen;
    if (const char* folder = std::getenv("BURIN_BENCH_SCENE")) {
      made->scene = LoadColmapScene(folder);
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
    made->context =
        FreezeRound(made->views, made->pairs, made->mesh, Motion::kNormal, 3, &made->domains);
    made->energy = std::make_unique<PhotometricEnergy>(PhotometricOptions());
    made->energy->BeginLevel(made->views);
    return made;
  }();
  return *frozen;
}

void Evaluation(benchmark::State& state) {
  Frozen& frozen = TheFrozen();
  SetThreadCount(static_cast<int>(state.range(1)));
  int64_t windows = 0;
  for (auto _ : state) {
    state.PauseTiming();
    frozen.energy->BeginRound(frozen.context);  // forget the cached evaluation
    state.ResumeTiming();
    benchmark::DoNotOptimize(frozen.energy->Evaluate(frozen.mesh.vertices, state.range(0) != 0));
    windows += frozen.energy->valid_windows();
  }
  state.counters["valid_windows_per_s"] =
      benchmark::Counter(static_cast<double>(windows), benchmark::Counter::kIsRate);
  state.counters["faces"] = static_cast<double>(frozen.mesh.faces.size());
  state.counters["pairs"] = static_cast<double>(frozen.pairs.size());
}
BENCHMARK(Evaluation)
    ->ArgNames({"derivatives", "threads"})
    ->Args({0, 1})
    ->Args({1, 1})
    ->Args({1, 2})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void Visibility(benchmark::State& state) {
  Frozen& frozen = TheFrozen();
  SetThreadCount(static_cast<int>(state.range(0)));
  std::vector<ViewDomain> domains;
  for (auto _ : state) {
    FreezeRound(frozen.views, frozen.pairs, frozen.mesh, Motion::kNormal, 3, &domains);
  }
}
BENCHMARK(Visibility)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace burin

BENCHMARK_MAIN();
