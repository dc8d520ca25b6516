#include "core/exchange/frame_measures.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.h"
#include "tests/core/exchange/texts.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

class FrameMeasures : public testing::Test {
 protected:
  void Patb(const std::string& text, const std::string& file = "block.txt") {
    all_ = {};
    std::ofstream(folder_ / file) << text;
    AddPatbMeasures(folder_ / file, {0.005, 0.05}, &all_);
  }
  void Bingo(const std::string& text) {
    all_ = {};
    std::ofstream(folder_ / "image.dat") << text;
    AddBingoMeasures(folder_ / "image.dat", {0.005, 0.05}, &all_);
  }
  void PatbRefused(const std::string& text, std::initializer_list<std::string> parts,
                   const std::string& file = "block.txt") {
    ExpectError<InputError>([&] { Patb(text, file); }, parts);
  }
  void BingoRefused(const std::string& text, std::initializer_list<std::string> parts) {
    ExpectError<InputError>([&] { Bingo(text); }, parts);
  }
  const std::vector<ImagePointMeasurement>& Seen() const { return all_.All().image_points; }
  const std::vector<GroundPoint>& Points() const { return all_.All().points; }
  std::string Notes() const { return NotesOf(all_); }

  TemporaryFolder folder_;
  GatheredMeasurements all_;
};

TEST_F(FrameMeasures, APhotosHeadingHasOneToFourWords) {
  for (const char* heading : {"11", "11 153000.0", "11 153000.0 0", "11 153000.0 0 12"}) {
    Patb(std::string(heading) + "\n1001 34214.8 -77830.8 1\n1002 -5000.0 100.5\n-99\n");
    ASSERT_EQ(Seen().size(), 2u) << heading;
    EXPECT_EQ(Seen()[0].photo, "11");
    EXPECT_NEAR(Seen()[0].photo_mm->x(), 34.2148, 1e-12);
    EXPECT_TRUE(Points().empty());
  }
}

TEST_F(FrameMeasures, AHeadingWhereAPhotosEndIsMissingIsNamed) {
  const std::string photo = "11 153000.0 0 0\n1001 34214.8 -77830.8 1\n";
  PatbRefused(photo + "12 153000.0 0 0\n1001 -34214.8 -77830.8 1\n-99\n",
              {"block.txt, line 3", "153000.0", "-99 is missing", "photo 11"});
  PatbRefused(photo + "12 153000.0\n1001 -34214.8 -77830.8 1\n-99\n",
              {"line 3", "2 words", "-99 is missing"});
  PatbRefused(photo, {"line 2", "photo 11", "not ended by -99"});
}

TEST_F(FrameMeasures, LinesThatFitNoRecordAreRefused) {
  const std::string head = "11 153000.0\n";
  PatbRefused(head + "1001 34214.8 x 1\n-99\n", {"line 2", "y is \"x\""});
  PatbRefused(head + "1001 34214.8 -77830.8 1 5 6\n-99\n", {"line 2", "6 words"});
  PatbRefused(head + "1001 34214.8 -77830.8 0.5\n-99\n", {"line 2", "\"0.5\"", "code"});
  PatbRefused(head + "1001 34214.8 -77830.8\n-99\n12 153000.0 1 2 3\n-99\n", {"line 4", "heading"});
  PatbRefused(head + "1001 34214.8 -77830.8\n-99\n1001 34214.8 -77830.8\n-99\n",
              {"line 4", "\"-77830.8\"", "heading is missing"});
  PatbRefused("", {"block.txt", "empty"});
}

TEST_F(FrameMeasures, APointMeasuredTwiceInAPhotoIsRefused) {
  PatbRefused("11 153000.0\n1001 34214.8 10.0\n1001 34214.9 10.0\n-99\n",
              {"line 3", "point 1001 of photo 11", "line 2"});
}

TEST_F(FrameMeasures, CoordinatesInAnotherUnitAreRefused) {
  PatbRefused("11 153.0\n1001 34.2148 -77.8308\n-99\n", {"77.8308", "micrometres", "--from bingo"});
  BingoRefused("11 rc30\n1001 34214.8 -77830.8\n-99\n",
               {"line 2", "34214.8", "millimetres", "--from patb"});
}

TEST_F(FrameMeasures, PhotosHaveTheNamesThatLieBeside) {
  std::ofstream(folder_ / "photo_numbers.txt") << "# number photo\n1 strip 3_0182.v2\n";
  Patb("1 153000.0\n1001 34214.8 10.0\n-99\n2 153000.0\n1001 34214.8 10.0\n-99\n");
  EXPECT_EQ(Seen()[0].photo, "strip 3_0182.v2");
  EXPECT_EQ(Seen()[1].photo, "2");
  EXPECT_NE(Notes().find("photo_numbers.txt beside: 1"), std::string::npos) << Notes();
}

