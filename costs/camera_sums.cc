#include "costs/camera_sums.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>

#include "core/support/parallel.h"
#include "costs/outer_products.h"
#include "costs/pair_rows.h"

namespace burin {
namespace {

constexpr int kFacetGrain = 512;
constexpr int kVertexGrain = 512;
constexpr int kUnknowns = 12;
constexpr int kFacetsAhead = 4;  // fetched while a facet is summed: they come from all over memory

// Bits of the cameras of each vertex.
class CameraBits {
 public:
  CameraBits(size_t vertices, size_t cameras)
      : cameras_(cameras), words_((cameras + 63) / 64), bits_(vertices * words_, 0) {}
  void Set(int vertex, int camera) {
    bits_[vertex * words_ + camera / 64] |= uint64_t{1} << (camera % 64);
  }
  Adjacency Lists() const {
    Adjacency lists;
    lists.start.push_back(0);
    for (size_t first = 0; first < bits_.size(); first += words_) {
      for (size_t camera = 0; camera < cameras_; ++camera) {
        if ((bits_[first + camera / 64] >> (camera % 64) & 1) != 0) {
          lists.index.push_back(static_cast<int>(camera));
        }
      }
      lists.start.push_back(static_cast<int>(lists.index.size()));
    }
    lists.index.shrink_to_fit();
    lists.start.shrink_to_fit();
    return lists;
  }

 private:
  size_t cameras_;
  size_t words_;
  std::vector<uint64_t> bits_;
};

template <typename T>
void SetCross(const Eigen::Matrix<T, 3, 1>& a, const Eigen::Matrix<T, 3, 1>& b, T* cross) {
  cross[0] = a.y() * b.z() - a.z() * b.y();
  cross[1] = a.z() * b.x() - a.x() * b.z();
  cross[2] = a.x() * b.y() - a.y() * b.x();
}

}  // namespace

std::vector<char> FacetsInPairs(const ViewDomain& domain, const PartnerBits& pixels) {
  const size_t partners = pixels.partners();
  const auto facets = static_cast<int>(domain.facet.size());
  std::vector<char> in_pair(facets * partners, 0);
  ParallelFor(facets, kFacetGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      for (const ImagePixel pixel : domain.PixelsOf(k)) {
        for (size_t b = 0; b < partners; ++b) {
          if (pixels.Test(b, pixel.index)) in_pair[k * partners + b] = 1;
        }
      }
    }
  });
  return in_pair;
}

void CameraSums::MakePattern(const RoundContext& context, const PairSample& sample) {
  pairs.clear();
  first_pair.clear();
  const std::vector<Eigen::Vector3i>& faces = context.mesh->faces;
  CameraBits bits(context.mesh->vertices.size(), context.views->size());
  for (size_t i = 0; i < sample.partners.size(); ++i) {
    const auto first = static_cast<int>(i);
    first_pair.push_back(static_cast<int>(pairs.size()));
    const std::vector<int>& seconds = sample.partners[i]->seconds;
    for (const int second : seconds) {
      pairs.emplace_back();
      pairs.back().first = first;
      pairs.back().second = second;
    }
    const ViewDomain& domain = (*context.domains)[i];
    const std::vector<char> in_pair = FacetsInPairs(domain, sample.Pixels(i));
    for (size_t k = 0; k < domain.facet.size(); ++k) {
      for (size_t b = 0; b < seconds.size(); ++b) {
        if (in_pair[k * seconds.size() + b] == 0) continue;
        for (const int v : faces[domain.facet[k]]) {
          bits.Set(v, first);
          bits.Set(v, seconds[b]);
        }
      }
    }
  }
  coupling.rows = context.motion == Motion::kNormal ? 1 : 3;
  coupling.cameras = bits.Lists();
}

void CameraSums::Clear(bool in_double) {
  for (Pair& pair : pairs) {
    pair.gradient.setZero();
    pair.curvature.setZero();
  }
  coupling.Clear(in_double);
}

