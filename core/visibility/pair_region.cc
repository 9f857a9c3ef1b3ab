#include "core/visibility/pair_region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/support/parallel.h"
#include "core/visibility/facet_pencil.h"

namespace burin {
namespace {

constexpr int kRowGrain = 16;
constexpr int kFacetGrain = 512;
constexpr int kBatch = 256;  // points, which stay in the first-level cache
constexpr double kHiddenPx = 8;
constexpr double kNearest =
    0.1;  // of a point's depth: what hides it for certain, where the focal length is some pixels

// Of a point in view j.
enum Place : uint8_t { kOutside = 0, kInside = 1, kBetweenCentres = 2 };

// Without a branch.
int Both(int a, int b) { return a & b; }

// Surface points of view i, field by field, for loops without branches.
struct Batch {
  int count = 0;
  std::array<double, kBatch> x;  // the image point in i
  std::array<double, kBatch> y;
  std::array<double, kBatch> inverse;  // depth in i
  std::array<double, kBatch> inverse_j;
  std::array<double, kBatch> x_j;  // in j, less half a pixel
  std::array<double, kBatch> y_j;
  std::array<int, kBatch> facet;
  std::array<uint32_t, kBatch> pixel;
  std::array<int, kBatch> block;  // in j, of the four pixel centres around: its first pixel
  std::array<uint8_t, kBatch> place;
  std::array<int, kBatch> open;  // of the points of which the pixels of j have to tell more
  // Points that need a ray of their own.
  std::vector<Eigen::Vector3d> ray_points;
  std::vector<int> ray_facets;
  std::vector<uint32_t> ray_pixels;
  std::vector<uint8_t> ray_visible;
};

class PairRegion {
 public:
  PairRegion(const FacetRays& facet_rays, const ViewPixels& first, const SecondView& second,
             double border_px, size_t partner, PartnerBits* bits)
      : facet_rays_(facet_rays),
        first_(first),
        first_rays_(first.camera),
        second_(second),
        border_px_(border_px),
        bytes_(bits->MutableBytes(partner)),
        bit_(bits->Of(partner).bit) {
    const Eigen::Matrix<double, 3, 4> projection = second.camera.ProjectionMatrix();
    second_from_first_ = projection.leftCols<3>() * first_rays_.ray_from_pixel;
    epipole_ = projection.leftCols<3>() * first_rays_.center + projection.col(3);
    const double focal = std::sqrt(second.camera.fx * second.camera.fy);
    hides_from_ = static_cast<float>(1 / std::max(1 - kHiddenPx / focal, kNearest));
  }

  // Of visible facets [begin, end).
  int64_t Cast(int begin, int end) const {
    const ViewDomain& domain = first_.domain;
    const TriangleMesh& mesh = facet_rays_.mesh();
    Batch batch;
    std::array<InverseDepthPlane, kFacetGrain>
        planes;  // apart from the pixels' loop, that mispredicts
    for (int k = begin; k < end; ++k) {
      planes[k - begin] = MakeInverseDepth(mesh.vertices, mesh.faces[domain.facet[k]], first_rays_);
    }
    int64_t count = 0;
    for (int k = begin; k < end; ++k) {
      const int facet = domain.facet[k];
      if (second_.facing[facet] == 0) continue;
      const InverseDepthPlane& plane = planes[k - begin];
      for (const ImagePixel pixel : domain.PixelsOf(k)) {
        if (batch.count == kBatch) count += Flush(&batch);
        const int n = batch.count;
        batch.x[n] = pixel.x();
        batch.y[n] = pixel.y();
        batch.inverse[n] = plane.At(pixel.x(), pixel.y());
        batch.facet[n] = facet;
        batch.pixel[n] = pixel.index;
        const bool taken =
            first_.mask.empty() || first_.mask.at<uint8_t>(pixel.row, pixel.column) != 0;
        batch.count += taken ? 1 : 0;
      }
    }
    return count + Flush(&batch);
  }

