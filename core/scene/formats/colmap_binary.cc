// Binary form of a COLMAP model: little-endian, packed, with a count before every list.
#include <cstring>

#include "core/scene/formats/colmap_model.h"
#include "core/support/atomic_file.h"
#include "core/support/error.h"
#include "core/support/file_bytes.h"

namespace burin {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "numbers are copied from and to the files as they are");

// Bytes of the fixed part of each element, for comparing a count with what is left of the file.
constexpr std::size_t kCameraBytes = 4 + 4 + 8 + 8 + 2 * 8;  // no model has fewer parameters
constexpr std::size_t kImageBytes = 4 + 7 * 8 + 4 + 1 + 8;   // an empty name, no observations
constexpr std::size_t kObservationBytes = 8 + 8 + 8;
constexpr std::size_t kPointBytes = 8 + 3 * 8 + 3 + 8 + 8;  // an empty track
constexpr std::size_t kTrackElementBytes = 4 + 4;

// Reads values in turn and knows which element it is in, for messages.
class Bytes {
 public:
  explicit Bytes(const std::filesystem::path& path) : path_(path), bytes_(ReadFileBytes(path)) {}

  void SetElement(const std::string& element) { element_ = element + ": "; }

  template <typename T>
  T Read(const char* field) {
    T value;
    std::memcpy(&value, Take(sizeof(T), field), sizeof(T));
    return value;
  }

  template <int kSize>
  Eigen::Matrix<double, kSize, 1> ReadVector(const char* field) {
    Eigen::Matrix<double, kSize, 1> vector;
    std::memcpy(vector.data(), Take(kSize * sizeof(double), field), kSize * sizeof(double));
    return vector;
  }

  // A count of elements of at least element_bytes each, which the rest of the file has room for.
  std::size_t ReadCount(std::size_t element_bytes, const char* field) {
    const auto count = Read<std::uint64_t>(field);
    if (count > Left() / element_bytes) {
      Fail(field, "is " + std::to_string(count) + ", which needs at least " +
                      std::to_string(element_bytes) + " bytes each, but only " +
                      std::to_string(Left()) + " bytes follow");
    }
    return count;
  }

  std::string ReadName(const char* field) {
    const std::size_t end = bytes_.find('\0', position_);
    if (end == std::string::npos) Fail(field, "the file ends before the name does");
    std::string name = bytes_.substr(position_, end - position_);
    position_ = end + 1;
    return name;
  }

  void Skip(std::size_t count, const char* field) { Take(count, field); }

  void ExpectEnd() {
    element_.clear();
    if (Left() > 0) {
      Fail("end of file", std::to_string(Left()) + " bytes follow the last element");
    }
  }

 private:
  std::size_t Left() const { return bytes_.size() - position_; }

  const char* Take(std::size_t count, const char* field) {
    if (count > Left()) {
      Fail(field, "the file is truncated: " + std::to_string(count) + " bytes needed, " +
                      std::to_string(Left()) + " left");
    }
    const char* data = bytes_.data() + position_;
    position_ += count;
    return data;
  }

  [[noreturn]] void Fail(const std::string& field, const std::string& reason) const {
    throw InputError(path_, element_ + field + ": " + reason);
  }

  std::filesystem::path path_;
  std::string bytes_;
  std::size_t position_ = 0;
  std::string element_;
};

// A file: a count, then elements that begin with their id; read(bytes, element) takes the rest of one.
template <typename Element, typename ReadRest>
std::vector<Element> ReadElements(const std::filesystem::path& path, const char* name,
                                  const char* id_field, std::size_t least_bytes,
                                  const ReadRest& read) {
  Bytes bytes(path);
  const std::string count_field = "number of " + std::string(name) + "s";
  std::vector<Element> elements(bytes.ReadCount(least_bytes, count_field.c_str()));
  for (Element& element : elements) {
    element.id = bytes.Read<decltype(element.id)>(id_field);
    bytes.SetElement(name + (" " + std::to_string(element.id)));
    read(&bytes, &element);
  }
  bytes.ExpectEnd();
  return elements;
}

std::vector<ColmapCamera> ReadCameras(const std::filesystem::path& path) {
  return ReadElements<ColmapCamera>(
      path, "camera", "CAMERA_ID", kCameraBytes, [&path](Bytes* bytes, ColmapCamera* camera) {
        camera->model = FindCameraModel(bytes->Read<std::int32_t>("MODEL"), camera->id, path);
        camera->width = bytes->Read<std::uint64_t>("WIDTH");
        camera->height = bytes->Read<std::uint64_t>("HEIGHT");
        for (int i = 0; i < camera->model->ParameterCount(); ++i) {
          camera->parameters.push_back(bytes->Read<double>("PARAMS"));
        }
      });
}