// What all pixels of a pair share, in the frame of the first camera.
template <typename T>
struct CameraGather<T>::Geometry {
  Geometry(const Camera& first, const Camera& second)
      : fx_inverse(static_cast<T>(1 / first.fx)),
        fy_inverse(static_cast<T>(1 / first.fy)),
        cx(static_cast<T>(first.cx)),
        cy(static_cast<T>(first.cy)),
        fx(static_cast<T>(second.fx)),
        fy(static_cast<T>(second.fy)),
        rotation((second.rotation * first.rotation.transpose()).cast<T>()),
        translation((second.rotation * first.Center() + second.translation).cast<T>()) {}

  T fx_inverse, fy_inverse, cx, cy;    // of the first
  T fx, fy;                            // of the second
  Eigen::Matrix<T, 3, 3> rotation;     // R_j R_i^T
  Eigen::Matrix<T, 3, 1> translation;  // of the second from the first
};

template <typename T>
void CameraGather<T>::BeginView(const View& view) {
  const ViewDomain& domain = (*view.context->domains)[view.view];
  const TriangleMesh& mesh = *view.context->mesh;
  view_ = view;
  order_.assign(mesh.vertices.size(), -1);
  vertices_.clear();
  std::vector<int> degree;
  for (const int f : domain.facet) {
    for (const int v : mesh.faces[f]) {
      if (order_[v] < 0) {
        order_[v] = static_cast<int>(vertices_.size());
        vertices_.push_back(v);
        degree.push_back(0);
      }
      ++degree[order_[v]];
    }
  }
  corners_.start.assign(1, 0);
  for (const int count : degree) corners_.start.push_back(corners_.start.back() + count);
  corners_.index.resize(corners_.start.back());
  std::vector<int> next(corners_.start.begin(), corners_.start.end() - 1);
  for (size_t k = 0; k < domain.facet.size(); ++k) {
    for (int c = 0; c < 3; ++c) {
      const int v = mesh.faces[domain.facet[k]][c];
      corners_.index[next[order_[v]]++] = 3 * static_cast<int>(k) + c;
    }
  }
  rows_.resize(domain.facet.size() * 3 * kUnknowns);
  own_.resize(domain.facet.size() * 3 * 2);
  in_pair_.resize(domain.facet.size());
}

template <typename T>
void CameraGather<T>::AddPair(const PairFields<T>& fields, const PartnerPixels& pixels, int number,
                              CameraSums* sums, PairRows* vertices) {
  CameraSums::Pair* pair = &sums->pairs[number];
  const Camera& first = (*view_.cameras)[pair->first];
  const Geometry geometry(first, (*view_.cameras)[pair->second]);
  const ViewDomain& domain = (*view_.context->domains)[view_.view];
  const auto facets = static_cast<int>(domain.facet.size());
  std::vector<CameraSums::Pair> chunks((facets + kFacetGrain - 1) / kFacetGrain);
  ParallelFor(facets, kFacetGrain, [&](int begin, int end) {
    CameraSums::Pair& chunk = chunks[begin / kFacetGrain];
    chunk.gradient.setZero();
    chunk.curvature.setZero();
    for (int k = begin; k < end; ++k) {
      if (k + kFacetsAhead < end) {
        for (const ImagePixel pixel : domain.PixelsOf(k + kFacetsAhead)) {
          __builtin_prefetch(fields.Of(pixel.index));
        }
      }
      in_pair_[k] = AddFacet(geometry, fields, pixels, k, &chunk) ? 1 : 0;
    }
  });
  CameraSums::Pair sum;
  sum.gradient.setZero();
  sum.curvature.setZero();
  for (const CameraSums::Pair& chunk : chunks) {
    sum.gradient += chunk.gradient;
    sum.curvature += chunk.curvature;
  }
  // Centres in the world instead of the first camera's frame.
  const Eigen::Matrix3d world_from_first = first.rotation.transpose();
  Eigen::Matrix<double, kUnknowns, kUnknowns> turn =
      Eigen::Matrix<double, kUnknowns, kUnknowns>::Identity();
  turn.block<3, 3>(3, 3) = world_from_first;
  turn.block<3, 3>(9, 9) = world_from_first;
  pair->gradient += turn * sum.gradient;
  pair->curvature += turn * sum.curvature * turn.transpose();

  ParallelFor(static_cast<int>(vertices_.size()), kVertexGrain, [&](int begin, int end) {
    for (int n = begin; n < end; ++n) {
      AddVertex(n, world_from_first, *pair, &sums->coupling);
      if (vertices != nullptr) AddVertex(n, world_from_first, number, vertices);
    }
  });
}

