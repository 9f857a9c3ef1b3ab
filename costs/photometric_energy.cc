#include "costs/photometric_energy.h"

#include <glog/logging.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/facet_pencil.h"
#include "core/parallel.h"
#include "core/stopwatch.h"
#include "core/symmetric_matrix.h"
#include "costs/pair_kernel.h"
#include "costs/patch_cost.h"
#include "costs/step_band.h"

namespace burin {
namespace {

constexpr int kTileColumns = 512;
constexpr int kTileRows = 96;
constexpr int kRowGrain = 32;
constexpr int kFacetGrain = 512;
constexpr int kPatchGrain = 256;
// Subtracted from all images: keeps the squares in the window sums small in single precision.
constexpr float kGreyOffset = 128.0F;

// Maps a pixel (x, y, 1) of the reference and its inverse depth s to the second image:
// q ~ warp * (x, y, 1) + epipole * s.
void FillWarp(const Camera& reference, const Camera& second, double warp[9], double epipole[3]) {
  Eigen::Matrix3d reference_inverse;
  reference_inverse << 1 / reference.fx, 0, -reference.cx / reference.fx,  //
      0, 1 / reference.fy, -reference.cy / reference.fy,                   //
      0, 0, 1;
  Eigen::Matrix3d intrinsics;
  intrinsics << second.fx, 0, second.cx, 0, second.fy, second.cy, 0, 0, 1;
  const Eigen::Matrix3d a =
      intrinsics * second.rotation * reference.rotation.transpose() * reference_inverse;
  const Eigen::Vector3d e =
      intrinsics * (second.rotation * reference.Center() + second.translation);
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(warp, 3, 3) = a;
  Eigen::Map<Eigen::Vector3d>(epipole, 3) = e;
}

// Squares of 6 pixels, 48 apart: 1.6 % of the pixels.
bool InSquare(uint32_t x, uint32_t y) { return (x + 27) % 48 < 6 && (y + 27) % 48 < 6; }

struct ViewTile {
  Tile tile;
  std::vector<int> partners;  // indices into ViewDomain::seconds with a pixel in the tile
};

std::vector<ViewTile> CutTiles(const ViewDomain& domain) {
  std::vector<ViewTile> tiles;
  for (int y0 = 0; y0 < domain.height; y0 += kTileRows) {
    for (int x0 = 0; x0 < domain.width; x0 += kTileColumns) {
      ViewTile entry;
      entry.tile = {x0, y0, std::min(domain.width, x0 + kTileColumns),
                    std::min(domain.height, y0 + kTileRows)};
      for (size_t group = 0; group < domain.second_visible.size(); ++group) {
        unsigned int any = 0;
        for (int y = y0; y < entry.tile.y1; ++y) {
          const uint8_t* row =
              domain.second_visible[group].data() + static_cast<size_t>(y) * domain.width;
          for (int x = x0; x < entry.tile.x1; ++x) any |= row[x];
        }
        for (int bit = 0; bit < 8; ++bit) {
          if ((any >> bit) & 1U) entry.partners.push_back(static_cast<int>(8 * group) + bit);
        }
      }
      if (!entry.partners.empty()) tiles.push_back(std::move(entry));
    }
  }
  return tiles;
}

}  // namespace

void PhotometricOptions::Describe(OptionSet* set) {
  set->Add("photo.window", &window, "Taps along a side of the correlation window; odd", 3, 31);
  set->Add("photo.variance_floor", &variance_floor,
           "Variance added to every window, squared grey levels: flat windows lose weight", 1e-6,
           1e6);
  set->Add("photo.reliability", &reliability,
           "Weight windows by s^2/(s^2 + n * reliability * noise^2); 0 = all alike", 0, 1e6);
  set->Add("photo.min_valid_share", &min_valid_share,
           "Windows with a smaller share of valid taps are left out", 0, 1);
  set->Add("photo.double_precision", &double_precision,
           "Pixel fields in double precision (slower; for derivative checks)");
  mask.Describe(set);
}

// Everything that does not depend on the precision of the fields.
struct PhotometricEnergy::Shared {
  explicit Shared(const PhotometricOptions& o) : options(o) {}
  virtual ~Shared() = default;
  virtual void BeginLevel() = 0;
  virtual void EvaluateView(int view, bool derivatives) = 0;

