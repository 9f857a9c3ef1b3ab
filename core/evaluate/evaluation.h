// Scores a mesh against ground truth: how far the surface is from the truth (accuracy, precision)
// and how much of the truth it reaches (completeness, recall). One protocol for every comparison,
// said here in full, so that two scores of burin can be set side by side.
//
// Protocol
//  1. Points. The mesh is sampled area-uniformly (core/mesh/surface_samples.h), so its score does not
//     depend on how it is triangulated. A truth cloud is used point for point; a truth mesh is
//     sampled like the mesh. The truth should be evenly spaced, or dense parts weigh more.
//  2. Alignment, when asked for: trimmed point-to-plane ICP between the samples of this mesh and the
//     truth, rigid or with a scale (core/mesh/alignment.h), reach = half the matching distance. It starts
//     where the mesh is or, with `cameras`, where the similarity between two models of the same photographs
//     (core/evaluate/camera_evaluation.h) puts it, and has a scale then. The mesh is moved onto the truth, and
//     everything after it is measured in the truth's frame and units. It is fitted anew to each mesh, before and after a refinement alike.
//  3. Matching. The match of a point is its nearest point on the other side (exact on a mesh;
//     nearest point of a cloud). It counts when no further than the matching distance: `max_distance`,
//     or else a 64th of the truth's diameter (DiameterOf in core/evaluate/truth.h). That is a length of
//     the truth alone: neither the thresholds nor the mesh change what the statistics are over.
//  4. Distance between a point a and its match b:
//       point   |a - b|
//       plane   |n_b . (a - b)|, n_b the normal at the match: the cloud's, or that of the face.
//     `distance` says which is scored; `auto` takes plane for a cloud with normals and point
//     otherwise. The statistics of the other are reported beside it when the truth has normals.
//     With a cloud, |a - b| cannot fall below its spacing; the plane distance can. The price: beside
//     a border a point counts as near when it lies in the other surface's plane, up to the matching
//     distance. Where the match lies inside a face both distances are the same.
//  5. Accuracy and completeness statistics (mean, median, RMSE) are over matched points. The matched
//     share is reported beside them: whoever matches fewer points gets a better mean.
//  6. precision(tau) = share of the mesh's samples that are matched and closer than tau;
//     recall(tau) = share of the truth's points that are matched and closer than tau;
//     F1 = 2 P R / (P + R). Here a match counts up to tau where tau is beyond the matching distance. Recall is always over all of the truth. Precision is over all samples
//     too, so that nothing hides by being far off. `unmatched` = drop takes it over the matched
//     samples, for truths that show only part of what the mesh rightly has.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/evaluate/mesh_shape.h"
#include "core/evaluate/truth.h"
#include "core/mesh/alignment.h"
#include "core/mesh/mesh.h"
#include "core/scene/similarity.h"
#include "core/support/distance_statistics.h"
#include "core/support/options.h"

namespace burin {

// Choices in steps 2, 4 and 6 of the protocol.
enum class AlignmentKind { kNone, kRigid, kSimilarity, kCameras };
inline Choices<AlignmentKind> ChoicesOf(AlignmentKind) {
  return {{AlignmentKind::kNone, "none"},
          {AlignmentKind::kRigid, "rigid"},
          {AlignmentKind::kSimilarity, "similarity"},
          {AlignmentKind::kCameras, "cameras"}};
}
enum class DistanceKind { kAuto, kPoint, kPlane };
inline Choices<DistanceKind> ChoicesOf(DistanceKind) {
  return {{DistanceKind::kAuto, "auto"},
          {DistanceKind::kPoint, "point"},
          {DistanceKind::kPlane, "plane"}};
}
enum class UnmatchedSamples { kCount, kDrop };
inline Choices<UnmatchedSamples> ChoicesOf(UnmatchedSamples) {
  return {{UnmatchedSamples::kCount, "count"}, {UnmatchedSamples::kDrop, "drop"}};
}

struct EvaluationOptions {
  std::string tau = "5,10,20";  // thresholds, in `unit`
  double unit = 0.001;  // of tau and of the report, world units (0.001: mm in a metre world)
  AlignmentKind align = AlignmentKind::kNone;
  DistanceKind distance = DistanceKind::kAuto;
  UnmatchedSamples unmatched = UnmatchedSamples::kCount;  // mesh samples, in the precision
  double max_distance = 0;    // matching distance in `unit`; 0 = a 64th of the truth's diameter
  int sample_count = 500000;  // on the mesh, and on the truth when it is one
  int seed = 0;
  double fit_keep = 0.7;  // share of the pairs that the alignment keeps
  // Where kCameras starts, CameraEvaluation::truth_from_scene; no option, as it is measured.
  std::optional<Similarity> truth_from_scene;

