// NumPy arrays from and to burin's meshes, images and pairs. What does not fit throws InputError, with the
// argument's name.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/pairs.h"
#include "core/support/error.h"

namespace burin {

namespace py = pybind11;

constexpr double kMostCoordinate = 1e30;  // as in mesh files

template <typename T>
using Dense = py::array_t<T, py::array::c_style | py::array::forcecast>;

// (N, 3) of real numbers, or of whole ones, as numpy has them; lists and other kinds of numbers are not
// converted in silence.
template <typename T>
Dense<T> Rows3(const py::array& array, const std::string& name, const std::string& size,
               const std::string& kinds, const std::string& what) {
  if (array.ndim() != 2 || array.shape(1) != 3) {
    throw InputError(name + ": must be an array of shape (" + size + ", 3)");
  }
  if (kinds.find(array.dtype().kind()) == std::string::npos) {
    throw InputError(name + ": must be " + what + ", not " +
                     py::str(array.dtype()).cast<std::string>());
  }
  return Dense<T>(array);
}

inline TriangleMesh MeshOf(const py::array& given_vertices, const py::array& given_faces) {
  const auto vertices = Rows3<double>(given_vertices, "vertices", "V", "fiu", "real numbers");
  const auto faces = Rows3<int64_t>(given_faces, "faces", "F", "iu", "whole numbers");
  TriangleMesh mesh;
  const auto v = vertices.unchecked<2>();
  const auto f = faces.unchecked<2>();
  for (py::ssize_t k = 0; k < v.shape(0); ++k)
    mesh.vertices.emplace_back(v(k, 0), v(k, 1), v(k, 2));
  for (py::ssize_t k = 0; k < f.shape(0); ++k) {
    for (int c = 0; c < 3; ++c) {
      if (f(k, c) < 0 || f(k, c) >= v.shape(0)) {
        throw InputError("faces: row " + std::to_string(k) + " names vertex " +
                         std::to_string(f(k, c)) + " of " + std::to_string(v.shape(0)));
      }
    }
    mesh.faces.emplace_back(static_cast<int>(f(k, 0)), static_cast<int>(f(k, 1)),
                            static_cast<int>(f(k, 2)));
  }
  if (mesh.faces.empty()) throw InputError("faces: there are none");
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    if (!(vertex.cwiseAbs().maxCoeff() < kMostCoordinate)) {
      throw InputError("vertices: must be finite and below 1e30");
    }
  }
  return mesh;
}

inline py::array_t<double> Array(const std::vector<Eigen::Vector3d>& points) {
  py::array_t<double> array({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
  auto out = array.mutable_unchecked<2>();
  for (size_t k = 0; k < points.size(); ++k) {
    for (int c = 0; c < 3; ++c) out(static_cast<py::ssize_t>(k), c) = points[k][c];
  }
  return array;
}

inline py::array_t<double> Array(const std::vector<Eigen::Matrix3d>& matrices) {
  py::array_t<double> array(
      {static_cast<py::ssize_t>(matrices.size()), py::ssize_t{3}, py::ssize_t{3}});
  auto out = array.mutable_unchecked<3>();
  for (size_t k = 0; k < matrices.size(); ++k) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) out(static_cast<py::ssize_t>(k), r, c) = matrices[k](r, c);
    }
  }
  return array;
}

inline py::array_t<int> Array(const std::vector<Eigen::Vector3i>& faces) {
  py::array_t<int> array({static_cast<py::ssize_t>(faces.size()), py::ssize_t{3}});
  auto out = array.mutable_unchecked<2>();
  for (size_t k = 0; k < faces.size(); ++k) {
    for (int c = 0; c < 3; ++c) out(static_cast<py::ssize_t>(k), c) = faces[k][c];
  }
  return array;
}

template <typename T>
py::array_t<T> Array(const std::vector<T>& values) {
  return py::array_t<T>(static_cast<py::ssize_t>(values.size()), values.data());
}

template <typename T>
py::array_t<T> ImageArray(const cv::Mat& image) {
  py::array_t<T> array({image.rows, image.cols});
  for (int row = 0; row < image.rows; ++row) {
    std::copy(image.ptr<T>(row), image.ptr<T>(row) + image.cols, array.mutable_data(row, 0));
  }
  return array;
}

inline std::vector<CameraPair> PairsOf(const std::vector<std::pair<int, int>>& pairs) {
  std::vector<CameraPair> result;
  result.reserve(pairs.size());
  for (const auto& [reference, second] : pairs) result.push_back({reference, second});
  return result;
}

inline std::vector<std::pair<int, int>> PairTuples(const std::vector<CameraPair>& pairs) {
  std::vector<std::pair<int, int>> result;
  result.reserve(pairs.size());
  for (const CameraPair& pair : pairs) result.emplace_back(pair.reference, pair.second);
  return result;
}

}  // namespace burin
