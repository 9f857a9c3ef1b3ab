#include "core/evidence/free_space.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>

#include "core/evidence/window_matches.h"
#include "core/evidence/window_places.h"
#include "core/scene/track_errors.h"
#include "core/support/parallel.h"
#include "core/visibility/mesh_rays.h"

namespace burin {
namespace {

constexpr int kPlacesPerView = 320;
constexpr int kRayStep = 8;  // px of the reduced photograph, of the rays that ask what is behind
constexpr double kFarBehind = 1.15;      // depth of what is behind, in depths of the facet
constexpr double kLeastParallaxPx = 4;   // between facet and what is behind, in a partner
constexpr int kSearchPx = 6;             // along the epipolar line, to each side
constexpr int kRimPx = 10;               // a window's radius, and what a coarse rim may be off
constexpr float kAgrees = 0.75F;         // ZNCC
constexpr float kClearlyBetter = 0.25F;  // of ZNCC
constexpr double kWellInFront = 0.93;    // of the depth of a measured point
constexpr double kOnSurface = 0.03;
constexpr int kLeastAgainst = 6;
constexpr int kAgainstPerFor = 4;
constexpr double kAround = 0.08;  // of the photograph's longer side: a vote's surroundings
constexpr int kLeastAround = 4;
constexpr int kUnknownSteps = 10;          // over facets that no ray of the grid meets
constexpr double kLeastBehindShare = 0.8;  // of a facet's rays

// Where a view's ray meets a facet that it votes against or for.
struct Vote {
  Eigen::Vector3d at;
  double reach;  // kAround there
  int facet;
  bool against;
};

// By facet, but for the list.
struct Votes {
  std::vector<Vote> list;
  std::vector<int> against;
  std::vector<int> in_favour;
  std::vector<int> rays;         // of the grid: that meet it,
  std::vector<int> rays_behind;  // and of those a front side far behind
  explicit Votes(size_t facets)
      : against(facets), in_favour(facets), rays(facets), rays_behind(facets) {}
  void Add(const Vote& vote) {
    list.push_back(vote);
    ++(vote.against ? against : in_favour)[vote.facet];
  }
  void Add(const Votes& other) {
    list.insert(list.end(), other.list.begin(), other.list.end());
    for (size_t f = 0; f < against.size(); ++f) {
      against[f] += other.against[f];
      in_favour[f] += other.in_favour[f];
      rays[f] += other.rays[f];
      rays_behind[f] += other.rays_behind[f];
    }
  }
};

double ReachAt(const Camera& camera, const Eigen::Vector3d& point) {
  return kAround * std::max(camera.width, camera.height) * camera.Footprint(point);
}

class FreeSpaceJury {
 public:
  FreeSpaceJury(const Scene& scene, const TriangleMesh& mesh, const std::vector<CameraPair>& pairs)
      : mesh_(mesh), single_(mesh), partners_(scene.views.size()) {
    for (const CameraPair& pair : FirstPartners(scene, pairs)) {
      partners_[pair.reference].push_back(pair.second);
    }
    views_.resize(scene.views.size());
    ParallelFor(static_cast<int>(views_.size()), 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) views_[i] = Reduce(scene.views[i], kMatchSidePx);
    });
    points_of_.resize(views_.size());
    for (const ScenePoint& point : scene.points) {
      for (const int i : point.views) points_of_[i].push_back(&point.position);
    }
    // Where points are not where a view measured them, nothing is known of what it sees them through.
    for (const int i : MeasureTrackErrors(scene).off) points_of_[i].clear();
  }