  void Freeze();
  void FreezeMasks();
  void HoldBack();

  // cost and derivatives of all views at `positions`.
  double Evaluate(const std::vector<Eigen::Vector3d>& vertices, bool derivatives);

  PhotometricOptions options;
  const std::vector<LevelView>* views = nullptr;
  const RoundContext* context = nullptr;
  std::vector<std::vector<ViewTile>> tiles;  // per view
  std::vector<WindowMasks> masks;            // per view
  std::vector<PartnerBits> used_pixels;      // per view: what is used of Omega_ij; empty = all
  int64_t reference_pixels = 0;              // of all views: windows that could have a mask
  bool frozen = false;  // tiles, masks and used pixels are those of the context
  double mask_seconds = 0;
  bool hold_squares = false;
  std::vector<FacetScore>* scores = nullptr;  // filled in where wanted
  bool score_squares_only = false;
  std::vector<Eigen::Vector3d>* parameters = nullptr;
  std::vector<PatchCost*> patches;  // owned by the round's problem

  std::vector<Eigen::Vector3d> positions;  // last evaluated
  bool have_energy = false;
  bool have_derivatives = false;
  bool linearized = false;  // the patches, at `positions`
  double energy = 0;
  std::vector<CornerSums> sums;
  std::vector<Eigen::Vector3d> normals;
  int64_t windows = 0;
  int64_t evaluations = 0;
  double seconds = 0;
};

template <typename T>
struct PhotometricEnergy::State : public PhotometricEnergy::Shared {
  explicit State(const PhotometricOptions& o) : Shared(o) {}

