// Derivatives of the photometric energy by cameras against central differences, and what must not change it.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <memory>
#include <tuple>

#include "core/refine/round.h"
#include "core/solve/motion.h"
#include "core/support/parallel.h"
#include "costs/grey_units.h"
#include "costs/patch_system.h"
#include "costs/photometric_energy.h"
#include "costs/spline_image.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

using test::Random;

// Cameras as lenses have them: pixels that are not square, principal points beside the middle.
std::vector<LevelView> UnevenViews(int count = 3) {
  std::vector<LevelView> views = test::RandomViews(96, 80, count);
  for (size_t i = 0; i < views.size(); ++i) {
    Camera& camera = views[i].camera;
    camera.fx *= 1.02 + 0.05 * static_cast<double>(i);
    camera.fy *= 0.96;
    camera.cx += 3.3 - 2.0 * static_cast<double>(i);
    camera.cy -= 1.7;
  }
  return views;
}

struct Fixture {
  explicit Fixture(const PhotometricOptions& photometric, Motion motion = Motion::kNormal)
      : options(photometric) {
    mesh = test::OccluderMesh();
    views = UnevenViews();
    context = FreezeRound(views, test::AllPairs(), mesh, motion, 2, &domains);
    term = std::make_unique<PhotometricEnergy>(options);
    term->BeginLevel(views);
    energy = term->FreezeRound(context);
    for (const LevelView& view : views) poses.push_back(PoseOf(view.camera));
  }
  // Poses after a step of `steps` (six numbers a camera) of their manifold.
  std::vector<CameraPose> Moved(const Eigen::VectorXd& steps) const {
    std::vector<CameraPose> moved = poses;
    for (size_t i = 0; i < poses.size(); ++i) {
      EXPECT_TRUE(PoseManifold().Plus(poses[i].data(), steps.data() + 6 * i, moved[i].data()));
    }
    return moved;
  }
  // By the steps of the manifolds.
  Eigen::VectorXd Gradient() {
    energy->Evaluate(mesh.vertices, poses, true);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(6 * static_cast<long>(poses.size()));
    for (const CameraSums::Pair& pair : energy->camera_sums().pairs) {
      Eigen::Matrix<double, 12, 1> scaled = pair.gradient;
      scaled.segment<3>(0) *= 2;  // Ceres' step is half a rotation vector
      scaled.segment<3>(6) *= 2;
      gradient.segment<6>(6 * pair.first) += scaled.head<6>();
      gradient.segment<6>(6 * pair.second) += scaled.tail<6>();
    }
    return gradient;
  }
  PhotometricOptions options;
  TriangleMesh mesh;
  std::vector<LevelView> views;
  std::vector<ViewDomain> domains;
  RoundContext context;
  std::unique_ptr<PhotometricEnergy> term;
  std::unique_ptr<PhotometricRound> energy;
  std::vector<CameraPose> poses;
};

PhotometricOptions Options(int window, MaskMode mode) {
  PhotometricOptions options;
  options.double_precision = true;
  options.window = window;
  options.min_valid_share = 0.4;
  options.mask.mode = mode;
  options.mask.plane_px = 2;
  return options;
}

class CameraDerivatives : public testing::TestWithParam<std::tuple<int, MaskMode>> {};
INSTANTIATE_TEST_SUITE_P(All, CameraDerivatives,
                         testing::Combine(testing::Values(3, 5, 7),
                                          testing::Values(MaskMode::kNone, MaskMode::kPlane)),
                         [](const auto& test) {
                           return "window" + std::to_string(std::get<0>(test.param)) + "_" +
                                  NameOf(std::get<1>(test.param));
                         });

