#include "core/visibility/mesh_cover.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace burin {
namespace {

struct Crossing {
  float x;
  int jump;
};

// Rows k with y between those of a and b, at (k + 0.5) / rows: [first, last).
struct RowRange {
  int first, last;
  RowRange(double y_a, double y_b, int rows, int count) {
    const auto row = [&](double y) {
      return static_cast<int>(
          std::clamp(std::ceil(y * rows - 0.5), 0.0, static_cast<double>(count)));
    };
    first = row(std::min(y_a, y_b));
    last = row(std::max(y_a, y_b));
  }
};

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

EdgeFacets::EdgeFacets(const TriangleMesh& mesh, const Adjacency& neighbors,
                       const Adjacency& faces) {
  start_.push_back(0);
  for (int v = 0; v + 1 < static_cast<int>(neighbors.start.size()); ++v) {
    for (const int* n = neighbors.Begin(v); n != neighbors.End(v); ++n) {
      if (*n < v) continue;
      a_.push_back(v);
      b_.push_back(*n);
      for (const int* f = faces.Begin(v); f != faces.End(v); ++f) {
        const Eigen::Vector3i& face = mesh.faces[*f];
        for (int c = 0; c < 3; ++c) {
          if (face[c] == v && face[(c + 1) % 3] == *n) facets_.push_back({*f, 1});
          if (face[c] == *n && face[(c + 1) % 3] == v) facets_.push_back({*f, -1});
        }
      }
      start_.push_back(static_cast<int>(facets_.size()));
    }
  }
}

MeshCover::MeshCover(const TriangleMesh& mesh, const EdgeFacets& edges, const Camera& camera,
                     int rows)
    : width_(camera.width), height_(camera.height), rows_(rows) {
  std::vector<int> weights;
  FindRims(mesh, edges, camera, &weights);
  FillRows(weights);
}

void MeshCover::FindRims(const TriangleMesh& mesh, const EdgeFacets& edges, const Camera& camera,
                         std::vector<int>* weights) {
  const size_t count = mesh.vertices.size();
  std::vector<Eigen::Vector2d> points(count);
  std::vector<char> in_front(count);
  for (size_t v = 0; v < count; ++v) {
    in_front[v] =
        static_cast<char>(camera.Depth(mesh.vertices[v]) > std::max(0.0, camera.near_depth));
    if (in_front[v] != 0) points[v] = camera.Project(mesh.vertices[v]);
  }
  std::vector<int8_t> turn(mesh.faces.size(), 0);  // which way it goes round in the image
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3i& face = mesh.faces[f];
    if (in_front[face[0]] == 0 || in_front[face[1]] == 0 || in_front[face[2]] == 0) continue;
    const double area = Cross(points[face[1]] - points[face[0]], points[face[2]] - points[face[0]]);
    turn[f] = static_cast<int8_t>((area > 0) - (area < 0));
  }
  for (int e = 0; e < edges.size(); ++e) {
    int weight = 0;
    for (const EdgeFacets::Facet* f = edges.Begin(e); f != edges.End(e); ++f) {
      weight += f->direction * turn[f->face];
    }
    if (weight == 0) continue;
    const Eigen::Vector2d& a = points[edges.a(e)];
    const Eigen::Vector2d& b = points[edges.b(e)];
    const Eigen::Vector2d along = b - a;
    const double length = along.norm();
    if (!(length > 0)) continue;
    const double side = (weight > 0 ? 1 : -1) / length;
    rims_.push_back({e, a, b, {side * along.y(), -side * along.x()}});
    weights->push_back(weight);
  }
}

