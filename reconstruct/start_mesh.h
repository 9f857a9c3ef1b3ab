// A mesh to start a refinement from, made of the scene itself: points, their Delaunay tetrahedra, a minimum cut on
// lines of sight, its surface.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/scene.h"
#include "reconstruct/start_options.h"

namespace burin {

struct StartStage {
  std::string name;
  double seconds = 0;
  double processor_seconds = 0;  // of all threads
};

struct StartMesh {
  TriangleMesh mesh;
  std::vector<float> sights;  // by vertex: the views that see its point
  int sparse_points = 0;
  int dense_points = 0;
  int points = 0;  // after merging
  int cells = 0;
  long lines = 0;
  long lost_lines = 0;
  double spacing = 0;  // world units
  int long_facets = 0;
  int small_parts = 0;
  std::vector<StartStage> stages;
};

struct StartObservers {
  std::function<void(double share, const std::string& doing)> on_progress;  // share done, in [0, 1]
  std::function<void(const std::string& line)> on_line;
  std::function<void()> check_stop;    // throws to end the work
  std::filesystem::path depth_folder;  // where depth maps are kept and found again; empty: nowhere
};

// Throws InputError where the scene gives no points, or these no surface. The same mesh for any number of threads.
StartMesh MakeStartMesh(const Scene& scene, const StartOptions& options,
                        const StartObservers& observers = {});

}  // namespace burin
