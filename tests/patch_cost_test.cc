// What Ceres and burin's own normal equations get from the patches is the energy and its gradient, at every vertex: at silhouettes too,
// where patches have taps of windows that are centred elsewhere.
#include "costs/patch_cost.h"

#include <ceres/crs_matrix.h>
#include <gtest/gtest.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <memory>

#include "core/mesh/subdivide.h"
#include "core/refine/normalized_world.h"
#include "core/refine/round.h"
#include "core/scene/pyramid.h"
#include "core/solve/ceres_problem.h"
#include "core/solve/motion.h"
#include "core/solve/normal_equations.h"
#include "core/synthetic/synthetic.h"
#include "costs/photometric_energy.h"
#include "selection/pair_selection.h"

namespace burin {
namespace {

// A round of bodies in front of each other, its mesh cut to the pixels, in double precision.
struct Round {
  Round(int width, int height, int views_count, Motion motion) {
    SyntheticOptions scene_options;
    scene_options.scene = SyntheticKind::kOccluders;
    scene_options.width = width;
    scene_options.height = height;
    scene_options.views = views_count;
    scene_options.truth_point_count = 1000;
    const SyntheticScene synthetic = MakeSyntheticScene(scene_options);
    const NormalizedWorld world = NormalizedWorld::Of(synthetic.scene, synthetic.init);
    mesh = world.FromWorld(synthetic.init);
    views = MakeLevelViews(synthetic.scene, 0, world.origin, 1 / world.footprint);
    std::vector<Camera> cameras;
    for (const LevelView& view : views) cameras.push_back(view.camera);
    SplitLargeFaces(&mesh, cameras, SubdivisionOptions());
    const std::vector<CameraPair> pairs =
        SelectPairs(synthetic.scene, synthetic.init, PairsOptions()).pairs;
    context = FreezeRound(views, pairs, mesh, motion, 3, &domains);
    PhotometricOptions options;
    options.double_precision = true;
    term = std::make_unique<PhotometricEnergy>(options);
    term->BeginLevel(views);
    photometric = term->FreezeRound(context);
    parameters.vertices = mesh.vertices;
    energy = std::make_unique<RoundEnergy>(&parameters);
    photometric->AddBlocks(energy.get());
    vertices = energy->Used();
    lines.reserve(vertices.size());
    for (const int v : vertices) {
      if (motion == Motion::kNormal) {
        energy->SetManifold(v, &lines.emplace_back(context.normals[v]));
      }
    }
    problem = std::make_unique<CeresProblem>(*energy, photometric->Callback());
  }

  // By entry of `vertices`: along the normal, or x, y, z.
  std::vector<double> CeresGradient(double* cost) {
    ceres::Problem::EvaluateOptions evaluate;
    for (const int v : vertices) {
      evaluate.parameter_blocks.push_back(parameters.vertices[v].data());
    }
    std::vector<double> gradient;
    EXPECT_TRUE(problem->get()->Evaluate(evaluate, cost, nullptr, &gradient, nullptr));
    return gradient;
  }

  // Of the energy with respect to all coordinates, from the corner sums.
  std::vector<Eigen::Vector3d> Gradient() {
    photometric->Evaluate(mesh.vertices, true);
    std::vector<Eigen::Vector3d> gradient(mesh.vertices.size(), Eigen::Vector3d::Zero());
    for (size_t f = 0; f < mesh.faces.size(); ++f) {
      for (int c = 0; c < 3; ++c) {
        const CornerSums& sums = photometric->corner_sums()[3 * f + c];
        for (int k = 0; k < 3; ++k) {
          gradient[mesh.faces[f][k]] += sums.slope[k] * photometric->facet_normals()[f];
        }
      }
    }
    return gradient;
  }

  // Supported vertices whose patch has a gradient, and no window centred in it: the number.
  int PatchesOfTapsAlone() {
    photometric->Evaluate(mesh.vertices, true);
    int count = 0;
    for (const int v : vertices) {
      double cost = 0;
      double slope = 0;
      for (const int* f = context.faces.Begin(v); f != context.faces.End(v); ++f) {
        for (int c = 0; c < 3; ++c) {
          if (mesh.faces[*f][c] != v) continue;
          const CornerSums& sums = photometric->corner_sums()[3 * static_cast<size_t>(*f) + c];
          cost += sums.cost;
          for (const double s : sums.slope) slope += std::abs(s);
        }
      }
      count += cost == 0 && slope > 0 ? 1 : 0;
    }
    return count;
  }

