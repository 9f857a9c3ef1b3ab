#include "costs/step_band.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/support/parallel.h"
#include "core/visibility/facet_pencil.h"

namespace burin {
namespace {

constexpr int kFacetGrain = 512;
constexpr int kRowGrain = 16;

// Whether the depth at `to` is off the plane of `from` by `limit` = plane_px / focal or more, in
// units of the depth at `from`. What is not a number is off.
bool OffPlane(const DepthPlanes& planes, size_t from, size_t to, int dx, int dy, double limit) {
  const double centre = planes.inverse_depth[from];
  const double tap = planes.inverse_depth[to];
  const double predicted = centre + dx * planes.slope_x[from] + dy * planes.slope_y[from];
  return !(predicted > 0 && std::abs(predicted - tap) * centre < limit * tap * predicted);
}

bool IsStep(const DepthPlanes& planes, const std::vector<uint8_t>& open_border, size_t a, size_t b,
            int dx, int dy, double limit) {
  const bool has_a = planes.inverse_depth[a] > 0;
  const bool has_b = planes.inverse_depth[b] > 0;
  if (has_a != has_b) return open_border.empty() || open_border[has_a ? a : b] == 0;
  if (!has_a) return false;
  return OffPlane(planes, a, b, dx, dy, limit) && OffPlane(planes, b, a, -dx, -dy, limit);
}

// Which squares of kSquare pixels of a view have a pixel near a step.
class StepSquares {
 public:
  StepSquares(const std::vector<uint8_t>& near, int width, int height)
      : columns_(SquareOf(width - 1) + 1), rows_(SquareOf(height - 1) + 1) {
    occupied_.assign(static_cast<size_t>(columns_) * rows_, 0);
    for (int y = 0; y < height; ++y) {
      uint8_t* row = &occupied_[static_cast<size_t>(SquareOf(y)) * columns_];
      const uint8_t* pixels = near.data() + static_cast<size_t>(y) * width;
      for (int x = 0; x < width; ++x) row[SquareOf(x)] |= pixels[x];
    }
  }
  // Some pixel that a point between these, clamped to the image, falls into may be near a step.
  bool Near(const Eigen::Array2f& low, const Eigen::Array2f& high) const {
    const int x0 = std::clamp(Floor(low.x()), 0, columns_ - 1);
    const int x1 = std::clamp(Floor(high.x()), 0, columns_ - 1);
    const int y0 = std::clamp(Floor(low.y()), 0, rows_ - 1);
    const int y1 = std::clamp(Floor(high.y()), 0, rows_ - 1);
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        if (occupied_[static_cast<size_t>(y) * columns_ + x] != 0) return true;
      }
    }
    return false;
  }

 private:
  static constexpr int kSquare = 4;
  static int SquareOf(int pixel) { return pixel / kSquare; }
  // Of what may be anywhere: far off is far off.
  static int Floor(float pixel) {
    return static_cast<int>(std::floor(std::clamp(pixel / kSquare, -1e6F, 1e6F)));
  }
  int columns_;
  int rows_;
  std::vector<uint8_t> occupied_;
};

// Where the vertices are in a view; not a number behind it.
std::vector<Eigen::Array2f> ProjectAll(const TriangleMesh& mesh, const Camera& camera) {
  std::vector<Eigen::Array2f> projected(mesh.vertices.size());
  ParallelFor(static_cast<int>(projected.size()), kFacetGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      projected[v].setConstant(std::numeric_limits<float>::quiet_NaN());
      if (!(camera.Depth(mesh.vertices[v]) > 0)) continue;
      projected[v] = camera.Project(mesh.vertices[v]).cast<float>().array();
    }
  });
  return projected;
}

// Takes the pixels near a step out of `bits`, of view i's partner b. Points of a facet are between its vertices, so
// that most facets need no point.
void RemoveNearSteps(const ViewDomain& domain, size_t b, const Camera& reference,
                     const Camera& second, const TriangleMesh& mesh,
                     const std::vector<Eigen::Array2f>& projected, const StepSquares& squares,
                     const std::vector<uint8_t>& near, PartnerBits* bits) {
  constexpr float kRounding = 0.05F;  // pixels, of `projected`
  const ViewRays rays(reference);
  ParallelFor(static_cast<int>(domain.facet.size()), kFacetGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const Eigen::Vector3i& face = mesh.faces[domain.facet[k]];
      const Eigen::Array2f* const at[3] = {&projected[face[0]], &projected[face[1]],
                                           &projected[face[2]]};
      const bool known = std::isfinite(at[0]->sum() + at[1]->sum() + at[2]->sum());
      if (known && !squares.Near(at[0]->min(*at[1]).min(*at[2]) - kRounding,
                                 at[0]->max(*at[1]).max(*at[2]) + kRounding)) {
        continue;
      }
      const InverseDepthPlane plane = MakeInverseDepth(mesh.vertices, face, rays);
      for (const ImagePixel pixel : domain.PixelsOf(k)) {
        if (!bits->Test(b, pixel.index)) continue;
        const Eigen::Vector2d q = second.Project(rays.SurfacePoint(pixel.x(), pixel.y(), plane));
        const int qx = std::clamp(static_cast<int>(q.x()), 0, second.width - 1);
        const int qy = std::clamp(static_cast<int>(q.y()), 0, second.height - 1);
        if (near[static_cast<size_t>(qy) * second.width + qx] != 0) bits->Clear(b, pixel.index);
      }
    }
  });
}

