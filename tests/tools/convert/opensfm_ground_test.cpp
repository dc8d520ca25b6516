// The ground system of an OpenSfM reconstruction: its own, or the one OpenDroneMap puts in its
// place.
#include "tools/convert/opensfm_ground.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/terrain/geocentric.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"
#include "tests/tools/convert/two_photos.h"

namespace orient {
namespace {
namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

constexpr int kPhotos = 24;
constexpr double kHeight_m = 300;
const Eigen::Vector2d kOffset(580000, 5003000);

// A strip flown to and fro, 80 km east of the central meridian: a convergence of 0.7 degrees.
ConvertSource Flight(double east_m) {
  ConvertSource source = TwoPhotos();
  source.block.photos.clear();
  source.block.points.clear();
  source.ground_height_m.assign(kPhotos, kHeight_m);
  for (int i = 0; i < kPhotos; ++i) {
    ExchangePhoto photo;
    photo.image = std::to_string(100 + i) + ".tif";
    const int column = i / 6, row = i % 6;
    SetPose({{east_m + 400 * column, 5003000 + 250.0 * row, 1500 + 3.0 * i},
             {0.02, -0.01 * row, column % 2 == 0 ? 1.5 : -1.6}},
            &photo);
    source.block.photos.push_back(photo);
  }
  return source;
}

Vector3d ToVector(const Json& v) {
  return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()};
}
Json ToArray(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

class OpensfmGround : public testing::Test {
 protected:
  // As OpenSfM leaves a flight with GPS of some decimetres.
  void Write(const ConvertSource& source) {
    WriteExports(source, {{ExchangeFormat::kOpensfm}, folder_.Path(), 0, {}});
    fs::remove(fs::path(Input()) / "export.json");
    std::mt19937 random(7);
    std::normal_distribution<double> noise(0, 0.6);
    Json json = Read();
    for (auto& shot : json[0]["shots"])
      shot["gps_position"] =
          ToArray(ToVector(shot["gps_position"]) + Vector3d(noise(random), noise(random), 2));
    Store(json);
  }

  // opensfm/actions/export_geocoords.py: the rows of A and b are differences of projected points.
  void ExportGeocoords() {
    Json json = Read();
    const Json lla = json[0]["reference_lla"];
    const Topocentric local(
        {RadFromDeg(lla["latitude"]), RadFromDeg(lla["longitude"]), lla["altitude"].get<double>()});
    const CoordinateTransform transform = CoordinateTransform::Between("EPSG:32635", "EPSG:4326");
    const auto projected = [&](const Vector3d& p) {
      const Geodetic at = GeodeticFromGeocentric(local.GeocentricFromLocal(p));
      const auto xy = *transform({DegFromRad(at.longitude_rad), DegFromRad(at.latitude_rad)});
      return Vector3d(xy.x(), xy.y(), at.height_m);
    };
    const Vector3d zero = projected(Vector3d::Zero());
    Matrix3d a;
    for (int i = 0; i < 3; ++i) a.col(i) = projected(Vector3d::Unit(i)) - zero;
    const Vector3d b = zero - Vector3d(kOffset.x(), kOffset.y(), 0);
    for (auto& shot : json[0]["shots"]) {
      const Vector3d turn = ToVector(shot["rotation"]), t = ToVector(shot["translation"]);
      const Matrix3d r = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
      // Kept as it is, no rotation any more, and written as the rotation vector of its quaternion.
      const Matrix3d turned = r * a.inverse();
      const Eigen::AngleAxisd axis(turned);
      shot["rotation"] = ToArray(axis.angle() * axis.axis());
      shot["translation"] = ToArray(-turned * (a * (-r.transpose() * t) + b));
    }
    Store(json);
  }

  void ShiftGps() {
    Json json = Read();
    for (auto& shot : json[0]["shots"])
      shot["gps_position"] = ToArray(ToVector(shot["gps_position"]) + Vector3d(500, 500, 0));
    Store(json);
  }

  void WithoutGps() {
    Json json = Read();
    for (auto& shot : json[0]["shots"]) shot["gps_dop"] = 999999.0;
    Store(json);
  }

  ConvertSource ReadBack(const std::optional<Eigen::Vector2d>& offset = {}) const {
    ConvertSourceOptions options;
    options.input = Input();
    options.crs = "EPSG:32635";
    options.ground_height_m = kHeight_m;
    options.opensfm_offset = offset;
    return ReadForeign(ExchangeFormat::kOpensfm, options);
  }

  // What the way into the topocentric system and back leaves.
  static void ExpectSame(const ConvertSource& read, const ConvertSource& written,
                         double tolerance_m = 0.02) {
    ASSERT_EQ(read.block.photos.size(), written.block.photos.size());
    for (std::size_t i = 0; i < read.block.photos.size(); ++i) {
      const ExchangePhoto &a = read.block.photos[i], &b = written.block.photos[i];
      EXPECT_LT((a.centre - b.centre).norm(), tolerance_m) << a.image;
      EXPECT_LT((a.ground_from_photo - b.ground_from_photo).norm(), 2e-5) << a.image;
    }
  }

  static bool Says(const ConvertSource& read, const std::string& part) {
    for (const std::string& message : read.messages)
      if (message.find(part) != std::string::npos) return true;
    return false;
  }

  std::string Input() const { return folder_ / "opensfm"; }

  Json Read() const { return Json::parse(ReadFile(Path())); }
  void Store(const Json& json) const { WriteFileAtomically(Path(), json.dump()); }
  std::string Path() const { return (fs::path(Input()) / "reconstruction.json").string(); }

  const TemporaryFolder folder_;
};

TEST_F(OpensfmGround, OpensfmsOwnIsTopocentric) {
  const ConvertSource flight = Flight(580000);
  Write(flight);
  const ConvertSource read = ReadBack();
  ExpectSame(read, flight);
  EXPECT_TRUE(Says(read, "the poses are topocentric"));
}

TEST_F(OpensfmGround, OpenDroneMapsIsProjectedAndItsCoordsHoldTheOffset) {
  const ConvertSource flight = Flight(580000);
  Write(flight);
  ExportGeocoords();
  WriteFileAtomically(folder_ / "opensfm/coords.txt", "WGS84 UTM 35N\n580000 5003000\n1 2 3\n");
  const ConvertSource read = ReadBack();
  ExpectSame(read, flight);
  EXPECT_TRUE(Says(read, "the poses are in a projected system minus an offset"));
}

TEST_F(OpensfmGround, WithoutTheOffsetAProjectedOneIsRefused) {
  const ConvertSource flight = Flight(580000);
  Write(flight);
  ExportGeocoords();
  ExpectError<InputError>([&] { ReadBack(); }, {"projected system minus an offset", "--offset"});
  ExpectSame(ReadBack(kOffset), flight);
  // Another block's offset.
  ExpectError<InputError>([&] { ReadBack(kOffset + Eigen::Vector2d(2000, 0)); },
                          {"neither as topocentric", "200"});
}

TEST_F(OpensfmGround, AnOffsetOfATopocentricOneIsRefused) {
  Write(Flight(580000));
  ExpectError<InputError>([&] { ReadBack(kOffset); },
                          {"--offset", "topocentric", "leave --offset"});
}

TEST_F(OpensfmGround, ReferencesOffTheEarthAreNamed) {
  Write(Flight(580000));
  Json json = Read();
  json[0]["reference_lla"]["latitude"] = 95;
  Store(json);
  ExpectError<InputError>([&] { ReadBack(); }, {"latitude", "95"});
}

TEST_F(OpensfmGround, WhatFitsNeitherIsRefused) {
  Write(Flight(580000));
  Json json = Read();
  for (auto& shot : json[0]["shots"]) {
    const Vector3d gps = ToVector(shot["gps_position"]);
    shot["gps_position"] = ToArray({-gps.y(), gps.x(), gps.z()});
  }
  Store(json);
  ExpectError<InputError>([&] { ReadBack(); }, {"gps_position", "neither", "90.0"});
}

// Of another datum, another reference: it turns nothing.
TEST_F(OpensfmGround, GpsThatIsShiftedAsAWholeSpeaksForNoSystem) {
  const ConvertSource flight = Flight(580000);
  Write(flight);
  ShiftGps();
  const ConvertSource read = ReadBack();
  ExpectSame(read, flight);
  EXPECT_TRUE(Says(read, "the poses are topocentric"));
  EXPECT_TRUE(Says(read, "707.") || Says(read, "706.")) << "how far away they are is said";
  ExportGeocoords();
  ExpectError<InputError>([&] { ReadBack(); }, {"projected system minus an offset", "--offset"});
}

TEST_F(OpensfmGround, FarFromGpsWhereTheTurnTellsNothingIsRefused) {
  Write(Flight(500000 - 600));
  ShiftGps();
  ExpectError<InputError>([&] { ReadBack(); }, {"neither", "707 m away"});
}

TEST_F(OpensfmGround, OnTheCentralMeridianNothingTellsAndThatIsSaid) {
  const ConvertSource flight = Flight(500000 - 600);
  Write(flight);
  const ConvertSource read = ReadBack();
  ExpectSame(read, flight);
  EXPECT_TRUE(Says(read, "might as well be projected"));
}

TEST_F(OpensfmGround, WithoutGpsTheFormatsDefinitionHoldsAndThatIsSaid) {
  const ConvertSource flight = Flight(580000);
  Write(flight);
  WithoutGps();
  const ConvertSource read = ReadBack();
  ExpectSame(read, flight);
  EXPECT_TRUE(Says(read, "no GPS positions"));
  // What OpenDroneMap keeps beside its own.
  fs::copy_file(Path(), fs::path(Input()) / "reconstruction.topocentric.json");
  ExportGeocoords();
  ExpectError<InputError>([&] { ReadBack(); }, {"--offset"});
  ExpectSame(ReadBack(kOffset), flight);
}

TEST_F(OpensfmGround, FurtherReconstructionsAreNamed) {
  Write(Flight(580000));
  Json json = Read();
  json.push_back(json[0]);
  Store(json);
  EXPECT_TRUE(Says(ReadBack(), "the first of 2 reconstructions"));
}

}  // namespace
}  // namespace orient
