#include "core/evaluate/evaluation.h"

#include <glog/logging.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>

#include "core/evaluate/match.h"
#include "core/mesh/surface_samples.h"
#include "core/support/error.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kFitSamples = 50000;
constexpr int kVertexGrain = 1024;

constexpr double kMatchingShare = 1.0 / 64;  // of the truth's diameter

// Over the points whose match is within `reach`.
DistanceStatistics StatisticsWithin(const MatchDistances& distances, bool to_plane, double reach) {
  std::vector<double> within = to_plane ? distances.plane : distances.point;
  for (size_t k = 0; k < within.size(); ++k) {
    if (distances.point[k] > reach) within[k] = -1;
  }
  return StatisticsOf(within);
}

// Share of the points closer than tau: of all, or of those that have a match.
double ShareCloser(const MatchDistances& distances, bool to_plane, double max_distance, double tau,
                   UnmatchedSamples unmatched) {
  const double reach = std::max(max_distance, tau);
  const std::vector<double>& scored = to_plane ? distances.plane : distances.point;
  std::int64_t closer = 0;
  std::int64_t matched = 0;
  for (size_t k = 0; k < scored.size(); ++k) {
    if (scored[k] < 0 || distances.point[k] > reach) continue;
    ++matched;
    if (scored[k] < tau) ++closer;
  }
  const auto of =
      unmatched == UnmatchedSamples::kCount ? static_cast<std::int64_t>(scored.size()) : matched;
  return of > 0 ? static_cast<double>(closer) / static_cast<double>(of) : 0;
}

std::optional<double> TurnedShare(const MatchDistances& distances, double reach) {
  std::int64_t matched = 0;
  std::int64_t turned = 0;
  for (size_t k = 0; k < distances.cosine.size(); ++k) {
    if (distances.point[k] < 0 || distances.point[k] > reach) continue;
    ++matched;
    if (distances.cosine[k] < 0) ++turned;
  }
  if (matched == 0) return std::nullopt;
  return static_cast<double>(turned) / static_cast<double>(matched);
}

void AddGroups(const MatchDistances& from_truth, const std::vector<char>& flags,
               const std::vector<double>& thresholds, bool to_plane, Evaluation* evaluation) {
  MatchDistances flagged;
  MatchDistances others;
  for (size_t k = 0; k < flags.size(); ++k) {
    MatchDistances& group = flags[k] != 0 ? flagged : others;
    group.point.push_back(from_truth.point[k]);
    group.plane.push_back(from_truth.plane[k]);
  }
  const double reach = evaluation->max_distance;
  evaluation->grouped = true;
  evaluation->flagged = StatisticsWithin(flagged, to_plane, reach);
  evaluation->others = StatisticsWithin(others, to_plane, reach);
  for (const double tau : thresholds) {
    evaluation->flagged_recall.push_back(
        ShareCloser(flagged, to_plane, reach, tau, UnmatchedSamples::kCount));
    evaluation->others_recall.push_back(
        ShareCloser(others, to_plane, reach, tau, UnmatchedSamples::kCount));
  }
}

SurfaceSamples SamplesOf(const TriangleMesh& mesh, int count, std::uint64_t seed,
                         const std::string& name) {
  SurfaceSamples samples = SampleSurface(mesh, count, seed);
  if (samples.points.empty()) {
    throw InputError("evaluation: the " + name + " has no surface (" +
                     std::to_string(mesh.faces.size()) + " faces, area 0)");
  }
  return samples;
}

// What lays mesh samples onto the truth; nothing moves where no alignment is asked for.
Alignment FitToTruth(const TriangleMesh& mesh, const MatchSide& truth, double max_distance,
                     const EvaluationOptions& options) {
  if (options.align == AlignmentKind::kNone) {
    Alignment none;
    none.converged = true;
    return none;
  }
  const bool by_cameras = options.align == AlignmentKind::kCameras;
  if (by_cameras && !options.truth_from_scene) {
    throw InputError("align = cameras: needs the mesh's cameras and those of the truth");
  }
  const Similarity start = options.truth_from_scene.value_or(Similarity());
  const double reach = 0.5 * max_distance;
  const SurfaceSamples samples =
      SamplesOf(by_cameras ? Moved(mesh, start) : mesh, std::min(kFitSamples, options.sample_count),
                static_cast<std::uint64_t>(options.seed) + 1, "mesh");
  const PlaneOf plane_of = [&](int index, const Eigen::Vector3d& point,
                               Eigen::Vector3d* counterpart, Eigen::Vector3d* normal) {
    const Match match = truth.Find(point, reach);
    *counterpart = match.point;
    // Without normals on the truth the mesh's own plane serves; a small motion hardly turns it.
    *normal = match.normal.isZero(0) ? samples.normals[index] : match.normal;
    return match.found;
  };
  AlignmentOptions fit;
  fit.scale = options.align != AlignmentKind::kRigid;
  fit.keep_fraction = options.fit_keep;
  fit.max_iterations = 50;
  fit.min_step = 1e-6;  // far below what the choice of samples changes
  Alignment alignment;
  std::string error;
  if (!AlignToSurface(samples.points, plane_of, fit, &alignment, &error)) {
    throw InputError("evaluation: " + error + " (it looks as far as half of max_distance, " +
                     std::to_string(reach) + " world units)");
  }
  if (by_cameras) alignment.motion = alignment.motion * start;
  return alignment;
}