TEST_F(FrameMeasures, ControlOfOneBlockHasAllThreeCoordinates) {
  Patb("1001 500000.5 5000000.0 123 1\n1002 500001.0 5000001.0 124.5 1 2\n-99\n");
  ASSERT_EQ(Points().size(), 2u);
  EXPECT_EQ(Points()[0].ground_m, Eigen::Vector3d(500000.5, 5000000, 123));
  EXPECT_EQ(Points()[1].sigma_m.x(), 0.05);
  Patb("1001 500000.5 5000000.0 123.0\n-99\n");
  EXPECT_EQ(Points()[0].ground_m.z(), 123);
}

TEST_F(FrameMeasures, ControlOfAHorizontalAndAVerticalBlockIsJoined) {
  Patb(
      "1001 500000.5 5000000.0 1\n1002 500001.0 5000001.0 1\n-99\n"
      "1002 124.5 2\n1001 123.0 2\n1003 99.0 2\n-99\n");
  ASSERT_EQ(Points().size(), 2u);
  EXPECT_EQ(Points()[0].ground_m, Eigen::Vector3d(500000.5, 5000000, 123));
  EXPECT_EQ(Points()[1].ground_m, Eigen::Vector3d(500001, 5000001, 124.5));
  EXPECT_NE(Notes().find("points with nothing but a height, left out"), std::string::npos);
  EXPECT_NE(Notes().find(": 1003"), std::string::npos) << Notes();
}

TEST_F(FrameMeasures, HorizontalControlWithoutHeightsIsLeftOutAndNamed) {
  Patb("1001 500000.5 5000000.0\n1002 500001.0 5000001.0\n-99\n");
  EXPECT_TRUE(Points().empty());
  EXPECT_NE(Notes().find("points without a height, left out"), std::string::npos);
  EXPECT_NE(Notes().find("1001, 1002"), std::string::npos);
}

TEST_F(FrameMeasures, VerticalControlAloneIsNoImageCoordinates) {
  Patb("-99\n1001 123.0 1\n-99\n");
  EXPECT_TRUE(Seen().empty());
  EXPECT_NE(Notes().find("nothing but a height"), std::string::npos);
}

TEST_F(FrameMeasures, ControlThatMayMeanTwoThingsIsRefused) {
  PatbRefused("1001 500000.5 5000000.0 1\n-99\n", {"line 1", "\"1\"", "height", "code"});
  PatbRefused("1001 500000.5 5000000.0 123.4 1\n1002 500000.5 5000000.0 2\n-99\n",
              {"line 2", "\"2\""});
  PatbRefused("1001 500000.5 5000000.0 123.4 1\n-99\n1 2.0 3\n-99\n4 5.5\n-99\n",
              {"line 5", "third block"});
  PatbRefused("1001 500000.5 5000000.0 123.4 1\n-99\n-99\n-99\n4 5.5\n-99\n",
              {"line 5", "third block"});
  PatbRefused("1001 500000.5 5000000.0 123.4 1\n", {"line 1", "not ended by -99"});
  PatbRefused("11 1001 34214.8 -77830.8\n-99\n", {"line 1", "-77830.8", "no ground"});
}

TEST_F(FrameMeasures, WhatMayBeControlOrImageCoordinatesIsAskedForTheFilesEnding) {
  const std::string text = "11 153000.0 0 0\n12 20000.0 10 1\n-99\n";
  PatbRefused(text, {"line 1", ".im", ".con"});
  Patb(text, "block.im");
  EXPECT_EQ(Seen().size(), 1u);
  PatbRefused(text, {"line 1", "\"0\"", "height"}, "block.con");
}

TEST_F(FrameMeasures, BingosControlIsOfFiveWordsAndOtherRecordsAreNoPhotos) {
  Bingo("11 rc30\n1001 34.2148 -77.8308 1\n-99\nCONT 1001 1.0 2.0 3.0\n");
  EXPECT_EQ(Seen().size(), 1u);
  EXPECT_EQ(Points()[0].ground_m, Eigen::Vector3d(1, 2, 3));
  BingoRefused("CONT 1001 1.0 2.0 3.0 0.1 0.1 0.1\n", {"line 1", "8 words"});
  BingoRefused("CONT 1001 1.0 2.0\n", {"line 1", "4 words"});
  BingoRefused("ORIA 11 1 2 3 0 0 0\n", {"line 1", "heading", "8"});
  BingoRefused("1001 34.2148 -77.8308\n-99\n", {"line 1", "\"-77.8308\"", "heading is missing"});
}

}  // namespace
}  // namespace orient
