#include "core/synthetic/synthetic.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <utility>

#include "core/image/noise.h"
#include "core/support/counter_random.h"
#include "core/support/error.h"
#include "core/support/parallel.h"
#include "core/synthetic/synthetic_layout.h"
#include "core/synthetic/synthetic_shapes.h"
#include "core/synthetic/synthetic_stress.h"
#include "core/visibility/ray_render.h"

namespace burin {
namespace {

constexpr double kOffsetPerGain = 40;    // grey levels of exposure offset per unit of gain spread
constexpr double kTrackDropOut = 0.1;    // a view that sees a sparse point misses it this often
constexpr int kCandidatesPerPoint = 12;  // pixels tried for each sparse point wanted
constexpr std::uint64_t kMaxPerPoint = 16;  // counters set aside for one point

enum Stream : std::uint64_t {
  kPoseStream = 50,
  kIntrinsicsStream,
  kTrackStream,
  kTextureStream = 100,
  kExposureStream,
  kInitStream,
  kPointStream,
  kTruthStream,
  kSensorStream,  // + view; the last one
};

CounterRandom Random(const SyntheticOptions& options, std::uint64_t stream) {
  return {static_cast<std::uint64_t>(options.seed), stream};
}

// What a sensor makes of the light: exposure, noise, 8 bits.
cv::Mat Exposed(const cv::Mat1f& radiance, double gain, double offset, double noise_sigma,
                const CounterRandom& random) {
  cv::Mat1b image(radiance.size());
  ParallelFor(image.rows, 16, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int col = 0; col < image.cols; ++col) {
        const auto pixel = static_cast<std::uint64_t>(row) * image.cols + col;
        const double noise = noise_sigma > 0 ? noise_sigma * random.Normal(pixel) : 0;
        const double level = gain * radiance(row, col) + offset + noise;
        image(row, col) =
            static_cast<unsigned char>(std::clamp(std::floor(level + 0.5), 0.0, 255.0));
      }
    }
  });
  return image;
}

void RenderViews(const SyntheticLayout& layout, const MeshRays& rays, SyntheticScene* synthetic) {
  const SyntheticOptions& options = synthetic->options;
  const StoneTexture texture(Random(options, kTextureStream).Bits(0),
                             options.texture_px * layout.footprint);
  const Stress stress(options.stress, layout.footprint);
  const std::vector<Eigen::Vector3d> vertex_normals =
      VertexNormals(layout.truth, VertexFaces(layout.truth));
  const Eigen::Vector3d light = Eigen::Vector3d(-0.5, 0.6, 0.8).normalized();
  const SurfaceShader shader = [&](const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
    // Half of the light comes from all around, so that no side is black.
    const double lambert = 0.5 + 0.5 * std::max(0.0, normal.dot(light));
    return stress.Albedo(texture, point) * (1 - options.shading + options.shading * lambert);
  };
  const CounterRandom exposure = Random(options, kExposureStream);
  const CounterRandom pose = Random(options, kPoseStream);
  const CounterRandom intrinsics = Random(options, kIntrinsicsStream);
  for (size_t v = 0; v < layout.cameras.size(); ++v) {
    View view;
    char name[32];
    std::snprintf(name, sizeof(name), "view_%03d.png", static_cast<int>(v));
    view.name = name;
    view.camera = layout.cameras[v];
    cv::Mat1f radiance = RenderView(rays, vertex_normals, view.camera, shader, layout.background,
                                    options.samples_per_axis);
    const double gain = std::max(0.2, 1 + options.exposure_spread * exposure.Normal(2 * v));
    const double offset = kOffsetPerGain * options.exposure_spread * exposure.Normal(2 * v + 1);
    const auto count = static_cast<int>(layout.cameras.size());
    const auto index = static_cast<int>(v);
    stress.ChangeRadiance(index, count, texture, &radiance);
    const Exposure used = stress.ExposureOf(index, {gain, offset});
    view.gray = Exposed(radiance, used.gain, used.offset, options.noise_sigma,
                        Random(options, kSensorStream + v));
    view.camera =
        WithIntrinsicsNoise(WithPoseNoise(stress.Calibration(index, count, layout.cameras[v]),
                                          options.pose_noise_px, pose, index),
                            options.focal_noise, options.principal_point_noise_px, intrinsics,
                            options.one_camera ? 0 : index);
    if (options.one_camera) view.origin.camera_id = 1;
    synthetic->scene.views.push_back(std::move(view));
    synthetic->depth.push_back(RenderDepth(rays, layout.cameras[v]));
  }
}

std::vector<int> ViewsThatSee(const MeshRays& rays, const std::vector<Camera>& cameras,
                              const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
  std::vector<int> views;
  for (size_t v = 0; v < cameras.size(); ++v) {
    if (rays.Sees(cameras[v], point, normal)) views.push_back(static_cast<int>(v));
  }
  return views;
}