// What the options and the kind of truth come to.
struct Protocol {
  Protocol(const Truth& truth, const EvaluationOptions& options) {
    CheckTruth(truth);
    thresholds = options.Thresholds();
    if (options.distance == DistanceKind::kPlane && !truth.HasNormals()) {
      throw InputError("distance = plane: the truth has no normals");
    }
    to_plane = options.distance == DistanceKind::kPlane ||
               (options.distance == DistanceKind::kAuto && truth.HasNormals() && !truth.IsMesh());
    max_distance = options.MatchingDistance(truth);
  }
  std::vector<double> thresholds;  // world units
  bool to_plane = false;
  double max_distance = 0;  // world units
};

}  // namespace

void EvaluationOptions::Describe(OptionSet* set) {
  set->Add("tau", &tau, "Distance thresholds of precision and recall, in unit, comma-separated");
  set->Add("unit", &unit, "Length of the unit of tau and of the report, in world units", 1e-12,
           1e12);
  set->Add("align", &align,
           "Motion of the mesh onto the truth before scoring; similarity: rigid and a scale; "
           "cameras: likewise, from where the "
           "cameras of --scene lie on those of --cameras");
  set->Add("distance", &distance,
           "Distance that is scored; auto is plane for clouds with normals, else point");
  set->Add("unmatched", &unmatched,
           "Whether mesh samples without a match count against the precision");
  set->Add(
      "max_distance", &max_distance,
      "Points further from the other surface are unmatched, in unit; 0 = a 64th of the truth's "
      "diameter",
      0, 1e12);
  set->Add("sample_count", &sample_count, "Points sampled on a mesh", 100, 100000000);
  set->Add("seed", &seed, "Of the sampling", 0, 1000000000);
  set->Add("fit_keep", &fit_keep, "Share of the point pairs that the alignment keeps", 0.1, 1);
}

std::vector<double> EvaluationOptions::Thresholds() const {
  std::vector<double> thresholds;
  for (size_t begin = 0; begin <= tau.size();) {
    const size_t end = std::min(tau.find(',', begin), tau.size());
    const std::string item = tau.substr(begin, end - begin);
    double number = 0;
    const auto parsed = std::from_chars(item.data(), item.data() + item.size(), number);
    if (parsed.ec != std::errc() || parsed.ptr != item.data() + item.size() ||
        !std::isfinite(number) || number <= 0) {
      throw InputError("tau = " + tau + ": must be positive numbers separated by commas");
    }
    thresholds.push_back(number * unit);
    begin = end + 1;
  }
  std::sort(thresholds.begin(), thresholds.end());
  thresholds.erase(std::unique(thresholds.begin(), thresholds.end()), thresholds.end());
  return thresholds;
}

double EvaluationOptions::MatchingDistance(const Truth& truth) const {
  if (max_distance > 0) return max_distance * unit;
  const double diameter = DiameterOf(truth);
  if (!(diameter > 0)) {
    throw InputError("evaluation: the truth has no extent; max_distance must be given");
  }
  return kMatchingShare * diameter;
}

