// Camera files, written and read back.
#include <gtest/gtest.h>

#include <filesystem>

#include "core/geometry/rotation.h"
#include "tests/core/files/camera_texts.h"

namespace orient {
namespace {

constexpr double kExact = 1e-12;

TEST(CameraFile, Roundtrip) {
  const TemporaryFolder folder;
  CameraFile file = ReadText(kFilm);
  file.camera.name = "a \"quoted\" \\ name\twith \xC3\xBC";
  WriteFileAtomically(folder / "notch.png", "");
  file.marks["n.1"] = {{}, MarkBackground::kImage, MarkImage{folder / "notch.png", 0.025, {7, 8}}};
  file.fiducials[3].mark = "n.1";
  WriteCameraFile(folder / "camera.toml", file);
  const CameraFile read = ReadCameraFile(folder / "camera.toml");
  EXPECT_EQ(read.camera.name, file.camera.name);
  EXPECT_EQ(read.camera.principal_point_mm, file.camera.principal_point_mm);
  EXPECT_EQ(read.camera.frame_centre_mm, file.camera.frame_centre_mm);
  EXPECT_EQ(std::get<BrownDistortion>(read.camera.lens).k,
            std::get<BrownDistortion>(file.camera.lens).k);
  ASSERT_EQ(read.fiducials.size(), 4u);
  EXPECT_EQ(read.fiducials[1].symbol->step_mm, file.fiducials[1].symbol->step_mm);
  EXPECT_EQ(read.fiducials[3].mark, "n.1");
  const auto& cross = std::get<CrossElement>(read.marks.at("corner").elements.at(0));
  EXPECT_NEAR(cross.angle_rad, RadFromDeg(45), kExact);
  EXPECT_EQ(read.marks.at("n.1").image->path, folder / "notch.png");
  EXPECT_EQ(read.marks.at("n.1").image->centre_px, Eigen::Vector2d(7, 8));
}

TEST(CameraFile, DigitalAndRadialTableRoundtrip) {
  const TemporaryFolder folder;
  CameraFile file = ReadText(kDigital);
  file.camera.lens = RadialTable{{0, 20, 40.5}, {0, 1.2, -0.8}};
  WriteCameraFile(folder / "camera.toml", file);
  const CameraFile read = ReadCameraFile(folder / "camera.toml");
  EXPECT_EQ(read.camera.image_px, file.camera.image_px);
  EXPECT_EQ(std::get<RadialTable>(read.camera.lens).radius_mm, (std::vector<double>{0, 20, 40.5}));
}

TEST(CameraFile, WhatMakesTheBorderAsymmetricRoundtrips) {
  const TemporaryFolder folder;
  CameraFile file = ReadText(kFilm);
  EXPECT_FALSE(file.data_strip);
  EXPECT_TRUE(file.border.empty());
  file.data_strip = FrameSide::kBottom;
  file.border = {{BorderSign::kText, {-114, -80}, {-107, 20}},
                 {BorderSign::kDark, {90, 100}, {106, 106}},
                 {BorderSign::kBright, {-3, -110}, {3, -106}}};
  WriteCameraFile(folder / "camera.toml", file);
  const CameraFile read = ReadCameraFile(folder / "camera.toml");
  EXPECT_EQ(read.data_strip, FrameSide::kBottom);
  ASSERT_EQ(read.border.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read.border[i].shows, file.border[i].shows);
    EXPECT_EQ(read.border[i].from_mm, file.border[i].from_mm);
    EXPECT_EQ(read.border[i].to_mm, file.border[i].to_mm);
  }
}

TEST(CameraFile, CornersOfABorderFeatureMayComeInAnyOrder) {
  const CameraFile file =
      ReadText(kFilm + "[[border]]\nshows = \"text\"\nfrom_mm = [-107, -80]\nto_mm = [-114, 20]\n");
  EXPECT_EQ(file.border.at(0).from_mm, Eigen::Vector2d(-114, -80));
  EXPECT_EQ(file.border.at(0).to_mm, Eigen::Vector2d(-107, 20));
}

}  // namespace
}  // namespace orient