template <typename T>
bool CameraGather<T>::AddFacet(const Geometry& geometry, const PairFields<T>& fields,
                               const PartnerPixels& pixels, int k, CameraSums::Pair* sums) {
  using Vector = Eigen::Matrix<T, 3, 1>;
  using Pairs = VectorPairs<T>;
  const Camera& camera = (*view_.cameras)[view_.view];
  const FacetPencil& pencil = (*view_.pencils)[k];
  const ViewDomain& domain = (*view_.context->domains)[view_.view];
  const PixelRange range = domain.PixelsOf(k);
  const Vector normal = (camera.rotation * pencil.normal).template cast<T>();
  // u_k at the facet's first pixel, and by how much they change along x and y.
  const ImagePixel origin = *range.begin();
  const Vector u_origin =
      (pencil.coefficients * Eigen::Vector3d(origin.x(), origin.y(), 1)).template cast<T>();
  const Vector along_x = pencil.coefficients.col(0).template cast<T>();
  const Vector along_y = pencil.coefficients.col(1).template cast<T>();
  // Of the pixels of a facet: a; and w a, dE/dW, and w by how much the vertices move the point.
  static thread_local Pairs pairs;
  pairs.count = 0;
  alignas(64) T products[Pairs::kSize][Pairs::kSize] = {};
  bool any = false;
  for (const ImagePixel pixel : range) {
    if (!pixels.Has(pixel.index)) continue;
    const T* here = fields.Of(pixel.index);
    const T weight = here[PairFields<T>::kWeight];
    if (!(weight > 0)) continue;  // a tap of no window
    any = true;
    const Vector ray((static_cast<T>(pixel.x()) - geometry.cx) * geometry.fx_inverse,
                     (static_cast<T>(pixel.y()) - geometry.cy) * geometry.fy_inverse, 1);
    const T depth = 1 / view_.inverse_depth[pixel.index];
    const Vector point = depth * ray;
    const Vector in_second = geometry.rotation * point + geometry.translation;
    const T inverse = 1 / in_second.z();
    Vector m(here[PairFields<T>::kGradientX] * geometry.fx * inverse,
             here[PairFields<T>::kGradientY] * geometry.fy * inverse, 0);
    m.z() = -(m.x() * in_second.x() + m.y() * in_second.y()) * inverse;
    const Vector f = geometry.rotation.transpose() * m;
    const T share = f.dot(ray) / normal.dot(ray);
    const Vector b = f - share * normal;
    T* a = pairs.right[pairs.count];
    T* left = pairs.left[pairs.count];
    SetCross(b, point, a);
    SetCross(in_second, m, a + 6);
    for (int c = 0; c < 3; ++c) {
      a[3 + c] = b[c];
      a[9 + c] = -f[c];
    }
    for (int u = 0; u < kUnknowns; ++u) left[u] = weight * a[u];
    left[kUnknowns] = here[PairFields<T>::kDerivative];
    const auto dx = static_cast<T>(pixel.column - origin.column);
    const auto dy = static_cast<T>(pixel.row - origin.row);
    const T scale = share * depth;
    for (int v = 0; v < 3; ++v) {
      a[kUnknowns + v] = scale * (u_origin[v] + along_x[v] * dx + along_y[v] * dy);
      left[kUnknowns + 1 + v] = weight * a[kUnknowns + v];
    }
    a[kUnknowns + 3] = 0;
    if (++pairs.count < Pairs::kMost) continue;
    AddOuterProducts(pairs, products);
    pairs.count = 0;
  }
  if (!any) return false;
  AddOuterProducts(pairs, products);
  for (int u = 0; u < kUnknowns; ++u) {
    for (int w = 0; w < kUnknowns; ++w) sums->curvature(w, u) += products[u][w];
    sums->gradient[u] += products[kUnknowns][u];
  }
  const Eigen::Vector3i& face = view_.context->mesh->faces[domain.facet[k]];
  T* rows = &rows_[static_cast<size_t>(k) * 3 * kUnknowns];
  T* own = &own_[static_cast<size_t>(k) * 3 * 2];
  for (int v = 0; v < 3; ++v) {
    const T along = view_.context->motion == Motion::kNormal
                        ? static_cast<T>(pencil.normal.dot(view_.context->normals[face[v]]))
                        : T(1);
    const T* row = products[kUnknowns + 1 + v];
    for (int u = 0; u < kUnknowns; ++u) rows[v * kUnknowns + u] = along * row[u];
    const T* with_vertices = row + kUnknowns;
    own[2 * v] =
        std::abs(with_vertices[0]) + std::abs(with_vertices[1]) + std::abs(with_vertices[2]);
    own[2 * v + 1] = products[kUnknowns][kUnknowns + v];
  }
  return true;
}