  void Describe(OptionSet* set);
  // The thresholds in world units, ascending. Throws InputError unless tau is a list of positive
  // numbers separated by commas.
  std::vector<double> Thresholds() const;
  // The matching distance in world units. Throws InputError when it is the truth's to say and the
  // truth is a single point or has no area.
  double MatchingDistance(const Truth& truth) const;
};

struct ThresholdScore {
  double tau = 0;  // world units
  double precision = 0;
  double recall = 0;
  double f1 = 0;
};

struct Evaluation {
  std::int64_t vertex_count = 0;
  std::int64_t face_count = 0;
  double area = 0;  // of the mesh, world units squared
  MeshShape shape;
  double truth_area = 0;  // of a truth that is a mesh
  // Share of the mesh's matched samples whose normal is more than 90 degrees off that of their match: surface that is turned
  // over or folded, which no distance sees. Nothing for a truth without normals, and without matched samples.
  std::optional<double> turned;
  bool truth_is_mesh = false;
  DistanceKind distance = DistanceKind::kPoint;  // as scored, not kAuto
  UnmatchedSamples unmatched = UnmatchedSamples::kCount;
  std::int64_t zero_normals = 0;  // of a truth with others: to those points the distance is |a - b|
  double unit = 1;                // for the report, world units
  double max_distance = 0;        // that the statistics below are within, world units
  DistanceStatistics accuracy;
  DistanceStatistics completeness;
  std::vector<ThresholdScore> scores;  // one per tau, ascending

  // The same points by the distance that is not scored; empty for a truth without normals.
  std::optional<DistanceKind> other_distance;
  DistanceStatistics other_accuracy;
  DistanceStatistics other_completeness;

  // With flags for the truth's points: completeness of those flagged and of the rest, and their
  // shares closer than each tau.
  bool grouped = false;
  DistanceStatistics flagged;
  DistanceStatistics others;
  std::vector<double> flagged_recall;
  std::vector<double> others_recall;

  AlignmentKind align = AlignmentKind::kNone;
  Similarity truth_from_mesh;  // identity without an alignment
  double fit_shift = 0;        // how far it moves the centre of the mesh's samples, world units
  bool fit_converged = true;
};

// The protocol above. Throws InputError when the mesh or the truth has nothing to measure, the
// options do not fit together (plane without normals), or the alignment finds no counterparts.
// Statistics of nothing are NaN. `flags`, one per point of a truth cloud (or empty), splits the completeness in two.
Evaluation EvaluateMesh(const TriangleMesh& mesh, const Truth& truth,
                        const EvaluationOptions& options = {}, const std::vector<char>& flags = {});

// The alignment of EvaluateMesh() alone; the identity where none is asked for. Throws InputError when
// there is nothing to align or it finds no counterparts.
Similarity TruthFromMesh(const TriangleMesh& mesh, const Truth& truth,
                         const EvaluationOptions& options);

// The accuracy of many meshes against one truth: keeps the truth's search structure. Measure() is
// EvaluateMesh(mesh, truth, options).accuracy.
class AccuracyMeter {
 public:
  // `truth` must outlive the meter. Throws InputError when it has nothing to measure or the options
  // do not fit together.
  AccuracyMeter(const Truth& truth, const EvaluationOptions& options);
  ~AccuracyMeter();
  // Throws InputError when the mesh has no area or the alignment finds no counterparts.
  DistanceStatistics Measure(const TriangleMesh& mesh) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

// Root mean square over area-uniform samples of `mesh` of the exact distance to `truth`, world
// units. Throws InputError when either has no area.
double RmseToTruthMesh(const TriangleMesh& mesh, const TriangleMesh& truth,
                       int sample_count = 200000);

// Signed distance of every vertex to the truth, world units, for pictures: positive on the side the
// truth's normals point to; for a cloud with normals the signed plane distance to its nearest
// point; for a cloud without, the unsigned distance. NaN where nothing is within max_distance.
// Where the mesh is to be aligned first, pass Moved(mesh, TruthFromMesh(...)).
std::vector<double> VertexErrors(const TriangleMesh& mesh, const Truth& truth,
                                 double max_distance = std::numeric_limits<double>::infinity());

}  // namespace burin