TEST_P(CameraDerivatives, GradientMatchesCentralDifferences) {
  for (const double reliability : {0.0, 20.0}) {
    PhotometricOptions options = Options(std::get<0>(GetParam()), std::get<1>(GetParam()));
    options.reliability = reliability;
    Fixture fixture(options);
    const Eigen::VectorXd gradient = fixture.Gradient();
    // Every camera is first and second in pairs.
    ASSERT_EQ(fixture.energy->camera_sums().pairs.size(), 6);
    const double step = 1e-7;
    for (int u = 0; u < gradient.size(); ++u) {
      const Eigen::VectorXd direction = step * Eigen::VectorXd::Unit(gradient.size(), u);
      const double numeric =
          (fixture.energy->Evaluate(fixture.mesh.vertices, fixture.Moved(direction), false) -
           fixture.energy->Evaluate(fixture.mesh.vertices, fixture.Moved(-direction), false)) /
          (2 * step);
      EXPECT_NEAR(gradient[u], numeric, 1e-4 * std::abs(numeric) + 1e-8 * gradient.norm())
          << "camera " << u / 6 << ", unknown " << u % 6;
      EXPECT_GT(std::abs(numeric), 1e-3);
    }
  }
}

// The curvature in all coordinates of the vertices and the motions of the cameras behind them, without what the patches
// of costs/patch_system.h do to it.
Eigen::MatrixXd JointCurvature(const PhotometricRound& energy) {
  const RoundContext& context = energy.context();
  const auto vertices = static_cast<int>(context.mesh->vertices.size());
  const int first_camera = 3 * vertices;
  const int size = first_camera + 6 * static_cast<int>(context.views->size());
  Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(size, size);
  PatchSystem system;
  for (int v = 0; v < vertices; ++v) {
    system.Make(energy, v);
    const long n = system.Unknowns();
    for (long row = 0; row < n; ++row) {
      for (long column = 0; column < n; ++column) {
        joint(3 * system.vertices[row / 3] + row % 3,
              3 * system.vertices[column / 3] + column % 3) += system.curvature[row * n + column];
      }
    }
  }
  const CameraCoupling& coupling = energy.camera_sums().coupling;
  for (int v = 0; v < vertices; ++v) {
    for (const int* c = coupling.cameras.Begin(v); c != coupling.cameras.End(v); ++c) {
      const auto block = coupling.Block(coupling.Place(v, *c));
      joint.block<3, 6>(3 * v, first_camera + 6 * *c) = block;
      joint.block<6, 3>(first_camera + 6 * *c, 3 * v) = block.transpose();
    }
  }
  for (const CameraSums::Pair& pair : energy.camera_sums().pairs) {
    const int at[2] = {first_camera + 6 * pair.first, first_camera + 6 * pair.second};
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        joint.block<6, 6>(at[i], at[j]) += pair.curvature.block<6, 6>(6 * i, 6 * j);
      }
    }
  }
  return joint;
}

// Vertices, then cameras, moved by `x` in the unknowns of JointCurvature().
void Move(const Eigen::VectorXd& x, std::vector<Eigen::Vector3d>* vertices,
          std::vector<CameraPose>* poses) {
  for (size_t v = 0; v < vertices->size(); ++v) (*vertices)[v] += x.segment<3>(3 * v);
  for (size_t i = 0; i < poses->size(); ++i) {
    Eigen::Matrix<double, 6, 1> step = x.segment<6>(3 * vertices->size() + 6 * i);
    step.head<3>() /= 2;
    const CameraPose from = (*poses)[i];
    ASSERT_TRUE(PoseManifold().Plus(from.data(), step.data(), (*poses)[i].data()));
  }
}

