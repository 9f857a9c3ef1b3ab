// Every option of the selection of camera pairs, and the values that the named methods give to options
// left at "the method's own".
#pragma once

#include <string>

#include "core/support/options.h"
#include "selection/coverage.h"
#include "selection/pair_survey.h"
#include "selection/pair_terms.h"

namespace burin {

// docs/camera_pairs.md says what each is.
enum class PairsMethod {
  kTuned,
  kPaper,
  kPaperStrict,
  kVu,
  kTola,
  kSparsePoints,
  kMeshParallax,
  kAll,
  kFile
};
inline Choices<PairsMethod> ChoicesOf(PairsMethod) {
  return {{PairsMethod::kTuned, "tuned"},
          {PairsMethod::kPaper, "paper"},
          {PairsMethod::kPaperStrict, "paper_strict"},
          {PairsMethod::kVu, "vu"},
          {PairsMethod::kTola, "tola"},
          {PairsMethod::kSparsePoints, "sparse_points"},
          {PairsMethod::kMeshParallax, "mesh_parallax"},
          {PairsMethod::kAll, "all"},
          {PairsMethod::kFile, "file"}};
}

// Of a place where the paper's print contradicts its text: which of the two. kPreset is the method's own.
enum class PaperReading { kPreset, kPrinted, kCorrected };
inline Choices<PaperReading> ChoicesOf(PaperReading) {
  return {{PaperReading::kPreset, "preset"},
          {PaperReading::kPrinted, "printed"},
          {PaperReading::kCorrected, "corrected"}};
}

struct PairsOptions {
  PairsMethod method = PairsMethod::kTuned;
  std::string file;  // of the method kFile
  int per_camera = 4;
  double min_parallax_deg = -1;  // -1 = the method's own
  double max_parallax_deg = -1;
  int survey_px = 128;
  int candidates = -1;      // 0 = all, -1 = by per_camera
  double min_overlap = -1;  // -1 = the method's own
  std::string terms = "OSPRC";
  double reference_parallax_deg = -1;  // -1 = the method's own
  double sigma_parallax_deg = -1;
  BpvOptions bpv;     // the other numbers in it
  SwapOptions swaps;  // the number in it
  PaperReading overlap_area = PaperReading::kPreset;
  PaperReading symmetry_term = PaperReading::kPreset;
  PaperReading symmetry_mean = PaperReading::kPreset;
  PaperReading resolution_term = PaperReading::kPreset;
  PaperReading energy_test = PaperReading::kPreset;
  PaperReading used_partners = PaperReading::kPreset;
  PaperReading swap_state = PaperReading::kPreset;
  PaperReading coverage_test = PaperReading::kPreset;
  PaperReading coverage_facets = PaperReading::kPreset;

  void Describe(OptionSet* set);

  // Throws InputError for values that do not fit together.
  void Check() const;
};

// A PairsOptions with every preset, -1 and letter replaced by what it stands for.
struct PairsRecipe {
  PairsMethod method = PairsMethod::kTuned;
  std::string file;
  int per_camera = 0;
  double min_parallax_deg = 0;  // methods by sparse points and mesh_parallax
  double max_parallax_deg = 0;
  double min_overlap = 0;  // least part of what view i sees of the mesh that j must share
  bool improve_coverage = false;
  int candidates = 0;  // partners of each view that are measured; 0 = all
  BpvOptions bpv;
  SwapOptions swaps;
  SurveyOptions survey;

  bool UsesSparsePoints() const {
    return method == PairsMethod::kVu || method == PairsMethod::kTola ||
           method == PairsMethod::kSparsePoints;
  }
  bool ByMesh() const { return method != PairsMethod::kFile && !UsesSparsePoints(); }
  bool UsesEnergies() const {
    return method == PairsMethod::kTuned || method == PairsMethod::kPaper ||
           method == PairsMethod::kPaperStrict;
  }
};

// Throws as Check() does.
PairsRecipe Resolve(const PairsOptions& options);

}  // namespace burin