// Surface points behind random pixels of random views, with the views that see them and where the photographs
// show them.
void AddSparsePoints(const SyntheticLayout& layout, const MeshRays& rays,
                     SyntheticScene* synthetic) {
  const SyntheticOptions& options = synthetic->options;
  const CounterRandom random = Random(options, kPointStream);
  const int view_count = static_cast<int>(layout.cameras.size());
  const std::uint64_t counters = kMaxPerPoint + view_count;
  std::vector<ScenePoint> candidates(static_cast<size_t>(options.point_count) *
                                     kCandidatesPerPoint);
  std::vector<Eigen::Vector3d> on_surface(candidates.size());
  ParallelFor(static_cast<int>(candidates.size()), 64, [&](int begin, int end) {
    RayHit hit;
    for (int c = begin; c < end; ++c) {
      const std::uint64_t first = c * counters;
      const Camera& camera = layout.cameras[static_cast<int>(random.Uniform(first) * view_count)];
      const double x = random.Uniform(first + 1) * camera.width;
      const double y = random.Uniform(first + 2) * camera.height;
      const Eigen::Vector3d center = camera.Center();
      if (!rays.Intersect(center, camera.Ray(x, y), &hit)) continue;
      const Eigen::Vector3d normal = FaceAreaNormal(layout.truth, hit.face);
      for (const int view : ViewsThatSee(rays, layout.cameras, hit.point, normal)) {
        if (random.Uniform(first + kMaxPerPoint + view) >= kTrackDropOut) {
          candidates[c].views.push_back(view);
        }
      }
      on_surface[c] = hit.point;
      const double sigma = options.point_noise_px * layout.footprint;
      // Normal(k) uses uniform numbers 2k and 2k+1: start beyond those taken above.
      const std::uint64_t deviates =
          candidates.size() * counters + 3 * static_cast<std::uint64_t>(c);
      candidates[c].position =
          hit.point + sigma * Eigen::Vector3d(random.Normal(deviates), random.Normal(deviates + 1),
                                              random.Normal(deviates + 2));
    }
  });
  const CounterRandom track = Random(options, kTrackStream);
  std::uint64_t measured = 0;
  for (size_t c = 0; c < candidates.size(); ++c) {
    if (static_cast<int>(synthetic->scene.points.size()) == options.point_count) break;
    if (candidates[c].views.size() < 2) continue;
    synthetic->scene.tracks.BeginPoint();
    for (const int view : candidates[c].views) {
      Eigen::Vector2d at = layout.cameras[view].Project(on_surface[c]);
      for (int k = 0; k < 2; ++k) at[k] += options.track_noise_px * track.Normal(measured++);
      synthetic->scene.tracks.Add({at, view});
    }
    synthetic->scene.points.push_back(std::move(candidates[c]));
  }
}

// Points spread evenly by area over the truth, without those that fewer than two views see.
void AddTruthPoints(const SyntheticLayout& layout, const MeshRays& rays,
                    SyntheticScene* synthetic) {
  const SyntheticOptions& options = synthetic->options;
  const CounterRandom random = Random(options, kTruthStream);
  const int face_count = static_cast<int>(layout.truth.faces.size());
  std::vector<double> area_before(face_count + 1, 0);
  for (int f = 0; f < face_count; ++f) {
    area_before[f + 1] = area_before[f] + FaceAreaNormal(layout.truth, f).norm() / 2;
  }
  // One point per squared footprint is all that the images can tell apart.
  const double pixels = area_before[face_count] / (layout.footprint * layout.footprint);
  const int count = static_cast<int>(std::min<double>(options.truth_point_count, pixels));
  std::vector<Eigen::Vector3d> points(count);
  std::vector<Eigen::Vector3d> normals(count, Eigen::Vector3d::Zero());
  ParallelFor(count, 256, [&](int begin, int end) {
    for (int p = begin; p < end; ++p) {
      // One point in each of `count` equal strata of the area.
      const double area =
          (p + random.Uniform(3 * static_cast<std::uint64_t>(p))) / count * area_before[face_count];
      const auto above = std::upper_bound(area_before.begin(), area_before.end(), area);
      const int f =
          std::clamp(static_cast<int>(above - area_before.begin()) - 1, 0, face_count - 1);
      const double root = std::sqrt(random.Uniform(3 * static_cast<std::uint64_t>(p) + 1));
      const double along = random.Uniform(3 * static_cast<std::uint64_t>(p) + 2);
      const Eigen::Vector3i& face = layout.truth.faces[f];
      points[p] = (1 - root) * layout.truth.vertices[face[0]] +
                  root * (1 - along) * layout.truth.vertices[face[1]] +
                  root * along * layout.truth.vertices[face[2]];
      const Eigen::Vector3d normal = FaceAreaNormal(layout.truth, f).normalized();
      if (ViewsThatSee(rays, layout.cameras, points[p], normal).size() >= 2) normals[p] = normal;
    }
  });
  for (int p = 0; p < count; ++p) {
    if (normals[p].isZero()) continue;
    synthetic->truth_points.push_back(points[p]);
    synthetic->truth_normals.push_back(normals[p]);
  }
}

