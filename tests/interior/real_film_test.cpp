// Real scanned film frames, marks measured by eye beside them.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "interior/interior.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

using Eigen::Vector2d;

constexpr double kOkFramePx = 0.7;    // the corner marks of the ring-and-cross frames
constexpr double kAnyUsedMarkPx = 1;  // a used mark of whatever frame ends ok

struct HandMark {
  std::string name;
  Vector2d pixel;
};

std::vector<HandMark> HandMarks(const std::string& folder, const std::string& frame) {
  std::ifstream file(folder + "/marks.csv");
  std::vector<HandMark> marks;
  for (std::string line; std::getline(file, line);) {
    std::stringstream cells(line);
    std::string of_frame, name, col, row;
    std::getline(cells, of_frame, ',');
    std::getline(cells, name, ',');
    std::getline(cells, col, ',');
    std::getline(cells, row, ',');
    if (of_frame == frame && !col.empty())
      marks.push_back({name, {std::stod(col), std::stod(row)}});
  }
  return marks;
}

InteriorResult Orient(const std::string& folder, const std::string& frame,
                      const std::string& camera_name) {
  const CameraFile camera = ReadCameraFile(ProjectFile("data/cameras/" + camera_name));
  return OrientInterior(Raster::Open(folder + "/" + frame + ".jpg"), camera, ShapesOf(camera));
}

// Distance to the nearest hand mark.
double Error(const std::vector<HandMark>& hand, const Vector2d& pixel) {
  double nearest = 1e9;
  for (const HandMark& mark : hand) nearest = std::min(nearest, (mark.pixel - pixel).norm());
  return nearest;
}

class RingAndCrossFrame : public testing::TestWithParam<std::string> {};

TEST_P(RingAndCrossFrame, IsOkWithEveryCornerNearTheHandMark) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  const InteriorResult result = Orient(folder, GetParam(), "wild_rc10.toml");
  ASSERT_EQ(result.status, Status::kOk);
  EXPECT_EQ(result.polarity, Polarity::kPositive);
  EXPECT_FALSE(result.orientation);
  const auto hand = HandMarks(folder, GetParam());
  for (const MarkResult& mark : result.marks) {
    ASSERT_EQ(mark.state, MarkState::kUsed) << mark.id;
    EXPECT_LT(Error(hand, *mark.pixel), kOkFramePx) << mark.id;
  }
}
INSTANTIATE_TEST_SUITE_P(Wild, RingAndCrossFrame,
                         testing::Values("0bbe1004", "0c8e8831", "5bdd5cf4"));

struct FrameAndCamera {
  std::string frame, camera;
  friend std::ostream& operator<<(std::ostream& out, const FrameAndCamera& value) {
    return out << value.frame << " with " << value.camera;
  }
};
class AnyFrame : public testing::TestWithParam<FrameAndCamera> {};

TEST_P(AnyFrame, IsNeverSilentlyWrong) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  const InteriorResult result = Orient(folder, GetParam().frame, GetParam().camera);
  EXPECT_FALSE(result.messages.empty());
  if (result.status != Status::kOk) return;
  const auto hand = HandMarks(folder, GetParam().frame);
  for (const MarkResult& mark : result.marks)
    if (mark.state == MarkState::kUsed) {
      EXPECT_LT(Error(hand, *mark.pixel), kAnyUsedMarkPx) << mark.id;
    }
}
INSTANTIATE_TEST_SUITE_P(OfItsCamera, AnyFrame,
                         testing::Values(FrameAndCamera{"0cec8b13", "wild_rc8_23.toml"},
                                         FrameAndCamera{"66685fc2", "wild_18cm.toml"},
                                         FrameAndCamera{"0b4cb981", "zeiss_rmk_mid.toml"}));

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

}  // namespace
}  // namespace orient