  Votes Ask() const {
    Votes votes(mesh_.faces.size());
    std::mutex adding;  // votes are only counted: their order does not matter
    ParallelFor(static_cast<int>(views_.size()), 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        Votes of_view(mesh_.faces.size());
        AskWindows(i, &of_view);
        AskPoints(i, &of_view);
        AskGrid(i, &of_view);
        const std::lock_guard<std::mutex> lock(adding);
        votes.Add(of_view);
      }
    });
    return votes;
  }

  // Share of the view's pixels that meet a facet of `chosen` first.
  double Share(int i, const std::vector<char>& chosen) const {
    int count = 0;
    int hits = 0;
    ForGrid(i, [&](const Eigen::Vector2d&, const RayHit* hit) {
      ++count;
      if (hit != nullptr && chosen[hit->face] != 0) ++hits;
    });
    return count > 0 ? static_cast<double>(hits) / count : 0;
  }

 private:
  template <typename Visit>
  void ForGrid(int i, const Visit& visit) const {
    const Camera& camera = views_[i].camera;
    for (int y = kRayStep / 2; y < camera.height; y += kRayStep) {
      for (int x = kRayStep / 2; x < camera.width; x += kRayStep) {
        const Eigen::Vector2d at(x + 0.5, y + 0.5);
        RayHit hit;
        const bool meets = First(camera, camera.Ray(at.x(), at.y()), &hit);
        visit(at, meets ? &hit : nullptr);
      }
    }
  }

  // What the camera sees along a ray of depth 1; the hit's distance is its depth.
  bool First(const Camera& camera, const Eigen::Vector3d& ray, RayHit* hit) const {
    if (!single_.Intersect(camera.Center() + camera.near_depth * ray, ray, hit)) return false;
    hit->distance += camera.near_depth;
    return true;
  }

  // The first front side that the ray through `at` meets far behind `depth` (Camera::Ray has depth 1).
  std::optional<RayHit> Behind(const Camera& camera, const Eigen::Vector2d& at,
                               double depth) const {
    const Eigen::Vector3d ray = camera.Ray(at.x(), at.y());
    double start = kFarBehind * depth;
    for (int step = 0; step < 16; ++step) {
      RayHit hit;
      if (!single_.Intersect(camera.Center() + start * ray, ray, &hit)) return std::nullopt;
      const double hit_depth = start + hit.distance;
      if (FaceAreaNormal(mesh_, hit.face).dot(ray) < 0) {
        hit.distance = hit_depth;
        return hit;
      }
      start = hit_depth * (1 + 1e-6);
    }
    return std::nullopt;
  }

  // ZNCC of the window with the view's partners through the plane of a facet: the second best of them, each
  // the best of places along its epipolar line. Nothing where fewer than two can tell. Partners in which
  // `other`, the point of the other hypothesis, is at the same place cannot. Not looked for above `enough`.
  std::optional<float> Agreement(int i, const Eigen::Vector2d& at, int facet,
                                 const Eigen::Vector3d& point, const Eigen::Vector3d* other,
                                 float enough) const {
    Eigen::Vector3d normal = FaceAreaNormal(mesh_, facet).normalized();
    // The photograph looks at it from behind: then so does whoever sees the same side.
    if (normal.dot(views_[i].camera.Center() - point) < 0) normal = -normal;
    std::vector<float> scores;
    for (const int j : partners_[i]) {
      const SmallView& second = views_[j];
      if (second.camera.Depth(point) <= 0) continue;
      const Eigen::Vector2d there = second.camera.Project(point);
      if (!second.MayHoldWindow(there)) continue;
      if (other != nullptr && second.camera.Depth(*other) > 0 &&
          (second.camera.Project(*other) - there).norm() < kLeastParallaxPx) {
        continue;
      }
      const std::optional<WarpedWindow> warped =
          WarpThroughPlane(views_[i], second, at, point, normal, -1.0);
      if (!warped.has_value()) continue;
      const GridWindow window(views_[i].image, warped->at_i);
      if (!window.valid() || window.contrast() < kLeastContrast) continue;
      float best = -1;
      for (int k = 0; k <= 2 * kSearchPx && best < enough; ++k) {
        SampleGrid shifted = warped->at_j;
        shifted.center = warped->at_j.At(k % 2 == 0 ? k / 2 : -(k + 1) / 2, 0);
        best = std::max(best, window.ScoreAt(second.image, shifted).value_or(-1.0F));
      }
      scores.push_back(best);
      if (std::count_if(scores.begin(), scores.end(), [&](float s) { return s >= enough; }) == 2) {
        return enough;
      }
    }
    if (scores.size() < 2) return std::nullopt;
    std::nth_element(scores.begin(), scores.begin() + 1, scores.end(), std::greater<>());
    return scores[1];
  }

  // All around a window the view sees something nearer than `depth`: it is not at the rim of what is in front.
  bool CoversWindow(const Camera& camera, const Eigen::Vector2d& at, double depth) const {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        RayHit hit;
        const Eigen::Vector3d ray = camera.Ray(at.x() + kRimPx * x, at.y() + kRimPx * y);
        if (!First(camera, ray, &hit) || hit.distance > depth) return false;
      }
    }
    return true;
  }

  void AskWindows(int i, Votes* votes) const {
    if (partners_[i].size() < 2) return;
    const Camera& camera = views_[i].camera;
    for (const WindowPlace& place : PlacesOf(mesh_, views_[i], i, kPlacesPerView)) {
      const std::optional<RayHit> behind = Behind(camera, place.at, camera.Depth(place.point));
      const std::optional<float> here = Agreement(i, place.at, place.facet, place.point,
                                                  behind ? &behind->point : nullptr, kAgrees);
      const double reach = ReachAt(camera, place.point);
      if (here.has_value() && *here >= kAgrees) {
        votes->Add({place.point, reach, place.facet, false});
      }
      if (!behind.has_value()) continue;
      const std::optional<float> there =
          Agreement(i, place.at, behind->face, behind->point, &place.point, 1);
      if (there.has_value() && *there >= kAgrees && here.value_or(-1) <= *there - kClearlyBetter &&
          CoversWindow(camera, place.at, (camera.Depth(place.point) + behind->distance) / 2)) {
        votes->Add({place.point, reach, place.facet, true});
      }
    }
  }

  void AskPoints(int i, Votes* votes) const {
    const Camera& camera = views_[i].camera;
    for (const Eigen::Vector3d* point : points_of_[i]) {
      const double depth = camera.Depth(*point);
      if (!(depth > 0)) continue;
      RayHit hit;
      const Eigen::Vector3d ray = (*point - camera.Center()) / depth;
      if (!First(camera, ray, &hit)) continue;
      const bool against = hit.distance < kWellInFront * depth;
      if (!against && std::abs(hit.distance - depth) > kOnSurface * depth) continue;
      votes->Add({hit.point, ReachAt(camera, hit.point), hit.face, against});
    }
  }

  void AskGrid(int i, Votes* votes) const {
    ForGrid(i, [&](const Eigen::Vector2d& at, const RayHit* hit) {
      if (hit == nullptr) return;
      ++votes->rays[hit->face];
      if (Behind(views_[i].camera, at, hit->distance).has_value()) ++votes->rays_behind[hit->face];
    });
  }

  const TriangleMesh& mesh_;
  const MeshRays single_;
  std::vector<std::vector<int>> partners_;
  std::vector<SmallView> views_;
  std::vector<std::vector<const Eigen::Vector3d*>> points_of_;  // by view
};

