#include "core/measurements/gathered_measurements.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/support/expect_error.h"

namespace orient {
namespace {

const ImagePointMeasurement kSeen = {"a", "p", Eigen::Vector2d(1, 2), std::nullopt, 1};

TEST(GatheredMeasurements, TakeTheSameOnceAndCountItTwice) {
  GatheredMeasurements all;
  all.Add("x, line 1", kSeen);
  all.Add("x, line 2", kSeen);
  EXPECT_EQ(all.All().image_points.size(), 1u);
  EXPECT_EQ(all.Found(), 2u);
}

TEST(GatheredMeasurements, RefuseTwoValuesNamingBothPlaces) {
  GatheredMeasurements all;
  all.Add("x, line 1", kSeen);
  ImagePointMeasurement other = kSeen;
  other.pixel->x() += 1;
  ExpectError<InputError>([&] { all.Add("y, line 7", other); },
                          {"y, line 7: point p of photo a", "x, line 1"});
  all.Add("x, line 3", GroundPoint{"p", {1, 2, 3}});
  ExpectError<InputError>(
      [&] {
        all.Add("y, line 8", GroundPoint{"p", {1, 2, 4}});
      },
      {"y, line 8: point p is given", "x, line 3"});
}

TEST(GatheredMeasurements, RefusePixelsBesideMillimetres) {
  GatheredMeasurements all;
  all.Add("x, line 1", kSeen);
  ExpectError<InputError>(
      [&] {
        all.Add("y, line 7", ImagePointMeasurement{"b", "p", std::nullopt, Eigen::Vector2d(1, 2)});
      },
      {"y, line 7", "millimetres", "pixels", "two folders"});
}

TEST(GatheredMeasurements, RefuseNamesAndSigmasThatNoTableHolds) {
  GatheredMeasurements all;
  ImagePointMeasurement bad = kSeen;
  bad.photo = "";
  ExpectError<InputError>([&] { all.Add("x, line 1", bad); }, {"x, line 1", "photo has no name"});
  bad.photo = "a\nb";
  ExpectError<InputError>([&] { all.Add("x, line 1", bad); }, {"line break"});
  bad = kSeen;
  bad.sigma = 0;
  ExpectError<InputError>([&] { all.Add("x, line 1", bad); }, {"is 0", "must lie between"});
  bad.sigma = 1e300;
  ExpectError<InputError>([&] { all.Add("x, line 1", bad); }, {"is 1e+300", "1000000"});
}

}  // namespace
}  // namespace orient
