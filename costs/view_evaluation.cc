#include "costs/view_evaluation.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
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
constexpr int kFacetsAhead = 4;  // fetched while a facet is summed: they come from all over memory

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

  void Add(const Input& frozen, int view, const Point& point, bool derivatives,
           Output* output) override {
    const ViewDomain& domain = (*frozen.context->domains)[view];
    const std::vector<Eigen::Vector3i>& faces = frozen.context->mesh->faces;
    const std::vector<ViewTile>& tiles = frozen.sample->tiles[view];
    if (tiles.empty()) return;
    const int facets = static_cast<int>(domain.facet.size());
    const size_t pixels = static_cast<size_t>(domain.width) * domain.height;

    image_.create(domain.height, domain.width);
    fields_.Resize(pixels, derivatives,
                   output->scores != nullptr || output->cell_scores != nullptr);
    ParallelFor(domain.height, kRowGrain, [&](int begin, int end) {
      cv::Mat rows = image_.rowRange(begin, end);
      (*views_)[view].image.rowRange(begin, end).convertTo(rows, CV_32F, 1 / units_[view].unit);
      fields_.Clear(static_cast<size_t>(begin) * domain.width,
                    static_cast<size_t>(end) * domain.width);
    });
    pencils_.resize(facets);
    inverse_depth_.resize(pixels);  // outside the facets' pixels anything
    const ViewRays rays((*point.cameras)[view]);
    ParallelFor(facets, kFacetGrain, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        pencils_[k] = MakeFacetPencil(*point.positions, faces[domain.facet[k]], rays);
        const InverseDepthPlane plane = pencils_[k].InverseDepth();
        for (const ImagePixel pixel : domain.PixelsOf(k)) {
          inverse_depth_[pixel.index] = static_cast<T>(plane.At(pixel.x(), pixel.y()));
        }
      }
    });

    const std::vector<PairInput<T>> inputs = PairInputs(frozen, view, *point.cameras);
    if (output->cameras != nullptr) {
      AddByPair(frozen, view, point, inputs, output);
    } else {
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
    }

    ParallelFor(facets, kFacetGrain, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        if (k + kFacetsAhead < end) Prefetch(domain, k + kFacetsAhead, output->sums);
        if (output->scores != nullptr) {
          ScoreFacet(domain, k, frozen.squares_only, &(*output->scores)[domain.facet[k]]);
        }
        GatherFacet(domain, k, derivatives, &output->sums);
      }
    });
    if (output->cell_scores != nullptr) {
      ScoreCells(view, frozen.squares_only, output->cell_scores);
    }
  }

 private:
  // The tiles of one partner after the other, each followed by its sums for cameras: their fields are kept
  // of one pair at a time.
  void AddByPair(const Input& frozen, int view, const Point& point,
                 const std::vector<PairInput<T>>& inputs, Output* output) {
    if (gather_ == nullptr) gather_ = std::make_unique<CameraGather<T>>();
    gather_->BeginView({frozen.context, view, point.cameras, &pencils_, inverse_depth_.data()});
    pair_fields_.values.resize(inverse_depth_.size() * PairFields<T>::kCount);
    for (size_t b = 0; b < inputs.size(); ++b) {
      std::vector<Tile> tiles;
      for (const ViewTile& entry : frozen.sample->tiles[view]) {
        const std::vector<int>& partners = entry.partners;
        if (std::binary_search(partners.begin(), partners.end(), static_cast<int>(b))) {
          tiles.push_back(entry.tile);
        }
      }
      if (tiles.empty()) continue;
      std::atomic<int64_t> counted{0};
      ParallelFor(static_cast<int>(tiles.size()), 1, [&](int begin, int end) {
        static thread_local PairKernel<T> kernel;
        for (int t = begin; t < end; ++t) {
          counted +=
              kernel.AddTile(inputs[b], tiles[t], /*derivatives=*/true, &fields_, &pair_fields_);
        }
      });
      output->windows += counted;
      gather_->AddPair(pair_fields_, inputs[b].domain,
                       output->cameras->first_pair[view] + static_cast<int>(b), output->cameras,
                       output->pair_rows);
    }
  }

  std::vector<PairInput<T>> PairInputs(const Input& frozen, int view,
                                       const std::vector<Camera>& cameras) const {
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
      FillWarp(cameras[view], cameras[second], input.warp, input.epipole);
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
      score->cost += fields_.Of(pixel.index)[PixelFields<T>::kCost];
      score->weight += fields_.weight[pixel.index];
    }
  }

  void ScoreCells(int view, bool squares_only, std::vector<CellScore>* scores) const {
    const HeldBackSquares squares(options_.window);
    const int across = (image_.cols + kCellPx - 1) / kCellPx;
    for (int first_row = 0; first_row < image_.rows; first_row += kCellPx) {
      std::vector<CellScore> cells(across, CellScore{view});
      for (int row = first_row; row < std::min(first_row + kCellPx, image_.rows); ++row) {
        for (int column = 0; column < image_.cols; ++column) {
          if (squares_only && !squares.Judge(column, row)) continue;
          const size_t p = static_cast<size_t>(row) * image_.cols + column;
          CellScore& cell = cells[column / kCellPx];
          cell.cost += static_cast<float>(fields_.Of(p)[PixelFields<T>::kCost]);
          cell.weight += static_cast<float>(fields_.weight[p]);
        }
      }
      for (int k = 0; k < across; ++k) {
        if (!(cells[k].weight > 0)) continue;
        cells[k].cell = static_cast<uint32_t>(first_row / kCellPx * across + k);
        scores->push_back(cells[k]);
      }
    }
  }

  void Prefetch(const ViewDomain& domain, int k, const CornerSumsList& sums) const {
    for (const ImagePixel pixel : domain.PixelsOf(k)) __builtin_prefetch(fields_.Of(pixel.index));
    const size_t first = 3 * static_cast<size_t>(domain.facet[k]);
    for (size_t corner = 0; corner < 3; ++corner) sums.Prefetch(first + corner);
  }

  // Adds the pixels of a facet to the sums of its three corners.
  void GatherFacet(const ViewDomain& domain, int k, bool derivatives,
                   CornerSumsList* totals) const {
    const size_t first = 3 * static_cast<size_t>(domain.facet[k]);
    CornerSums of_corner;
    if (!derivatives) {
      for (int corner = 0; corner < 3; ++corner) {
        T cost = 0;  // as below
        for (const ImagePixel pixel : domain.PixelsOf(k, corner)) {
          cost += *fields_.Of(pixel.index);
        }
        of_corner.cost = cost;
        totals->Add(first + corner, of_corner);
      }
      return;
    }
    // -u_k / offset at the facet's first pixel, and by how much they change along x and y.
    using Four = Eigen::Array<T, 4, 1>;
    const FacetPencil& pencil = pencils_[k];
    const ImagePixel origin = *domain.PixelsOf(k).begin();
    const Eigen::Matrix3d u = pencil.coefficients * (-1 / pencil.offset);
    const Eigen::Vector3d u_origin = u * Eigen::Vector3d(origin.x(), origin.y(), 1);
    // Of k = 0, 1, 2, and of 1, 2, 0 for the products.
    const auto lanes = [](const Eigen::Vector3d& v) { return Four(v[0], v[1], v[2], 0); };
    const auto turned = [](const Eigen::Vector3d& v) { return Four(v[1], v[2], v[0], 0); };
    const Four at_origin[2] = {lanes(u_origin), turned(u_origin)};
    const Four along_x[2] = {lanes(u.col(0)), turned(u.col(0))};
    const Four along_y[2] = {lanes(u.col(1)), turned(u.col(1))};
    for (int corner = 0; corner < 3; ++corner) {
      Four sums = Four::Zero();
      Four slope = Four::Zero();
      Four squares = Four::Zero();   // (0,0) (1,1) (2,2)
      Four products = Four::Zero();  // (0,1) (1,2) (2,0)
      for (const ImagePixel pixel : domain.PixelsOf(k, corner)) {
        const Four here = Eigen::Map<const Four>(fields_.Of(pixel.index));
        const auto dx = static_cast<T>(pixel.column - origin.column);
        const auto dy = static_cast<T>(pixel.row - origin.row);
        const Four at = at_origin[0] + along_x[0] * dx + along_y[0] * dy;
        const Four weighted = at * here[PixelFields<T>::kCurvature];
        sums += here;
        slope += at * here[PixelFields<T>::kSlope];
        squares += weighted * at;
        products += weighted * (at_origin[1] + along_x[1] * dx + along_y[1] * dy);
      }
      of_corner.cost = sums[PixelFields<T>::kCost];
      of_corner.share = sums[PixelFields<T>::kShare];
      for (int c = 0; c < 3; ++c) of_corner.slope[c] = slope[c];
      of_corner.curvature[0] = squares[0];
      of_corner.curvature[1] = products[0];
      of_corner.curvature[2] = products[2];
      of_corner.curvature[3] = squares[1];
      of_corner.curvature[4] = products[1];
      of_corner.curvature[5] = squares[2];
      totals->Add(first + corner, of_corner);
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
  PairFields<T> pair_fields_;  // where cameras move
  std::unique_ptr<CameraGather<T>> gather_;
};

}  // namespace

std::unique_ptr<ViewEvaluation> ViewEvaluation::Make(const PhotometricOptions& options) {
  if (options.double_precision) return std::make_unique<ViewEvaluationIn<double>>(options);
  return std::make_unique<ViewEvaluationIn<float>>(options);
}

}  // namespace burin
