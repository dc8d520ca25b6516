// orient cameras new and try as a user calls them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/files/camera_file.h"
#include "core/raster/raster.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"
#include "tools/commands/commands.h"

namespace orient {
namespace {

struct Outcome {
  int code = -1;
  std::string out, err;
};

class CamerasCommandTest : public testing::Test {
 protected:
  CamerasCommandTest() {
    WriteScan(scan_, frame_.scan);
    for (size_t i = 0; i < frame_.mark_pixels.size(); ++i)
      clicks_.insert(clicks_.end(), {"--mark", Click(i)});
  }

  // Rendered once.
  static const FilmFrame& Frame() {
    static const FilmFrame frame = [] {
      FilmFrameSpec spec;
      spec.camera = RingCamera(25, 60);
      spec.pixel_mm = 0.08;
      return RenderFilmFrame(spec);
    }();
    return frame;
  }

  std::string Click(size_t i) const {
    return fmt::format("{}={},{}", i + 1, std::round(frame_.mark_pixels[i].x()),
                       std::round(frame_.mark_pixels[i].y()));
  }

  static Outcome Cameras(std::vector<std::string> arguments) {
    CommandList commands;
    commands.push_back(MakeCamerasCommand());
    std::ostringstream out, err;
    arguments.insert(arguments.begin(), "cameras");
    Outcome outcome;
    outcome.code = RunProgram(commands, arguments, out, err);
    outcome.out = out.str();
    outcome.err = err.str();
    return outcome;
  }

  Outcome New(const std::vector<std::string>& further) const {
    std::vector<std::string> arguments = {"new", scan_,   "--principal-distance-mm",
                                          "153", "--out", camera_};
    arguments.insert(arguments.end(), further.begin(), further.end());
    return Cameras(arguments);
  }

  static void Expect(const Outcome& outcome, int code, const std::string& text) {
    EXPECT_EQ(outcome.code, code) << outcome.out << outcome.err;
    EXPECT_NE((outcome.out + outcome.err).find(text), std::string::npos)
        << outcome.out << outcome.err;
  }

  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }

  TemporaryFolder folder_;
  std::string scan_ = folder_ / "scan.png", camera_ = folder_ / "camera.toml";
  const FilmFrame& frame_ = Frame();
  std::vector<std::string> clicks_;
};

TEST_F(CamerasCommandTest, WhatNewWritesTryReads) {
  std::vector<std::string> arguments = clicks_;
  arguments.insert(arguments.end(), {"--pixel-size-um", "80", "--frame-mm", "60", "60"});
  Expect(New(arguments), 0, "every outline should lie on its mark");
  const CameraFile camera = ReadCameraFile(camera_);
  EXPECT_EQ(camera.fiducials.size(), 4u);
  EXPECT_EQ(camera.camera.frame_mm, Eigen::Vector2d(60, 60));
  const Raster picture = Raster::Open(folder_ / "camera.marks.png");
  EXPECT_GT(picture.Width(), 900);
  EXPECT_GT(picture.Height(), 700);

  Expect(New(arguments), 1, "--overwrite");
  Expect(Cameras({"try", camera_, scan_, "--out", folder_ / "try.png"}), 0, "used");
  EXPECT_EQ(Raster::Open(folder_ / "try.png").Height(), picture.Height());
  Expect(Cameras({"try", camera_, scan_, "--out", scan_, "--overwrite"}), 1, "is an input");
}

TEST_F(CamerasCommandTest, MarksAreReadFromMeasurements) {
  std::string marks = "photo,mark,col,row,sigma\n";
  for (size_t i = 0; i < 4; ++i)
    marks += fmt::format("scan,{},{:.1f},{:.1f},1\n", i + 1, frame_.mark_pixels[i].x(),
                         frame_.mark_pixels[i].y());
  std::filesystem::create_directory(folder_ / "said");
  Write("said/marks.csv", marks);
  Write("distances.csv", "from,to,distance_mm\n1,2,70.711\n3,4,70.711\n");
  Expect(New({"--measurements", folder_ / "said", "--distances", folder_ / "distances.csv"}), 0,
         "stated mm");
}

TEST_F(CamerasCommandTest, NewReplacesNoInput) {
  Write("camera.marks.png", "mark,x_mm,y_mm\n1,0,1\n2,1,0\n3,0,-1\n");
  Expect(New({"--mark", "1=100,100", "--overwrite", "--positions", folder_ / "camera.marks.png"}),
         1, "camera.marks.png is an input");
}

TEST_F(CamerasCommandTest, AMarkThatCannotBeReadIsUsage) {
  Expect(New({"--mark", "1=12", "--pixel-size-um", "80"}), 1, "ID=COL,ROW");
  Expect(New({"--mark", "=1,2", "--pixel-size-um", "80"}), 1, "ID=COL,ROW");
  Expect(New({"--mark", "1=a,b", "--pixel-size-um", "80"}), 1, "ID=COL,ROW");
}

TEST_F(CamerasCommandTest, AMarkTwiceIsUsage) {
  Expect(New({"--mark", "1=12,13", "--mark", "1=40,50", "--pixel-size-um", "80"}), 1, "twice");
}

TEST_F(CamerasCommandTest, AMarkOutsideTheScanIsNamed) {
  std::vector<std::string> arguments = clicks_;
  arguments.insert(arguments.end(), {"--mark", "far=90000,5", "--pixel-size-um", "80"});
  Expect(New(arguments), 2, "far");
  EXPECT_FALSE(std::filesystem::exists(camera_));
}

TEST_F(CamerasCommandTest, AnUnclickedScanSaysHowToClick) {
  Expect(New({"--pixel-size-um", "80"}), 2, "--mark ID=COL,ROW");
}

TEST_F(CamerasCommandTest, ATableOfPositionsWithoutAColumnIsNamed) {
  Write("positions.csv", "mark,x_mm\n1,5\n");
  std::vector<std::string> arguments = clicks_;
  arguments.insert(arguments.end(), {"--positions", folder_ / "positions.csv"});
  Expect(New(arguments), 2, "y_mm");
}

TEST_F(CamerasCommandTest, ADigitalCameraCannotBeTried) {
  Write("digital.toml",
        "name = \"d\"\nkind = \"digital\"\nprincipal_distance_mm = 100\nframe_mm = [60.0, 60.0]\n"
        "image_px = [600, 600]\nprincipal_point_mm = [0.0, 0.0]\n");
  Expect(Cameras({"try", folder_ / "digital.toml", scan_, "--out", folder_ / "try.png"}), 2,
         "digital");
}

}  // namespace
}  // namespace orient
