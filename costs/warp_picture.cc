#include "costs/warp_picture.h"

#include <cmath>

#include "costs/spline_image.h"

namespace burin {

WarpPicture MakeWarpPicture(const std::vector<LevelView>& views, int reference,
                            const ViewDomain& domain, int partner, const TriangleMesh& mesh) {
  const LevelView& view = views[reference];
  const LevelView& second = views[domain.seconds[partner]];
  const SplineImage<double> spline(second.FloatImage(), 0.0);
  const cv::Mat1f image = view.FloatImage();
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
    const FacetPencil pencil =
        MakeFacetPencil(mesh.vertices, mesh.faces[domain.facet[k]], view.camera);
    for (uint32_t m = domain.start[3 * k]; m < domain.start[3 * k + 3]; ++m) {
      const uint32_t p = domain.pixel[m];
      if (((domain.second_visible[partner / 8][p] >> (partner % 8)) & 1) == 0) continue;
      const int x = static_cast<int>(p) % domain.width;
      const int y = static_cast<int>(p) / domain.width;
      const double inverse_depth =
          (pencil.coefficients * Eigen::Vector3d(x + 0.5, y + 0.5, 1)).sum();
      const Eigen::Vector3d point =
          view.camera.Center() + view.camera.Ray(x + 0.5, y + 0.5) / inverse_depth;
      const Eigen::Vector2d q = second.camera.Project(point);
      double value = 0;
      spline.Sample(q.x(), q.y(), &value);
      picture.warped(y, x) = static_cast<float>(value);
      picture.valid(y, x) = 255;
      const double intensity = image(y, x);
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

}  // namespace burin
