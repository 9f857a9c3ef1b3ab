#include "core/refine/local_guard.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kVertexGrain = 1024;
constexpr int kSweeps = 30;  // of the membrane
constexpr int kTries = 3;    // with a membrane, before displacements are taken back whole

class LocalGuard {
 public:
  LocalGuard(const std::vector<Eigen::Vector3d>& before, const Adjacency& faces,
             const Adjacency& neighbors, double pixel, const GuardOptions& options,
             TriangleMesh* mesh)
      : before_(before),
        faces_(faces),
        neighbors_(neighbors),
        pixel_(pixel),
        options_(options),
        mesh_(mesh) {}
  LocalGuardReport Run();

 private:
  bool Inverted(int face) const {
    const Eigen::Vector3i& f = mesh_->faces[face];
    const Eigen::Vector3d was =
        (before_[f[1]] - before_[f[0]]).cross(before_[f[2]] - before_[f[0]]);
    return was.dot(FaceAreaNormal(*mesh_, face)) < 0;
  }
  bool Stretched(int v, int w) const {
    const double length = (mesh_->vertices[v] - mesh_->vertices[w]).norm();
    return length > options_.max_stretch * std::max(pixel_, (before_[v] - before_[w]).norm());
  }
  bool Far(int v) const {
    return (mesh_->vertices[v] - before_[v]).norm() > options_.max_move_px * pixel_;
  }
  // By vertex: it is at fault. `report`, where given, counts why.
  std::vector<char> Faults(LocalGuardReport* report) const;
  void FillDisplacements(const std::vector<char>& faulty);

  const std::vector<Eigen::Vector3d>& before_;
  const Adjacency& faces_;
  const Adjacency& neighbors_;
  double pixel_;
  const GuardOptions& options_;
  TriangleMesh* mesh_;
};

std::vector<char> LocalGuard::Faults(LocalGuardReport* report) const {
  const auto count = static_cast<int>(before_.size());
  std::vector<char> faulty(count, 0);
  std::vector<char> inverted(mesh_->faces.size(), 0);
  ParallelFor(static_cast<int>(mesh_->faces.size()), kVertexGrain, [&](int begin, int end) {
    for (int f = begin; f < end; ++f) inverted[f] = static_cast<char>(Inverted(f));
  });
  std::vector<int> stretched(count, 0);
  std::vector<char> far(count, 0);
  ParallelFor(count, kVertexGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (const int* f = faces_.Begin(v); f != faces_.End(v); ++f) {
        if (options_.inverted && inverted[*f] != 0) faulty[v] = 1;
      }
      for (const int* w = neighbors_.Begin(v); w != neighbors_.End(v); ++w) {
        if (options_.max_stretch > 0 && Stretched(v, *w)) ++stretched[v];
      }
      far[v] = static_cast<char>(options_.max_move_px > 0 && Far(v));
      if (stretched[v] > 0 || far[v] != 0) faulty[v] = 1;
    }
  });
  if (report != nullptr) {
    report->inverted_facets = static_cast<int>(std::count(inverted.begin(), inverted.end(), 1));
    for (const int edges : stretched) report->stretched_edges += edges;
    report->stretched_edges /= 2;
    report->far_vertices = static_cast<int>(std::count(far.begin(), far.end(), 1));
  }
  return faulty;
}

// Jacobi sweeps of the mean over neighbours, from zero.
void LocalGuard::FillDisplacements(const std::vector<char>& faulty) {
  std::vector<int> list;
  for (size_t v = 0; v < faulty.size(); ++v) {
    if (faulty[v] != 0) list.push_back(static_cast<int>(v));
  }
  const auto count = static_cast<int>(list.size());
  for (const int v : list) mesh_->vertices[v] = before_[v];
  std::vector<Eigen::Vector3d> next(count);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    ParallelFor(count, kVertexGrain, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        const int v = list[k];
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (const int* w = neighbors_.Begin(v); w != neighbors_.End(v); ++w) {
          sum += mesh_->vertices[*w] - before_[*w];
        }
        next[k] = before_[v] + sum / std::max(1, neighbors_.Degree(v));
      }
    });
    for (int k = 0; k < count; ++k) mesh_->vertices[list[k]] = next[k];
  }
}

LocalGuardReport LocalGuard::Run() {
  LocalGuardReport report;
  std::vector<char> faulty = Faults(&report);
  std::vector<char> reverted(faulty.size(), 0);
  for (int attempt = 0; std::count(faulty.begin(), faulty.end(), 1) > 0; ++attempt) {
    for (size_t v = 0; v < faulty.size(); ++v) reverted[v] |= faulty[v];
    if (attempt < kTries) {
      FillDisplacements(reverted);
    } else {
      for (size_t v = 0; v < faulty.size(); ++v) {
        if (faulty[v] != 0) mesh_->vertices[v] = before_[v];
      }
    }
    faulty = Faults(nullptr);
    // A facet between vertices that stand where they stood cannot be at fault; each turn takes back
    // at least one vertex more.
    for (size_t v = 0; v < faulty.size(); ++v) {
      if (attempt >= kTries && mesh_->vertices[v] == before_[v]) faulty[v] = 0;
    }
  }
  report.reverted_vertices = static_cast<int>(std::count(reverted.begin(), reverted.end(), 1));
  return report;
}

}  // namespace

void GuardOptions::Describe(OptionSet* set) {
  set->Add("guard.levels", &levels,
           "Undo a level of the pyramid when photographs held back agree less with the mesh after "
           "it than before");
  set->Add("guard.max_stretch", &max_stretch,
           "A vertex is taken back when a round makes an edge at it longer than this many times "
           "what it was (or than so many pixels of the level); 0 = any",
           0, 1e9);
  set->Add("guard.max_move_px", &max_move_px,
           "A vertex is taken back when a round moves it by more pixels of the level; 0 = any", 0,
           1e9);
  set->Add("guard.inverted", &inverted,
           "Take back the vertices of facets that the last round turns over");
  set->Add(
      "guard.crossings", &crossings,
      "Parts of the surface that a round pushes through others: take_back = they go as far as "
      "they do not cross; report = facets that cross and back faces are counted; off = neither");
}

LocalGuardReport RevertFaults(const std::vector<Eigen::Vector3d>& before, const Adjacency& faces,
                              const Adjacency& neighbors, double pixel, const GuardOptions& options,
                              TriangleMesh* mesh) {
  return LocalGuard(before, faces, neighbors, pixel, options, mesh).Run();
}

}  // namespace burin
