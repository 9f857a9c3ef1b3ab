// Runs in several threads of one process: each with its own number of threads, all with the bytes that they
// have one after the other.
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include "apps/run/level_energy.h"
#include "apps/run/pipeline.h"
#include "core/support/parallel.h"
#include "core/synthetic/synthetic.h"

namespace burin {
namespace {

const SyntheticScene& Relief() {
  static const auto* scene = [] {
    SyntheticOptions options;
    options.views = 4;
    options.width = 120;
    options.height = 90;
    options.samples_per_axis = 1;
    options.init_edge_px = 24;
    options.truth_point_count = 100;
    options.point_count = 100;
    return new SyntheticScene(MakeSyntheticScene(options));
  }();
  return *scene;
}

TriangleMesh Refined(int threads) {
  PipelineOptions options;
  options.threads = threads;
  options.refinement.level.count = 2;
  options.refinement.level.min_side_px = 30;
  options.refinement.solver.max_iterations = 5;
  return RunPipeline(Relief().scene, Relief().init, options).mesh;
}

// Calls work(k) for k below `count` at once.
template <typename Work>
void AtOnce(int count, const Work& work) {
  std::vector<std::thread> threads;
  threads.reserve(count);
  for (int k = 0; k < count; ++k) threads.emplace_back([&work, k] { work(k); });
  for (std::thread& thread : threads) thread.join();
}

void ExpectSameBytesAtOnce(const std::vector<int>& thread_counts) {
  const TriangleMesh alone = Refined(1);
  std::vector<TriangleMesh> together(thread_counts.size());
  AtOnce(static_cast<int>(thread_counts.size()),
         [&](int k) { together[k] = Refined(thread_counts[k]); });
  for (const TriangleMesh& mesh : together) {
    EXPECT_TRUE(mesh.vertices == alone.vertices);
    EXPECT_TRUE(mesh.faces == alone.faces);
  }
}

TEST(ConcurrentRuns, TwoHaveTheBytesOfOne) { ExpectSameBytesAtOnce({2, 2}); }

TEST(ConcurrentRuns, FourWithDifferentThreadCountsHaveTheBytesOfOne) {
  ExpectSameBytesAtOnce({1, 2, 4, 0});
}

TEST(ConcurrentRuns, EnergiesAndRunsAtOnce) {
  PipelineOptions options;
  options.threads = 2;
  const std::vector<CameraPair> pairs = {{0, 1}, {1, 0}, {1, 2}, {2, 1}};
  const auto value = [&](LevelEnergy* energy) {
    Eigen::VectorXd gradient;
    return energy->Evaluate(Eigen::VectorXd::Zero(energy->unknowns()), &gradient);
  };
  LevelEnergy first(Relief().scene, Relief().init, pairs, options, 0);
  const double expected = value(&first);
  std::vector<double> values(3);
  AtOnce(4, [&](int k) {
    if (k == 3) {
      Refined(2);
      return;
    }
    LevelEnergy own(Relief().scene, Relief().init, pairs, options, 0);
    for (int repeat = 0; repeat < 5; ++repeat) values[k] = value(k == 0 ? &first : &own);
  });
  for (const double v : values) EXPECT_EQ(v, expected);
}

TEST(ThreadScope, BelongsToItsThreadAndItsItems) {
  const int all = ThreadCount();
  EXPECT_EQ(all, ThreadsFor(0));
  const ThreadScope three(3);
  EXPECT_EQ(ThreadCount(), 3);
  {
    const ThreadScope one(1);
    EXPECT_EQ(ThreadCount(), 1);
  }
  EXPECT_EQ(ThreadCount(), 3);
  AtOnce(1, [&](int) { EXPECT_EQ(ThreadCount(), all); });
  std::atomic<int> inherited{0};
  ParallelFor(64, 1, [&](int, int) {
    ParallelFor(4, 1, [&](int, int) { inherited += ThreadCount() == 3 ? 1 : 0; });
    ParallelInvoke([&] { inherited += ThreadCount() == 3 ? 1 : 0; },
                   [&] { inherited += ThreadCount() == 3 ? 1 : 0; });
  });
  EXPECT_EQ(inherited, 64 * 6);
  EXPECT_THROW(ParallelFor(8, 1, [](int, int) { throw std::runtime_error("as it is"); }),
               std::runtime_error);
  EXPECT_EQ(ThreadCount(), 3);
}

}  // namespace
}  // namespace burin
