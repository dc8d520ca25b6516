#include "tools/report/verdict.h"

#include <gtest/gtest.h>

#include "tests/tools/report/example_block.h"

namespace orient {
namespace {

PhotoRecord Record(const std::string& name, Status status) {
  PhotoRecord record;
  record.name = name;
  record.interior = ExampleInterior(name);
  record.exterior = ExampleExterior(name, status);
  return record;
}

BlockRecord Block(int ok_photos) {
  BlockRecord block;
  for (int i = 0; i < ok_photos; ++i)
    block.photos.push_back(Record(std::to_string(i), Status::kOk));
  return block;
}

TEST(Verdict, CountsStatusesAndPatches) {
  BlockRecord block = Block(2);
  block.photos.push_back(Record("w", Status::kWeak));
  block.photos.push_back(Record("f", Status::kFailed));
  const BlockVerdict verdict = Judge(block);
  EXPECT_EQ(verdict.ok, 2);
  EXPECT_EQ(verdict.weak, 1);
  EXPECT_EQ(verdict.failed, 1);
  EXPECT_EQ(verdict.matched, 9);    // three in each photo but the failed one
  EXPECT_EQ(verdict.searched, 15);  // what is not visible was not searched
  EXPECT_EQ(verdict.photos[0].marks_used, 1);
  EXPECT_EQ(verdict.photos[0].marks, 2);
}

TEST(Verdict, FailedPhotosComeFirst) {
  BlockRecord block = Block(1);
  block.photos.push_back(Record("w", Status::kWeak));
  block.photos.push_back(Record("f", Status::kFailed));
  const BlockVerdict verdict = Judge(block);
  ASSERT_EQ(verdict.concerns.size(), 2u);
  EXPECT_EQ(verdict.concerns[0].photo, 2u);
  EXPECT_EQ(verdict.concerns[0].text, "only 3 patches agree on a pose");
  EXPECT_EQ(verdict.concerns[1].photo, 1u);
}

TEST(Verdict, BlockOfEqualPhotosRaisesNoConcern) { EXPECT_TRUE(Judge(Block(4)).concerns.empty()); }

TEST(Verdict, OutstandingSigma0IsAConcern) {
  BlockRecord block = Block(4);
  block.photos[2].exterior->sigma0_px = 0.9;  // the others have 0.31
  const BlockVerdict verdict = Judge(block);
  ASSERT_EQ(verdict.concerns.size(), 1u);
  EXPECT_EQ(verdict.concerns[0].photo, 2u);
  EXPECT_NE(verdict.concerns[0].text.find("0.90 px"), std::string::npos);
}

TEST(Verdict, OutstandingPositionSigmaIsAConcern) {
  BlockRecord block = Block(4);
  (*block.photos[1].exterior->covariance)(2, 2) = 25;
  const BlockVerdict verdict = Judge(block);
  ASSERT_EQ(verdict.concerns.size(), 1u);
  EXPECT_NE(verdict.concerns[0].text.find("5.00 m"), std::string::npos);
  EXPECT_EQ(verdict.least_precise, 1u);
}

TEST(Verdict, LargeResidualOfAMatchedPatchIsAConcern) {
  BlockRecord block = Block(1);
  block.photos[0].exterior->patches[0].residual_px = Eigen::Vector2d(0, 4);
  ASSERT_EQ(Judge(block).concerns.size(), 1u);
  // Sigma0 weighs residuals by what neighbours share: it says nothing about which one stands out.
  block = Block(1);
  block.photos[0].exterior->sigma0_px = 0.01;
  EXPECT_TRUE(Judge(block).concerns.empty());
}

TEST(Verdict, AFewLargeResidualsAmongManyAreUsual) {
  BlockRecord block = Block(1);
  std::vector<PatchResult>& patches = block.photos[0].exterior->patches;
  const PatchResult first = patches[0];
  while (patches.size() < 200) patches.push_back(first);
  for (PatchResult& patch : patches) {
    patch.state = PatchState::kMatched;
    patch.residual_px = Eigen::Vector2d(0.1, 0);
  }
  for (int i = 0; i < 6; ++i) patches[i].residual_px = Eigen::Vector2d(1, 0);
  EXPECT_TRUE(Judge(block).concerns.empty());
  patches[6].residual_px = Eigen::Vector2d(1, 0);
  ASSERT_EQ(Judge(block).concerns.size(), 1u);
  EXPECT_NE(Judge(block).concerns[0].text.find("7 matched patches"), std::string::npos);
}

TEST(Verdict, PhotoThatStoppedHalfWayHasFailed) {
  BlockRecord block = Block(2);
  block.photos[1].exterior.reset();
  const BlockVerdict verdict = Judge(block);
  EXPECT_EQ(verdict.photos[1].status, Status::kFailed);
  EXPECT_FALSE(verdict.photos[1].reasons.empty());
}

TEST(Verdict, InteriorAloneIsJudgedByInterior) {
  BlockRecord block = Block(2);
  for (PhotoRecord& photo : block.photos) photo.exterior.reset();
  EXPECT_EQ(Judge(block).ok, 2);
}

TEST(Verdict, FailedInteriorIsNeverOk) {
  BlockRecord block = Block(1);
  block.photos[0].interior->status = Status::kFailed;
  EXPECT_EQ(Judge(block).photos[0].status, Status::kFailed);
}

TEST(Verdict, PhotoKnownFromTheTableAloneIsWeak) {
  BlockRecord block = Block(1);
  PhotoRecord photo;
  photo.name = "t";
  photo.table_row = OrientationRow{"t", Pose{}, std::nullopt};
  block.photos.push_back(photo);
  EXPECT_EQ(Judge(block).photos[1].status, Status::kWeak);
}

TEST(Verdict, DamagedFileMakesThePhotoFail) {
  BlockRecord block = Block(1);
  block.photos[0].unreadable = {"x.json is not valid JSON"};
  const BlockVerdict verdict = Judge(block);
  EXPECT_EQ(verdict.failed, 1);
  EXPECT_EQ(verdict.concerns.at(0).text, "x.json is not valid JSON");
}

}  // namespace
}  // namespace orient