// Facets with a vote against them that those around it bear out: within its reach at least kLeastAround are
// against, and kAgainstPerFor times as many as for.
std::vector<char> BorneOut(const Votes& votes, size_t facets) {
  std::vector<char> seed(facets, 0);
  for (const Vote& vote : votes.list) {
    if (!vote.against || votes.against[vote.facet] <= votes.in_favour[vote.facet]) continue;
    int against = 0;
    int in_favour = 0;
    for (const Vote& other : votes.list) {
      if ((other.at - vote.at).squaredNorm() > vote.reach * vote.reach) continue;
      ++(other.against ? against : in_favour);
    }
    if (against >= kLeastAround && against >= kAgainstPerFor * in_favour) seed[vote.facet] = 1;
  }
  return seed;
}

// Grows a patch from `seed` over facets that share an edge; `taken` are those of patches.
FreeSpacePatch Grow(const TriangleMesh& mesh, const Adjacency& vertex_faces, const Votes& votes,
                    int seed, std::vector<char>* taken) {
  const auto far_in_front = [&](int f) {
    return votes.against[f] > votes.in_favour[f] ||
           (votes.in_favour[f] == 0 && votes.rays[f] > 0 &&
            votes.rays_behind[f] >= kLeastBehindShare * votes.rays[f]);
  };
  struct Entry {
    int facet;
    int steps;  // over unknown facets
  };
  FreeSpacePatch patch;
  std::vector<Entry> queue = {{seed, 0}};
  (*taken)[seed] = 1;
  for (size_t k = 0; k < queue.size(); ++k) {
    const Entry at = queue[k];
    patch.facets.push_back(at.facet);
    patch.votes_against += votes.against[at.facet];
    patch.votes_for += votes.in_favour[at.facet];
    for (int c = 0; c < 3; ++c) {
      const int v = mesh.faces[at.facet][c];
      for (const int* g = vertex_faces.Begin(v); g != vertex_faces.End(v); ++g) {
        if ((*taken)[*g] != 0) continue;
        if (CommonVertices(mesh.faces[at.facet], mesh.faces[*g]) < 2) continue;
        const bool unknown = votes.rays[*g] == 0 && votes.in_favour[*g] == 0;
        const bool known = far_in_front(*g);
        if (!known && !(unknown && at.steps < kUnknownSteps)) continue;
        (*taken)[*g] = 1;
        queue.push_back({*g, known ? 0 : at.steps + 1});
      }
    }
  }
  std::sort(patch.facets.begin(), patch.facets.end());
  return patch;
}

