#include "patchdb/store/selection.h"

#include <gtest/gtest.h>

#include "patchdb/maintenance/life.h"
#include "tests/support/made_up_patches.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

class SelectionTest : public testing::Test {
 protected:
  std::vector<std::int64_t> Chosen(const PatchFilter& filter) {
    return ChooseIds(database_, filter);
  }
  TemporaryFolder folder_;
  PatchDatabase database_ = MadeUpDatabase(folder_ / "patches.gpkg", 4, 3);
};

using Ids = std::vector<std::int64_t>;

TEST_F(SelectionTest, WithoutARuleAllInOrder) {
  EXPECT_EQ(Chosen({}).size(), 12u);
  EXPECT_FALSE(PatchFilter().HasRule());
}

TEST_F(SelectionTest, SummarySaysWhatThePatchSays) {
  PatchFilter filter;
  filter.ids = {6};
  int visited = 0;
  VisitPatches(database_, filter, [&](const PatchSummary& summary) {
    const Patch patch = *database_.ReadPatch(6);
    EXPECT_EQ(summary.ground_m, patch.ground_m);
    EXPECT_NEAR(summary.sigma_m.z(), 0.5, 1e-12);
    EXPECT_EQ(summary.chip_px, 31);
    EXPECT_EQ(summary.quality, 0.75);
    EXPECT_EQ(summary.source_name, "1990.tif");
    EXPECT_EQ(summary.source_date, "1990-07-01");
    EXPECT_EQ(summary.life, PatchLife::kActive);
    ++visited;
  });
  EXPECT_EQ(visited, 1);
}

TEST_F(SelectionTest, BoxAndPolygonChooseWhatLiesInside) {
  PatchFilter box;
  box.bounds = Bounds{500050, 4999950, 500250, 5000050};
  EXPECT_EQ(Chosen(box), (Ids{2, 3}));
  PatchFilter triangle;  // with a hole around patch 6
  triangle.polygon = {{{499950, 4999950}, {500350, 4999950}, {499950, 5000350}},
                      {{500090, 5000090}, {500110, 5000090}, {500110, 5000110}, {500090, 5000110}}};
  EXPECT_EQ(Chosen(triangle), (Ids{1, 2, 3, 5, 9}));
}

TEST_F(SelectionTest, RulesHoldTogether) {
  RetirePatches(database_, {2, 4}, "test");
  database_.RecordAttempts({MadeUpAttempt(1, "a", false), MadeUpAttempt(1, "b", false),
                            MadeUpAttempt(3, "a", false), MadeUpAttempt(5, "a", true)});
  PatchFilter filter;
  filter.life = PatchLife::kRetired;
  EXPECT_EQ(Chosen(filter), (Ids{2, 4}));
  filter.retired_before = "2000-01-01";
  EXPECT_TRUE(Chosen(filter).empty());
  PatchFilter failing;
  failing.min_failures = 1;
  EXPECT_EQ(Chosen(failing), (Ids{1, 3}));
  failing.success_below = 0.4;
  EXPECT_EQ(Chosen(failing), (Ids{1}));
  PatchFilter unlucky;  // the belief in all others, never sought, is 0.75
  unlucky.success_below = 0.9;
  EXPECT_EQ(Chosen(unlucky), (Ids{1, 3, 5}));
  PatchFilter quality;
  quality.quality_below = 0.75;
  EXPECT_TRUE(Chosen(quality).empty());
  PatchFilter old;
  old.older_than = "1990-07-02";
  EXPECT_EQ(Chosen(old).size(), 12u);
  old.older_than = "1990-07-01";
  EXPECT_TRUE(Chosen(old).empty());
  PatchFilter source;
  source.source = "1990.tif' OR '1'='1";
  EXPECT_TRUE(Chosen(source).empty());
}

TEST_F(SelectionTest, UnknownIdsChooseNothing) {
  PatchFilter filter;
  filter.ids = {99, 3};
  EXPECT_EQ(Chosen(filter), (Ids{3}));
}

}  // namespace
}  // namespace orient::patchdb
