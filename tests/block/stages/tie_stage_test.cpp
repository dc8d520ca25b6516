#include "block/stages/tie_stage.h"

#include <gtest/gtest.h>

#include <functional>

#include "core/base/atomic_write.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

// Photos with poses, whose footprints do not touch. Nothing of them is measured then.
class TieStageOf : public testing::Test {
 protected:
  TieStageOf() {
    for (const std::string name : {"a", "b", "c"}) {
      BlockPhotoFile photo;
      photo.name = photo.exterior.photo = name;
      photo.path = folder_ / (name + ".tif");
      photo.result_path = ExteriorResultPath(folder_.Path(), name);
      WriteFileAtomically(photo.path, "scan " + name);
      photo.exterior.status = Status::kOk;
      photo.exterior.pose.emplace();
      photo.exterior.covariance = Matrix6d::Identity();
      const double x = 1000.0 * static_cast<double>(photos_.size());
      photo.footprint.Include(x, 0);
      photo.footprint.Include(x + 500, 500);
      WriteExteriorResult(folder_.Path(), photo.exterior);
      photos_.push_back(photo);
    }
  }

  // The number of ties; `findings_` and `done_` are of this run.
  std::size_t Run() {
    findings_.clear();
    done_ = 0;
    const TieStage stage{photos_, camera_, surface_, inputs_, store_, 1};
    return RunTieStage(
               stage, [&] { ++done_; }, &findings_)
        .size();
  }
  // As if a run had found one.
  void PutTie(const std::string& photo) {
    const auto made_from = store_.MadeFrom(photo);
    ASSERT_TRUE(made_from);
    WriteTieFile(store_.PathOf(photo), photo, *made_from,
                 {{{1, 2, 3}, {{photo, {4, 5}, Eigen::Matrix2d::Identity(), 0.9}}}});
  }

  const TemporaryFolder folder_;
  Camera camera_;
  GroundSurface surface_ = GroundSurface::FromGrid(Eigen::MatrixXf::Zero(9, 9), 0, 900, 100);
  std::vector<BlockPhotoFile> photos_;
  Inputs inputs_ = {{"camera", "1"}, {"dem", "2"}};
  const ResultStore store_{folder_ / "ties", ".ties.json"};
  Findings findings_;
  int done_ = 0;
};

TEST_F(TieStageOf, PhotosWithoutNeighboursHaveResultsWithoutTies) {
  EXPECT_EQ(Run(), 0u);
  EXPECT_EQ(store_.Jobs(), (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_TRUE(findings_.empty());
  EXPECT_EQ(done_, 3);
}

TEST_F(TieStageOf, PhotosWithoutAPoseHaveNoResult) {
  photos_[1].exterior.pose.reset();
  EXPECT_EQ(Run(), 0u);
  EXPECT_EQ(store_.Jobs(), (std::vector<std::string>{"a", "c"}));
  EXPECT_EQ(done_, 2);
}

TEST_F(TieStageOf, WhatIsCurrentIsKept) {
  Run();
  PutTie("a");
  PutTie("c");
  EXPECT_EQ(Run(), 2u);
  EXPECT_EQ(done_, 3) << "a kept one, too";
}

TEST_F(TieStageOf, AnotherScanPoseCameraOrDemIsDoneAgain) {
  const auto kept = [&](const std::function<void()>& change) {
    Run();
    PutTie("a");
    PutTie("c");
    change();
    return Run();
  };
  EXPECT_EQ(kept([&] { WriteFileAtomically(photos_[0].path, "another scan"); }), 1u);
  EXPECT_EQ(kept([&] {
              photos_[2].exterior.pose->position_m.x() = 7;
              WriteExteriorResult(folder_.Path(), photos_[2].exterior);
            }),
            1u);
  EXPECT_EQ(kept([&] { inputs_["dem"] = "3"; }), 0u);
  EXPECT_EQ(kept([] {}), 2u);
}

TEST_F(TieStageOf, WhatTouchesAPhotoNewlyOrHasChangedIsOneOfItsInputs) {
  Run();
  PutTie("a");
  PutTie("c");
  // The scans are none: the two that touch now give no ties.
  photos_[1].footprint.Include(100, 100);
  EXPECT_EQ(Run(), 1u) << "only c, which has no part in it";
  EXPECT_EQ(findings_.size(), 2u);
}

TEST_F(TieStageOf, AnImageThatCannotBeReadLeavesItsPhotoWithoutTiesAndIsTold) {
  photos_[1].footprint.Include(100, 100);  // touches a
  Run();
  ASSERT_EQ(findings_.size(), 2u);
  for (const std::size_t i : {0, 1}) {
    EXPECT_EQ(findings_[i].reason, Reason::kNoTiesFromPhoto);
    EXPECT_EQ(findings_[i].where.find(photos_[i].name + ": "), 0u) << findings_[i].where;
    EXPECT_NE(findings_[i].where.find(photos_[i].path), std::string::npos) << findings_[i].where;
  }
  EXPECT_EQ(store_.Jobs(), std::vector<std::string>{"c"}) << "the others are tried again next time";
  EXPECT_EQ(done_, 3);
}

TEST_F(TieStageOf, ADamagedResultIsDoneAgain) {
  Run();
  WriteFileAtomically(store_.PathOf("b"), "{");
  PutTie("a");
  EXPECT_EQ(Run(), 1u);
  EXPECT_TRUE(findings_.empty());
  EXPECT_TRUE(ReadTieFile(store_.PathOf("b")).empty());
}

TEST_F(TieStageOf, AResultThatSaysWhatItWasMadeFromAndIsDamagedIsDoneAgain) {
  Run();
  PutTie("a");
  std::string text = ReadFile(store_.PathOf("a"));
  const std::size_t ties = text.find("\"ties\"");
  ASSERT_NE(ties, std::string::npos);
  WriteFileAtomically(store_.PathOf("a"), text.replace(ties, 6, "\"lost\""));
  ASSERT_TRUE(store_.MadeFrom("a"));
  EXPECT_EQ(Run(), 0u);
  EXPECT_TRUE(ReadTieFile(store_.PathOf("a")).empty());
}

TEST_F(TieStageOf, OfAnotherMethodIsDoneAgain) {
  Run();
  Inputs made_from = store_.MadeFrom("a").value();
  ASSERT_EQ(made_from.count("method"), 1u);
  made_from["method"] = "of yesterday";
  WriteTieFile(store_.PathOf("a"), "a", made_from, {{{1, 2, 3}, {}}});
  EXPECT_EQ(Run(), 0u);
}

TEST_F(TieStageOf, OfNoPhotosIsNothing) {
  photos_.clear();
  EXPECT_EQ(Run(), 0u);
  EXPECT_TRUE(store_.Jobs().empty());
  EXPECT_TRUE(findings_.empty());
}

}  // namespace
}  // namespace orient::block