SyntheticLayout MakeLayout(const SyntheticOptions& options, const TriangleMesh& scan) {
  switch (options.scene) {
    case SyntheticKind::kRelief:
      return ReliefLayout(options);
    case SyntheticKind::kOccluders:
      return OccludersLayout(options);
    case SyntheticKind::kScan:
      return ScanLayout(options, scan);
    case SyntheticKind::kRods:
      return RodsLayout(options);
    case SyntheticKind::kPlates:
      return PlatesLayout(options);
    case SyntheticKind::kMembrane:
      return MembraneLayout(options);
    case SyntheticKind::kSky:
      return SkyLayout(options);
    case SyntheticKind::kBoulder:
      return BoulderLayout(options);
  }
  throw InputError("synth.scene: no such scene");
}

}  // namespace

void SyntheticOptions::Describe(OptionSet* set) {
  set->Add("synth.scene", &scene, "what is photographed");
  set->Add("synth.mesh_path", &mesh_path, "mesh file of the scene \"scan\"");
  set->Add("synth.scan_up", &scan_up, "axis of the scan that points up");
  set->Add("synth.seed", &seed, "seed of everything random", 0, 2147483647);
  set->Add("synth.views", &views,
           "number of views; 0 = relief and membrane 7, occluders and sky 8, rods 9, plates 10, "
           "scan and boulder 24",
           0, 999);
  set->Add("synth.rig", &rig,
           "even: views evenly spaced at one distance; uneven: crowded, every third 1.7 times as "
           "far");
  set->Add("synth.width", &width, "image width in pixels", 16, 8192);
  set->Add("synth.height", &height, "image height in pixels", 16, 8192);
  set->Add("synth.samples_per_axis", &samples_per_axis, "rays per pixel along x and along y", 1,
           16);
  set->Add("synth.texture_px", &texture_px, "finest wavelength of the texture in pixels", 0.5,
           1000);
  set->Add("synth.shading", &shading, "share of the shading by a fixed light", 0, 1);
  set->Add("synth.relief_px", &relief_px, "RMS height of the fine relief in pixel footprints", 0,
           50);
  set->Add(
      "synth.gap_px", &gap_px,
      "gap between the plates of the scene \"plates\" and thickness of each, in pixel footprints",
      0.5, 100);
  set->Add("synth.noise_sigma", &noise_sigma, "sensor noise in grey levels", 0, 100);
  set->Add("synth.exposure_spread", &exposure_spread, "standard deviation of the views' gains", 0,
           0.5);
  set->Add("synth.stress", &stress, "what is wrong with the photographs");
  set->Add("synth.pose_noise_px", &pose_noise_px,
           "error of every view's pose as the scene gives it, standard deviation in pixels", 0,
           100);
  set->Add("synth.focal_noise", &focal_noise,
           "error of the focal length as the scene gives it, standard deviation as a share of it",
           0, 0.3);
  set->Add("synth.principal_point_noise_px", &principal_point_noise_px,
           "error of the principal point as the scene gives it, standard deviation of each "
           "coordinate in pixels",
           0, 1000);
  set->Add("synth.one_camera", &one_camera,
           "all views share one camera in the model, and one error of its focal length and "
           "principal point");
  set->Add("synth.init_edge_px", &init_edge_px,
           "edge length of the initial mesh in pixel footprints", 1, 1000);
  set->Add("synth.init_noise_px", &init_noise_px,
           "noise of the initial vertices along their normals in pixel footprints", 0, 50);
  set->Add("synth.point_count", &point_count, "sparse points", 0, 1000000);
  set->Add("synth.point_noise_px", &point_noise_px,
           "noise of the sparse points per coordinate in pixel footprints", 0, 50);
  set->Add("synth.track_noise_px", &track_noise_px,
           "noise of where the photographs show the sparse points, per coordinate in pixels", 0,
           50);
  set->Add("synth.truth_point_count", &truth_point_count,
           "truth points on the whole surface, before the unseen ones are dropped", 0, 100000000);
}

SyntheticScene MakeSyntheticScene(const SyntheticOptions& options, const TriangleMesh& scan) {
  SyntheticScene synthetic;
  synthetic.options = options;
  OptionSet set;
  synthetic.options.Describe(&set);
  std::string error;
  if (!set.IsValid(&error)) throw InputError(error);

  SyntheticLayout layout = MakeLayout(options, scan);
  synthetic.options.views = static_cast<int>(layout.cameras.size());
  synthetic.footprint = layout.footprint;
  synthetic.init = std::move(layout.init);
  PerturbAlongNormals(Random(options, kInitStream).Bits(0),
                      layout.init_noise_share * options.init_noise_px * layout.footprint,
                      &synthetic.init);
  {
    // Layouts stand around the origin. Another one would round another way: other bytes.
    const MeshRays rays(layout.truth, Eigen::Vector3d::Zero());
    RenderViews(layout, rays, &synthetic);
    AddSparsePoints(layout, rays, &synthetic);
    AddTruthPoints(layout, rays, &synthetic);
  }
  synthetic.truth = std::move(layout.truth);
  synthetic.true_cameras = std::move(layout.cameras);
  return synthetic;
}

}  // namespace burin
