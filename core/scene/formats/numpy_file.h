// Arrays as NumPy writes them: NAME.npy, one array; NAME.npz, a zip archive of such. Numbers of any kind become doubles.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace burin {

struct NumpyArray {
  std::vector<std::size_t> shape;
  std::vector<double> values;  // the last index runs fastest

  // One with two indices; else the matrix is empty.
  Eigen::MatrixXd Matrix() const;
};

// Throws InputError, naming `element` of `file` (empty = the file itself), for bytes that are no array of little-endian integers or
// floating-point numbers, are not as long as the header says, or have a number that is not finite.
NumpyArray ParseNumpy(const std::string& bytes, const std::filesystem::path& file,
                      const std::string& element);

// The archive's arrays whose names, without .npy, are `wanted`. Throws InputError when it is no zip archive.
std::map<std::string, NumpyArray> ReadNumpyArchive(const std::filesystem::path& file,
                                                   bool (*wanted)(const std::string& name));

}  // namespace burin
