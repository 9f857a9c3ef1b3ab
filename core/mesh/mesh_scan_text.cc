#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "core/mesh/mesh_scan.h"
#include "core/support/error.h"

namespace burin {
namespace {

// Lines without comments, with '\' joining a line to the next; blank ones are passed over.
class LineReader {
 public:
  explicit LineReader(const std::string& data) : data_(data) {}

  // False at the end of the file. The words stay valid until the next call.
  bool Next(std::vector<std::string_view>* words) {
    words->clear();
    while (words->empty() && at_ < data_.size()) {
      bool joined = true;
      while (joined && at_ < data_.size()) {
        const size_t end = std::min(data_.find('\n', at_), data_.size());
        std::string_view line(data_.data() + at_, end - at_);
        at_ = end + 1;
        ++line_;
        line = line.substr(0, line.find('#'));
        while (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        joined = !line.empty() && line.back() == '\\';
        if (joined) line.remove_suffix(1);
        Split(line, words);
      }
    }
    return !words->empty();
  }

  std::string Where() const { return "line " + std::to_string(line_); }
  size_t BytesLeft() const { return data_.size() - std::min(at_, data_.size()); }

 private:
  static void Split(std::string_view line, std::vector<std::string_view>* words) {
    size_t begin = line.find_first_not_of(" \t\r");
    while (begin != std::string_view::npos) {
      const size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
      words->push_back(line.substr(begin, end - begin));
      begin = line.find_first_not_of(" \t\r", end);
    }
  }

  const std::string& data_;
  size_t at_ = 0;
  std::int64_t line_ = 0;
};

// x, y, z from words[first ..], appended to the mesh and to its text.
void TakePosition(const std::filesystem::path& path, const LineReader& lines,
                  const std::vector<std::string_view>& words, size_t first, ScannedMesh* mesh) {
  const auto vertex = static_cast<std::int64_t>(mesh->positions.size());
  if (words.size() < first + 3) {
    throw InputError(path, lines.Where() + ": vertex " + std::to_string(vertex) +
                               ": has fewer than three coordinates");
  }
  Eigen::Vector3d position;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = words[first + axis];
    if (!ParseNumber(word, &position[axis])) {
      throw InputError(path, lines.Where() + ": vertex " + std::to_string(vertex) + ": '" +
                                 std::string(word) + "' is not a number");
    }
    mesh->text.append(word).push_back(axis < 2 ? ' ' : '\n');
  }
  CheckPosition(path, vertex, position);
  mesh->positions.push_back(position);
}

}  // namespace

bool ParseNumber(std::string_view token, double* value) {
  if (!token.empty() && token.front() == '+') token.remove_prefix(1);
  const char* end = token.data() + token.size();
  const auto [stop, error] = std::from_chars(token.data(), end, *value);
  if (stop != end || token.empty()) return false;
  if (error == std::errc::result_out_of_range) {
    // Too large or too small; the exponent's sign tells which.
    const size_t exponent = token.find_first_of("eE");
    const bool tiny =
        exponent != std::string_view::npos ? token[exponent + 1] == '-' : token.find('.') < 2;
    *value = tiny ? 0.0 : std::numeric_limits<double>::infinity();
    return true;
  }
  return error == std::errc();
}

bool ParseInteger(std::string_view token, std::int64_t* value) {
  if (!token.empty() && token.front() == '+') token.remove_prefix(1);
  const char* end = token.data() + token.size();
  const auto [stop, error] = std::from_chars(token.data(), end, *value);
  return stop == end && error == std::errc() && !token.empty();
}

void CheckPosition(const std::filesystem::path& path, std::int64_t vertex,
                   const Eigen::Vector3d& position) {
  for (int axis = 0; axis < 3; ++axis) {
    const double value = position[axis];
    if (std::abs(value) < 1e30) continue;  // false for nan
    const std::string text = std::isnan(value)   ? "nan"
                             : std::isinf(value) ? (value < 0 ? "-inf" : "inf")
                                                 : std::to_string(value);
    throw InputError(path, "vertex " + std::to_string(vertex) + ": " + "xyz"[axis] + " is " + text +
                               ", must be a finite number below 1e30");
  }
}

ScannedMesh ScanObj(const std::filesystem::path& path, const std::string& data) {
  ScannedMesh mesh;
  LineReader lines(data);
  std::vector<std::string_view> words;
  std::vector<std::int64_t> corners;
  std::string face_text;
  std::int64_t face = 0;
  std::int64_t highest = -1;  // the largest vertex index used, and where
  std::string highest_where;
  while (lines.Next(&words)) {
    if (words[0] == "v") {
      mesh.text += "v ";
      TakePosition(path, lines, words, 1, &mesh);
    } else if (words[0] == "f") {
      const std::string where = lines.Where() + ": face " + std::to_string(face++);
      corners.clear();
      face_text += 'f';
      for (size_t w = 1; w < words.size(); ++w) {
        const std::string_view vertex = words[w].substr(0, words[w].find('/'));
        const auto defined = static_cast<std::int64_t>(mesh.positions.size());
        std::int64_t index = 0;
        if (!ParseInteger(vertex, &index) || index == 0) {
          throw InputError(path, where + ": '" + std::string(words[w]) +
                                     "' must be a vertex number, 1 or more, or -1 or less");
        }
        if (index < 0) index += defined + 1;  // -1 is the last vertex so far
        if (index < 1 || index > std::numeric_limits<int>::max()) {
          throw InputError(path, where + ": vertex number " + std::string(vertex) + " of " +
                                     std::to_string(defined) + " does not exist");
        }
        if (index > highest) {
          highest = index;
          highest_where = where;
        }
        corners.push_back(index);
        face_text += ' ' + std::to_string(index);
      }
      face_text += '\n';
      std::sort(corners.begin(), corners.end());
      const bool has_area = std::unique(corners.begin(), corners.end()) - corners.begin() >= 3;
      ++(has_area ? mesh.face_count : mesh.skipped_face_count);
    }
  }
  if (mesh.positions.empty()) throw InputError(path, "v lines: the mesh has no vertices");
  if (face == 0) throw InputError(path, "f lines: the mesh has no faces");
  if (highest > static_cast<std::int64_t>(mesh.positions.size())) {
    throw InputError(path, highest_where + ": vertex number " + std::to_string(highest) + " of " +
                               std::to_string(mesh.positions.size()) + " does not exist");
  }
  mesh.text += face_text;
  return mesh;
}

ScannedMesh ScanOff(const std::filesystem::path& path, const std::string& data) {
  ScannedMesh mesh;
  LineReader lines(data);
  std::vector<std::string_view> words;
  const auto fail = [&](const std::string& reason) { throw InputError(path, reason); };
  if (!lines.Next(&words)) fail("header: the file is empty");
  if (words[0] != "OFF" && words[0] != "COFF" && words[0] != "NOFF" && words[0] != "CNOFF" &&
      words[0] != "STOFF" && words[0] != "STCOFF" && words[0] != "STNOFF" &&
      words[0] != "STCNOFF") {
    fail("header: '" + std::string(words[0].substr(0, 16)) + "' must be OFF, COFF, NOFF or STOFF");
  }
  words.erase(words.begin());
  if (!words.empty() && words[0] == "BINARY") fail("header: BINARY is not supported, must be text");
  if (words.empty()) lines.Next(&words);
  std::int64_t vertex_count = 0;
  if (words.size() < 2 || !ParseInteger(words[0], &vertex_count) ||
      !ParseInteger(words[1], &mesh.face_count)) {
    fail("header: must give the numbers of vertices and faces");
  }
  if (vertex_count <= 0) fail("header: the mesh has no vertices");
  if (mesh.face_count <= 0) fail("header: the mesh has no faces");
  // "0 0 0\n" and "3 0 0 0\n" are the shortest lines.
  const auto left = static_cast<std::int64_t>(lines.BytesLeft()) + 1;
  if (vertex_count > left / 6)
    fail("header: " + std::to_string(vertex_count) + " vertices are more than the file holds");
  if (mesh.face_count > left / 2)
    fail("header: " + std::to_string(mesh.face_count) + " faces are more than the file holds");
  mesh.text =
      "OFF\n" + std::to_string(vertex_count) + " " + std::to_string(mesh.face_count) + " 0\n";
  mesh.positions.reserve(vertex_count);
  for (std::int64_t v = 0; v < vertex_count; ++v) {
    if (!lines.Next(&words)) fail("vertex " + std::to_string(v) + ": the file is truncated here");
    TakePosition(path, lines, words, 0, &mesh);
  }
  for (std::int64_t f = 0; f < mesh.face_count; ++f) {
    const std::string where = "face " + std::to_string(f);
    if (!lines.Next(&words)) fail(where + ": the file is truncated here");
    std::int64_t length = 0;
    if (!ParseInteger(words[0], &length) || length < 0) {
      fail(lines.Where() + ": " + where + ": '" + std::string(words[0]) + "' is not a count");
    }
    if (length > static_cast<std::int64_t>(words.size()) - 1) {
      fail(lines.Where() + ": " + where + ": has fewer vertices than the " +
           std::to_string(length) + " announced");
    }
    for (std::int64_t w = 0; w <= length; ++w) {
      std::int64_t index = 0;
      if (!ParseInteger(words[w], &index) || (w > 0 && (index < 0 || index >= vertex_count))) {
        fail(lines.Where() + ": " + where + ": vertex index " + std::string(words[w]) +
             " must be below the vertex count " + std::to_string(vertex_count));
      }
      mesh.text += std::to_string(index) + (w < length ? ' ' : '\n');
    }
  }
  if (lines.Next(&words))
    fail(lines.Where() + ": follows the last face, the header's counts do not match");
  return mesh;
}

}  // namespace burin
