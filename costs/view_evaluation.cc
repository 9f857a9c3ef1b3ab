#include "costs/view_evaluation.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <opencv2/core.hpp>

#include "core/support/parallel.h"
#include "core/visibility/facet_pencil.h"
#include "costs/grey_units.h"
#include "costs/pair_kernel.h"
#include "costs/spline_image.h"

namespace burin {
namespace {

constexpr int kRowGrain = 32;
constexpr int kFacetGrain = 512;

// Maps a pixel (x, y, 1) of the reference and its inverse depth s to the second image:
// q ~ warp * (x, y, 1) + epipole * s.
void FillWarp(const Camera& reference, const Camera& second, double warp[9], double epipole[3]) {
  Eigen::Matrix3d reference_inverse;
  reference_inverse << 1 / reference.fx, 0, -reference.cx / reference.fx,  //
      0, 1 / reference.fy, -reference.cy / reference.fy,                   //
      0, 0, 1;
  Eigen::Matrix3d intrinsics;
  intrinsics << second.fx, 0, second.cx, 0, second.fy, second.cy, 0, 0, 1;
  const Eigen::Matrix3d a =
      intrinsics * second.rotation * reference.rotation.transpose() * reference_inverse;
  const Eigen::Vector3d e =
      intrinsics * (second.rotation * reference.Center() + second.translation);
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(warp, 3, 3) = a;
  Eigen::Map<Eigen::Vector3d>(epipole, 3) = e;
}

float ScaledOffset(const GreyUnits& units) { return static_cast<float>(units.offset / units.unit); }

template <typename T>
class ViewEvaluationIn : public ViewEvaluation {
 public:
  explicit ViewEvaluationIn(const PhotometricOptions& options) : options_(options) {}

  void BeginLevel(const std::vector<LevelView>& level_views) override {
    views_ = &level_views;
    splines_.clear();
    splines_.resize(views_->size());
    units_.resize(views_->size());
    ParallelFor(static_cast<int>(views_->size()), 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        units_[i] = UnitsOf((*views_)[i], options_);
        cv::Mat1f image;
        (*views_)[i].image.convertTo(image, CV_32F, 1 / units_[i].unit);
        splines_[i] = SplineImage<T>(image, static_cast<T>(ScaledOffset(units_[i])));
      }
    });
  }