 private:
  int64_t Flush(Batch* batch) const {
    Project(batch);
    if (!second_.mask.empty()) LeaveOutMasked(batch);
    int64_t count = 0;
    const int open = SeeConnected(batch, &count);
    batch->ray_points.clear();
    batch->ray_facets.clear();
    batch->ray_pixels.clear();
    for (int n = 0; n < open; ++n) {
      const float* depths = second_.inverse_depth[0] + batch->block[batch->open[n]];
      __builtin_prefetch(depths);
      __builtin_prefetch(depths + second_.inverse_depth.cols);
    }
    for (int n = 0; n < open; ++n) count += LookAround(batch->open[n], batch) ? 1 : 0;
    count += CastRays(batch);
    batch->count = 0;
    return count;
  }

  // Where the points are in j. Here and below what is not a number is outside.
  void Project(Batch* batch) const {
    const Eigen::Matrix3d& m = second_from_first_;
    const double m00 = m(0, 0), m01 = m(0, 1), m02 = m(0, 2), e0 = epipole_[0];
    const double m10 = m(1, 0), m11 = m(1, 1), m12 = m(1, 2), e1 = epipole_[1];
    const double m20 = m(2, 0), m21 = m(2, 1), m22 = m(2, 2), e2 = epipole_[2];
    const int count = batch->count;
    for (int n = 0; n < count; ++n) {
      // Homogeneous image point in j, times the inverse depth.
      const double inverse = batch->inverse[n];
      const double qx = m00 * batch->x[n] + m01 * batch->y[n] + m02 + inverse * e0;
      const double qy = m10 * batch->x[n] + m11 * batch->y[n] + m12 + inverse * e1;
      const double qz = m20 * batch->x[n] + m21 * batch->y[n] + m22 + inverse * e2;
      const double scale = 1 / qz;
      batch->x_j[n] = qx * scale;
      batch->y_j[n] = qy * scale;
      batch->inverse_j[n] = inverse * scale;
    }
    const int* map = second_.facet_map[0];
    const uint8_t* connected = second_.connected[0];
    const double high_x = second_.camera.width - border_px_;
    const double high_y = second_.camera.height - border_px_;
    const double last_x = second_.camera.width - 0.5;
    const double last_y = second_.camera.height - 0.5;
    const int stride = second_.facet_map.cols;
    for (int n = 0; n < count; ++n) {
      const double x = batch->x_j[n];
      const double y = batch->y_j[n];
      const int inside =
          Both(Both(batch->inverse[n] > 0, batch->inverse_j[n] > 0),
               Both(Both(x >= border_px_, y >= border_px_), Both(x <= high_x, y <= high_y)));
      const int between =
          Both(Both(inside, Both(x >= 0.5, y >= 0.5)), Both(x < last_x, y < last_y));
      batch->place[n] = static_cast<uint8_t>(inside + between);
      const int column = static_cast<int>(between != 0 ? x - 0.5 : 0.0);
      const int row = static_cast<int>(between != 0 ? y - 0.5 : 0.0);
      const int block = row * stride + column;
      batch->block[n] = block;
      __builtin_prefetch(map + block);
      __builtin_prefetch(map + block + stride);
      __builtin_prefetch(connected + block);
      __builtin_prefetch(bytes_ + batch->pixel[n], 1);
    }
  }

  void LeaveOutMasked(Batch* batch) const {
    const int last_column = second_.camera.width - 1;
    const int last_row = second_.camera.height - 1;
    for (int n = 0; n < batch->count; ++n) {
      if (batch->place[n] == kOutside) continue;
      const int column = std::clamp(static_cast<int>(batch->x_j[n]), 0, last_column);
      const int row = std::clamp(static_cast<int>(batch->y_j[n]), 0, last_row);
      if (second_.mask.at<uint8_t>(row, column) == 0) batch->place[n] = kOutside;
    }
  }