// Rays meet planes, points are projected: W of every pixel of Omega_ij, NaN elsewhere.
std::vector<double> Warped(const RoundContext& context, const PhotometricOptions& options, int i,
                           size_t b, const std::vector<Eigen::Vector3d>& vertices,
                           const std::vector<CameraPose>& poses) {
  const ViewDomain& domain = (*context.domains)[i];
  const int j = domain.seconds[b];
  Camera first = (*context.views)[i].camera;
  Camera second = (*context.views)[j].camera;
  SetPose(poses[i], &first);
  SetPose(poses[j], &second);
  const LevelView& view = (*context.views)[j];
  const SplineImage<double> spline(cv::Mat1f(view.FloatImage() * (1 / UnitsOf(view, options).unit)),
                                   0.0);
  std::vector<double> warped(static_cast<size_t>(domain.width) * domain.height, NAN);
  for (size_t k = 0; k < domain.facet.size(); ++k) {
    const Eigen::Vector3i& face = context.mesh->faces[domain.facet[k]];
    const Eigen::Vector3d normal =
        (vertices[face[1]] - vertices[face[0]]).cross(vertices[face[2]] - vertices[face[0]]);
    for (const ImagePixel pixel : domain.PixelsOf(k)) {
      if (!domain.second_visible.Test(b, pixel.index)) continue;
      const Eigen::Vector3d ray = first.Ray(pixel.x(), pixel.y());
      const double depth = normal.dot(vertices[face[0]] - first.Center()) / normal.dot(ray);
      const Eigen::Vector2d q = second.Project(first.Center() + depth * ray);
      double gx;
      double gy;
      spline.Sample(q.x(), q.y(), &warped[pixel.index], &gx, &gy);
    }
  }
  return warped;
}

// w of every pixel: the sum over the windows that have it as a tap of omega / s_b^2, with omega = 1.
std::vector<double> Weights(const ViewDomain& domain, const std::vector<double>& warped,
                            const PhotometricOptions& options) {
  const int radius = options.window / 2;
  std::vector<double> weights(warped.size(), 0);
  std::vector<size_t> taps;
  for (int y = 0; y < domain.height; ++y) {
    for (int x = 0; x < domain.width; ++x) {
      if (std::isnan(warped[y * domain.width + x])) continue;
      taps.clear();
      for (int v = std::max(0, y - radius); v <= std::min(domain.height - 1, y + radius); ++v) {
        for (int u = std::max(0, x - radius); u <= std::min(domain.width - 1, x + radius); ++u) {
          const size_t tap = static_cast<size_t>(v) * domain.width + u;
          if (!std::isnan(warped[tap])) taps.push_back(tap);
        }
      }
      const auto n = static_cast<double>(taps.size());
      if (n < std::ceil(options.min_valid_share * options.window * options.window)) continue;
      double mean = 0;
      for (const size_t tap : taps) mean += warped[tap] / n;
      double square = n;
      for (const size_t tap : taps) square += (warped[tap] - mean) * (warped[tap] - mean);
      for (const size_t tap : taps) weights[tap] += 1 / square;
    }
  }
  return weights;
}

// Few enough vertices for every column by differences.
struct SmallFixture : Fixture {
  explicit SmallFixture(Motion motion) : Fixture(Options(5, MaskMode::kNone), motion) {
    mesh = TriangleMesh();
    test::AppendGrid(&mesh, 2, 0, 0, 1.3, [](double x, double y) { return 0.2 * x * y; });
    test::AppendGrid(&mesh, 1, 0.1, 0, 0.3, [](double x, double) { return 0.5 + 0.2 * x; });
    context = FreezeRound(views, test::AllPairs(), mesh, motion, 2, &domains);
    energy = term->FreezeRound(context);
    energy->Evaluate(mesh.vertices, poses, true);
  }
};