  void BeginLevel() override {
    splines.clear();
    splines.resize(views->size());
    ParallelFor(static_cast<int>(views->size()), 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        splines[i] = SplineImage<T>((*views)[i].FloatImage(), T(kGreyOffset));
      }
    });
  }

  void EvaluateView(int view, bool derivatives) override {
    const ViewDomain& domain = (*context->domains)[view];
    const std::vector<Eigen::Vector3i>& faces = context->mesh->faces;
    const int facets = static_cast<int>(domain.facet.size());
    const size_t pixels = static_cast<size_t>(domain.width) * domain.height;

    image.create(domain.height, domain.width);
    fields.Resize(pixels, derivatives, scores != nullptr);
    ParallelFor(domain.height, kRowGrain, [&](int begin, int end) {
      cv::Mat rows = image.rowRange(begin, end);
      (*views)[view].image.rowRange(begin, end).convertTo(rows, CV_32F);
      fields.Clear(static_cast<size_t>(begin) * domain.width,
                   static_cast<size_t>(end) * domain.width);
    });
    pencils.resize(facets);
    inverse_depth.resize(pixels);  // outside the facets' pixels anything
    const ViewRays rays((*views)[view].camera);
    ParallelFor(facets, kFacetGrain, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        pencils[k] = MakeFacetPencil(positions, faces[domain.facet[k]], rays);
        const Eigen::RowVector3d row = pencils[k].InverseDepth();
        for (uint32_t n = domain.start[3 * k]; n < domain.start[3 * k + 3]; ++n) {
          const uint32_t p = domain.pixel[n];
          const double x = p % domain.width + 0.5;
          const double y = static_cast<double>(p / domain.width) + 0.5;
          inverse_depth[p] = static_cast<T>(row[0] * x + row[1] * y + row[2]);
        }
      }
    });

    std::vector<PairInput<T>> inputs(domain.seconds.size());
    for (size_t b = 0; b < inputs.size(); ++b) {
      const int second = domain.seconds[b];
      PairInput<T>& input = inputs[b];
      input.width = domain.width;
      input.height = domain.height;
      input.image = image[0];
      input.grey_offset = kGreyOffset;
      input.inverse_depth = inverse_depth.data();
      const PartnerBits& counted = used_pixels.empty() ? domain.second_visible : used_pixels[view];
      input.domain = counted[b / 8].data();
      input.bit = static_cast<uint8_t>(1U << (b % 8));
      input.second = &splines[second];
      FillWarp((*views)[view].camera, (*views)[second].camera, input.warp, input.epipole);
      input.radius = options.window / 2;
      input.variance_floor = options.variance_floor;
      const double noise_i = (*views)[view].noise_sigma;
      const double noise_j = (*views)[second].noise_sigma;
      input.reliability_noise = options.reliability * (noise_i * noise_i + noise_j * noise_j);
      const double taps = options.window * options.window;
      if (masks[view].size() > 0) input.masks = &masks[view];
      input.full_below = options.mask.below == "full";
      input.full_thin = options.mask.below == "full_thin";
      input.min_taps = std::max(2, static_cast<int>(std::ceil(options.min_valid_share * taps)));
    }
    std::atomic<int64_t> counted{0};
    const std::vector<ViewTile>& view_tiles = tiles[view];
    ParallelFor(static_cast<int>(view_tiles.size()), 1, [&](int begin, int end) {
      static thread_local PairKernel<T> kernel;
      for (int t = begin; t < end; ++t) {
        for (int b : view_tiles[t].partners) {
          counted += kernel.AddTile(inputs[b], view_tiles[t].tile, derivatives, &fields);
        }
      }
    });
    windows += counted;

    ParallelFor(facets, kFacetGrain, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        if (scores != nullptr) ScoreFacet(domain, k);
        GatherFacet(domain, k, derivatives);
      }
    });
  }

  void ScoreFacet(const ViewDomain& domain, int k) {
    FacetScore& score = (*scores)[domain.facet[k]];
    for (uint32_t n = domain.start[3 * k]; n < domain.start[3 * k + 3]; ++n) {
      const uint32_t p = domain.pixel[n];
      if (score_squares_only && !InSquare(p % domain.width, p / domain.width)) continue;
      score.cost += fields.cost[p];
      score.weight += fields.weight[p];
    }
  }

  // Adds the pixels of a facet to its corner sums.
  void GatherFacet(const ViewDomain& domain, int k, bool derivatives) {
    const FacetPencil& pencil = pencils[k];
    const Eigen::Matrix3d& u = pencil.coefficients;
    const double scale = -1 / pencil.offset;
    const double width = domain.width;
    const double rows_per_pixel = 1 / width;
    for (int corner = 0; corner < 3; ++corner) {
      CornerSums local;
      for (uint32_t n = domain.start[3 * k + corner]; n < domain.start[3 * k + corner + 1]; ++n) {
        const uint32_t p = domain.pixel[n];
        local.cost += fields.cost[p];
        if (!derivatives) continue;
        // Row and column without integer divisions; the half keeps the quotient off whole numbers.
        const int row = static_cast<int>((p + 0.5) * rows_per_pixel);
        const double x = p - row * width + 0.5;
        const double y = row + 0.5;
        const double u0 = scale * (u(0, 0) * x + u(0, 1) * y + u(0, 2));
        const double u1 = scale * (u(1, 0) * x + u(1, 1) * y + u(1, 2));
        const double u2 = scale * (u(2, 0) * x + u(2, 1) * y + u(2, 2));
        const double slope = fields.slope[p];
        const double curvature = fields.curvature[p];
        local.slope[0] += slope * u0;
        local.slope[1] += slope * u1;
        local.slope[2] += slope * u2;
        local.curvature[0] += curvature * u0 * u0;
        local.curvature[1] += curvature * u0 * u1;
        local.curvature[2] += curvature * u0 * u2;
        local.curvature[3] += curvature * u1 * u1;
        local.curvature[4] += curvature * u1 * u2;
        local.curvature[5] += curvature * u2 * u2;
      }
      CornerSums& total = sums[3 * static_cast<size_t>(domain.facet[k]) + corner];
      total.cost += local.cost;
      for (int c = 0; c < 3; ++c) total.slope[c] += local.slope[c];
      for (int c = 0; c < 6; ++c) total.curvature[c] += local.curvature[c];
    }
  }

  std::vector<SplineImage<T>> splines;
  // Of the view in work.
  cv::Mat1f image;
  std::vector<FacetPencil> pencils;
  std::vector<T> inverse_depth;
  PixelFields<T> fields;
};

