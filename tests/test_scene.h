// A tiny scene for derivative checks: bodies in front of a wall and of each other, and one smooth random
// image per view. The images need not agree with the geometry, since derivatives must hold anywhere.
#pragma once

#include <cmath>
#include <vector>

#include "core/scene/pairs.h"
#include "core/solve/energy_term.h"

namespace burin::test {

// splitmix64 as a stream of doubles in [-1, 1).
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  double Uniform() {
    state_ += 0x9E3779B97F4A7C15ULL;
    uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    z ^= z >> 31;
    return static_cast<double>(z >> 11) * 0x1p-52 - 1;
  }
  Eigen::Vector3d Vector() {
    const double x = Uniform();
    const double y = Uniform();
    return {x, y, Uniform()};
  }

 private:
  uint64_t state_;
};

// Camera at `center` looking at `target`, y axis of the image towards -world_up.
inline Camera LookAt(const Eigen::Vector3d& center, const Eigen::Vector3d& target, int width,
                     int height, double focal_px) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = focal_px;
  camera.cx = width / 2.0;
  camera.cy = height / 2.0;
  const Eigen::Vector3d forward = (target - center).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitY()).normalized();
  camera.rotation.row(0) = right;
  camera.rotation.row(1) = forward.cross(right);
  camera.rotation.row(2) = forward;
  camera.translation = -camera.rotation * center;
  return camera;
}

// A (cells+1)^2 grid over [-half, half]^2 at height z(x, y), facing +z.
template <typename Height>
void AppendGrid(TriangleMesh* mesh, int cells, double cx, double cy, double half, Height z) {
  const int base = static_cast<int>(mesh->vertices.size());
  for (int i = 0; i <= cells; ++i) {
    for (int j = 0; j <= cells; ++j) {
      const double x = cx - half + 2 * half * j / cells;
      const double y = cy - half + 2 * half * i / cells;
      mesh->vertices.emplace_back(x, y, z(x, y));
    }
  }
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      const int a = base + i * (cells + 1) + j;
      mesh->faces.emplace_back(a, a + 1, a + cells + 2);
      mesh->faces.emplace_back(a, a + cells + 2, a + cells + 1);
    }
  }
}

inline TriangleMesh OccluderMesh() {
  TriangleMesh mesh;
  AppendGrid(&mesh, 10, 0, 0, 1.3,
             [](double x, double y) { return 0.08 * std::sin(3 * x) * std::cos(2 * y); });
  AppendGrid(&mesh, 4, -0.35, 0.1, 0.3,
             [](double x, double y) { return 0.5 - 0.4 * (x + 0.35) * (x + 0.35) + 0.1 * y; });
  AppendGrid(&mesh, 3, 0.4, -0.2, 0.2, [](double x, double) { return 0.8 + 0.2 * x; });
  return mesh;
}

inline std::vector<LevelView> RandomViews(int width, int height, int count = 3) {
  const Eigen::Vector3d centers[3] = {{-0.9, 0.2, 3.2}, {0.1, -0.3, 3.4}, {1.0, 0.3, 3.0}};
  std::vector<LevelView> views(count);
  Random random(7);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d center = centers[i % 3] + i / 3 * Eigen::Vector3d(0.05, 0.15, 0.1);
    views[i].camera = LookAt(center, Eigen::Vector3d(0, 0, 0.2), width, height, 1.1 * width);
    cv::Mat1f image(height, width);
    double phase[6];
    for (double& p : phase) p = 3 * random.Uniform();
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const double u = x + 0.5;
        const double v = y + 0.5;
        image(y, x) = static_cast<float>(
            120 + 40 * std::sin(0.35 * u + phase[0]) * std::cos(0.31 * v + phase[1]) +
            25 * std::sin(0.8 * u + 0.5 * v + phase[2]) +
            12 * std::cos(1.3 * v - 0.6 * u + phase[3]));
      }
    }
    views[i].image = image;
    views[i].noise_sigma = 1.0;
    views[i].contrast = 50;  // a floor of 25 squared grey levels by default
  }
  return views;
}

inline std::vector<CameraPair> AllPairs() {
  return {{0, 1}, {1, 0}, {1, 2}, {2, 1}, {0, 2}, {2, 0}};
}

}  // namespace burin::test
