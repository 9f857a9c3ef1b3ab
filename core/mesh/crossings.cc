#include "core/mesh/crossings.h"

#include <embree3/rtcore.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <tuple>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kFacetGrain = 4096;
// Of the product of the three lengths that a volume is made of.
constexpr double kRounding = 1e-12;

using Corners = Eigen::Matrix3d;  // a column each

Corners CornersOf(const std::vector<Eigen::Vector3d>& vertices, const Eigen::Vector3i& face) {
  Corners corners;
  for (int c = 0; c < 3; ++c) corners.col(c) = vertices[face[c]];
  return corners;
}

// 1 in front of the plane of `of`, -1 behind it, 0 within rounding of it; by column of `points`.
Eigen::Vector3i Sides(const Corners& of, const Corners& points) {
  const Eigen::Vector3d u = of.col(1) - of.col(0);
  const Eigen::Vector3d v = of.col(2) - of.col(0);
  const Eigen::Vector3d normal = u.cross(v);
  const double area = kRounding * std::sqrt(u.squaredNorm() * v.squaredNorm());
  Eigen::Vector3i sides;
  for (int c = 0; c < 3; ++c) {
    const Eigen::Vector3d d = points.col(c) - of.col(0);
    const double height = normal.dot(d);
    const double bound = area * d.norm();
    sides[c] = static_cast<int>(height > bound) - static_cast<int>(height < -bound);
  }
  return sides;
}

// The line from p to q passes through a point of `of`, whose plane it crosses.
bool LineMeets(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Corners& of) {
  const Eigen::Vector3d d = q - p;
  bool left = false;
  bool right = false;
  for (int c = 0; c < 3; ++c) {
    const Eigen::Vector3d a = of.col(c) - p;
    const Eigen::Vector3d b = of.col((c + 1) % 3) - p;
    const double volume = d.dot(a.cross(b));
    const double bound = kRounding * std::sqrt(d.squaredNorm() * a.squaredNorm() * b.squaredNorm());
    left |= volume > bound;
    right |= volume < -bound;
  }
  return !(left && right);
}

bool EdgesPass(const Corners& edges, const Eigen::Vector3i& sides, const Corners& of) {
  for (int c = 0; c < 3; ++c) {
    const int next = (c + 1) % 3;
    if (sides[c] * sides[next] < 0 && LineMeets(edges.col(c), edges.col(next), of)) return true;
  }
  return false;
}

bool OnOneSide(const Eigen::Vector3i& sides) {
  return sides.minCoeff() >= 0 || sides.maxCoeff() <= 0;
}

Eigen::AlignedBox3f BoxOf(const Eigen::Vector3i& face, const std::vector<Eigen::Vector3d>& from,
                          const std::vector<Eigen::Vector3d>& to) {
  Eigen::AlignedBox3d box;
  for (int c = 0; c < 3; ++c) {
    box.extend(from[face[c]]);
    box.extend(to[face[c]]);
  }
  constexpr float kFar = std::numeric_limits<float>::infinity();
  Eigen::AlignedBox3f rounded;
  for (int axis = 0; axis < 3; ++axis) {
    rounded.min()[axis] = std::nextafter(static_cast<float>(box.min()[axis]), -kFar);
    rounded.max()[axis] = std::nextafter(static_cast<float>(box.max()[axis]), kFar);
  }
  return rounded;
}

// Collects the pairs that Embree hands over from any of its threads.
struct Collector {
  const std::vector<Eigen::Vector3i>& faces;
  const std::vector<Eigen::Vector3d>& vertices;
  const std::vector<int>* some;  // what the first scene has; null: all
  const std::vector<char>& in_some;
  std::mutex mutex;
  std::vector<FacetPair> found;
};

void Collect(void* user, RTCCollision* collisions, unsigned int count) {
  auto& collector = *static_cast<Collector*>(user);
  for (unsigned int k = 0; k < count; ++k) {
    auto a = static_cast<int>(collisions[k].primID0);
    const auto b = static_cast<int>(collisions[k].primID1);
    if (collector.some != nullptr) a = (*collector.some)[a];
    // Every pair of facets that both are in the first scene comes twice.
    const bool twice = collector.some == nullptr || collector.in_some[b] != 0;
    if (a == b || (twice && a > b)) continue;
    if (!FacetsCross(collector.vertices, collector.faces[a], collector.faces[b])) continue;
    const std::lock_guard<std::mutex> lock(collector.mutex);
    collector.found.push_back({std::min(a, b), std::max(a, b)});
  }
}

}  // namespace

