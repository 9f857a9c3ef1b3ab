#include "core/visibility/render.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "core/image/picture.h"
#include "core/support/parallel.h"
#include "core/visibility/ray_render.h"

namespace burin {
namespace {

// Light that a surface of unit albedo returns, in [0, 1], and which side is seen.
struct Shade {
  double light = 0;
  bool from_behind = false;
};

Shade ShadeOf(const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& vertex_normals,
              const Camera& camera, const Eigen::Vector3d& ray, const RayHit& hit) {
  Shade shade;
  Eigen::Vector3d normal = FaceAreaNormal(mesh, hit.face);
  shade.from_behind = normal.dot(ray) > 0;
  if (!vertex_normals.empty()) {
    const Eigen::Vector3d face_normal = normal;
    normal.setZero();
    for (int c = 0; c < 3; ++c) {
      normal += hit.barycentric[c] * vertex_normals[mesh.faces[hit.face][c]];
    }
    if (normal.isZero(0)) normal = face_normal;
  }
  if (shade.from_behind) normal = -normal;
  normal = (camera.rotation * normal).normalized();
  const Eigen::Vector3d to_eye = -(camera.rotation * ray).normalized();
  static const Eigen::Vector3d kKeyLight = Eigen::Vector3d(-0.6, -0.7, -0.6).normalized();
  const double key = std::max(0.0, normal.dot(kKeyLight));
  const double head = std::max(0.0, normal.dot(to_eye));
  shade.light = std::min(1.0, 0.08 + 0.62 * key + 0.30 * head);
  return shade;
}

// Averages color_of(hit, ray) over the rays of each pixel; components in [0, 255].
cv::Mat3b RenderColors(
    const TriangleMesh& mesh, const Camera& camera, const RenderOptions& options,
    const std::function<cv::Vec3d(const RayHit&, const Eigen::Vector3d& ray)>& color_of) {
  const MeshRays mesh_rays(mesh);
  const Eigen::Vector3d center = camera.Center();
  const int rays = std::max(1, options.supersampling);
  cv::Mat3b picture(camera.height, camera.width, options.background);
  ParallelFor(camera.height, 4, [&](int begin, int end) {
    RayHit hit;
    for (int row = begin; row < end; ++row) {
      for (int col = 0; col < camera.width; ++col) {
        cv::Vec3d sum(0, 0, 0);
        for (int s = 0; s < rays * rays; ++s) {
          const Eigen::Vector2d at = SamplePoint(col, row, s, rays);
          const Eigen::Vector3d ray = camera.Ray(at.x(), at.y());
          sum += mesh_rays.Intersect(center, ray, &hit) ? color_of(hit, ray)
                                                        : cv::Vec3d(options.background);
        }
        for (int c = 0; c < 3; ++c) {
          picture(row, col)[c] = cv::saturate_cast<uchar>(sum[c] / (rays * rays));
        }
      }
    }
  });
  return picture;
}

cv::Vec3b LabToBgr(const cv::Vec3f& lab) {
  cv::Mat3f pixel(1, 1, lab);
  cv::cvtColor(pixel, pixel, cv::COLOR_Lab2BGR);
  cv::Vec3b bgr;
  for (int c = 0; c < 3; ++c) bgr[c] = cv::saturate_cast<uchar>(255 * pixel(0, 0)[c]);
  return bgr;
}

constexpr int kTableSize = 511;  // odd: the middle of a signed scale is an entry

// The colours of a scale in equal steps from min to max.
std::vector<cv::Vec3b> ColorTable(const ColorScale& scale) {
  std::vector<cv::Vec3b> table(kTableSize);
  if (scale.min < 0 && scale.max > 0) {
    const cv::Vec3f blue(35, 15, -60);
    const cv::Vec3f middle(92, 0, 0);
    const cv::Vec3f red(38, 60, 42);
    for (int k = 0; k < kTableSize; ++k) {
      const float t = 2.0F * static_cast<float>(k) / (kTableSize - 1) - 1;
      table[k] = LabToBgr(middle + std::abs(t) * ((t < 0 ? blue : red) - middle));
    }
    return table;
  }
  cv::Mat1b index(1, 256);
  for (int k = 0; k < 256; ++k) index(0, k) = static_cast<uchar>(k);
  cv::Mat3b colors;
  cv::applyColorMap(index, colors, cv::COLORMAP_VIRIDIS);
  for (int k = 0; k < kTableSize; ++k) table[k] = colors(0, k / 2);
  return table;
}

constexpr uchar kNoValueGray = 128;

cv::Vec3b TableColor(const std::vector<cv::Vec3b>& table, const ColorScale& scale, double value) {
  if (std::isnan(value)) return {kNoValueGray, kNoValueGray, kNoValueGray};
  const double share = std::min(1.0, std::max(0.0, (value - scale.min) / (scale.max - scale.min)));
  return table[static_cast<int>(std::lround(share * (kTableSize - 1)))];
}

// WithColorBar with the table at hand.
cv::Mat3b AttachColorBar(const cv::Mat3b& picture, const ColorScale& scale,
                         const std::vector<cv::Vec3b>& table) {
  const int margin = std::max(4, picture.rows / 40);
  const int text_height = std::max(8, picture.rows / 40);
  const int bar_width = std::max(8, picture.rows / 30);
  const int panel_width = bar_width + 2 * margin + 6 * text_height;
  cv::Mat3b all(picture.rows, picture.cols + panel_width, cv::Vec3b(255, 255, 255));
  picture.copyTo(all(cv::Rect(0, 0, picture.cols, picture.rows)));
  const int left = picture.cols + margin;
  DrawText(scale.label, {left, margin + text_height / 2}, {panel_width - margin, text_height},
           &all);
  const int top = 3 * margin + text_height;
  const int bottom = picture.rows - 1 - 2 * margin;
  if (bottom <= top) return all;
  for (int row = top; row <= bottom; ++row) {
    const double share = static_cast<double>(bottom - row) / (bottom - top);
    const cv::Vec3b& color = table[static_cast<int>(std::lround(share * (kTableSize - 1)))];
    for (int col = left; col < left + bar_width; ++col) all(row, col) = color;
  }
  for (int tick = 0; tick <= 4; ++tick) {
    const int row = bottom - tick * (bottom - top) / 4;
    const double value = (scale.min + tick * (scale.max - scale.min) / 4) / scale.unit;
    char number[32];
    std::snprintf(number, sizeof(number), "%.3g", value);
    const int right = left + bar_width;
    cv::line(all, {right, row}, {right + margin / 2, row}, cv::Scalar(30, 30, 30));
    const int width = static_cast<int>(std::string(number).size()) * text_height;
    DrawText(number, {right + margin, row},
             {std::min(width, panel_width - bar_width - 2 * margin), text_height}, &all);
  }
  return all;
}

std::vector<Eigen::Vector3d> NormalsFor(const TriangleMesh& mesh, const RenderOptions& options) {
  return options.smooth ? VertexNormals(mesh, VertexFaces(mesh)) : std::vector<Eigen::Vector3d>();
}

}  // namespace

cv::Mat3b RenderShaded(const TriangleMesh& mesh, const Camera& camera,
                       const RenderOptions& options) {
  const std::vector<Eigen::Vector3d> normals = NormalsFor(mesh, options);
  return RenderColors(
      mesh, camera, options, [&](const RayHit& hit, const Eigen::Vector3d& ray) -> cv::Vec3d {
        const Shade shade = ShadeOf(mesh, normals, camera, ray, hit);
        // Less than a display's gamma: contrast on surfaces that face the camera matters more.
        const double level = 240 * std::pow(shade.light, 1 / 1.15);
        return shade.from_behind ? cv::Vec3d(0.45 * level, 0.5 * level, 0.85 * level)
                                 : cv::Vec3d(0.97 * level, 0.98 * level, level);
      });
}

cv::Vec3b ScaleColor(const ColorScale& scale, double value) {
  return TableColor(ColorTable(scale), scale, value);
}

cv::Mat3b WithColorBar(const cv::Mat3b& picture, const ColorScale& scale) {
  return AttachColorBar(picture, scale, ColorTable(scale));
}

namespace {

// The mesh in the colours of value_of(hit), slightly shaded, with a colour bar.
cv::Mat3b RenderScalar(const TriangleMesh& mesh, const Camera& camera,
                       const std::function<double(const RayHit&)>& value_of,
                       const ColorScale& scale, const RenderOptions& options) {
  CHECK(scale.min < scale.max);
  const std::vector<Eigen::Vector3d> normals = NormalsFor(mesh, options);
  const std::vector<cv::Vec3b> table = ColorTable(scale);
  const cv::Mat3b picture = RenderColors(
      mesh, camera, options, [&](const RayHit& hit, const Eigen::Vector3d& ray) -> cv::Vec3d {
        const double light = ShadeOf(mesh, normals, camera, ray, hit).light;
        return cv::Vec3d(TableColor(table, scale, value_of(hit))) * (0.6 + 0.4 * light);
      });
  return AttachColorBar(picture, scale, table);
}

}  // namespace

cv::Mat3b RenderVertexScalar(const TriangleMesh& mesh, const Camera& camera,
                             const std::vector<double>& values, const ColorScale& scale,
                             const RenderOptions& options) {
  CHECK_EQ(values.size(), mesh.vertices.size());
  const auto interpolated = [&](const RayHit& hit) {
    double value = 0;
    for (int c = 0; c < 3; ++c) value += hit.barycentric[c] * values[mesh.faces[hit.face][c]];
    return value;
  };
  return RenderScalar(mesh, camera, interpolated, scale, options);
}

cv::Mat3b RenderFaceScalar(const TriangleMesh& mesh, const Camera& camera,
                           const std::vector<double>& values, const ColorScale& scale,
                           const RenderOptions& options) {
  CHECK_EQ(values.size(), mesh.faces.size());
  return RenderScalar(
      mesh, camera, [&](const RayHit& hit) { return values[hit.face]; }, scale, options);
}

}  // namespace burin
