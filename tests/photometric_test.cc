// The photometric energy against central differences and against itself written again without shortcuts.
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <memory>

#include "core/refine/round.h"
#include "core/support/parallel.h"
#include "costs/grey_units.h"
#include "costs/patch_system.h"
#include "costs/photometric_energy.h"
#include "costs/spline_image.h"
#include "costs/step_band.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

using test::Random;

struct Fixture {
  explicit Fixture(Motion motion, double reliability = 0, bool double_precision = true,
                   const MaskOptions& mask = MaskOptions()) {
    options.double_precision = double_precision;
    options.reliability = reliability;
    options.mask = mask;
    options.min_valid_share = 0.4;
    options.window = 7;
    mesh = test::OccluderMesh();
    views = test::RandomViews(96, 80);
    context = FreezeRound(views, test::AllPairs(), mesh, motion, 2, &domains);
    term = std::make_unique<PhotometricEnergy>(options);
    term->BeginLevel(views);
    energy = term->FreezeRound(context);
  }
  // Gradient of E with respect to all vertex coordinates.
  std::vector<Eigen::Vector3d> Gradient() {
    energy->Evaluate(mesh.vertices, true);
    std::vector<Eigen::Vector3d> g(mesh.vertices.size(), Eigen::Vector3d::Zero());
    for (size_t f = 0; f < mesh.faces.size(); ++f) {
      for (int c = 0; c < 3; ++c) {
        const CornerSums sums = energy->corner_sums()[3 * f + c];
        for (int k = 0; k < 3; ++k) {
          g[mesh.faces[f][k]] += sums.slope[k] * energy->facet_normals()[f];
        }
      }
    }
    return g;
  }
  double CentralDifference(const std::vector<Eigen::Vector3d>& direction, double step) {
    std::vector<Eigen::Vector3d> moved = mesh.vertices;
    double values[2];
    for (int side = 0; side < 2; ++side) {
      for (size_t v = 0; v < moved.size(); ++v) {
        moved[v] = mesh.vertices[v] + (side == 0 ? step : -step) * direction[v];
      }
      values[side] = energy->Evaluate(moved, false);
    }
    return (values[0] - values[1]) / (2 * step);
  }
  PhotometricOptions options;
  TriangleMesh mesh;
  std::vector<LevelView> views;
  std::vector<ViewDomain> domains;
  RoundContext context;
  std::unique_ptr<PhotometricEnergy> term;
  std::unique_ptr<PhotometricRound> energy;
};

double Dot(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b) {
  double sum = 0;
  for (size_t v = 0; v < a.size(); ++v) sum += a[v].dot(b[v]);
  return sum;
}

TEST(Photometric, SceneHasOcclusions) {
  Fixture fixture(Motion::kNormal);
  for (const ViewDomain& domain : fixture.domains) {
    for (int64_t pixels : domain.pair_pixels) {
      EXPECT_GT(pixels, 1000);
      EXPECT_LT(pixels, 0.97 * static_cast<double>(domain.PixelCount()));
    }
  }
}

// Derivatives hold for every way of masking windows.
MaskOptions Mask(MaskMode mode, PoorWindow below = PoorWindow::kDrop, double band_px = 0) {
  MaskOptions mask;
  mask.mode = mode;
  mask.below = below;
  mask.plane_px = 2;
  mask.band_px = band_px;
  mask.evidence = 3;
  return mask;
}

class PhotometricMasks : public testing::TestWithParam<MaskOptions> {};
INSTANTIATE_TEST_SUITE_P(
    All, PhotometricMasks,
    testing::Values(Mask(MaskMode::kNone), Mask(MaskMode::kPaperStrict), Mask(MaskMode::kPaper),
                    Mask(MaskMode::kPlane), Mask(MaskMode::kPlane, PoorWindow::kFull),
                    Mask(MaskMode::kPlane, PoorWindow::kFullThin),
                    Mask(MaskMode::kPlane, PoorWindow::kFullThin, 1)),
    [](const auto& test) {
      return NameOf(test.param.mode) +
             (test.param.below == PoorWindow::kDrop ? "" : "_" + NameOf(test.param.below)) +
             (test.param.band_px > 0 ? "_band" : "");
    });

// Of the windows that count, a tenth and more have lost taps to their mask.
TEST_P(PhotometricMasks, MaskManyWindows) {
  const Fixture fixture(Motion::kNormal, 0, true, GetParam());
  int64_t windows = 0;
  int64_t partly = 0;
  for (size_t i = 0; i < fixture.domains.size(); ++i) {
    windows += static_cast<int64_t>(fixture.domains[i].PixelCount());
    const WindowMasks& masks = fixture.energy->masks(static_cast<int>(i));
    for (size_t entry = 0; entry < masks.size(); ++entry) {
      const int kept = __builtin_popcountll(masks.bits[entry]);
      partly += kept >= 5 ? 1 : 0;
    }
  }
  if (GetParam().mode == MaskMode::kNone) {
    EXPECT_EQ(partly, 0);
  } else {
    EXPECT_GT(static_cast<double>(partly), 0.1 * static_cast<double>(windows));
  }
}