bool FacetsCross(const std::vector<Eigen::Vector3d>& vertices, const Eigen::Vector3i& a,
                 const Eigen::Vector3i& b) {
  if (ShareVertex(a, b)) return false;
  const Corners first = CornersOf(vertices, a);
  const Corners second = CornersOf(vertices, b);
  const Eigen::Vector3i first_sides = Sides(second, first);
  if (OnOneSide(first_sides)) return false;
  const Eigen::Vector3i second_sides = Sides(first, second);
  if (OnOneSide(second_sides)) return false;
  return EdgesPass(first, first_sides, second) || EdgesPass(second, second_sides, first);
}

// Boxes in an Embree scene of their own.
class CrossingSearch::BoxTree {
 public:
  // Of `boxes`, or of some of them.
  explicit BoxTree(const std::vector<Eigen::AlignedBox3f>& boxes,
                   const std::vector<int>* some = nullptr)
      : boxes_(boxes), some_(some), device_(rtcNewDevice(nullptr)) {
    CHECK(device_ != nullptr) << "Embree error " << rtcGetDeviceError(nullptr);
    scene_ = rtcNewScene(device_);
    // A tree is asked once or a few times: building it takes most of the time.
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_LOW);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(
        geometry, static_cast<unsigned>(some != nullptr ? some->size() : boxes.size()));
    rtcSetGeometryUserData(geometry, this);
    rtcSetGeometryBoundsFunction(geometry, Bounds, nullptr);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    ParallelFor(1, 1, [this](int, int) { rtcCommitScene(scene_); });
  }
  ~BoxTree() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  BoxTree(const BoxTree&) = delete;
  BoxTree& operator=(const BoxTree&) = delete;

  RTCScene scene() const { return scene_; }

 private:
  static void Bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto& tree = *static_cast<const BoxTree*>(arguments->geometryUserPtr);
    const auto k = static_cast<int>(arguments->primID);
    const Eigen::AlignedBox3f& box = tree.boxes_[tree.some_ != nullptr ? (*tree.some_)[k] : k];
    RTCBounds& bounds = *arguments->bounds_o;
    bounds.lower_x = box.min().x();
    bounds.lower_y = box.min().y();
    bounds.lower_z = box.min().z();
    bounds.upper_x = box.max().x();
    bounds.upper_y = box.max().y();
    bounds.upper_z = box.max().z();
  }

  const std::vector<Eigen::AlignedBox3f>& boxes_;
  const std::vector<int>* some_;
  RTCDevice device_;
  RTCScene scene_ = nullptr;
};

CrossingSearch::CrossingSearch(const std::vector<Eigen::Vector3i>& faces,
                               const std::vector<Eigen::Vector3d>& from,
                               const std::vector<Eigen::Vector3d>& to)
    : faces_(faces), boxes_(faces.size()) {
  CHECK_EQ(from.size(), to.size());
  const auto vertex_count = static_cast<int>(from.size());
  for (const Eigen::Vector3i& face : faces) {
    CHECK(face.minCoeff() >= 0 && face.maxCoeff() < vertex_count) << "face index out of range";
  }
  ParallelFor(static_cast<int>(faces.size()), kFacetGrain, [&](int begin, int end) {
    for (int f = begin; f < end; ++f) boxes_[f] = BoxOf(faces[f], from, to);
  });
  tree_ = std::make_unique<BoxTree>(boxes_);
}

CrossingSearch::~CrossingSearch() = default;

std::vector<FacetPair> CrossingSearch::Find(const std::vector<Eigen::Vector3d>& now,
                                            const std::vector<int>* some) const {
  std::vector<char> in_some;
  std::unique_ptr<BoxTree> part;
  if (some != nullptr) {
    in_some.assign(faces_.size(), 0);
    for (const int f : *some) in_some[f] = 1;
    part = std::make_unique<BoxTree>(boxes_, some);
  }
  Collector collector{faces_, now, some, in_some, {}, {}};
  const RTCScene first = some != nullptr ? part->scene() : tree_->scene();
  // Embree searches in the threads of whoever calls it: those of the run.
  ParallelFor(1, 1, [&](int, int) { rtcCollide(first, tree_->scene(), Collect, &collector); });
  std::sort(collector.found.begin(), collector.found.end(),
            [](const FacetPair& a, const FacetPair& b) {
              return std::tie(a.first, a.second) < std::tie(b.first, b.second);
            });
  return std::move(collector.found);
}

std::vector<FacetPair> CrossingFacets(const TriangleMesh& mesh) {
  return CrossingSearch(mesh.faces, mesh.vertices, mesh.vertices).Find(mesh.vertices);
}

int CountFacets(const std::vector<FacetPair>& pairs) {
  std::vector<int> facets;
  for (const FacetPair& pair : pairs) facets.insert(facets.end(), {pair.first, pair.second});
  std::sort(facets.begin(), facets.end());
  return static_cast<int>(std::unique(facets.begin(), facets.end()) - facets.begin());
}

}  // namespace burin
