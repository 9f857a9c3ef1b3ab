#include "core/mesh/edge_lengths.h"

#include <glog/logging.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "core/mesh/smoothed_normals.h"
#include "core/support/median.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kGrain = 2048;
constexpr double kUnset = std::numeric_limits<double>::infinity();

// Spreads values along edges: value[b] = min(value[b], next(value[a], |ab|)), from the smallest on. lowered(a, b) is told of
// each b that got less from a.
template <typename Next, typename Lowered>
void Spread(const TriangleMesh& mesh, const Adjacency& neighbors, const Next& next,
            const Lowered& lowered, std::vector<double>* value) {
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto spread_from = [&](int v) {
    for (const int* w = neighbors.Begin(v); w != neighbors.End(v); ++w) {
      const double bound = next((*value)[v], (mesh.vertices[*w] - mesh.vertices[v]).norm());
      if (!(bound < (*value)[*w])) continue;
      (*value)[*w] = bound;
      lowered(v, *w);
      queue.emplace(bound, *w);
    }
  };
  for (size_t v = 0; v < value->size(); ++v) {
    if ((*value)[v] < kUnset) spread_from(static_cast<int>(v));
  }
  while (!queue.empty()) {
    const auto [bound, v] = queue.top();
    queue.pop();
    if (bound == (*value)[v]) spread_from(v);
  }
}

// Larger principal curvature, in size, of the quadratic form that explains best how normals turn along the edges.
double FacetCurvature(const TriangleMesh& mesh, int facet, const Eigen::Vector3d& area_normal,
                      const std::vector<Eigen::Vector3d>& normals) {
  const Eigen::Vector3i& face = mesh.faces[facet];
  const Eigen::Vector3d u = (mesh.vertices[face[1]] - mesh.vertices[face[0]]).normalized();
  const Eigen::Vector3d w = area_normal.normalized().cross(u);
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();  // of (uu, uw, ww)
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();
  for (int c = 0; c < 3; ++c) {
    const int a = face[c];
    const int b = face[(c + 1) % 3];
    const Eigen::Vector3d edge = mesh.vertices[b] - mesh.vertices[a];
    const Eigen::Vector3d turn = normals[b] - normals[a];
    const Eigen::Vector3d rows[2] = {{edge.dot(u), edge.dot(w), 0}, {0, edge.dot(u), edge.dot(w)}};
    const double values[2] = {turn.dot(u), turn.dot(w)};
    for (int r = 0; r < 2; ++r) {
      matrix += rows[r] * rows[r].transpose();
      vector += values[r] * rows[r];
    }
  }
  matrix.diagonal().array() += 1e-12 * matrix.trace();
  const Eigen::Vector3d form = matrix.ldlt().solve(vector);
  const double mean = 0.5 * (form[0] + form[2]);
  return std::abs(mean) + std::hypot(0.5 * (form[0] - form[2]), form[1]);
}

}  // namespace

