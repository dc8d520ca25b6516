// Real scanned film frames, marks measured by eye beside them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "interior/interior.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr double kCommonPx = 0.3;

struct HandMark {
  std::string name;
  Vector2d pixel;
  double sigma_px = 0;
};

std::vector<HandMark> HandMarks(const std::string& folder, const std::string& frame) {
  std::ifstream file(folder + "/marks.csv");
  std::vector<HandMark> marks;
  for (std::string line; std::getline(file, line);) {
    std::stringstream cells(line);
    std::string of_frame, name, col, row, sigma;
    std::getline(cells, of_frame, ',');
    std::getline(cells, name, ',');
    std::getline(cells, col, ',');
    std::getline(cells, row, ',');
    std::getline(cells, sigma, ',');
    if (of_frame == frame && !col.empty())
      marks.push_back({name, {std::stod(col), std::stod(row)}, std::stod(sigma)});
  }
  return marks;
}

InteriorResult Orient(const std::string& folder, const std::string& frame,
                      const std::string& camera_name) {
  const CameraFile camera = ReadCameraFile(ProjectFile("data/cameras/" + camera_name));
  return OrientInterior(Raster::Open(folder + "/" + frame + ".jpg"), camera, ShapesOf(camera));
}

HandMark Nearest(const std::vector<HandMark>& hand, const Vector2d& pixel) {
  return *std::min_element(hand.begin(), hand.end(), [&](const HandMark& a, const HandMark& b) {
    return (a.pixel - pixel).norm() < (b.pixel - pixel).norm();
  });
}

// Three sigma of the measurement by eye, and what its two passes may have in common.
void ExpectAtAHandMark(const std::vector<HandMark>& hand, const MarkResult& mark) {
  const HandMark nearest = Nearest(hand, *mark.pixel);
  EXPECT_LT((nearest.pixel - *mark.pixel).norm(), 3 * nearest.sigma_px + kCommonPx)
      << mark.id << " at " << nearest.name;
}

struct FrameAndCamera {
  std::string frame, camera;
  friend std::ostream& operator<<(std::ostream& out, const FrameAndCamera& value) {
    return out << value.frame << " with " << value.camera;
  }
};
class ClearFrame : public testing::TestWithParam<FrameAndCamera> {};

TEST_P(ClearFrame, IsOkWithEveryMarkAtItsHandMark) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  const InteriorResult result = Orient(folder, GetParam().frame, GetParam().camera);
  ASSERT_EQ(result.status, Status::kOk);
  EXPECT_EQ(result.polarity, Polarity::kPositive);
  EXPECT_FALSE(result.orientation);
  const auto hand = HandMarks(folder, GetParam().frame);
  for (const MarkResult& mark : result.marks) {
    ASSERT_EQ(mark.state, MarkState::kUsed) << mark.id;
    ExpectAtAHandMark(hand, mark);
  }
}
INSTANTIATE_TEST_SUITE_P(Frames, ClearFrame,
                         testing::Values(FrameAndCamera{"0bbe1004", "wild_rc10.toml"},
                                         FrameAndCamera{"0c8e8831", "wild_rc10.toml"},
                                         FrameAndCamera{"5bdd5cf4", "wild_rc10.toml"},
                                         FrameAndCamera{"66685fc2", "wild_18cm.toml"},
                                         // dots of one pixel, found by the notches beside them
                                         FrameAndCamera{"0b4cb981", "zeiss_rmk_mid.toml"}));

// Three usable corner marks on a curled print: no more than weak.
TEST(CurledPrint, IsNotOk) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  const InteriorResult result = Orient(folder, "0cec8b13", "wild_rc8_23.toml");
  EXPECT_NE(result.status, Status::kOk);
  EXPECT_FALSE(result.findings.empty());
}

// A frame read with a camera file that is not its own has no right answer but "not ok".
class WrongCamera : public testing::TestWithParam<FrameAndCamera> {};

TEST_P(WrongCamera, IsNotOk) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  const InteriorResult result = Orient(folder, GetParam().frame, GetParam().camera);
  EXPECT_NE(result.status, Status::kOk);
}
INSTANTIATE_TEST_SUITE_P(Frames, WrongCamera,
                         testing::Values(FrameAndCamera{"0bbe1004", "zeiss_rmk_mid.toml"},
                                         FrameAndCamera{"5bdd5cf4", "wild_18cm.toml"},
                                         FrameAndCamera{"66685fc2", "wild_rc10.toml"},
                                         FrameAndCamera{"0b4cb981", "wild_rc10.toml"},
                                         FrameAndCamera{"0b4cb981", "wild_rc8_23.toml"}));

// Of what the dots' camera finds on the frame, measuring rejects all but two marks.
TEST(FailedCamera, HasNoEvidenceFromMarksThatWereRejected) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  const Raster scan = Raster::Open(folder + "/66685fc2.jpg");
  const auto nats_of = [&](const std::string& name) {
    const CameraFile camera = ReadCameraFile(ProjectFile("data/cameras/" + name + ".toml"));
    double nats = 0;
    OrientInterior(scan, camera, ShapesOf(camera), {}, &nats);
    return nats;
  };
  EXPECT_LT(nats_of("fairchild_t12_dots"), nats_of("wild_18cm") - 10);
}

// Every frame with every film camera there is, its own and its twins left out: cameras with marks
// of the same look in the same places find what is there.
TEST(SlowWrongCamera, IsNeverOkInAWrongPlace) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  for (const std::string frame :
       {"0b4cb981", "0bbe1004", "0c8e8831", "0cec8b13", "5bdd5cf4", "66685fc2"}) {
    const auto hand = HandMarks(folder, frame);
    for (const auto& entry : std::filesystem::directory_iterator(ProjectFile("data/cameras"))) {
      if (entry.path().extension() != ".toml") continue;
      const std::string camera = entry.path().filename().string();
      if (ReadCameraFile(entry.path().string()).fiducials.empty()) continue;
      const InteriorResult result = Orient(folder, frame, camera);
      if (result.status != Status::kOk) continue;
      SCOPED_TRACE(frame + " with " + camera);
      for (const MarkResult& mark : result.marks)
        if (mark.state == MarkState::kUsed) ExpectAtAHandMark(hand, mark);
    }
  }
}

}  // namespace
}  // namespace orient::interior