void PhotometricEnergy::Shared::Freeze() {
  if (frozen) return;
  const auto count = static_cast<int>(views->size());
  tiles.resize(count);
  ParallelFor(count, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) tiles[i] = CutTiles((*context->domains)[i]);
  });
  FreezeMasks();
  frozen = true;
}

void PhotometricEnergy::Shared::FreezeMasks() {
  const Stopwatch watch;
  const MaskMode mode = MaskModeNamed(options.mask.mode);
  const int min_taps =
      static_cast<int>(std::ceil(options.min_valid_share * options.window * options.window));
  masks.assign(views->size(), WindowMasks());
  used_pixels.clear();
  const bool band = mode == MaskMode::kPlane && options.mask.band_px > 0 && !context->first_level;
  std::vector<std::vector<uint8_t>> near_steps(views->size());
  reference_pixels = 0;
  for (size_t i = 0; i < views->size(); ++i) {
    const ViewDomain& domain = (*context->domains)[i];
    reference_pixels += static_cast<int64_t>(domain.pixel.size());
    if (tiles[i].empty() || mode == MaskMode::kNone) continue;
    const DepthPlanes planes = MakeDepthPlanes(domain, *context->mesh, (*views)[i].camera);
    masks[i] = MakeWindowMasks(planes, options.window / 2, mode, options.mask.plane_px, min_taps);
    if (!band) continue;
    near_steps[i] = NearSteps(planes, OpenBorderPixels(domain, *context->mesh, context->boundary),
                              options.mask.plane_px, options.mask.band_px);
  }
  if (band) {
    std::vector<Camera> cameras;
    for (const LevelView& view : *views) cameras.push_back(view.camera);
    used_pixels =
        WithoutSteps(*context->domains, cameras, *context->mesh, near_steps, options.mask.evidence);
  }
  if (hold_squares) HoldBack();
  mask_seconds = watch.Seconds();
}

void PhotometricEnergy::Shared::HoldBack() {
  used_pixels.resize(views->size());
  for (size_t i = 0; i < views->size(); ++i) {
    const ViewDomain& domain = (*context->domains)[i];
    if (used_pixels[i].empty()) used_pixels[i] = domain.second_visible;
    for (std::vector<uint8_t>& plane : used_pixels[i]) {
      for (uint32_t p = 0; p < plane.size(); ++p) {
        if (InSquare(p % domain.width, p / domain.width)) plane[p] = 0;
      }
    }
  }
}

double PhotometricEnergy::Shared::Evaluate(const std::vector<Eigen::Vector3d>& vertices,
                                           bool derivatives) {
  CHECK(context != nullptr);
  const bool same = have_energy && positions == vertices;
  if (same && (have_derivatives || !derivatives)) return energy;
  Freeze();
  const Stopwatch watch;
  positions = vertices;
  windows = 0;
  const size_t face_count = context->mesh->faces.size();
  sums.resize(3 * face_count);
  normals.resize(face_count);
  ParallelFor(static_cast<int>(face_count), kFacetGrain, [&](int begin, int end) {
    std::fill(sums.begin() + 3L * begin, sums.begin() + 3L * end, CornerSums());
    for (int f = begin; f < end; ++f) {
      const Eigen::Vector3i& face = context->mesh->faces[f];
      normals[f] =
          (positions[face[1]] - positions[face[0]]).cross(positions[face[2]] - positions[face[0]]);
    }
  });
  for (size_t i = 0; i < views->size(); ++i) {
    if (!tiles[i].empty()) EvaluateView(static_cast<int>(i), derivatives);
  }
  energy = ChunkedSum(static_cast<int>(sums.size()), [&](int begin, int end) {
    double part = 0;
    for (int k = begin; k < end; ++k) part += sums[k].cost;
    return part;
  });
  have_energy = true;
  have_derivatives = derivatives;
  linearized = false;
  ++evaluations;
  seconds += watch.Seconds();
  return energy;
}

PhotometricEnergy::PhotometricEnergy(const PhotometricOptions& options) {
  if (options.double_precision) {
    shared_ = std::make_unique<State<double>>(options);
  } else {
    shared_ = std::make_unique<State<float>>(options);
  }
}