// Adds the rest of a part of the mesh that is mostly a patch, where nothing speaks for the rest.
void TakeRests(const TriangleMesh& mesh, const Votes& votes, FreeSpace* free_space) {
  for (const std::vector<int>& part : ConnectedComponents(mesh)) {
    size_t taken = 0;
    bool rest_has_votes = false;
    for (const int f : part) {
      taken += free_space->facet[f];
      rest_has_votes |= free_space->facet[f] == 0 && votes.in_favour[f] > 0;
    }
    if (2 * taken <= part.size() || rest_has_votes) continue;
    for (FreeSpacePatch& patch : free_space->patches) {
      if (!std::binary_search(part.begin(), part.end(), patch.facets[0])) continue;
      for (const int f : part) {
        if (std::exchange(free_space->facet[f], 1) == 0) patch.facets.push_back(f);
      }
      std::sort(patch.facets.begin(), patch.facets.end());
    }
  }
}

}  // namespace

FreeSpace FindFreeSpace(const Scene& scene, const TriangleMesh& mesh,
                        const std::vector<CameraPair>& pairs) {
  FreeSpace result;
  result.facet.assign(mesh.faces.size(), 0);
  if (mesh.faces.empty()) return result;
  const FreeSpaceJury jury(scene, mesh, pairs);
  const Votes votes = jury.Ask();
  const Adjacency vertex_faces = VertexFaces(mesh);
  std::vector<char> taken(mesh.faces.size(), 0);
  const std::vector<char> seeds = BorneOut(votes, mesh.faces.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    if (taken[f] != 0 || seeds[f] == 0) continue;
    FreeSpacePatch patch = Grow(mesh, vertex_faces, votes, static_cast<int>(f), &taken);
    if (patch.votes_against < kLeastAgainst ||
        patch.votes_against < kAgainstPerFor * patch.votes_for) {
      continue;
    }
    for (const int facet : patch.facets) result.facet[facet] = 1;
    result.patches.push_back(std::move(patch));
  }
  if (result.patches.empty()) return result;
  TakeRests(mesh, votes, &result);
  std::vector<double> share(scene.views.size());
  ParallelFor(static_cast<int>(share.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) share[i] = jury.Share(i, result.facet);
  });
  for (size_t i = 0; i < share.size(); ++i) {
    if (share[i] > 0) result.hidden.push_back({scene.views[i].name, share[i]});
  }
  std::stable_sort(result.hidden.begin(), result.hidden.end(),
                   [](const HiddenView& a, const HiddenView& b) { return a.share > b.share; });
  return result;
}

}  // namespace burin