Evaluation EvaluateMesh(const TriangleMesh& mesh, const Truth& truth,
                        const EvaluationOptions& options, const std::vector<char>& flags) {
  const Protocol protocol(truth, options);
  CHECK(flags.empty() || (!truth.IsMesh() && flags.size() == truth.cloud.points.size()));
  const std::vector<double>& thresholds = protocol.thresholds;
  const bool to_plane = protocol.to_plane;

  Evaluation evaluation;
  evaluation.vertex_count = static_cast<std::int64_t>(mesh.vertices.size());
  evaluation.face_count = static_cast<std::int64_t>(mesh.faces.size());
  evaluation.area = SurfaceArea(mesh);
  evaluation.shape = ShapeOf(mesh);
  if (truth.IsMesh()) evaluation.truth_area = SurfaceArea(truth.mesh);
  evaluation.truth_is_mesh = truth.IsMesh();
  evaluation.distance = to_plane ? DistanceKind::kPlane : DistanceKind::kPoint;
  evaluation.unmatched = options.unmatched;
  evaluation.unit = options.unit;
  evaluation.max_distance = protocol.max_distance;
  evaluation.align = options.align;
  if (truth.HasNormals() && !truth.IsMesh()) {
    evaluation.zero_normals =
        std::count_if(truth.cloud.normals.begin(), truth.cloud.normals.end(),
                      [](const Eigen::Vector3d& normal) { return normal.isZero(0); });
  }

  const auto seed = static_cast<std::uint64_t>(options.seed);
  const SurfaceSamples samples = SamplesOf(mesh, options.sample_count, seed, "mesh");
  const MatchSide truth_side(truth);
  const Alignment fit = FitToTruth(mesh, truth_side, evaluation.max_distance, options);
  evaluation.truth_from_mesh = fit.motion;
  evaluation.fit_converged = fit.converged;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : samples.points) centre += point;
  centre /= static_cast<double>(samples.points.size());
  evaluation.fit_shift = (fit.motion * centre - centre).norm();
  const TriangleMesh moved = Moved(mesh, fit.motion);
  const MatchSide mesh_side(moved);

  // The thresholds may be beyond what the statistics are within.
  const double furthest = std::max(evaluation.max_distance, thresholds.back());
  const MatchDistances from_mesh =
      MeasureDistances(samples.points, evaluation.truth_from_mesh, truth_side, furthest,
                       truth.HasNormals() ? &samples.normals : nullptr);
  std::vector<Eigen::Vector3d> truth_samples;
  if (truth.IsMesh()) {
    truth_samples = SamplesOf(truth.mesh, options.sample_count, seed, "truth").points;
  }
  const MatchDistances from_truth = MeasureDistances(
      truth.IsMesh() ? truth_samples : truth.cloud.points, Similarity(), mesh_side, furthest);

  const double reach = evaluation.max_distance;
  evaluation.accuracy = StatisticsWithin(from_mesh, to_plane, reach);
  evaluation.completeness = StatisticsWithin(from_truth, to_plane, reach);
  if (truth.HasNormals()) {
    evaluation.turned = TurnedShare(from_mesh, reach);
    evaluation.other_distance = to_plane ? DistanceKind::kPoint : DistanceKind::kPlane;
    evaluation.other_accuracy = StatisticsWithin(from_mesh, !to_plane, reach);
    evaluation.other_completeness = StatisticsWithin(from_truth, !to_plane, reach);
  }
  for (const double tau : thresholds) {
    ThresholdScore score;
    score.tau = tau;
    score.precision = ShareCloser(from_mesh, to_plane, reach, tau, options.unmatched);
    score.recall = ShareCloser(from_truth, to_plane, reach, tau, UnmatchedSamples::kCount);
    const double sum = score.precision + score.recall;
    score.f1 = sum > 0 ? 2 * score.precision * score.recall / sum : 0;
    evaluation.scores.push_back(score);
  }
  if (!flags.empty()) AddGroups(from_truth, flags, thresholds, to_plane, &evaluation);
  return evaluation;
}

Similarity TruthFromMesh(const TriangleMesh& mesh, const Truth& truth,
                         const EvaluationOptions& options) {
  if (options.align == AlignmentKind::kNone) return {};  // without a search structure
  CheckTruth(truth);
  return FitToTruth(mesh, MatchSide(truth), options.MatchingDistance(truth), options).motion;
}

struct AccuracyMeter::Data {
  Data(const Truth& truth, const EvaluationOptions& o)
      : options(o), protocol(truth, o), side(truth) {}
  EvaluationOptions options;
  Protocol protocol;
  MatchSide side;
};

AccuracyMeter::AccuracyMeter(const Truth& truth, const EvaluationOptions& options)
    : data_(std::make_unique<Data>(truth, options)) {}

AccuracyMeter::~AccuracyMeter() = default;

DistanceStatistics AccuracyMeter::Measure(const TriangleMesh& mesh) const {
  const EvaluationOptions& options = data_->options;
  const double max_distance = data_->protocol.max_distance;
  const SurfaceSamples samples =
      SamplesOf(mesh, options.sample_count, static_cast<std::uint64_t>(options.seed), "mesh");
  const Similarity truth_from_mesh = FitToTruth(mesh, data_->side, max_distance, options).motion;
  const MatchDistances distances =
      MeasureDistances(samples.points, truth_from_mesh, data_->side, max_distance);
  return StatisticsOf(data_->protocol.to_plane ? distances.plane : distances.point);
}

double RmseToTruthMesh(const TriangleMesh& mesh, const TriangleMesh& truth, int sample_count) {
  if (!(SurfaceArea(truth) > 0)) throw InputError("evaluation: the truth has no surface");
  const SurfaceSamples samples = SamplesOf(mesh, sample_count, 0, "mesh");
  return StatisticsOf(MeasureDistances(samples.points, Similarity(), MatchSide(truth),
                                       std::numeric_limits<double>::infinity())
                          .point)
      .rmse;
}

std::vector<double> VertexErrors(const TriangleMesh& mesh, const Truth& truth,
                                 double max_distance) {
  CheckTruth(truth);
  const MatchSide side(truth);
  std::vector<double> errors(mesh.vertices.size());
  ParallelFor(static_cast<int>(errors.size()), kVertexGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const Match match = side.Find(mesh.vertices[v], max_distance);
      errors[v] = match.found ? match.signed_distance : std::numeric_limits<double>::quiet_NaN();
    }
  });
  return errors;
}

}  // namespace burin