TEST(CameraCurvature, IsTheWeightedSumOfOuterProductsOfDifferences) {
  const SmallFixture fixture(Motion::kFree);
  const Eigen::MatrixXd joint = JointCurvature(*fixture.energy);
  const long size = joint.rows();
  const double step = 1e-6;
  Eigen::MatrixXd reference = Eigen::MatrixXd::Zero(size, size);
  for (int i = 0; i < 3; ++i) {
    for (size_t b = 0; b < fixture.domains[i].seconds.size(); ++b) {
      const auto warped_at = [&](const Eigen::VectorXd& x) {
        std::vector<Eigen::Vector3d> vertices = fixture.mesh.vertices;
        std::vector<CameraPose> poses = fixture.poses;
        Move(x, &vertices, &poses);
        return Warped(fixture.context, fixture.options, i, b, vertices, poses);
      };
      const std::vector<double> warped = warped_at(Eigen::VectorXd::Zero(size));
      const std::vector<double> weights = Weights(fixture.domains[i], warped, fixture.options);
      Eigen::MatrixXd jacobian(warped.size(), size);
      for (long u = 0; u < size; ++u) {
        const std::vector<double> after = warped_at(step * Eigen::VectorXd::Unit(size, u));
        const std::vector<double> before = warped_at(-step * Eigen::VectorXd::Unit(size, u));
        for (size_t p = 0; p < warped.size(); ++p) {
          jacobian(static_cast<long>(p), u) =
              weights[p] > 0 ? std::sqrt(weights[p]) * (after[p] - before[p]) / (2 * step) : 0;
        }
      }
      reference += jacobian.transpose() * jacobian;
    }
  }
  // Entry by entry, in units of the diagonal. (Some vertices do not move their facets along some coordinate.)
  const Eigen::VectorXd scale = reference.diagonal().cwiseMax(1).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd difference = scale.asDiagonal() * (joint - reference) * scale.asDiagonal();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_GT(joint.topRightCorner(size - 18, 18).norm(), 0.01 * joint.norm());
}

// Columns: three turns of the world, three shifts, its scale.
Eigen::MatrixXd MotionsOfTheWorld(const Fixture& fixture) {
  const auto vertices = static_cast<long>(fixture.mesh.vertices.size());
  const auto cameras = static_cast<long>(fixture.views.size());
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(3 * vertices + 6 * cameras, 7);
  const auto move_point = [&](long row, const Eigen::Vector3d& point) {
    for (int c = 0; c < 3; ++c) {
      motions.block<3, 1>(row, c) = Eigen::Vector3d::Unit(c).cross(point);
      motions(row + c, 3 + c) = 1;
    }
    motions.block<3, 1>(row, 6) = point;
  };
  for (long v = 0; v < vertices; ++v) move_point(3 * v, fixture.mesh.vertices[v]);
  for (long i = 0; i < cameras; ++i) {
    const Camera& camera = fixture.views[i].camera;
    move_point(3 * vertices + 6 * i + 3, camera.Center());
    motions.block<3, 3>(3 * vertices + 6 * i, 0) = -camera.rotation;
  }
  return motions;
}

TEST(CameraCurvature, MotionsOfTheWorldAreItsNullSpace) {
  const SmallFixture fixture(Motion::kFree);
  const Eigen::MatrixXd joint = JointCurvature(*fixture.energy);
  const Eigen::MatrixXd motions = MotionsOfTheWorld(fixture);
  for (int k = 0; k < 7; ++k) {
    const Eigen::VectorXd motion = motions.col(k).normalized();
    EXPECT_LT((joint * motion).norm(), 1e-12 * joint.norm()) << k;
  }
  EXPECT_LT((joint - joint.transpose()).norm(), 1e-14 * joint.norm());
  const Eigen::VectorXd scale = joint.diagonal().cwiseMax(1e-9).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd matrix = scale.asDiagonal() * joint * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> all(matrix);
  EXPECT_GT(all.eigenvalues().minCoeff(), -1e-12);
  // With the surface fixed cameras have no motion that costs nothing.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> cameras(
      Eigen::MatrixXd(matrix.bottomRightCorner<18, 18>()));
  EXPECT_GT(cameras.eigenvalues().minCoeff(), 1e-6);
}

// Along normals the same matrix.
TEST(CameraCurvature, NormalsAreDirectionsOfFreeVertices) {
  const SmallFixture free(Motion::kFree);
  const SmallFixture normal(Motion::kNormal);
  const CameraCoupling& of_free = free.energy->camera_sums().coupling;
  const CameraCoupling& of_normal = normal.energy->camera_sums().coupling;
  ASSERT_EQ(of_free.cameras.index, of_normal.cameras.index);
  for (size_t v = 0; v < free.mesh.vertices.size(); ++v) {
    for (int place = of_free.cameras.start[v]; place < of_free.cameras.start[v + 1]; ++place) {
      const Eigen::MatrixXd block = of_normal.Block(place);
      const Eigen::MatrixXd expected = free.context.normals[v].transpose() * of_free.Block(place);
      EXPECT_LT((block - expected).norm(), 1e-12 * (1 + expected.norm()));
    }
  }
}