template <typename T>
void CameraGather<T>::AddVertex(int n, const Eigen::Matrix3d& world_from_first,
                                const CameraSums::Pair& pair, CameraCoupling* coupling) const {
  const int vertex = vertices_[n];
  const int rows = coupling->rows;
  Eigen::Matrix<double, kUnknowns, 3> sum = Eigen::Matrix<double, kUnknowns, 3>::Zero();
  bool any = false;
  for (const int* corner = corners_.Begin(n); corner != corners_.End(n); ++corner) {
    const int k = *corner / 3;
    if (in_pair_[k] == 0) continue;
    any = true;
    const T* row = &rows_[static_cast<size_t>(*corner) * kUnknowns];
    if (rows == 1) {
      for (int u = 0; u < kUnknowns; ++u) sum(u, 0) += row[u];
      continue;
    }
    const Eigen::Vector3d& normal = (*view_.pencils)[k].normal;
    for (int r = 0; r < rows; ++r) {
      for (int u = 0; u < kUnknowns; ++u) sum(u, r) += normal[r] * row[u];
    }
  }
  if (!any) return;
  for (int part = 0; part < 2; ++part) {  // of the two cameras
    double block[3 * CameraCoupling::kMotion];
    for (int r = 0; r < rows; ++r) {
      double* motion = block + r * CameraCoupling::kMotion;
      Eigen::Map<Eigen::Vector3d>(motion, 3) = sum.template block<3, 1>(6 * part, r);
      Eigen::Map<Eigen::Vector3d>(motion + 3, 3) =
          world_from_first * sum.template block<3, 1>(6 * part + 3, r);
    }
    coupling->Add(coupling->Place(vertex, part == 0 ? pair.first : pair.second), block);
  }
}

template <typename T>
void CameraGather<T>::AddVertex(int n, const Eigen::Matrix3d& world_from_first, int pair,
                                PairRows* vertices) const {
  const int vertex = vertices_[n];
  const int rows = vertices->rows();
  PairRows::VertexSums sums;
  bool any = false;
  for (const int* corner = corners_.Begin(n); corner != corners_.End(n); ++corner) {
    const int k = *corner / 3;
    if (in_pair_[k] == 0) continue;
    any = true;
    const Eigen::Vector3d& normal = (*view_.pencils)[k].normal;
    const T* row = &rows_[static_cast<size_t>(*corner) * kUnknowns];
    const T* own = &own_[static_cast<size_t>(*corner) * 2];
    // How the facet's plane moves with the vertex' unknowns.
    Eigen::Vector3d along = normal;
    if (rows == 1) along = {normal.dot(view_.context->normals[vertex]), 0, 0};
    sums.curvature += static_cast<double>(own[0]) * along * along.transpose();
    sums.gradient += static_cast<double>(own[1]) * along;
    for (int u = 0; u < kUnknowns; ++u) {
      for (int r = 0; r < rows; ++r) sums.coupling(u, r) += row[u] * (rows == 1 ? 1 : normal[r]);
    }
  }
  if (!any) return;
  for (const int centre : {3, 9}) {
    sums.coupling.middleRows<3>(centre) =
        Eigen::Matrix3d(world_from_first * sums.coupling.middleRows<3>(centre));
  }
  vertices->Add(pair, vertex, sums);
}

template class CameraGather<float>;
template class CameraGather<double>;

}  // namespace burin