TEST_P(PhotometricMasks, GradientMatchesCentralDifferencesInRandomDirections) {
  for (const double reliability : {0.0, 20.0}) {
    Fixture fixture(Motion::kFree, reliability, true, GetParam());
    const auto gradient = fixture.Gradient();
    Random random(1);
    for (int trial = 0; trial < 10; ++trial) {
      std::vector<Eigen::Vector3d> direction(fixture.mesh.vertices.size());
      for (auto& d : direction) d = random.Vector();
      if (trial % 2 == 1) {  // the normal motion's directions
        for (size_t v = 0; v < direction.size(); ++v) {
          direction[v] = direction[v].x() * fixture.context.normals[v];
        }
      }
      const double analytic = Dot(gradient, direction);
      const double numeric = fixture.CentralDifference(direction, 1e-6);
      EXPECT_NEAR(analytic, numeric, 1e-4 * std::abs(numeric)) << "trial " << trial;
    }
  }
}

TEST_P(PhotometricMasks, GradientMatchesCentralDifferencesOfSingleVertices) {
  Fixture fixture(Motion::kFree, 0, true, GetParam());
  const auto gradient = fixture.Gradient();
  double largest = 0;
  for (const auto& g : gradient) largest = std::max(largest, g.norm());
  int checked = 0;
  for (size_t v = 0; v < gradient.size(); v += 7) {
    for (int c = 0; c < 4; ++c) {
      std::vector<Eigen::Vector3d> direction(gradient.size(), Eigen::Vector3d::Zero());
      direction[v] = c < 3 ? Eigen::Vector3d::Unit(c).eval() : fixture.context.normals[v];
      const double analytic = Dot(gradient, direction);
      const double numeric = fixture.CentralDifference(direction, 1e-6);
      EXPECT_NEAR(analytic, numeric, 1e-4 * std::abs(numeric) + 1e-7 * largest) << v << " " << c;
      checked += gradient[v].norm() > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(checked, GetParam().mode == MaskMode::kPaperStrict ? 10 : 40);
}

// The energy written again without any of the kernel's shortcuts, with derivatives by ceres::Jet:
// rays meet planes, points are projected, windows are looped over. Its residuals are
//   e_p = sqrt(omega_p) [a/s_a - b/s_b ; floor terms],   1/2 |e_p|^2 = omega_p (1 - z_p).
constexpr int kUnknowns = 13;
using Jet = ceres::Jet<double, kUnknowns>;
using JetVector = Eigen::Matrix<Jet, 3, 1>;

struct Reference {
  double energy = 0;
  Eigen::Matrix<double, kUnknowns, 1> gradient = Eigen::Matrix<double, kUnknowns, 1>::Zero();
  Eigen::Matrix<double, kUnknowns, kUnknowns> gauss_newton =
      Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
};

// A view's grey levels in units of its floor, in single precision as the energy has them.
cv::Mat1f InUnits(const LevelView& view, const PhotometricOptions& options) {
  return cv::Mat1f(view.FloatImage() * (1 / UnitsOf(view, options).unit));
}

Reference EvaluateByAutodiff(const RoundContext& context, const PhotometricOptions& options) {
  const TriangleMesh& mesh = *context.mesh;
  std::vector<JetVector> vertices(mesh.vertices.size());
  for (size_t v = 0; v < vertices.size(); ++v) {
    for (int c = 0; c < 3; ++c) {
      vertices[v][c] = Jet(mesh.vertices[v][c]);
      vertices[v][c].v[static_cast<int>(v)] = context.normals[v][c];
    }
  }
  Reference result;
  const int radius = options.window / 2;
  for (size_t i = 0; i < context.domains->size(); ++i) {
    const ViewDomain& domain = (*context.domains)[i];
    const LevelView& view = (*context.views)[i];
    const cv::Mat1f image = InUnits(view, options);
    std::vector<int> facet_of(static_cast<size_t>(domain.width) * domain.height, -1);
    for (size_t k = 0; k < domain.facet.size(); ++k) {
      for (const ImagePixel pixel : domain.PixelsOf(k)) facet_of[pixel.index] = domain.facet[k];
    }
    const DepthPlanes planes = MakeDepthPlanes(domain, mesh, view.camera);
    const MaskMode mode = options.mask.mode;
    const double min_taps = std::ceil(options.min_valid_share * options.window * options.window);
    const WindowMasks masks =
        MakeWindowMasks(planes, radius, mode, options.mask.plane_px, static_cast<int>(min_taps));
    std::vector<char> thin(facet_of.size(), 0);
    for (int row = 0; row < domain.height; ++row) {
      for (size_t entry = masks.row_start[row]; entry < masks.row_start[row + 1]; ++entry) {
        thin[row * domain.width + masks.column[entry]] = masks.thin[entry];
      }
    }
    for (size_t b = 0; b < domain.seconds.size(); ++b) {
      const LevelView& second = (*context.views)[domain.seconds[b]];
      const SplineImage<double> spline(InUnits(second, options), 0.0);
      std::vector<Jet> warped(facet_of.size());
      std::vector<char> valid(facet_of.size(), 0);
      for (size_t p = 0; p < facet_of.size(); ++p) {
        if (facet_of[p] < 0 || !domain.second_visible.Test(b, p)) continue;
        valid[p] = 1;
        const Eigen::Vector3i& face = mesh.faces[facet_of[p]];
        const JetVector edge1 = vertices[face[1]] - vertices[face[0]];
        const JetVector edge2 = vertices[face[2]] - vertices[face[0]];
        const JetVector normal = edge1.cross(edge2);
        const JetVector center = view.camera.Center().cast<Jet>();
        const JetVector ray =
            view.camera.Ray(p % domain.width + 0.5, p / domain.width + 0.5).cast<Jet>();
        const JetVector to_plane = vertices[face[0]] - center;
        const JetVector point = center + ray * (normal.dot(to_plane) / normal.dot(ray));
        const JetVector in_second =
            second.camera.rotation.cast<Jet>() * point + second.camera.translation.cast<Jet>();
        const Jet x = in_second[0] / in_second[2] * second.camera.fx + second.camera.cx;
        const Jet y = in_second[1] / in_second[2] * second.camera.fy + second.camera.cy;
        double value;
        double gx;
        double gy;
        spline.Sample(x.a, y.a, &value, &gx, &gy);
        warped[p] = Jet(value, gx * x.v + gy * y.v);
      }
      for (int y = 0; y < domain.height; ++y) {
        for (int x = 0; x < domain.width; ++x) {
          if (valid[y * domain.width + x] == 0) continue;
          const std::vector<char> kept =
              WindowMask(planes, x, y, radius, mode, options.mask.plane_px);
          std::vector<size_t> taps;
          std::vector<size_t> all_taps;
          for (int v = std::max(0, y - radius); v <= std::min(domain.height - 1, y + radius); ++v) {
            for (int u = std::max(0, x - radius); u <= std::min(domain.width - 1, x + radius);
                 ++u) {
              const size_t tap = static_cast<size_t>(v) * domain.width + u;
              if (valid[tap] == 0) continue;
              all_taps.push_back(tap);
              if (kept[(v - y + radius) * options.window + u - x + radius] != 0) {
                taps.push_back(tap);
              }
            }
          }
          const PoorWindow below = options.mask.below;
          const bool is_thin = thin[y * domain.width + x] != 0;
          if (static_cast<double>(taps.size()) < min_taps &&
              (below == PoorWindow::kFull || (is_thin && below == PoorWindow::kFullThin))) {
            taps = all_taps;
          }
          const auto n = static_cast<double>(taps.size());
          if (n < min_taps) continue;
          double mean_i = 0;
          Jet mean_w(0.0);
          for (size_t t : taps) {
            mean_i += image(static_cast<int>(t) / domain.width, t % domain.width) / n;
            mean_w += warped[t] / n;
          }
          double square_a = n;
          Jet square_b(n);
          for (size_t t : taps) {
            const double a = image(static_cast<int>(t) / domain.width, t % domain.width) - mean_i;
            square_a += a * a;
            square_b += (warped[t] - mean_w) * (warped[t] - mean_w);
          }
          const double root_floor = std::sqrt(n);
          std::vector<Jet> residuals;
          for (size_t t : taps) {
            const double a = image(static_cast<int>(t) / domain.width, t % domain.width) - mean_i;
            residuals.push_back(a / std::sqrt(square_a) - (warped[t] - mean_w) / sqrt(square_b));
          }
          residuals.emplace_back(root_floor / std::sqrt(square_a));
          residuals.push_back(-root_floor / sqrt(square_b));
          for (const Jet& r : residuals) {
            result.energy += 0.5 * r.a * r.a;
            result.gradient += r.a * r.v;
            result.gauss_newton += r.v * r.v.transpose();
          }
        }
      }
    }
  }
  return result;
}

// The context's domains as mask.band_px leaves them.
std::vector<ViewDomain> ClearOfSteps(const RoundContext& context, const MaskOptions& mask) {
  std::vector<ViewDomain> domains = *context.domains;
  if (mask.mode != MaskMode::kPlane || mask.band_px == 0) return domains;
  std::vector<Camera> cameras;
  std::vector<std::vector<uint8_t>> near_steps;
  for (size_t i = 0; i < domains.size(); ++i) {
    cameras.push_back((*context.views)[i].camera);
    near_steps.push_back(NearSteps(MakeDepthPlanes(domains[i], *context.mesh, cameras[i]),
                                   OpenBorderPixels(domains[i], *context.mesh, context.boundary),
                                   mask.plane_px, mask.band_px));
  }
  const std::vector<PartnerBits> bits =
      WithoutSteps(domains, PartnersOf(domains), cameras, *context.mesh, near_steps, mask.evidence);
  for (size_t i = 0; i < domains.size(); ++i) domains[i].second_visible = bits[i];
  return domains;
}

TEST_P(PhotometricMasks, CurvatureMajorisesTheGaussNewtonMatrixOfAutodiff) {
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 2, 0, 0, 1.3, [](double x, double y) { return 0.2 * x * y; });
  test::AppendGrid(&mesh, 1, 0.1, 0, 0.3, [](double x, double) { return 0.5 + 0.2 * x; });
  ASSERT_EQ(mesh.vertices.size(), static_cast<size_t>(kUnknowns));
  const auto views = test::RandomViews(64, 56);
  std::vector<ViewDomain> domains;
  const RoundContext context =
      FreezeRound(views, test::AllPairs(), mesh, Motion::kNormal, 2, &domains);
  PhotometricOptions options;
  options.double_precision = true;
  options.mask = GetParam();
  PhotometricEnergy term(options);
  term.BeginLevel(views);
  const std::unique_ptr<PhotometricRound> energy = term.FreezeRound(context);
  const double value = energy->Evaluate(mesh.vertices, true);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(kUnknowns);
  Eigen::MatrixXd curvature = Eigen::MatrixXd::Zero(kUnknowns, kUnknowns);
  PatchSystem system;
  for (int v = 0; v < kUnknowns; ++v) {
    system.Make(*energy, v);
    const std::vector<int>& blocks = system.vertices;
    for (size_t k = 0; k < blocks.size(); ++k) {
      gradient[blocks[k]] += system.gradient[k];
      for (size_t l = 0; l < blocks.size(); ++l) {
        curvature(blocks[k], blocks[l]) += system.curvature[k * blocks.size() + l];
      }
    }
  }
  RoundContext clear = context;  // of steps: the reference knows no band
  const std::vector<ViewDomain> clear_domains = ClearOfSteps(context, options.mask);
  clear.domains = &clear_domains;
  const Reference reference = EvaluateByAutodiff(clear, options);
  EXPECT_GT(value, GetParam().mode == MaskMode::kPaperStrict ? 1 : 100);
  EXPECT_NEAR(value, reference.energy, 1e-9 * value);
  EXPECT_LT((gradient - reference.gradient).norm(), 1e-9 * gradient.norm());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> difference(curvature -
                                                                  reference.gauss_newton);
  const double scale = curvature.diagonal().maxCoeff();
  EXPECT_GT(difference.eigenvalues().minCoeff(), -1e-12 * scale);
  EXPECT_GT(reference.gauss_newton.diagonal().minCoeff(), 0.05 * scale * 1e-3);
}

TEST(Photometric, SinglePrecisionAgreesWithDouble) {
  Fixture exact(Motion::kNormal);
  Fixture fast(Motion::kNormal, 0, false);
  const auto g = exact.Gradient();
  const auto h = fast.Gradient();
  const double energy = exact.energy->Evaluate(exact.mesh.vertices, true);
  EXPECT_NEAR(fast.energy->Evaluate(fast.mesh.vertices, true), energy, 1e-6 * energy);
  double error = 0;
  double norm = 0;
  for (size_t v = 0; v < g.size(); ++v) {
    error += (g[v] - h[v]).squaredNorm();
    norm += g[v].squaredNorm();
  }
  EXPECT_LT(std::sqrt(error / norm), 1e-4);
}

TEST(Photometric, SameBytesForAnyNumberOfThreads) {
  Fixture fixture(Motion::kNormal, 0, false);
  const ThreadScope one_thread(1);
  const double one = fixture.energy->Evaluate(fixture.mesh.vertices, true);
  const auto sums = fixture.energy->corner_sums();
  for (int threads : {2, 4}) {
    const ThreadScope scope(threads);
    fixture.energy = fixture.term->FreezeRound(fixture.context);
    EXPECT_EQ(fixture.energy->Evaluate(fixture.mesh.vertices, true), one);
    for (size_t c = 0; c < sums.size(); ++c) {
      ASSERT_EQ(fixture.energy->corner_sums()[c].slope[0], sums[c].slope[0]);
      ASSERT_EQ(fixture.energy->corner_sums()[c].curvature[4], sums[c].curvature[4]);
    }
  }
}

}  // namespace
}  // namespace burin