std::vector<double> PixelWidths(const TriangleMesh& mesh, const std::vector<Camera>& cameras,
                                const std::vector<std::vector<char>>* face_visible_in_view,
                                double unseen_factor, double min_cos) {
  const int count = static_cast<int>(mesh.vertices.size());
  const Adjacency faces = VertexFaces(mesh);
  std::vector<double> width(count, kUnset);
  ParallelFor(count, kGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const Eigen::Vector3d& point = mesh.vertices[v];
      for (size_t i = 0; i < cameras.size(); ++i) {
        const Camera& camera = cameras[i];
        if (!(camera.Depth(point) > 0) || !camera.Contains(camera.Project(point))) continue;
        const Eigen::Vector3d to_view = (camera.Center() - point).normalized();
        for (const int* f = faces.Begin(v); f != faces.End(v); ++f) {
          if (face_visible_in_view != nullptr && (*face_visible_in_view)[*f][i] == 0) continue;
          const double cosine = FaceAreaNormal(mesh, *f).normalized().dot(to_view);
          if (!(cosine > 0)) continue;
          width[v] =
              std::min(width[v], camera.Footprint(point) / std::sqrt(std::max(cosine, min_cos)));
        }
      }
    }
  });
  std::vector<double> seen;
  for (const double w : width) {
    if (w < kUnset) seen.push_back(w);
  }
  if (seen.empty()) return std::vector<double>(count, 0.0);
  const double median = Median(std::move(seen));
  // The nearest along the surface; the median where nothing of a component is seen.
  std::vector<double> distance(count, kUnset);
  std::vector<int> nearest(count, -1);
  for (int v = 0; v < count; ++v) {
    if (!(width[v] < kUnset)) continue;
    distance[v] = 0;
    nearest[v] = v;
  }
  Spread(
      mesh, VertexNeighbors(mesh, faces), [](double from, double way) { return from + way; },
      [&](int from, int to) { nearest[to] = nearest[from]; }, &distance);
  for (int v = 0; v < count; ++v) {
    if (nearest[v] == v) continue;
    width[v] = unseen_factor * (nearest[v] >= 0 ? width[nearest[v]] : median);
  }
  return width;
}

std::vector<double> MaxCurvatures(const TriangleMesh& mesh, int smoothing_rounds) {
  const Adjacency faces = VertexFaces(mesh);
  const std::vector<Eigen::Vector3d> normals =
      SmoothedNormals(mesh, faces, VertexNeighbors(mesh, faces), smoothing_rounds);
  const int face_count = static_cast<int>(mesh.faces.size());
  std::vector<double> area(face_count);
  std::vector<double> of_facet(face_count, 0.0);
  ParallelFor(face_count, kGrain, [&](int begin, int end) {
    for (int f = begin; f < end; ++f) {
      const Eigen::Vector3d normal = FaceAreaNormal(mesh, f);
      area[f] = normal.norm();
      if (area[f] > 0) of_facet[f] = FacetCurvature(mesh, f, normal, normals);
    }
  });
  std::vector<double> curvature(mesh.vertices.size(), 0.0);
  ParallelFor(static_cast<int>(curvature.size()), kGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      double sum = 0;
      double weight = 0;
      for (const int* f = faces.Begin(v); f != faces.End(v); ++f) {
        sum += area[*f] * of_facet[*f];
        weight += area[*f];
      }
      if (weight > 0) curvature[v] = sum / weight;
    }
  });
  return curvature;
}

std::vector<double> EdgeLengths(const TriangleMesh& mesh, const std::vector<double>& pixel_width,
                                const EdgeLengthOptions& options) {
  CHECK_EQ(pixel_width.size(), mesh.vertices.size());
  const double max_turn = options.max_turn_deg * M_PI / 180;
  std::vector<double> length(pixel_width.size());
  std::vector<double> curvature(pixel_width.size(), 0.0);
  if (options.chord_px > 0 || options.max_turn_deg > 0)
    curvature = MaxCurvatures(mesh, options.smoothing_rounds);
  for (size_t v = 0; v < length.size(); ++v) {
    const double pixel = pixel_width[v];
    CHECK_GT(pixel, 0);
    double px = options.max_px;
    const double bend = curvature[v] * pixel;  // 1/px
    if (bend > 0 && options.chord_px > 0) {
      px = std::clamp(std::sqrt(8 * options.chord_px / bend), options.min_px, options.max_px);
    }
    if (bend > 0 && max_turn > 0) px = std::min(px, std::max(options.floor_px, max_turn / bend));
    length[v] = px * pixel;
  }
  const Adjacency faces = VertexFaces(mesh);
  Spread(
      mesh, VertexNeighbors(mesh, faces),
      [&](double from, double distance) { return from + options.gradation * distance; },
      [](int, int) {}, &length);
  return length;
}

}  // namespace burin
