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

double ShareWithin(const std::vector<double>& distances, double tau, std::int64_t of) {
  const auto within = std::count_if(distances.begin(), distances.end(),
                                    [&](double d) { return d >= 0 && d < tau; });
  return of > 0 ? static_cast<double>(within) / static_cast<double>(of) : 0;
}

void AddGroups(const std::vector<double>& from_truth, const std::vector<char>& flags,
               const std::vector<double>& thresholds, Evaluation* evaluation) {
  std::vector<double> flagged;
  std::vector<double> others;
  for (size_t k = 0; k < from_truth.size(); ++k) {
    (flags[k] != 0 ? flagged : others).push_back(from_truth[k]);
  }
  evaluation->grouped = true;
  evaluation->flagged = StatisticsOf(flagged);
  evaluation->others = StatisticsOf(others);
  for (const double tau : thresholds) {
    evaluation->flagged_recall.push_back(ShareWithin(flagged, tau, evaluation->flagged.count));
    evaluation->others_recall.push_back(ShareWithin(others, tau, evaluation->others.count));
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
Alignment FitToTruth(const TriangleMesh& mesh, const MatchSide& truth,
                     const EvaluationOptions& options) {
  if (options.align == AlignmentKind::kNone) {
    Alignment none;
    none.converged = true;
    return none;
  }
  const double reach = 0.5 * options.MatchingDistance();
  const SurfaceSamples samples = SamplesOf(mesh, std::min(kFitSamples, options.sample_count),
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
  fit.scale = options.align == AlignmentKind::kSimilarity;
  fit.keep_fraction = options.fit_keep;
  fit.max_iterations = 50;
  fit.min_step = 1e-6;  // far below what the choice of samples changes
  Alignment alignment;
  std::string error;
  if (!AlignToSurface(samples.points, plane_of, fit, &alignment, &error)) {
    throw InputError("evaluation: " + error + " (max_distance = " + std::to_string(reach) +
                     " world units)");
  }
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
    max_distance = options.MatchingDistance();
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
           "Motion of the mesh onto the truth before scoring; similarity: rigid and a scale");
  set->Add("distance", &distance,
           "Distance that is scored; auto is plane for clouds with normals, else point");
  set->Add("unmatched", &unmatched,
           "Whether mesh samples without a match count against the precision");
  set->Add("max_distance", &max_distance,
           "Points further from the other surface are unmatched, in unit; 0 = 10 x the largest tau",
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

double EvaluationOptions::MatchingDistance() const {
  return max_distance > 0 ? max_distance * unit : 10 * Thresholds().back();
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
  evaluation.truth_is_mesh = truth.IsMesh();
  evaluation.distance = to_plane ? DistanceKind::kPlane : DistanceKind::kPoint;
  evaluation.unmatched = options.unmatched;
  evaluation.unit = options.unit;
  evaluation.max_distance = protocol.max_distance;
  evaluation.align = options.align;

  const auto seed = static_cast<std::uint64_t>(options.seed);
  const SurfaceSamples samples = SamplesOf(mesh, options.sample_count, seed, "mesh");
  const MatchSide truth_side(truth);
  const Alignment fit = FitToTruth(mesh, truth_side, options);
  evaluation.truth_from_mesh = fit.motion;
  evaluation.fit_converged = fit.converged;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : samples.points) centre += point;
  centre /= static_cast<double>(samples.points.size());
  evaluation.fit_shift = (fit.motion * centre - centre).norm();
  const TriangleMesh moved = Moved(mesh, fit.motion);
  const MatchSide mesh_side(moved);

  const MatchDistances from_mesh = MeasureDistances(samples.points, evaluation.truth_from_mesh,
                                                    truth_side, evaluation.max_distance);
  std::vector<Eigen::Vector3d> truth_samples;
  if (truth.IsMesh()) {
    truth_samples = SamplesOf(truth.mesh, options.sample_count, seed, "truth").points;
  }
  const MatchDistances from_truth =
      MeasureDistances(truth.IsMesh() ? truth_samples : truth.cloud.points, Similarity(), mesh_side,
                       evaluation.max_distance);

  const std::vector<double>& accuracy = to_plane ? from_mesh.plane : from_mesh.point;
  const std::vector<double>& completeness = to_plane ? from_truth.plane : from_truth.point;
  evaluation.accuracy = StatisticsOf(accuracy);
  evaluation.completeness = StatisticsOf(completeness);
  if (truth.HasNormals()) {
    evaluation.other_distance = to_plane ? DistanceKind::kPoint : DistanceKind::kPlane;
    evaluation.other_accuracy = StatisticsOf(to_plane ? from_mesh.point : from_mesh.plane);
    evaluation.other_completeness = StatisticsOf(to_plane ? from_truth.point : from_truth.plane);
  }
  for (const double tau : thresholds) {
    ThresholdScore score;
    score.tau = tau;
    score.precision =
        ShareWithin(accuracy, tau,
                    options.unmatched == UnmatchedSamples::kDrop ? evaluation.accuracy.matched
                                                                 : evaluation.accuracy.count);
    score.recall = ShareWithin(completeness, tau, evaluation.completeness.count);
    const double sum = score.precision + score.recall;
    score.f1 = sum > 0 ? 2 * score.precision * score.recall / sum : 0;
    evaluation.scores.push_back(score);
  }
  if (!flags.empty()) AddGroups(completeness, flags, thresholds, &evaluation);
  return evaluation;
}

Similarity TruthFromMesh(const TriangleMesh& mesh, const Truth& truth,
                         const EvaluationOptions& options) {
  if (options.align == AlignmentKind::kNone) return {};  // without a search structure
  CheckTruth(truth);
  return FitToTruth(mesh, MatchSide(truth), options).motion;
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
  const Similarity truth_from_mesh = FitToTruth(mesh, data_->side, options).motion;
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

TriangleMesh Moved(const TriangleMesh& mesh, const Similarity& motion) {
  TriangleMesh moved = mesh;
  for (Eigen::Vector3d& vertex : moved.vertices) vertex = motion * vertex;
  return moved;
}

}  // namespace burin