  // Most points: a pixel around sees the point's facet, and the four hang together, so that none of them hides it. Lists
  // the others that are not outside; returns how many.
  int SeeConnected(Batch* batch, int64_t* count) const {
    const int* map = second_.facet_map[0];
    const uint8_t* connected = second_.connected[0];
    const int stride = second_.facet_map.cols;
    int open = 0;
    int sum = 0;
    for (int n = 0; n < batch->count; ++n) {
      const int facet = batch->facet[n];
      const int block = batch->block[n];
      const int* above = map + block;
      const int* below = above + stride;
      const int around = static_cast<int>(above[0] == facet) | static_cast<int>(above[1] == facet) |
                         static_cast<int>(below[0] == facet) | static_cast<int>(below[1] == facet);
      const int place = batch->place[n];
      const int seen = around & connected[block] & static_cast<int>(place == kBetweenCentres);
      bytes_[batch->pixel[n]] |= static_cast<uint8_t>(seen * bit_);
      sum += seen;
      batch->open[open] = n;
      open += static_cast<int>(place != kOutside) - seen;
    }
    *count += sum;
    return open;
  }

  enum class Sight { kSeen, kHidden, kUnclear };

  // Whether the pixels of j tell that point n is seen; queues its ray where they do not tell.
  bool LookAround(int n, Batch* batch) const {
    const int facet = batch->facet[n];
    Sight sight = Sight::kUnclear;
    if (batch->place[n] == kBetweenCentres) {
      sight = SightAround(batch->block[n], static_cast<float>(batch->inverse_j[n]), facet);
    }
    if (sight == Sight::kUnclear) {
      const Eigen::Vector3d direction =
          first_rays_.ray_from_pixel * Eigen::Vector3d(batch->x[n], batch->y[n], 1);
      batch->ray_points.emplace_back(first_rays_.center + direction / batch->inverse[n]);
      batch->ray_facets.push_back(facet);
      batch->ray_pixels.push_back(batch->pixel[n]);
    }
    if (sight != Sight::kSeen) return false;
    bytes_[batch->pixel[n]] |= bit_;
    return true;
  }

  // Of a point of `facet` at inverse depth `here` in j, by the four pixels around it. Seen: none of them sees something
  // nearer but `facet` itself or facets that share a vertex with it. Hidden: all of them see something else, nearer by
  // kHiddenPx pixel footprints.
  Sight SightAround(int block, float here, int facet) const {
    const int stride = second_.facet_map.cols;
    const int* map = second_.facet_map[0] + block;
    const float* depths = second_.inverse_depth[0] + block;
    const std::array<float, 4> around = {depths[0], depths[1], depths[stride], depths[stride + 1]};
    const std::array<int, 4> seen = {map[0], map[1], map[stride], map[stride + 1]};
    const std::vector<Eigen::Vector3i>& faces = facet_rays_.mesh().faces;
    int others = 0;
    for (int k = 0; k < 4; ++k) {
      if (!(around[k] > here) || seen[k] == facet) continue;
      if (seen[k] < 0 || !ShareVertex(faces[seen[k]], faces[facet])) ++others;
    }
    if (others == 0) return Sight::kSeen;
    if (others < 4) return Sight::kUnclear;
    // depth - nearer > kHiddenPx * depth / focal.
    const float nearest_hidden = *std::min_element(around.begin(), around.end());
    return nearest_hidden > here * hides_from_ ? Sight::kHidden : Sight::kUnclear;
  }

  int64_t CastRays(Batch* batch) const {
    const auto rays = static_cast<int>(batch->ray_points.size());
    batch->ray_visible.resize(rays);
    facet_rays_.CastToCamera(second_.camera, second_.facing, batch->ray_points.data(),
                             batch->ray_facets.data(), rays, batch->ray_visible.data());
    int64_t count = 0;
    for (int k = 0; k < rays; ++k) {
      if (batch->ray_visible[k] == 0) continue;
      bytes_[batch->ray_pixels[k]] |= bit_;
      ++count;
    }
    return count;
  }

