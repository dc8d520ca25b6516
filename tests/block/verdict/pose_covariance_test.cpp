#include "block/verdict/pose_covariance.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

#include "core/base/atomic_write.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

// Three inputs' photos, of which the last two are in the block and have poses of it.
class PoseCovarianceTable : public testing::Test {
 protected:
  PoseCovarianceTable() : results_(3) {
    adjusted_.result.converged = true;
    adjusted_.block.photos.resize(2);
    adjusted_.block.photos[0].name = "b";
    adjusted_.block.photos[1].name = "c";
    adjusted_.photo_of = {1, 2};
    adjusted_.result.covariance_photos = {1, 0};  // in an order of its own
    adjusted_.result.pose_covariance = Eigen::MatrixXd(12, 12);
    for (int i = 0; i < 12; ++i)
      for (int j = 0; j < 12; ++j) adjusted_.result.pose_covariance(i, j) = 100 * i + j;
    for (const std::size_t i : {1, 2}) {
      results_[i].pose.emplace();
      results_[i].alone.emplace();
    }
  }

  bool Write(bool wanted = true) {
    return WritePoseCovariance(folder_.Path(), wanted, adjusted_, results_);
  }
  bool IsThere() const { return std::filesystem::exists(PoseCovariancePath(folder_.Path())); }
  std::vector<std::vector<std::string>> Cells() const {
    std::vector<std::vector<std::string>> rows;
    std::istringstream text(ReadFile(PoseCovariancePath(folder_.Path())));
    for (std::string line; std::getline(text, line);) {
      rows.emplace_back();
      std::istringstream cells(line);
      for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
    }
    return rows;
  }

  const TemporaryFolder folder_;
  AdjustedBlock adjusted_;
  std::vector<ExteriorResult> results_;
};

TEST_F(PoseCovarianceTable, HasARowAndAColumnForEachElementOfEachPhoto) {
  EXPECT_TRUE(Write());
  const auto cells = Cells();
  ASSERT_EQ(cells.size(), 13u);
  for (const auto& row : cells) ASSERT_EQ(row.size(), 14u);
  EXPECT_EQ(cells[0][2], "c.x");
  EXPECT_EQ(cells[0][13], "b.kappa");
  EXPECT_EQ(cells[1][0], "c");
  EXPECT_EQ(cells[1][1], "x");
  EXPECT_EQ(cells[12][0], "b");
  EXPECT_EQ(cells[12][1], "kappa");
  EXPECT_EQ(cells[12][2], "1100");
  EXPECT_EQ(cells[3][13], "211");
}

// Of a photo whose adjusted pose was not accepted the block's covariance is not that of its pose.
TEST_F(PoseCovarianceTable, LeavesOutPhotosWhosePoseIsNotTheBlocks) {
  results_[2].alone.reset();  // kept as it was alone
  EXPECT_TRUE(Write());
  auto cells = Cells();
  ASSERT_EQ(cells.size(), 7u);
  EXPECT_EQ(cells[1][0], "b");
  EXPECT_EQ(cells[1][2], "606");
  results_[2].alone.emplace();
  results_[1].pose.reset();  // failed
  EXPECT_TRUE(Write());
  cells = Cells();
  ASSERT_EQ(cells.size(), 7u);
  EXPECT_EQ(cells[1][0], "c");
  EXPECT_EQ(cells[6][7], "505");
}

TEST_F(PoseCovarianceTable, OfAnEarlierRunGoesWhereItIsNotWanted) {
  ASSERT_TRUE(Write());
  ASSERT_TRUE(IsThere());
  EXPECT_TRUE(Write(false));
  EXPECT_FALSE(IsThere());
}

TEST_F(PoseCovarianceTable, OfAnEarlierRunGoesWhereTheBlockDidNotConvergeAndThatIsTold) {
  ASSERT_TRUE(Write());
  adjusted_.result.converged = false;
  EXPECT_FALSE(Write());
  EXPECT_FALSE(IsThere());
}

TEST_F(PoseCovarianceTable, OfABlockThatGaveNoneIsToldToBeMissing) {
  adjusted_.result.covariance_photos.clear();
  EXPECT_FALSE(Write());
  EXPECT_FALSE(IsThere());
  EXPECT_TRUE(Write(false));
}

TEST_F(PoseCovarianceTable, OfNoAcceptedPoseIsToldToBeMissing) {
  results_[1].pose.reset();
  results_[2].alone.reset();
  EXPECT_FALSE(Write());
  EXPECT_FALSE(IsThere());
}

}  // namespace
}  // namespace orient::block
