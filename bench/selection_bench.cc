// Selection of camera pairs with its survey, for a number of views of the scene "occluders": every view shares
// surface with nearly every other. Arguments: views; pairs.candidates, 0 = all pairs are measured. FromFile takes the
// pairs from a file and chooses those to hold back.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/support/parallel.h"
#include "core/synthetic/synthetic.h"
#include "selection/pair_selection.h"

namespace burin {
namespace {

const SyntheticScene& SceneOf(int views) {
  static auto* scenes = new std::map<int, SyntheticScene>;
  const auto found = scenes->find(views);
  if (found != scenes->end()) return found->second;
  SyntheticOptions options;
  options.scene = SyntheticKind::kOccluders;
  options.views = views;
  options.width = 320;
  options.height = 240;
  options.samples_per_axis = 1;
  options.truth_point_count = 0;
  return scenes->emplace(views, MakeSyntheticScene(options)).first->second;
}

void Selection(benchmark::State& state) {
  const SyntheticScene& synthetic = SceneOf(static_cast<int>(state.range(0)));
  const ThreadScope threads(1);
  PairsOptions options;
  options.candidates = static_cast<int>(state.range(1));
  size_t pairs = 0;
  for (auto _ : state) {
    pairs = SelectPairs(synthetic.scene, synthetic.init, options).pairs.size();
    benchmark::DoNotOptimize(pairs);
  }
  state.counters["pairs"] = static_cast<double>(pairs);
}
BENCHMARK(Selection)
    ->ArgNames({"views", "candidates"})
    ->Args({25, -1})
    ->Args({50, 0})
    ->Args({50, -1})
    ->Args({100, 0})
    ->Args({100, -1})
    ->Unit(benchmark::kMillisecond);

void FromFile(benchmark::State& state) {
  const Scene& scene = SceneOf(static_cast<int>(state.range(0))).scene;
  const TriangleMesh& mesh = SceneOf(static_cast<int>(state.range(0))).init;
  const ThreadScope threads(1);
  PairsOptions options;
  options.candidates = static_cast<int>(state.range(1));
  nlohmann::json json = {{"pairs", nlohmann::json::array()}};
  for (const auto& [i, j] : SelectPairs(scene, mesh, PairsOptions()).pairs) {
    json["pairs"].push_back({{"reference", scene.views[i].name}, {"second", scene.views[j].name}});
  }
  const std::filesystem::path path = std::filesystem::temp_directory_path() /
                                     ("selection_bench-" + std::to_string(getpid()) + ".json");
  std::ofstream(path) << json;
  options.method = PairsMethod::kFile;
  options.file = path.string();
  size_t pairs = 0;
  for (auto _ : state) {
    pairs = SelectPairs(scene, mesh, options).held_back.size();
    benchmark::DoNotOptimize(pairs);
  }
  state.counters["held_back"] = static_cast<double>(pairs);
  std::filesystem::remove(path);
}
BENCHMARK(FromFile)
    ->ArgNames({"views", "candidates"})
    ->Args({50, 0})
    ->Args({50, -1})
    ->Args({100, 0})
    ->Args({100, -1})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace burin
