// Synthetic scenes as bytes, to compare whole ones.
#pragma once

#include <string>
#include <vector>

#include "core/synthetic/synthetic.h"

namespace burin {

// Every number of a scene, as bytes.
inline std::string Bytes(const SyntheticScene& synthetic) {
  std::string bytes;
  const auto append = [&](const void* data, size_t size) {
    bytes.append(static_cast<const char*>(data), size);
  };
  const auto append_vectors = [&](const std::vector<Eigen::Vector3d>& vectors) {
    for (const Eigen::Vector3d& vector : vectors) append(vector.data(), 3 * sizeof(double));
  };
  for (size_t v = 0; v < synthetic.scene.views.size(); ++v) {
    const View& view = synthetic.scene.views[v];
    append(view.gray.data, view.gray.total());
    append(view.camera.rotation.data(), 9 * sizeof(double));
    append(synthetic.depth[v].data, synthetic.depth[v].total() * sizeof(float));
  }
  append_vectors(synthetic.truth.vertices);
  append_vectors(synthetic.init.vertices);
  append_vectors(synthetic.truth_points);
  append_vectors(synthetic.truth_normals);
  for (size_t p = 0; p < synthetic.scene.points.size(); ++p) {
    const ScenePoint& point = synthetic.scene.points[p];
    append_vectors({point.position});
    append(point.views.data(), point.views.size() * sizeof(int));
    for (const Measurement& measured : synthetic.scene.tracks.Of(p)) {
      append(measured.image_point.data(), 2 * sizeof(double));
      append(&measured.view, sizeof(int));
    }
  }
  return bytes;
}

}  // namespace burin