  void Add(const Input& frozen, int view, const std::vector<Eigen::Vector3d>& positions,
           bool derivatives, Output* output) override {
    const ViewDomain& domain = (*frozen.context->domains)[view];
    const std::vector<Eigen::Vector3i>& faces = frozen.context->mesh->faces;
    const std::vector<ViewTile>& tiles = frozen.sample->tiles[view];
    if (tiles.empty()) return;
    const int facets = static_cast<int>(domain.facet.size());
    const size_t pixels = static_cast<size_t>(domain.width) * domain.height;

    image_.create(domain.height, domain.width);
    fields_.Resize(pixels, derivatives, output->scores != nullptr);
    ParallelFor(domain.height, kRowGrain, [&](int begin, int end) {
      cv::Mat rows = image_.rowRange(begin, end);
      (*views_)[view].image.rowRange(begin, end).convertTo(rows, CV_32F, 1 / units_[view].unit);
      fields_.Clear(static_cast<size_t>(begin) * domain.width,
                    static_cast<size_t>(end) * domain.width);
    });
    pencils_.resize(facets);
    inverse_depth_.resize(pixels);  // outside the facets' pixels anything
    const ViewRays rays((*views_)[view].camera);
    ParallelFor(facets, kFacetGrain, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        pencils_[k] = MakeFacetPencil(positions, faces[domain.facet[k]], rays);
        const InverseDepthPlane plane = pencils_[k].InverseDepth();
        for (const ImagePixel pixel : domain.PixelsOf(k)) {
          inverse_depth_[pixel.index] = static_cast<T>(plane.At(pixel.x(), pixel.y()));
        }
      }
    });

    const std::vector<PairInput<T>> inputs = PairInputs(frozen, view);
    std::atomic<int64_t> counted{0};
    ParallelFor(static_cast<int>(tiles.size()), 1, [&](int begin, int end) {
      static thread_local PairKernel<T> kernel;
      for (int t = begin; t < end; ++t) {
        for (int b : tiles[t].partners) {
          counted += kernel.AddTile(inputs[b], tiles[t].tile, derivatives, &fields_);
        }
      }
    });
    output->windows += counted;

    ParallelFor(facets, kFacetGrain, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        if (output->scores != nullptr) {
          ScoreFacet(domain, k, frozen.squares_only, &(*output->scores)[domain.facet[k]]);
        }
        GatherFacet(domain, k, derivatives,
                    &output->sums[3 * static_cast<size_t>(domain.facet[k])]);
      }
    });
  }

 private:
  std::vector<PairInput<T>> PairInputs(const Input& frozen, int view) const {
    const ViewPartners& partners = *frozen.sample->partners[view];
    const PartnerBits& used = frozen.sample->Pixels(view);
    const WindowMasks& masks = frozen.windows->masks[view];
    std::vector<PairInput<T>> inputs(partners.seconds.size());
    for (size_t b = 0; b < inputs.size(); ++b) {
      const int second = partners.seconds[b];
      PairInput<T>& input = inputs[b];
      input.width = image_.cols;
      input.height = image_.rows;
      input.image = image_[0];
      input.grey_offset = ScaledOffset(units_[view]);
      input.inverse_depth = inverse_depth_.data();
      input.domain = used.Of(b);
      input.second = &splines_[second];
      FillWarp((*views_)[view].camera, (*views_)[second].camera, input.warp, input.epipole);
      input.radius = options_.window / 2;
      input.variance_floor = 1;
      const double noise_i = (*views_)[view].noise_sigma / units_[view].unit;
      const double noise_j = (*views_)[second].noise_sigma / units_[second].unit;
      input.reliability_noise = options_.reliability * (noise_i * noise_i + noise_j * noise_j);
      const double taps = options_.window * options_.window;
      if (masks.size() > 0) input.masks = &masks;
      input.full_below = options_.mask.below == PoorWindow::kFull;
      input.full_thin = options_.mask.below == PoorWindow::kFullThin;
      input.min_taps = std::max(2, static_cast<int>(std::ceil(options_.min_valid_share * taps)));
    }
    return inputs;
  }

  void ScoreFacet(const ViewDomain& domain, int k, bool squares_only, FacetScore* score) const {
    const HeldBackSquares squares(options_.window);
    for (const ImagePixel pixel : domain.PixelsOf(k)) {
      if (squares_only && !squares.Judge(pixel.column, pixel.row)) continue;
      score->cost += fields_.cost[pixel.index];
      score->weight += fields_.weight[pixel.index];
    }
  }

  // Adds the pixels of a facet to the sums of its three corners.
  void GatherFacet(const ViewDomain& domain, int k, bool derivatives, CornerSums* totals) const {
    const FacetPencil& pencil = pencils_[k];
    const Eigen::Matrix3d& u = pencil.coefficients;
    const double scale = -1 / pencil.offset;
    for (int corner = 0; corner < 3; ++corner) {
      CornerSums local;
      for (const ImagePixel pixel : domain.PixelsOf(k, corner)) {
        local.cost += fields_.cost[pixel.index];
        if (!derivatives) continue;
        const double x = pixel.x();
        const double y = pixel.y();
        const double u0 = scale * (u(0, 0) * x + u(0, 1) * y + u(0, 2));
        const double u1 = scale * (u(1, 0) * x + u(1, 1) * y + u(1, 2));
        const double u2 = scale * (u(2, 0) * x + u(2, 1) * y + u(2, 2));
        const double slope = fields_.slope[pixel.index];
        const double curvature = fields_.curvature[pixel.index];
        local.share += fields_.share[pixel.index];
        local.slope[0] += slope * u0;
        local.slope[1] += slope * u1;
        local.slope[2] += slope * u2;
        local.curvature[0] += curvature * u0 * u0;
        local.curvature[1] += curvature * u0 * u1;
        local.curvature[2] += curvature * u0 * u2;
        local.curvature[3] += curvature * u1 * u1;
        local.curvature[4] += curvature * u1 * u2;
        local.curvature[5] += curvature * u2 * u2;
      }
      CornerSums& total = totals[corner];
      total.cost += local.cost;
      total.share += local.share;
      for (int c = 0; c < 3; ++c) total.slope[c] += local.slope[c];
      for (int c = 0; c < 6; ++c) total.curvature[c] += local.curvature[c];
    }
  }

  const PhotometricOptions options_;
  const std::vector<LevelView>* views_ = nullptr;
  std::vector<GreyUnits> units_;
  std::vector<SplineImage<T>> splines_;
  // Of the view in work.
  cv::Mat1f image_;
  std::vector<FacetPencil> pencils_;
  std::vector<T> inverse_depth_;
  PixelFields<T> fields_;
};

}  // namespace

std::unique_ptr<ViewEvaluation> ViewEvaluation::Make(const PhotometricOptions& options) {
  if (options.double_precision) return std::make_unique<ViewEvaluationIn<double>>(options);
  return std::make_unique<ViewEvaluationIn<float>>(options);
}

}  // namespace burin