void MeshCover::FillRows(const std::vector<int>& weights) {
  const int count = height_ * rows_;
  std::vector<int64_t> start(count + 1, 0);
  for (const Rim& rim : rims_) {
    const RowRange range(rim.a.y(), rim.b.y(), rows_, count);
    for (int k = range.first; k < range.last; ++k) ++start[k + 1];
  }
  for (int k = 0; k < count; ++k) start[k + 1] += start[k];
  std::vector<Crossing> crossings(start[count]);
  std::vector<int64_t> next(start.begin(), start.end() - 1);
  for (size_t r = 0; r < rims_.size(); ++r) {
    const Eigen::Vector2d& a = rims_[r].a;
    const Eigen::Vector2d& b = rims_[r].b;
    const int jump = b.y() > a.y() ? -weights[r] : weights[r];
    const RowRange range(a.y(), b.y(), rows_, count);
    for (int k = range.first; k < range.last; ++k) {
      const double y = (k + 0.5) / rows_;
      const double x = a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      crossings[next[k]++] = {static_cast<float>(x), jump};
    }
  }
  row_start_.assign(1, 0);
  row_start_.reserve(count + 1);
  for (int k = 0; k < count; ++k) {
    std::sort(crossings.begin() + start[k], crossings.begin() + start[k + 1],
              [](const Crossing& one, const Crossing& other) {
                return one.x < other.x || (one.x == other.x && one.jump > other.jump);
              });
    int facets = 0;
    for (int64_t c = start[k]; c < start[k + 1]; ++c) {
      const int before = facets;
      facets += crossings[c].jump;
      if (before <= 0 && facets > 0) spans_.push_back({crossings[c].x, crossings[c].x});
      if (before > 0 && facets <= 0) spans_.back().end = crossings[c].x;
    }
    row_start_.push_back(static_cast<int64_t>(spans_.size()));
  }
}

bool MeshCover::Covers(const Eigen::Vector2d& point) const {
  const double row = std::floor(point.y() * rows_);
  if (!(row >= 0 && row < height_ * rows_)) return false;
  const auto k = static_cast<size_t>(row);
  const auto begin = spans_.begin() + row_start_[k];
  const auto after = std::upper_bound(begin, spans_.begin() + row_start_[k + 1], point.x(),
                                      [](double x, const Span& span) { return x < span.begin; });
  return after != begin && point.x() < (after - 1)->end;
}

cv::Mat1f MeshCover::Share(const cv::Rect& region) const {
  cv::Mat1f share(region.size(), 0.0F);
  const float left = static_cast<float>(region.x);
  const float right = static_cast<float>(region.x + region.width);
  const float weight = 1.0F / static_cast<float>(rows_);
  for (int y = 0; y < region.height; ++y) {
    float* out = share[y];
    for (int sub = 0; sub < rows_; ++sub) {
      const int k = (region.y + y) * rows_ + sub;
      for (int64_t s = row_start_[k]; s < row_start_[k + 1]; ++s) {
        const float begin = std::max(spans_[s].begin, left) - left;
        const float end = std::min(spans_[s].end, right) - left;
        if (!(begin < end)) continue;
        const int first = static_cast<int>(begin);
        const int last = std::min(static_cast<int>(end), region.width - 1);
        for (int x = first; x <= last; ++x) {
          const auto at = static_cast<float>(x);
          out[x] += weight * (std::min(end, at + 1) - std::max(begin, at));
        }
      }
    }
  }
  return share;
}

bool MeshCover::IsThin(const Sample& sample, double width) const {
  for (double inwards = 0.5; inwards <= width; inwards += 0.5) {
    if (!Covers(sample.point - inwards * rims_[sample.rim].outward)) return true;
  }
  return false;
}

std::vector<MeshCover::Sample> MeshCover::Contour(double length, double outwards) const {
  std::vector<Sample> samples;
  for (size_t r = 0; r < rims_.size(); ++r) {
    const Rim& rim = rims_[r];
    const double whole = (rim.b - rim.a).norm();
    const int pieces = std::max(1, static_cast<int>(std::ceil(whole / length)));
    for (int p = 0; p < pieces; ++p) {
      const double along = (p + 0.5) / pieces;
      const Eigen::Vector2d point = (1 - along) * rim.a + along * rim.b;
      if (point.x() < 1 || point.y() < 1 || point.x() > width_ - 1 || point.y() > height_ - 1) {
        continue;
      }
      if (Covers(point + outwards * rim.outward)) continue;
      samples.push_back({static_cast<int>(r), along, whole / pieces, point});
    }
  }
  return samples;
}

}  // namespace burin