// Facets whose patch is seen well enough with the pixels of `bits` alone.
std::vector<char> WellSeen(const std::vector<ViewDomain>& domains, const TriangleMesh& mesh,
                           const std::vector<PartnerBits>& bits, double evidence) {
  struct Seen {
    int64_t clear = 0;
    int64_t area = 0;
  };
  std::vector<Seen> facets(mesh.faces.size());
  for (size_t i = 0; i < domains.size(); ++i) {
    const ViewDomain& domain = domains[i];
    ParallelFor(static_cast<int>(domain.facet.size()), kFacetGrain, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        Seen& seen = facets[domain.facet[k]];
        const PixelRange pixels = domain.PixelsOf(k);
        seen.area = std::max(seen.area, static_cast<int64_t>(pixels.size()));
        for (const ImagePixel pixel : pixels) seen.clear += bits[i].Count(pixel.index);
      }
    });
  }
  std::vector<Seen> vertices(mesh.vertices.size());
  for (size_t f = 0; f < facets.size(); ++f) {
    for (int c = 0; c < 3; ++c) {
      vertices[mesh.faces[f][c]].clear += facets[f].clear;
      vertices[mesh.faces[f][c]].area += facets[f].area;
    }
  }
  std::vector<char> well(facets.size());
  for (size_t f = 0; f < facets.size(); ++f) {
    Seen patch;
    for (int c = 0; c < 3; ++c) {
      patch.clear += vertices[mesh.faces[f][c]].clear;
      patch.area += vertices[mesh.faces[f][c]].area;
    }
    well[f] =
        static_cast<double>(patch.clear) >= evidence * static_cast<double>(patch.area) ? 1 : 0;
  }
  return well;
}

}  // namespace

std::vector<uint8_t> OpenBorderPixels(const ViewDomain& domain, const TriangleMesh& mesh,
                                      const std::vector<char>& boundary) {
  std::vector<uint8_t> open(static_cast<size_t>(domain.width) * domain.height, 0);
  for (size_t k = 0; k < domain.facet.size(); ++k) {
    const Eigen::Vector3i& face = mesh.faces[domain.facet[k]];
    if (boundary[face[0]] == 0 && boundary[face[1]] == 0 && boundary[face[2]] == 0) continue;
    for (const ImagePixel pixel : domain.PixelsOf(k)) open[pixel.index] = 1;
  }
  return open;
}

cv::Mat1f StepDistances(const DepthPlanes& planes, const std::vector<uint8_t>& open_border,
                        double plane_px) {
  const int width = planes.width;
  const int height = planes.height;
  const double limit = plane_px / planes.focal;
  cv::Mat1b step(height, width, static_cast<uchar>(255));  // 0 = step, for the distance transform
  ParallelFor(height, kRowGrain, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      for (int x = 0; x < width; ++x) {
        const size_t p = static_cast<size_t>(y) * width + x;
        const auto step_to = [&](size_t q, int dx, int dy) {
          return IsStep(planes, open_border, p, q, dx, dy, limit);
        };
        const bool at_step =
            (x > 0 && step_to(p - 1, -1, 0)) || (x + 1 < width && step_to(p + 1, 1, 0)) ||
            (y > 0 && step_to(p - width, 0, -1)) || (y + 1 < height && step_to(p + width, 0, 1));
        if (at_step) step(y, x) = 0;
      }
    }
  });
  cv::Mat1f distance;
  cv::distanceTransform(step, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance;
}

std::vector<uint8_t> NearSteps(const DepthPlanes& planes, const std::vector<uint8_t>& open_border,
                               double plane_px, double band_px) {
  const cv::Mat1f distance = StepDistances(planes, open_border, plane_px);
  const int width = planes.width;
  const int height = planes.height;
  std::vector<uint8_t> near(planes.inverse_depth.size(), 0);
  const auto band = static_cast<float>(band_px);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      near[static_cast<size_t>(y) * width + x] = distance(y, x) <= band ? 1 : 0;
    }
  }
  return near;
}

std::vector<PartnerBits> WithoutSteps(const std::vector<ViewDomain>& domains,
                                      const std::vector<const ViewPartners*>& partners,
                                      const std::vector<Camera>& cameras, const TriangleMesh& mesh,
                                      const std::vector<std::vector<uint8_t>>& near_steps,
                                      double evidence) {
  std::vector<PartnerBits> result;
  result.reserve(domains.size());
  for (size_t i = 0; i < domains.size(); ++i) {
    result.push_back(partners[i]->second_visible);
    if (partners[i]->seconds.empty() || near_steps[i].empty()) continue;
    for (size_t pixel = 0; pixel < near_steps[i].size(); ++pixel) {
      if (near_steps[i][pixel] != 0) result[i].ClearAll(pixel);
    }
  }
  for (size_t j = 0; j < domains.size(); ++j) {
    if (near_steps[j].empty()) continue;
    const std::vector<Eigen::Array2f> projected = ProjectAll(mesh, cameras[j]);
    const StepSquares squares(near_steps[j], cameras[j].width, cameras[j].height);
    for (size_t i = 0; i < domains.size(); ++i) {
      const std::vector<int>& seconds = partners[i]->seconds;
      for (size_t b = 0; b < seconds.size(); ++b) {
        if (seconds[b] != static_cast<int>(j)) continue;
        RemoveNearSteps(domains[i], b, cameras[i], cameras[j], mesh, projected, squares,
                        near_steps[j], &result[i]);
      }
    }
  }
  const std::vector<char> well = WellSeen(domains, mesh, result, evidence);
  for (size_t i = 0; i < domains.size(); ++i) {
    const ViewDomain& domain = domains[i];
    ParallelFor(static_cast<int>(domain.facet.size()), kFacetGrain, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        if (well[domain.facet[k]] != 0) continue;
        for (const ImagePixel pixel : domain.PixelsOf(k)) {
          result[i].Copy(pixel.index, partners[i]->second_visible);
        }
      }
    });
  }
  return result;
}

}  // namespace burin
