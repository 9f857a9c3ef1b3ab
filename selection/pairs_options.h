// Every option of the selection of camera pairs, and the values that the named methods give to options
// left at "the method's own".
#pragma once

#include <string>

#include "core/support/options.h"
#include "selection/coverage.h"
#include "selection/pair_survey.h"
#include "selection/pair_terms.h"

namespace burin {

struct PairsOptions {
  std::string method = "tuned";
  std::string file;  // of the method "file"
  int per_camera = 4;
  double min_parallax_deg = -1;  // -1 = the method's own
  double max_parallax_deg = -1;
  int survey_px = 128;
  double min_overlap = -1;  // -1 = the method's own
  std::string terms = "OSPRC";
  double reference_parallax_deg = -1;  // -1 = the method's own
  double sigma_parallax_deg = -1;
  BpvOptions bpv;                       // the other numbers in it
  SwapOptions swaps;                    // the number in it
  std::string overlap_area = "preset";  // and the switches where the print contradicts itself
  std::string symmetry_term = "preset";
  std::string symmetry_mean = "preset";
  std::string resolution_term = "preset";
  std::string energy_test = "preset";
  std::string used_partners = "preset";
  std::string swap_state = "preset";
  std::string coverage_test = "preset";
  std::string coverage_facets = "preset";

  void Describe(OptionSet* set);

  // Throws InputError for values that do not fit together.
  void Check() const;
};

// A PairsOptions with every preset, -1 and letter replaced by what it stands for.
struct PairsRecipe {
  std::string method;
  std::string file;
  int per_camera = 0;
  double min_parallax_deg = 0;  // methods by sparse points and mesh_parallax
  double max_parallax_deg = 0;
  double min_overlap = 0;  // least part of what view i sees of the mesh that j must share
  bool improve_coverage = false;
  BpvOptions bpv;
  SwapOptions swaps;
  SurveyOptions survey;

  bool UsesSparsePoints() const {
    return method == "vu" || method == "tola" || method == "sparse_points";
  }
  bool UsesEnergies() const {
    return method == "tuned" || method == "paper" || method == "paper_strict";
  }
};

// Throws as Check() does.
PairsRecipe Resolve(const PairsOptions& options);

}  // namespace burin