  TriangleMesh mesh;
  std::vector<LevelView> views;
  std::vector<ViewDomain> domains;
  RoundContext context;
  std::unique_ptr<PhotometricEnergy> term;
  std::unique_ptr<PhotometricRound> photometric;
  RoundParameters parameters;
  std::vector<LineAlongNormal> lines;
  std::unique_ptr<RoundEnergy> energy;
  std::unique_ptr<CeresProblem> problem;
  std::vector<int> vertices;  // that the problem has
};

TEST(PatchCost, CeresHasTheEnergyAndItsGradientAtEveryVertexOfOccluders) {
  for (const Motion motion : {Motion::kNormal, Motion::kFree}) {
    Round round(320, 240, 0, motion);
    ASSERT_GT(round.vertices.size(), 5000U);
    EXPECT_GT(round.PatchesOfTapsAlone(), 100);
    const std::vector<Eigen::Vector3d> gradient = round.Gradient();
    const double energy = round.photometric->Evaluate(round.mesh.vertices, true);
    double cost = 0;
    const std::vector<double> found = round.CeresGradient(&cost);
    EXPECT_NEAR(cost, energy, 1e-9 * energy);
    int wrong = 0;
    size_t next = 0;
    for (const int v : round.vertices) {
      const Eigen::Vector3d& normal = round.context.normals[v];
      Eigen::Vector3d expected = gradient[v];
      Eigen::Vector3d delivered;
      if (motion == Motion::kNormal) {
        expected = expected.dot(normal) * normal;
        delivered = found[next++] * normal;
      } else {
        delivered = Eigen::Vector3d(found[next], found[next + 1], found[next + 2]);
        next += 3;
      }
      wrong += (delivered - expected).norm() > 1e-6 * expected.norm() + 1e-9 ? 1 : 0;
    }
    EXPECT_EQ(wrong, 0) << "of " << round.vertices.size();
  }
}

// Central differences of the total energy, one vertex at a time.
TEST(PatchCost, CeresGradientIsThatOfCentralDifferencesAtEveryVertex) {
  Round round(72, 54, 4, Motion::kNormal);
  ASSERT_GT(round.vertices.size(), 200U);
  EXPECT_GT(round.PatchesOfTapsAlone(), 5);
  double cost = 0;
  const std::vector<double> found = round.CeresGradient(&cost);
  double largest = 0;
  for (const double g : found) largest = std::max(largest, std::abs(g));
  constexpr double kStep = 1e-5;  // pixels
  std::vector<Eigen::Vector3d> moved = round.mesh.vertices;
  for (size_t k = 0; k < round.vertices.size(); ++k) {
    const int v = round.vertices[k];
    double energy[2];
    for (int side = 0; side < 2; ++side) {
      moved[v] = round.mesh.vertices[v] + (side == 0 ? kStep : -kStep) * round.context.normals[v];
      energy[side] = round.photometric->Evaluate(moved, false);
    }
    moved[v] = round.mesh.vertices[v];
    EXPECT_NEAR((energy[0] - energy[1]) / (2 * kStep), found[k],
                1e-4 * std::abs(found[k]) + 1e-6 * largest)
        << "vertex " << v;
  }
}

// The facets' gradient and curvature against what follows from the patches' residuals: some patches with beta above 1,
// some vertices constant.
TEST(FacetBlocks, GradientAndCurvatureAreThoseOfThePatches) {
  for (const Motion motion : {Motion::kNormal, Motion::kFree}) {
    Round round(160, 120, 4, motion);
    for (size_t k = 0; k < round.vertices.size(); k += 7)
      round.energy->SetConstant(round.vertices[k]);
    const CeresProblem problem(*round.energy, round.photometric->Callback());
    ceres::Problem::EvaluateOptions evaluate;
    for (const int v : round.energy->Moving()) {
      evaluate.parameter_blocks.push_back(round.energy->Values(v));
    }
    double expected_cost = 0;
    std::vector<double> expected;
    ceres::CRSMatrix crs;
    ASSERT_TRUE(problem->Evaluate(evaluate, &expected_cost, nullptr, &expected, &crs));
    using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor>;
    const Eigen::Map<const Sparse> jacobian(crs.num_rows, crs.num_cols,
                                            static_cast<long>(crs.values.size()), crs.rows.data(),
                                            crs.cols.data(), crs.values.data());
    NormalEquations equations(*round.energy, round.photometric->Callback());
    double cost = 0;
    Eigen::VectorXd gradient;
    ASSERT_TRUE(equations.Evaluate(&cost, &gradient));
    EXPECT_NEAR(cost, expected_cost, 1e-12 * cost);
    double cost_alone = 0;
    ASSERT_TRUE(equations.EvaluateCost(&cost_alone));
    EXPECT_EQ(cost_alone, cost);
    const Eigen::Map<const Eigen::VectorXd> map(expected.data(),
                                                static_cast<long>(expected.size()));
    EXPECT_LE((gradient - map).norm(), 1e-12 * map.norm());
    Sparse matrix(equations.unknowns(), equations.unknowns());
    std::vector<Eigen::Triplet<double>> entries;
    for (int row = 0; row < equations.unknowns(); ++row) {
      for (int64_t k = equations.matrix().start[row]; k < equations.matrix().start[row + 1]; ++k) {
        entries.emplace_back(row, equations.matrix().column[k], equations.matrix().value[k]);
      }
    }
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Sparse square = Sparse(jacobian.transpose()) * jacobian;
    EXPECT_LE((matrix - square).norm(), 1e-12 * square.norm());

    int scaled = 0;
    PatchSystem system;
    for (const int v : round.vertices) {
      system.Make(*round.photometric, v);
      scaled += ScaleOf(system).beta_squared > 1.01 ? 1 : 0;
    }
    RecordProperty(motion == Motion::kNormal ? "scaled_normal" : "scaled_free", scaled);
    EXPECT_GT(scaled, 0);
  }
}

}  // namespace
}  // namespace burin