TEST(CameraEnergy, DoesNotChangeWithTheWorld) {
  Fixture fixture(Options(5, MaskMode::kPlane));
  const double energy = fixture.energy->Evaluate(fixture.mesh.vertices, fixture.poses, false);
  const double without = fixture.energy->Evaluate(fixture.mesh.vertices, false);
  EXPECT_NEAR(energy, without, 1e-12 * energy);
  const Eigen::Quaterniond turn = Eigen::Quaterniond(0.8, 0.3, -0.4, 0.2).normalized();
  const Eigen::Vector3d shift(3, -5, 2);
  const double scale = 1.7;
  std::vector<Eigen::Vector3d> vertices = fixture.mesh.vertices;
  for (Eigen::Vector3d& vertex : vertices) vertex = scale * (turn * vertex) + shift;
  std::vector<CameraPose> poses = fixture.poses;
  for (CameraPose& pose : poses) {
    Eigen::Map<Eigen::Quaterniond> rotation(pose.rotation);
    Eigen::Map<Eigen::Vector3d> center(pose.center);
    rotation = rotation * turn.conjugate();
    center = scale * (turn * center) + shift;
  }
  EXPECT_NEAR(fixture.energy->Evaluate(vertices, poses, false), energy, 1e-10 * energy);
  // Cameras alone are not the world.
  EXPECT_GT(std::abs(fixture.energy->Evaluate(fixture.mesh.vertices, poses, false) - energy),
            1e-3 * energy);
}

TEST(CameraEnergy, SameBytesForAnyNumberOfThreads) {
  PhotometricOptions options = Options(5, MaskMode::kPlane);
  options.double_precision = false;
  Fixture fixture(options);
  Random random(3);
  Eigen::VectorXd step(18);
  for (double& entry : step) entry = 1e-3 * random.Uniform();
  const std::vector<CameraPose> poses = fixture.Moved(step);
  const ThreadScope one_thread(1);
  const double one = fixture.energy->Evaluate(fixture.mesh.vertices, poses, true);
  const CameraSums sums = fixture.energy->camera_sums();
  for (const int threads : {2, 4}) {
    const ThreadScope scope(threads);
    fixture.energy = fixture.term->FreezeRound(fixture.context);
    EXPECT_EQ(fixture.energy->Evaluate(fixture.mesh.vertices, poses, true), one);
    const CameraSums& again = fixture.energy->camera_sums();
    for (size_t k = 0; k < sums.pairs.size(); ++k) {
      EXPECT_EQ(again.pairs[k].gradient, sums.pairs[k].gradient);
      EXPECT_EQ(again.pairs[k].curvature, sums.pairs[k].curvature);
    }
    const auto blocks = static_cast<int>(sums.coupling.cameras.index.size());
    for (int place = 0; place < blocks; ++place) {
      ASSERT_EQ(again.coupling.Block(place), sums.coupling.Block(place));
    }
  }
  // The energy and what vertices have of it are the same with cameras that do not move.
  const double still = fixture.energy->Evaluate(fixture.mesh.vertices, fixture.poses, true);
  const CornerSumsList corners = fixture.energy->corner_sums();
  EXPECT_NEAR(fixture.energy->Evaluate(fixture.mesh.vertices, true), still, 1e-6 * still);
  for (size_t c = 0; c < corners.size(); ++c) {
    EXPECT_NEAR(fixture.energy->corner_sums()[c].share, corners[c].share,
                1e-4 * (1e-3 + corners[c].share));
  }
}

}  // namespace
}  // namespace burin
