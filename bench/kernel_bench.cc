// Each kernel of an evaluation by itself, on artificial data that fits the caches as a tile does in a run.
// It shows what bounds an evaluation, without memory, threads or visibility in the way.
//
// pixels_per_s counts the pixels of the tile, all of them in Omega_ij; facets_per_s counts the facets of
// the pencils.
#include <benchmark/benchmark.h>
#include <hwy/highway.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/support/parallel.h"
#include "core/synthetic/synthetic.h"
#include "core/visibility/facet_pencil.h"
#include "costs/occlusion_mask.h"
#include "costs/pair_kernel.h"
#include "costs/spline_image.h"

namespace burin {
namespace {

constexpr int kWidth = 512;
constexpr int kHeight = 96;

cv::Mat1f Texture(double shift) {
  cv::Mat1f image(kHeight, kWidth);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      image(y, x) = static_cast<float>(120 + 40 * std::sin(0.9 * (x + shift)) * std::cos(0.7 * y) +
                                       20 * std::sin(0.31 * x + 0.47 * y));
    }
  }
  return image;
}

// A pair that looks at a slanted plane, the second view a little to the side.
struct TilePair {
  TilePair() : image(Texture(0)), second(Texture(0.4), 128.0F) {
    depth.resize(kWidth * kHeight);
    for (size_t p = 0; p < depth.size(); ++p) {
      depth[p] = static_cast<float>(1 + 1e-4 * static_cast<double>(p % kWidth));
    }
    domain.assign(kWidth * kHeight, 1);
    input.width = kWidth;
    input.height = kHeight;
    input.image = image[0];
    input.grey_offset = 128;
    input.inverse_depth = depth.data();
    input.domain.bytes = domain.data();
    input.second = &second;
    for (int k = 0; k < 3; ++k) input.warp[4 * static_cast<size_t>(k)] = 1;
    input.epipole[0] = 0.7;
    input.epipole[1] = 0.2;
    input.variance_floor = 25;
    input.min_taps = 20;
    fields.Resize(depth.size(), true, false);
  }
  // Takes the two right columns of every window whose centre column is a multiple of `every`.
  void MaskColumns(int every) {
    masks.radius = input.radius;
    masks.words = 1;
    masks.row_start = {0};
    uint64_t bits = 0;
    for (int k = 0; k < 25; ++k) bits |= k % 5 < 4 ? uint64_t{1} << k : 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; x += every) {
        masks.column.push_back(x);
        masks.bits.push_back(bits);
        masks.thin.push_back(0);
      }
      masks.row_start.push_back(static_cast<uint32_t>(masks.column.size()));
    }
    input.masks = &masks;
  }
  cv::Mat1f image;
  SplineImage<float> second;
  std::vector<float> depth;
  std::vector<uint8_t> domain;
  WindowMasks masks;
  PairInput<float> input;
  PixelFields<float> fields;
};

void RunTile(benchmark::State& state, TilePair* pair, bool derivatives) {
  PairKernel<float> kernel;
  const Tile tile{0, 0, kWidth, kHeight};
  int64_t windows = 0;
  for (auto _ : state) windows += kernel.AddTile(pair->input, tile, derivatives, &pair->fields);
  state.counters["pixels_per_s"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * kWidth * kHeight, benchmark::Counter::kIsRate);
  state.counters["valid_windows"] =
      static_cast<double>(windows) / static_cast<double>(state.iterations());
}

// Warp, window sums and scores; with derivatives slope and curvature too.
void PairTile(benchmark::State& state) {
  TilePair pair;
  RunTile(state, &pair, state.range(0) != 0);
}
BENCHMARK(PairTile)->ArgName("derivatives")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

// The same with each instruction set that the machine has.
void PairTileWith(benchmark::State& state, int64_t target) {
  hwy::SetSupportedTargetsForTest(target);
  hwy::GetChosenTarget().DeInit();
  TilePair pair;
  RunTile(state, &pair, true);
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}
const bool kWithEachTarget = [] {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    benchmark::RegisterBenchmark(("PairTileWith/" + std::string(hwy::TargetName(target))).c_str(),
                                 [target](benchmark::State& state) { PairTileWith(state, target); })
        ->Unit(benchmark::kMicrosecond);
  }
  return true;
}();

// The cost of windows must hardly grow with their size.
void PairTileByWindow(benchmark::State& state) {
  TilePair pair;
  pair.input.radius = static_cast<int>(state.range(0)) / 2;
  pair.input.min_taps = static_cast<int>(state.range(0) * state.range(0) * 4 / 5);
  RunTile(state, &pair, true);
}
BENCHMARK(PairTileByWindow)
    ->ArgName("window")
    ->Arg(3)
    ->Arg(5)
    ->Arg(7)
    ->Arg(11)
    ->Arg(21)
    ->Arg(31)
    ->Unit(benchmark::kMicrosecond);

// Every n-th window has lost taps.
void PairTileMasked(benchmark::State& state) {
  TilePair pair;
  pair.MaskColumns(static_cast<int>(state.range(0)));
  RunTile(state, &pair, true);
}
BENCHMARK(PairTileMasked)->ArgName("every")->Arg(1)->Arg(4)->Arg(16)->Unit(benchmark::kMicrosecond);

void SplinePrefilter(benchmark::State& state) {
  const cv::Mat1f image = Texture(0);
  for (auto _ : state) {
    const SplineImage<float> spline(image, 128.0F);
    benchmark::DoNotOptimize(spline.coefficients());
  }
  state.counters["pixels_per_s"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * kWidth * kHeight, benchmark::Counter::kIsRate);
}
BENCHMARK(SplinePrefilter)->Unit(benchmark::kMicrosecond);

void Pencils(benchmark::State& state) {
  SyntheticOptions options;
  options.width = 64;
  options.height = 48;
  const SyntheticScene scene = MakeSyntheticScene(options);
  const ViewRays rays(scene.scene.views[0].camera);
  for (auto _ : state) {
    for (const Eigen::Vector3i& face : scene.truth.faces) {
      benchmark::DoNotOptimize(MakeFacetPencil(scene.truth.vertices, face, rays));
    }
  }
  state.counters["facets_per_s"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * static_cast<double>(scene.truth.faces.size()),
      benchmark::Counter::kIsRate);
}
BENCHMARK(Pencils)->Unit(benchmark::kMicrosecond);

// Masks of a view with a depth step every 32 columns.
void Masks(benchmark::State& state) {
  const ThreadScope threads(1);
  DepthPlanes planes;
  planes.width = kWidth;
  planes.height = kHeight;
  planes.focal = 500;
  planes.slope_x.assign(kWidth * kHeight, 0);
  planes.slope_y.assign(kWidth * kHeight, 0);
  planes.ray_length.assign(kWidth * kHeight, 1);
  for (int p = 0; p < kWidth * kHeight; ++p) {
    planes.inverse_depth.push_back((p % kWidth) / 32 % 2 == 0 ? 1.0F : 0.8F);
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(MakeWindowMasks(planes, 2, MaskMode::kPlane, 3, 20).size());
  }
  state.counters["pixels_per_s"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * kWidth * kHeight, benchmark::Counter::kIsRate);
}
BENCHMARK(Masks)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace burin

BENCHMARK_MAIN();
