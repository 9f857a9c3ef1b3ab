#include "core/refine/crossing_guard.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>

namespace burin {
namespace {

constexpr int kHalvings = 3;  // before displacements are taken back whole
constexpr int kTurns = 8;
constexpr int kRings = 1;  // around the facets, taken back with them
constexpr int kNear = 6;   // edges

// Which facets lie near each other on the surface.
class SurfaceDistance {
 public:
  SurfaceDistance(const RoundContext& context, const TriangleMesh& mesh)
      : context_(context), mesh_(mesh), reached_(mesh.vertices.size(), 0) {}

  // At most kNear edges lie between them. Quick for the same `from` again.
  bool Near(int from, int to) {
    if (from != from_) Reach(from);
    const Eigen::Vector3i& face = mesh_.faces[to];
    return std::any_of(face.begin(), face.end(), [this](int v) { return reached_[v] == search_; });
  }

 private:
  void Reach(int from) {
    from_ = from;
    ++search_;
    list_.clear();
    const auto add = [this](int v) {
      if (reached_[v] == search_) return;
      reached_[v] = search_;
      list_.push_back(v);
    };
    for (const int v : mesh_.faces[from]) add(v);
    size_t next = 0;
    for (int ring = 0; ring < kNear; ++ring) {
      for (const size_t end = list_.size(); next < end; ++next) {
        const int v = list_[next];
        std::for_each(context_.neighbors.Begin(v), context_.neighbors.End(v), add);
      }
    }
  }

  const RoundContext& context_;
  const TriangleMesh& mesh_;
  int from_ = -1;
  int search_ = 0;
  std::vector<int> reached_;  // by vertex: the last search that came there
  std::vector<int> list_;
};

// Which pairs a round must not leave behind.
class NewPairs {
 public:
  NewPairs(const std::vector<FacetPair>& crossing, const std::vector<Eigen::Vector3d>& before,
           const RoundContext& context, const TriangleMesh& mesh)
      : before_(before),
        context_(context),
        mesh_(mesh),
        distance_(context, mesh),
        crossed_(mesh.faces.size(), 0) {
    for (const FacetPair& pair : crossing) crossed_[pair.first] = crossed_[pair.second] = 1;
  }

  std::vector<FacetPair> Of(const std::vector<FacetPair>& pairs) {
    std::vector<FacetPair> found;
    std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(found), [&](const FacetPair& pair) {
      if (crossed_[pair.first] != 0 || crossed_[pair.second] != 0) return false;
      if (!Opposed(pair)) return false;
      return !MayBeAFold(pair) || !distance_.Near(pair.first, pair.second);
    });
    return found;
  }

 private:
  bool Opposed(const FacetPair& pair) const {
    const auto normal = [this](int facet) {
      const Eigen::Vector3i& face = mesh_.faces[facet];
      const Eigen::Vector3d& corner = before_[face[0]];
      return (before_[face[1]] - corner).cross(before_[face[2]] - corner).eval();
    };
    return normal(pair.first).dot(normal(pair.second)) < 0;
  }

  // All of it is seen, or a part is on its way out of sight.
  bool MayBeAFold(const FacetPair& pair) const {
    bool seen = true;
    for (const int facet : {pair.first, pair.second}) {
      for (const int v : mesh_.faces[facet]) {
        if (context_.seen[v] != 0) continue;
        if (context_.moves[v] != 0) return true;
        seen = false;
      }
    }
    return seen;
  }

  const std::vector<Eigen::Vector3d>& before_;
  const RoundContext& context_;
  const TriangleMesh& mesh_;
  SurfaceDistance distance_;
  std::vector<char> crossed_;  // by facet, before the round
};

// The motion of a round, of which each vertex goes a share.
class PartialMotion {
 public:
  PartialMotion(const std::vector<Eigen::Vector3d>& before, const RoundContext& context,
                TriangleMesh* mesh)
      : before_(before),
        after_(mesh->vertices),
        context_(context),
        mesh_(mesh),
        share_(before.size(), 1),
        changed_(mesh->faces.size(), 0) {}

  // Multiplies the share of the vertices of `pairs` and around them.
  void Shorten(const std::vector<FacetPair>& pairs, double factor) {
    for (const int v : Around(pairs)) {
      share_[v] *= factor;
      mesh_->vertices[v] = before_[v] + share_[v] * (after_[v] - before_[v]);
      for (const int* f = context_.faces.Begin(v); f != context_.faces.End(v); ++f) {
        changed_[*f] = 1;
      }
    }
  }
  bool Changed(int facet) const { return changed_[facet] != 0; }
  std::vector<int> ChangedFacets() const {
    std::vector<int> facets;
    for (size_t f = 0; f < changed_.size(); ++f) {
      if (changed_[f] != 0) facets.push_back(static_cast<int>(f));
    }
    return facets;
  }
  int ShortenedVertices() const {
    int count = 0;
    for (size_t v = 0; v < after_.size(); ++v) count += mesh_->vertices[v] != after_[v] ? 1 : 0;
    return count;
  }

 private:
  std::vector<int> Around(const std::vector<FacetPair>& pairs) const {
    std::vector<char> in(before_.size(), 0);
    std::vector<int> list;
    const auto add = [&](int v) {
      if (in[v] == 0) list.push_back(v);
      in[v] = 1;
    };
    for (const FacetPair& pair : pairs) {
      for (const int facet : {pair.first, pair.second}) {
        for (const int v : mesh_->faces[facet]) add(v);
      }
    }
    size_t next = 0;
    for (int ring = 0; ring < kRings; ++ring) {
      for (const size_t end = list.size(); next < end; ++next) {
        const int v = list[next];
        std::for_each(context_.neighbors.Begin(v), context_.neighbors.End(v), add);
      }
    }
    return list;
  }

  const std::vector<Eigen::Vector3d>& before_;
  const std::vector<Eigen::Vector3d> after_;
  const RoundContext& context_;
  TriangleMesh* mesh_;
  std::vector<double> share_;  // by vertex
  std::vector<char> changed_;  // by facet: the share of a vertex is below 1
};

}  // namespace

CrossingReport CrossingGuard::EndRound(const std::vector<Eigen::Vector3d>& before,
                                       const RoundContext& context, bool take_back,
                                       TriangleMesh* mesh) {
  NewPairs new_pairs(pairs_, before, context, *mesh);
  const CrossingSearch search(mesh->faces, before, mesh->vertices);
  pairs_ = search.Find(mesh->vertices);
  std::vector<FacetPair> fresh = new_pairs.Of(pairs_);
  CrossingReport report;
  report.found = report.left = static_cast<int>(fresh.size());
  if (!take_back || fresh.empty()) return report;
  PartialMotion motion(before, context, mesh);
  for (int turn = 0; turn < kTurns && !fresh.empty(); ++turn) {
    motion.Shorten(fresh, turn < kHalvings ? 0.5 : 0);
    pairs_.erase(std::remove_if(pairs_.begin(), pairs_.end(),
                                [&](const FacetPair& pair) {
                                  return motion.Changed(pair.first) || motion.Changed(pair.second);
                                }),
                 pairs_.end());
    const std::vector<int> changed = motion.ChangedFacets();
    const std::vector<FacetPair> again = search.Find(mesh->vertices, &changed);
    pairs_.insert(pairs_.end(), again.begin(), again.end());
    fresh = new_pairs.Of(pairs_);
  }
  report.left = static_cast<int>(fresh.size());
  report.taken_back = motion.ShortenedVertices();
  return report;
}

}  // namespace burin
