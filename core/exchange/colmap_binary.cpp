#include "core/exchange/colmap_binary.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "core/base/atomic_write.h"
#include "core/base/error.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little);

// src/colmap/sensor/models.h: a model's number is its index here.
constexpr std::array<const char*, 7> kModelOfNumber = {
    "SIMPLE_PINHOLE", "PINHOLE",        "SIMPLE_RADIAL", "RADIAL",
    "OPENCV",         "OPENCV_FISHEYE", "FULL_OPENCV"};
// Largest plausible side of an image or a camera, px.
constexpr std::uint64_t kLargestSide = 1000000;

class Bytes {
 public:
  explicit Bytes(std::string path) : path_(std::move(path)), bytes_(ReadFile(path_)) {}

  template <typename Value>
  Value Next(const char* what) {
    if (bytes_.size() - at_ < sizeof(Value)) Fail(fmt::format("ends where {} is expected", what));
    Value value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(Value));
    at_ += sizeof(Value);
    return value;
  }

  double Number(const char* what) {
    const auto number = Next<double>(what);
    if (!std::isfinite(number)) Fail(fmt::format("{} is not finite", what));
    return number;
  }

  int Side(const char* what) {
    const auto side = Next<std::uint64_t>(what);
    if (side > kLargestSide) Fail(fmt::format("{} is {} pixels", what, side));
    return static_cast<int>(side);
  }

  // How many records of at least `size` bytes follow.
  std::uint64_t Count(const char* what, std::size_t size) {
    const auto count = Next<std::uint64_t>(what);
    if (count > (bytes_.size() - at_) / size)
      Fail(fmt::format("{} is {}: so many are not in the file", what, count));
    return count;
  }

  void RequireEnd() const {
    if (at_ != bytes_.size())
      Fail(
          fmt::format("{} bytes follow the last record; the count at the file's beginning is wrong",
                      bytes_.size() - at_));
  }

  std::string Name() {
    const auto end = bytes_.find('\0', at_);
    if (end == std::string::npos) Fail("ends within an image's name");
    std::string name = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    if (name.empty()) Fail("an image has no name");
    return name;
  }

  [[noreturn]] void Fail(const std::string& complaint) const {
    throw InputError(fmt::format("{}, byte {}: {}", path_, at_, complaint));
  }

 private:
  std::string path_, bytes_;
  std::size_t at_ = 0;
};

std::string PathOf(const std::string& directory, const char* file) {
  return (fs::path(directory) / file).string();
}

std::map<int, ColmapCamera> ReadCameras(const std::string& directory) {
  Bytes bytes(PathOf(directory, "cameras.bin"));
  std::map<int, ColmapCamera> cameras;
  const std::uint64_t count = bytes.Count("the number of cameras", 24);
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto id = bytes.Next<std::int32_t>("CAMERA_ID");
    const auto number = bytes.Next<std::int32_t>("MODEL");
    ColmapCamera camera;
    if (number >= 0 && number < static_cast<int>(kModelOfNumber.size()))
      camera.model = kModelOfNumber[static_cast<std::size_t>(number)];
    const auto known = kColmapModels.find(camera.model);
    if (known == kColmapModels.end())
      bytes.Fail(
          fmt::format("camera model {} is not supported; undistort the images to PINHOLE or "
                      "OPENCV first",
                      camera.model.empty() ? std::to_string(number) : camera.model));
    camera.width = bytes.Side("WIDTH");
    camera.height = bytes.Side("HEIGHT");
    for (std::size_t k = 0; k < known->second; ++k) camera.params.push_back(bytes.Number("PARAMS"));
    if (!cameras.emplace(id, camera).second) bytes.Fail(fmt::format("a second camera {}", id));
  }
  bytes.RequireEnd();
  return cameras;
}

// A point of an image in images.bin.
struct Seen {
  std::uint64_t point = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};
constexpr std::uint64_t kNoPoint = ~std::uint64_t{0};

// `seen` null: points are skipped.
std::vector<ColmapImage> ReadImages(const std::string& directory,
                                    std::vector<std::vector<Seen>>* seen) {
  Bytes bytes(PathOf(directory, "images.bin"));
  std::vector<ColmapImage> images;
  const std::uint64_t count = bytes.Count("the number of images", 73);
  for (std::uint64_t i = 0; i < count; ++i) {
    ColmapImage image;
    bytes.Next<std::int32_t>("IMAGE_ID");
    for (int k = 0; k < 4; ++k) image.qvec[k] = bytes.Number("Q");
    for (int k = 0; k < 3; ++k) image.tvec[k] = bytes.Number("T");
    image.camera = bytes.Next<std::int32_t>("CAMERA_ID");
    image.name = bytes.Name();
    if (!(image.qvec.norm() > 0.5)) bytes.Fail("the quaternion is not of unit length");
    const std::uint64_t points = bytes.Count("the number of an image's points", 24);
    std::vector<Seen> of_image;
    for (std::uint64_t k = 0; k < points; ++k) {
      Seen point;
      point.pixel.x() = bytes.Number("X");
      point.pixel.y() = bytes.Number("Y");
      point.point = bytes.Next<std::uint64_t>("POINT3D_ID");
      if (seen && point.point != kNoPoint) of_image.push_back(point);
    }
    images.push_back(std::move(image));
    if (seen) seen->push_back(std::move(of_image));
  }
  bytes.RequireEnd();
  return images;
}

std::map<std::uint64_t, Eigen::Vector3d> ReadPoints(const std::string& path) {
  Bytes bytes(path);
  std::map<std::uint64_t, Eigen::Vector3d> points;
  const std::uint64_t count = bytes.Count("the number of points", 51);
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto id = bytes.Next<std::uint64_t>("POINT3D_ID");
    Eigen::Vector3d ground;
    for (int k = 0; k < 3; ++k) ground[k] = bytes.Number("X Y Z");
    bytes.Next<std::array<std::uint8_t, 3>>("R G B");
    bytes.Next<double>("ERROR");
    const std::uint64_t rays = bytes.Count("the length of a track", 8);
    for (std::uint64_t k = 0; k < rays; ++k) bytes.Next<std::uint64_t>("TRACK");
    points[id] = ground;
  }
  bytes.RequireEnd();
  return points;
}

}  // namespace

bool HoldsBinaryColmap(const std::string& directory) {
  return fs::exists(PathOf(directory, "images.bin")) ||
         fs::exists(PathOf(directory, "cameras.bin"));
}

ColmapModel ReadBinaryColmap(const std::string& directory) {
  return {ReadCameras(directory), ReadImages(directory, nullptr)};
}

std::vector<ColmapObservation> ReadBinaryColmapObservations(const std::string& directory) {
  const std::string path = PathOf(directory, "points3D.bin");
  if (!fs::exists(path)) return {};
  const auto points = ReadPoints(path);
  std::vector<std::vector<Seen>> seen;
  const std::vector<ColmapImage> images = ReadImages(directory, &seen);
  std::vector<ColmapObservation> observations;
  for (std::size_t i = 0; i < images.size(); ++i)
    for (const Seen& point : seen[i])
      if (const auto found = points.find(point.point); found != points.end())
        observations.push_back({images[i].name, found->second, point.pixel});
  return observations;
}

}  // namespace orient
