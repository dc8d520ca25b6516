#include "tools/convert/camera_given.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/support/expect_error.h"

namespace orient {
namespace {

ExchangeCamera Camera4000() {
  ExchangeCamera camera;
  camera.name = "one";
  camera.width = 4000;
  camera.height = 3000;
  camera.pixel_mm = 0.01;
  camera.focal_px = {5000, 5000};
  camera.principal_px = {2000, 1500};
  return camera;
}

TEST(CameraGiven, ThatTheFilesHaveNeedsNoWord) {
  EXPECT_EQ(CompareWithGiven({Camera4000(), Camera4000()}, Camera4000(), "model"), "");
}

TEST(CameraGiven, ReplacesAnotherCalibrationAndSaysByHowMuch) {
  ExchangeCamera file = Camera4000();
  file.focal_px *= 1.01;  // the corner is 2500 px from the principal point
  const std::string said = CompareWithGiven({file}, Camera4000(), "model");
  EXPECT_NE(said.find("model"), std::string::npos);
  EXPECT_NE(said.find("25.0 px"), std::string::npos) << said;
}

TEST(CameraGiven, OfAnotherImageSizeIsRefused) {
  ExchangeCamera file = Camera4000();
  file.width = 640;
  ExpectError<InputError>([&] { CompareWithGiven({file}, Camera4000(), "model"); },
                          {"model", "640 x 3000", "4000 x 3000"});
}

TEST(CameraGiven, OfAnotherPrincipalDistanceIsRefused) {
  ExchangeCamera file = Camera4000();
  file.width = file.height = 0;  // as in a TSAI file
  file.focal_px *= 0.2;
  ExpectError<InputError>([&] { CompareWithGiven({file}, Camera4000(), "a.tsai"); },
                          {"a.tsai", "1000 px", "5000 px"});
}

TEST(CameraGiven, OfAnotherPrincipalDistanceInMillimetresIsRefused) {
  ExchangeCamera file;  // as in a file of PAT-B
  file.pixel_mm = 1;
  file.focal_px = {153, 153};
  ExpectError<InputError>([&] { CompareWithGiven({file}, Camera4000(), "patb.ori"); },
                          {"patb.ori", "153 mm", "50 mm"});
  file.focal_px = {50, 50};
  EXPECT_EQ(CompareWithGiven({file}, Camera4000(), "patb.ori"), "");
  EXPECT_EQ(CompareWithGiven({ExchangeCamera()}, Camera4000(), "a.ori"), "");
}

TEST(CameraGiven, IsRefusedForFilesOfSeveralCameras) {
  ExchangeCamera other = Camera4000();
  other.name = "two";
  other.k[0] = -0.03;
  ExpectError<InputError>(
      [&] {
        CompareWithGiven({Camera4000(), other}, Camera4000(), "model");
      },
      {"model", "one and two", "leave --camera out"});
}

TEST(CameraGiven, IsRefusedForFilesThatNameSeveralCamerasAndSayNoMore) {
  ExchangeCamera one, two;  // as in a folder of BINGO
  one.name = "rc10";
  two.name = "rmk";
  EXPECT_EQ(CompareWithGiven({one, one}, Camera4000(), "bingo"), "");
  try {
    CompareWithGiven({one, two}, Camera4000(), "bingo");
    ADD_FAILURE() << "not refused";
  } catch (const InputError& error) {
    const std::string said = error.what();
    EXPECT_NE(said.find("rc10 and rmk"), std::string::npos) << said;
    EXPECT_NE(said.find("convert each camera's photos by themselves"), std::string::npos) << said;
    EXPECT_EQ(said.find("leave --camera out"), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace orient