  const FacetRays& facet_rays_;
  const ViewPixels& first_;
  const ViewRays first_rays_;
  const SecondView& second_;
  const double border_px_;
  uint8_t* const bytes_;  // of the partner, a pixel each
  const uint8_t bit_;
  Eigen::Matrix3d second_from_first_;  // pixels, at infinity
  Eigen::Vector3d epipole_;
  float hides_from_;  // times the inverse depth
};

}  // namespace

void SecondView::Look(const TriangleMesh& mesh, const ViewPixels& pixels) {
  camera = pixels.camera;
  mask = pixels.mask;
  facing = FacingFacets(mesh, camera.Center());
  const cv::Size size(std::max(2, camera.width), std::max(2, camera.height));
  facet_map.create(size);
  inverse_depth.create(size);
  connected.create(size);
  ParallelFor(size.height, kRowGrain, [&](int begin, int end) {
    facet_map.rowRange(begin, end) = -1;
    inverse_depth.rowRange(begin, end) = 0;
    connected.rowRange(begin, end) = 0;
  });
  const ViewDomain& domain = pixels.domain;
  const ViewRays rays(camera);
  ParallelFor(static_cast<int>(domain.facet.size()), kFacetGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const int facet = domain.facet[k];
      const InverseDepthPlane plane = MakeInverseDepth(mesh.vertices, mesh.faces[facet], rays);
      for (const ImagePixel pixel : domain.PixelsOf(k)) {
        facet_map(pixel.row, pixel.column) = facet;
        inverse_depth(pixel.row, pixel.column) = static_cast<float>(plane.At(pixel.x(), pixel.y()));
      }
    }
  });
  for (const PixelDepth& seen : pixels.behind) {
    const auto width = static_cast<uint32_t>(camera.width);
    inverse_depth(static_cast<int>(seen.pixel / width), static_cast<int>(seen.pixel % width)) =
        seen.inverse_depth;
  }
  ParallelFor(facet_map.rows - 1, kRowGrain, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) Connect(mesh, row);
  });
}

void SecondView::Connect(const TriangleMesh& mesh, int row) {
  // The vertices of the facets of two rows, by corner; none is that of no facet.
  const int columns = facet_map.cols;
  std::vector<int> vertices(6 * static_cast<size_t>(columns));
  std::array<const int*, 6> at;
  for (int k = 0; k < 6; ++k) at[k] = vertices.data() + static_cast<size_t>(k) * columns;
  for (const int r : {0, 1}) {
    const int* facets = facet_map[row + r];
    int* to = vertices.data() + static_cast<size_t>(3 * r) * columns;
    for (int x = 0; x < columns; ++x) {
      for (int c = 0; c < 3; ++c) {
        to[c * columns + x] = facets[x] < 0 ? -1 : mesh.faces[facets[x]][c];
      }
    }
  }
  uint8_t* result = connected[row];
  const auto share = [](const int* const* a, const int* const* b, int i, int j) {
    int any = 0;
    for (int k = 0; k < 3; ++k) {
      for (int l = 0; l < 3; ++l) any |= static_cast<int>(a[k][i] == b[l][j]);
    }
    return any;
  };
  const int* const* upper = at.data();
  const int* const* lower = at.data() + 3;
  for (int x = 0; x + 1 < columns; ++x) {
    const int facets = static_cast<int>((upper[0][x] >= 0) & (upper[0][x + 1] >= 0) &
                                        (lower[0][x] >= 0) & (lower[0][x + 1] >= 0));
    result[x] = static_cast<uint8_t>(facets & share(upper, upper, x, x + 1) &
                                     share(lower, lower, x, x + 1) & share(upper, lower, x, x) &
                                     share(upper, lower, x + 1, x + 1) &
                                     share(upper, lower, x, x + 1) & share(upper, lower, x + 1, x));
  }
}

int64_t CastPair(const FacetRays& rays, const ViewPixels& first, const SecondView& second,
                 double border_px, size_t partner, PartnerBits* bits) {
  const PairRegion region(rays, first, second, border_px, partner, bits);
  const auto facets = static_cast<int>(first.domain.facet.size());
  std::vector<int64_t> counts((static_cast<size_t>(facets) + kFacetGrain - 1) / kFacetGrain, 0);
  ParallelFor(facets, kFacetGrain,
              [&](int begin, int end) { counts[begin / kFacetGrain] = region.Cast(begin, end); });
  return std::accumulate(counts.begin(), counts.end(), int64_t{0});
}

}  // namespace burin
