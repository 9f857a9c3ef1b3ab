#include "costs/warp_picture.h"

#include <algorithm>
#include <cmath>

#include "core/visibility/facet_pencil.h"
#include "costs/grey_units.h"
#include "costs/spline_image.h"

namespace burin {

WarpPicture MakeWarpPicture(const std::vector<LevelView>& views, int reference,
                            const ViewDomain& domain, int partner, const TriangleMesh& mesh) {
  const LevelView& view = views[reference];
  const LevelView& second = views[domain.seconds[partner]];
  const SplineImage<double> spline(second.FloatImage(), 0.0);
  const cv::Mat1f image = view.FloatImage();
  const ViewRays rays(view.camera);
  WarpPicture picture;
  picture.warped = cv::Mat1f(domain.height, domain.width, 0.0F);
  picture.valid = cv::Mat1b(domain.height, domain.width, static_cast<uchar>(0));
  picture.residual = cv::Mat1f(domain.height, domain.width, 0.0F);
  double n = 0;
  double sum_i = 0;
  double sum_w = 0;
  double sum_ww = 0;
  double sum_iw = 0;
  for (size_t k = 0; k < domain.facet.size(); ++k) {
    const InverseDepthPlane plane =
        MakeFacetPencil(mesh.vertices, mesh.faces[domain.facet[k]], rays).InverseDepth();
    for (const ImagePixel pixel : domain.PixelsOf(k)) {
      if (!domain.second_visible.Test(partner, pixel.index)) continue;
      const Eigen::Vector2d q =
          second.camera.Project(rays.SurfacePoint(pixel.x(), pixel.y(), plane));
      double value = 0;
      spline.Sample(q.x(), q.y(), &value);
      picture.warped(pixel.row, pixel.column) = static_cast<float>(value);
      picture.valid(pixel.row, pixel.column) = 255;
      const double intensity = image(pixel.row, pixel.column);
      n += 1;
      sum_i += intensity;
      sum_w += value;
      sum_ww += value * value;
      sum_iw += intensity * value;
    }
  }
  if (n == 0) return picture;
  const double variance = sum_ww - sum_w * sum_w / n;
  const double gain = variance > 0 ? (sum_iw - sum_i * sum_w / n) / variance : 1;
  const double offset = (sum_i - gain * sum_w) / n;
  double total = 0;
  for (int y = 0; y < domain.height; ++y) {
    for (int x = 0; x < domain.width; ++x) {
      if (picture.valid(y, x) == 0) continue;
      const double residual = std::abs(image(y, x) - (gain * picture.warped(y, x) + offset));
      picture.residual(y, x) = static_cast<float>(residual);
      total += residual;
    }
  }
  picture.mean_residual = total / n;
  return picture;
}

cv::Mat1f WindowErrors(const LevelView& view, const LevelView& second, const WarpPicture& pair,
                       const PhotometricOptions& options, const WindowMasks* masks) {
  const cv::Mat1f image = view.FloatImage();
  const double floor_i = std::pow(UnitsOf(view, options).unit, 2);
  const double floor_w = std::pow(UnitsOf(second, options).unit, 2);
  const int radius = options.window / 2;
  const double min_taps =
      std::max(2.0, std::ceil(options.min_valid_share * options.window * options.window));
  cv::Mat1f errors(image.size(), 0.0F);
  for (int y = 0; y < image.rows; ++y) {
    size_t entry = masks != nullptr ? masks->row_start[y] : 0;
    for (int x = 0; x < image.cols; ++x) {
      bool masked = false;
      if (masks != nullptr) {
        while (entry < masks->row_start[y + 1] && masks->column[entry] < x) ++entry;
        masked = entry < masks->row_start[y + 1] && masks->column[entry] == x;
      }
      if (pair.valid(y, x) == 0) continue;
      double n = 0;
      double sum[5] = {0, 0, 0, 0, 0};
      const auto add_taps = [&](bool all) {
        n = 0;
        std::fill(sum, sum + 5, 0.0);
        for (int v = std::max(0, y - radius); v <= std::min(image.rows - 1, y + radius); ++v) {
          for (int u = std::max(0, x - radius); u <= std::min(image.cols - 1, x + radius); ++u) {
            if (pair.valid(v, u) == 0 || !(all || masks->Has(entry, u - x, v - y))) continue;
            const double i = image(v, u);
            const double w = pair.warped(v, u);
            n += 1;
            sum[0] += i;
            sum[1] += w;
            sum[2] += i * i;
            sum[3] += w * w;
            sum[4] += i * w;
          }
        }
      };
      add_taps(!masked);
      const bool in_full =
          masked && (options.mask.below == PoorWindow::kFull ||
                     (options.mask.below == PoorWindow::kFullThin && masks->thin[entry]));
      if (n < min_taps && in_full) add_taps(true);
      if (n < min_taps) continue;
      const double square_i = sum[2] - sum[0] * sum[0] / n + n * floor_i;
      const double square_w = sum[3] - sum[1] * sum[1] / n + n * floor_w;
      const double z = (sum[4] - sum[0] * sum[1] / n) / std::sqrt(square_i * square_w);
      errors(y, x) = static_cast<float>(1 - z);
    }
  }
  return errors;
}

cv::Mat3b KeptTapsPicture(const cv::Mat1f& image, const ViewDomain& domain,
                          const WindowMasks& masks) {
  const int side = 2 * masks.radius + 1;
  cv::Mat1f kept(image.size(), 0.0F);
  for (size_t k = 0; k < domain.facet.size(); ++k) {
    for (const ImagePixel pixel : domain.PixelsOf(k)) kept(pixel.row, pixel.column) = 1;
  }
  for (int y = 0; y < image.rows && masks.size() > 0; ++y) {
    for (size_t entry = masks.row_start[y]; entry < masks.row_start[y + 1]; ++entry) {
      int taps = 0;
      for (int word = 0; word < masks.words; ++word) {
        taps += __builtin_popcountll(masks.bits[entry * masks.words + word]);
      }
      kept(y, masks.column[entry]) = static_cast<float>(taps) / static_cast<float>(side * side);
    }
  }
  cv::Mat3b picture(image.size());
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const float grey = image(y, x);
      const auto other = cv::saturate_cast<uchar>(grey * (1 - 0.8F * kept(y, x)));
      picture(y, x) = {other, other, cv::saturate_cast<uchar>(grey + (255 - grey) * kept(y, x))};
    }
  }
  return picture;
}

}  // namespace burin
