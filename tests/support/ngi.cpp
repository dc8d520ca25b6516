#include "tests/support/ngi.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "core/terrain/reprojection.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::string PhotoNamed(const std::string& folder, const std::string& number) {
  for (const auto& entry : fs::directory_iterator(folder + "/photos"))
    if (entry.path().stem().string().find("_" + number + "_") != std::string::npos)
      return entry.path().string();
  throw std::runtime_error("no photo " + number);
}

}  // namespace

Ngi::Ngi(const std::string& data)
    : folder(data),
      camera(ReadCameraFile(data + "/camera.toml")),
      published(ReadOrientationTable(data + "/published_orientation.csv")),
      surface(GroundSurface::FromFile(data + "/dem.tif", *published.crs)) {}

std::string Ngi::Photo(const std::string& number) const { return PhotoNamed(folder, number); }

std::string Ngi::Orthophoto(const std::string& number) const {
  const std::string place = number == "0182"   ? "1"
                            : number == "0184" ? "2"
                            : number == "0251" ? "3"
                                               : "4";
  return folder + "/orthos/ngi_rgb_byte_" + place + ".tif";
}

const OrientationRow& Ngi::Published(const std::string& number) const {
  return *published.Find(PhotoName(Photo(number)));
}

void Ngi::WriteApproximations(const std::string& path, double position_m, double attitude_deg,
                              unsigned signs) const {
  OrientationTable table = published;
  for (OrientationRow& row : table.rows)
    for (int i = 0; i < 6; ++i, signs = (signs >> 1) | (signs << 31)) {
      const double sign = (signs & 1) != 0 ? 1 : -1;
      if (i < 3)
        row.pose.position_m[i] += sign * position_m;
      else
        row.pose.opk_rad[i - 3] += sign * RadFromDeg(attitude_deg);
    }
  WriteOrientationTable(path, table);
}

double Ngi::FrameRms(const ExteriorResult& result) const {
  const OrientationRow& truth = *published.Find(result.photo);
  const PhotoView view{camera.camera, DigitalPhotoFromPixel(camera.camera), truth.pose};
  return ReprojectionRms(view, *result.pose, camera.camera.image_px->x(),
                         camera.camera.image_px->y(), surface);
}

double Ngi::PositionError(const ExteriorResult& result) const {
  return (result.pose->position_m - published.Find(result.photo)->pose.position_m).norm();
}

double Ngi::AngleErrorDeg(const ExteriorResult& result) const {
  double largest = 0;
  for (int i = 0; i < 3; ++i)
    largest =
        std::max(largest, std::abs(NormalizeAngle(result.pose->opk_rad[i] -
                                                  published.Find(result.photo)->pose.opk_rad[i])));
  return DegFromRad(largest);
}

double Ngi::NormalisedError(const ExteriorResult& result) const {
  const Vector6d off = PoseDifference(*result.pose, published.Find(result.photo)->pose);
  return std::sqrt(off.dot(result.covariance->ldlt().solve(off)) / 6);
}

void ExpectOkOrPoorlyDetermined(const ExteriorResult& result) {
  if (result.status == Status::kOk) return;
  EXPECT_EQ(result.status, Status::kWeak) << result.photo;
  EXPECT_TRUE(std::any_of(result.findings.begin(), result.findings.end(), [](const Finding& told) {
    return told.reason == Reason::kPoorlyDetermined;
  })) << result.photo;
}

}  // namespace orient