std::vector<ColmapImage> ReadImages(const std::filesystem::path& path) {
  return ReadElements<ColmapImage>(
      path, "image", "IMAGE_ID", kImageBytes, [](Bytes* bytes, ColmapImage* image) {
        image->quaternion = bytes->ReadVector<4>("QW, QX, QY, QZ");
        image->translation = bytes->ReadVector<3>("TX, TY, TZ");
        image->camera_id = bytes->Read<std::uint32_t>("CAMERA_ID");
        image->name = bytes->ReadName("NAME");
        image->observations.resize(bytes->ReadCount(kObservationBytes, "number of POINTS2D"));
        for (ColmapObservation& observation : image->observations) {
          observation.image_point = bytes->ReadVector<2>("POINTS2D X, Y");
          observation.point_id = bytes->Read<std::uint64_t>("POINTS2D POINT3D_ID");
        }
      });
}

std::vector<ColmapPoint> ReadPoints(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return {};
  return ReadElements<ColmapPoint>(
      path, "point", "POINT3D_ID", kPointBytes, [](Bytes* bytes, ColmapPoint* point) {
        point->position = bytes->ReadVector<3>("X, Y, Z");
        bytes->Skip(3, "R, G, B");
        bytes->Skip(sizeof(double), "ERROR");
        point->track.resize(bytes->ReadCount(kTrackElementBytes, "length of TRACK"));
        for (ColmapTrackElement& seen : point->track) {
          seen.image_id = bytes->Read<std::uint32_t>("TRACK IMAGE_ID");
          seen.observation = bytes->Read<std::uint32_t>("TRACK POINT2D_IDX");
        }
      });
}

template <typename T>
void Append(T value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(T));
}

template <typename Vector>
void AppendVector(const Vector& vector, std::string* bytes) {
  for (Eigen::Index i = 0; i < vector.size(); ++i) Append<double>(vector[i], bytes);
}

template <typename Element, typename AppendRest>
void WriteElements(const std::vector<Element>& elements, const std::filesystem::path& path,
                   const AppendRest& append) {
  std::string bytes;
  Append<std::uint64_t>(elements.size(), &bytes);
  for (const Element& element : elements) {
    Append(element.id, &bytes);
    append(element, &bytes);
  }
  WriteTextAtomically(path, bytes);
}

}  // namespace

ColmapModel ReadColmapBinary(const ColmapFiles& files) {
  return {ReadCameras(files.cameras), ReadImages(files.images), ReadPoints(files.points)};
}

void WriteColmapBinary(const ColmapModel& model, const ColmapFiles& files) {
  WriteElements(model.cameras, files.cameras, [](const ColmapCamera& camera, std::string* bytes) {
    Append<std::int32_t>(camera.model->id, bytes);
    Append<std::uint64_t>(camera.width, bytes);
    Append<std::uint64_t>(camera.height, bytes);
    for (const double parameter : camera.parameters) Append<double>(parameter, bytes);
  });
  WriteElements(model.images, files.images, [](const ColmapImage& image, std::string* bytes) {
    AppendVector(image.quaternion, bytes);
    AppendVector(image.translation, bytes);
    Append<std::uint32_t>(image.camera_id, bytes);
    bytes->append(image.name.c_str(), image.name.size() + 1);
    Append<std::uint64_t>(image.observations.size(), bytes);
    for (const ColmapObservation& observation : image.observations) {
      AppendVector(observation.image_point, bytes);
      Append<std::uint64_t>(observation.point_id, bytes);
    }
  });
  WriteElements(model.points, files.points, [](const ColmapPoint& point, std::string* bytes) {
    AppendVector(point.position, bytes);
    for (int channel = 0; channel < 3; ++channel) Append<std::uint8_t>(point.gray, bytes);
    Append<double>(point.error, bytes);
    Append<std::uint64_t>(point.track.size(), bytes);
    for (const ColmapTrackElement& seen : point.track) {
      Append<std::uint32_t>(seen.image_id, bytes);
      Append<std::uint32_t>(seen.observation, bytes);
    }
  });
}

}  // namespace burin