PhotometricEnergy::~PhotometricEnergy() = default;

void PhotometricEnergy::BeginLevel(const std::vector<LevelView>& views) {
  shared_->views = &views;
  shared_->BeginLevel();
}

void PhotometricEnergy::BeginRound(const RoundContext& context) {
  CHECK(context.views == shared_->views);
  shared_->context = &context;
  shared_->frozen = false;
  shared_->have_energy = false;
  shared_->have_derivatives = false;
  shared_->linearized = false;
  shared_->patches.clear();
  shared_->evaluations = 0;
  shared_->seconds = 0;
  shared_->parameters = nullptr;
}

void PhotometricEnergy::Freeze() { shared_->Freeze(); }

void PhotometricEnergy::AddResiduals(ceres::Problem* problem,
                                     std::vector<Eigen::Vector3d>* vertices) {
  shared_->parameters = vertices;
  std::vector<int> supported;
  for (size_t v = 0; v < vertices->size(); ++v) {
    if (shared_->context->supported[v] != 0) supported.push_back(static_cast<int>(v));
  }
  shared_->patches.resize(supported.size());
  ParallelFor(static_cast<int>(supported.size()), kPatchGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) shared_->patches[k] = new PatchCost(this, supported[k]);
  });
  std::vector<double*> blocks;
  for (PatchCost* cost : shared_->patches) {
    blocks.clear();
    for (int block : cost->blocks()) blocks.push_back((*vertices)[block].data());
    problem->AddResidualBlock(cost, nullptr, blocks);
  }
}

void PhotometricEnergy::PrepareForEvaluation(bool /*evaluate_jacobians*/,
                                             bool /*new_evaluation_point*/) {
  const int64_t before = shared_->evaluations;
  shared_->Evaluate(*shared_->parameters, /*derivatives=*/true);
  if (shared_->evaluations == before && shared_->linearized) return;
  ParallelFor(static_cast<int>(shared_->patches.size()), kPatchGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) shared_->patches[k]->Linearize();
  });
  shared_->linearized = true;
}

double PhotometricEnergy::Evaluate(const std::vector<Eigen::Vector3d>& vertices, bool derivatives) {
  return shared_->Evaluate(vertices, derivatives);
}

void PhotometricEnergy::HoldBackSquares(bool hold) { shared_->hold_squares = hold; }

std::vector<FacetScore> PhotometricEnergy::FacetScores(const std::vector<Eigen::Vector3d>& vertices,
                                                       bool squares_only) {
  std::vector<FacetScore> scores(shared_->context->mesh->faces.size());
  Forget();
  shared_->scores = &scores;
  shared_->score_squares_only = squares_only;
  shared_->Evaluate(vertices, /*derivatives=*/false);
  shared_->scores = nullptr;
  Forget();
  return scores;
}

int64_t PhotometricEnergy::EvaluationCount() const { return shared_->evaluations; }

void PhotometricEnergy::Forget() {
  shared_->have_energy = false;
  shared_->have_derivatives = false;
  shared_->linearized = false;
}

nlohmann::json PhotometricEnergy::RoundReport() const {
  int64_t masked = 0;
  for (const WindowMasks& masks : shared_->masks) masked += static_cast<int64_t>(masks.size());
  const auto all = static_cast<double>(std::max<int64_t>(1, shared_->reference_pixels));
  return {{"evaluations", shared_->evaluations},
          {"valid_windows", shared_->windows},
          {"masked_window_share", static_cast<double>(masked) / all},
          {"mask_seconds", shared_->mask_seconds},
          {"evaluation_seconds", shared_->seconds}};
}

const std::vector<CornerSums>& PhotometricEnergy::corner_sums() const { return shared_->sums; }
const std::vector<Eigen::Vector3d>& PhotometricEnergy::facet_normals() const {
  return shared_->normals;
}
const RoundContext& PhotometricEnergy::context() const { return *shared_->context; }
int64_t PhotometricEnergy::valid_windows() const { return shared_->windows; }
const WindowMasks& PhotometricEnergy::masks(int view) const {
  shared_->Freeze();
  return shared_->masks[view];
}

}  // namespace burin
