#include "selection/pairs_options.h"

#include <algorithm>

#include "core/support/error.h"

namespace burin {
namespace {

// The parallax range that a method counts, degrees.
struct Range {
  double min, max;
};
Range OwnRange(PairsMethod method) {
  if (method == PairsMethod::kVu) return {20, 60};
  if (method == PairsMethod::kTola) return {10, 30};
  return {8, 45};
}

// Of pairs.candidates = -1: for each partner wanted, and at least.
constexpr int kCandidatesEach = 8;
constexpr int kLeastCandidates = 32;

bool Printed(PaperReading choice, PairsMethod method) {
  return choice == PaperReading::kPreset ? method == PairsMethod::kPaperStrict
                                         : choice == PaperReading::kPrinted;
}

}  // namespace

void PairsOptions::Describe(OptionSet* set) {
  set->Add(
      "pairs.method", &method,
      "paper: energies of the mesh and Algorithm 1, corrected; paper_strict: as printed; tuned: "
      "those of paper around a parallax of 20 degrees; vu, tola, sparse_points: "
      "most common sparse points under 20-60, 10-30, 8-45 degrees; mesh_parallax: most shared "
      "surface under 8-45 degrees; all: every pair that shares surface; file: those of "
      "pairs.file");
  set->Add("pairs.file", &file, "Pairs for the method file: pairs.json of burin select");
  set->Add("pairs.per_camera", &per_camera, "Partners of each camera at most", 1, 1000);
  set->Add("pairs.min_parallax_deg", &min_parallax_deg,
           "Smallest parallax that counts, degrees; -1 = the method's own; for vu, tola, "
           "sparse_points and mesh_parallax",
           -1, 180);
  set->Add("pairs.max_parallax_deg", &max_parallax_deg,
           "Largest parallax that counts, degrees; -1 = the method's own; for vu, tola, "
           "sparse_points and mesh_parallax",
           -1, 180);
  set->Add("pairs.survey_px", &survey_px,
           "Longer side of the images over which methods by mesh integrate, pixels", 8, 65536);
  set->Add("pairs.candidates", &candidates,
           "Partners of each view that are measured, the best by an estimate from some of its "
           "points, never fewer than pairs.per_camera; all where there are no more, for the method "
           "all, and with 0; -1 = eight for each of pairs.per_camera, at least 32",
           -1, 10000);
  set->Add("pairs.min_overlap", &min_overlap,
           "Methods by mesh: least part of what a view sees of the mesh that its partner must see "
           "too; -1 = the method's own (tuned, paper 0.05, others 0)",
           -1, 1);
  set->Add("pairs.terms", &terms,
           "What is switched on, as letters: O overlap, S symmetry, P parallax, R resolution, C "
           "Algorithm 1 (coverage)");
  set->Add("pairs.weight_parallax", &bpv.weight_parallax, "mu_1, weight of E_p", 0, 1e6);
  set->Add("pairs.weight_overlap", &bpv.weight_overlap, "mu_2, weight of E_o", 0, 1e6);
  set->Add("pairs.weight_symmetry", &bpv.weight_symmetry, "mu_3, weight of E_s", 0, 1e6);
  set->Add("pairs.weight_resolution", &bpv.weight_resolution, "mu_4, weight of E_r", 0, 1e6);
  set->Add("pairs.reference_parallax_deg", &reference_parallax_deg,
           "Parallax of least E_p, degrees; -1 = the method's own (tuned 20, paper 50)", -1, 180);
  set->Add("pairs.sigma_parallax_deg", &sigma_parallax_deg,
           "sigma_p, degrees; -1 = the method's own (tuned 10, paper 45)", -1, 1e6);
  set->Add("pairs.sigma_symmetry_deg", &bpv.sigma_symmetry_deg, "sigma_s, degrees", 0.1, 1e6);
  set->Add("pairs.sigma_resolution", &bpv.sigma_resolution, "sigma_r", 1e-3, 1e6);
  set->Add("pairs.energy_fraction", &swaps.energy_fraction,
           "Algorithm 1: share of the initial energy that must remain after swaps", 0, 1);
  const std::string why = "; preset = printed for paper_strict, else corrected";
  set->Add("pairs.overlap_area", &overlap_area,
           "E_o divides by the image (printed), which only weakens the term where the mesh fills "
           "little of it, or by the pixels that see the mesh (corrected)" +
               why);
  set->Add("pairs.symmetry_term", &symmetry_term,
           "Oriented angle difference (a_i - a_j)/2 (printed), small also for cameras side by "
           "side, or (a_i + s a_j)/2 (corrected)" +
               why);
  set->Add("pairs.symmetry_mean", &symmetry_mean,
           "Mean of the signed differences (printed), which cancel where a view looks along the "
           "normal, or of their magnitudes (corrected)" +
               why);
  set->Add("pairs.resolution_term", &resolution_term,
           "Discrepancy of resolution over the distance (printed), about 0 for any focal length in "
           "pixels, or relative (corrected)" +
               why);
  set->Add("pairs.energy_test", &energy_test,
           "Algorithm 1 as a loop while the sum is above 0.9 of a negative sum (printed), which "
           "never runs, or with the text's test of each swap (corrected)" +
               why);
  set->Add("pairs.used_partners", &used_partners,
           "Algorithm 1's used partners begin empty (printed), so the present one is tried again, "
           "or with the initial one (corrected)" +
               why);
  set->Add("pairs.swap_state", &swap_state,
           "Algorithm 1 starts every swap from the initial pairs (printed), so that earlier ones "
           "vanish, or from the present ones (corrected)" +
               why);
  set->Add("pairs.coverage_test", &coverage_test,
           "A swap must raise the mean coverage (printed), or not lower it (corrected, the "
           "authors' program)" +
               why);
  set->Add("pairs.coverage_facets", &coverage_facets,
           "Coverage over all facets (printed), where those nobody sees tie the spread to the "
           "mean, or over those that two views see (corrected)" +
               why);
}

void PairsOptions::Check() const { Resolve(*this); }

PairsRecipe Resolve(const PairsOptions& options) {
  PairsRecipe recipe;
  recipe.method = options.method;
  const PairsMethod method = recipe.method;
  if (method == PairsMethod::kFile && options.file.empty()) {
    throw InputError("pairs.file: must name a file for pairs.method = file");
  }
  if (method != PairsMethod::kFile && !options.file.empty()) {
    throw InputError("pairs.file: is read by pairs.method = file only, not by " + NameOf(method));
  }
  recipe.file = options.file;
  recipe.per_camera = options.per_camera;
  const Range own = OwnRange(method);
  recipe.min_parallax_deg = options.min_parallax_deg >= 0 ? options.min_parallax_deg : own.min;
  recipe.max_parallax_deg = options.max_parallax_deg >= 0 ? options.max_parallax_deg : own.max;
  if (recipe.min_parallax_deg >= recipe.max_parallax_deg) {
    throw InputError("pairs.min_parallax_deg: must be below pairs.max_parallax_deg");
  }
  recipe.min_overlap =
      options.min_overlap >= 0
          ? options.min_overlap
          : (method == PairsMethod::kPaper || method == PairsMethod::kTuned ? 0.05 : 0);

  recipe.candidates = options.candidates >= 0
                          ? options.candidates
                          : std::max(kLeastCandidates, kCandidatesEach * recipe.per_camera);
  if (recipe.candidates > 0) recipe.candidates = std::max(recipe.candidates, recipe.per_camera);
  if (method == PairsMethod::kAll) recipe.candidates = 0;

  recipe.bpv = options.bpv;
  const bool tuned = method == PairsMethod::kTuned;
  recipe.bpv.reference_parallax_deg =
      options.reference_parallax_deg >= 0 ? options.reference_parallax_deg : (tuned ? 20 : 50);
  recipe.bpv.sigma_parallax_deg =
      options.sigma_parallax_deg >= 0 ? options.sigma_parallax_deg : (tuned ? 10 : 45);
  if (recipe.bpv.sigma_parallax_deg == 0) {
    throw InputError("pairs.sigma_parallax_deg = 0: must be positive, or -1");
  }
  recipe.bpv.use_overlap = recipe.bpv.use_symmetry = false;
  recipe.bpv.use_parallax = recipe.bpv.use_resolution = false;
  for (const char letter : options.terms) {
    bool* term = letter == 'O'   ? &recipe.bpv.use_overlap
                 : letter == 'S' ? &recipe.bpv.use_symmetry
                 : letter == 'P' ? &recipe.bpv.use_parallax
                 : letter == 'R' ? &recipe.bpv.use_resolution
                 : letter == 'C' ? &recipe.improve_coverage
                                 : nullptr;
    if (term == nullptr || *term) {
      throw InputError("pairs.terms = " + options.terms +
                       ": must be letters of O, S, P, R, C, each at most once");
    }
    *term = true;
  }
  if (!recipe.bpv.use_overlap && !recipe.bpv.use_symmetry && !recipe.bpv.use_parallax &&
      !recipe.bpv.use_resolution) {
    throw InputError("pairs.terms = " + options.terms + ": needs one of O, S, P, R");
  }
  recipe.bpv.overlap_of_image = Printed(options.overlap_area, method);
  recipe.bpv.printed_symmetry = Printed(options.symmetry_term, method);
  recipe.bpv.signed_symmetry = Printed(options.symmetry_mean, method);
  recipe.bpv.printed_resolution = Printed(options.resolution_term, method);
  recipe.swaps = options.swaps;
  recipe.swaps.printed_energy_test = Printed(options.energy_test, method);
  recipe.swaps.printed_used_partners = Printed(options.used_partners, method);
  recipe.swaps.printed_state = Printed(options.swap_state, method);
  recipe.swaps.printed_coverage_test = Printed(options.coverage_test, method);
  recipe.swaps.printed_facets = Printed(options.coverage_facets, method);
  recipe.survey.resolution_px = options.survey_px;
  if (method == PairsMethod::kMeshParallax) {
    recipe.survey.parallax = {recipe.min_parallax_deg, recipe.max_parallax_deg};
  }
  return recipe;
}

}  // namespace burin
