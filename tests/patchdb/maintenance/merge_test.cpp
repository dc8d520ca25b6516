#include "patchdb/maintenance/merge.h"

#include <gtest/gtest.h>

#include "patchdb/maintenance/check.h"
#include "patchdb/maintenance/life.h"
#include "patchdb/maintenance/patch_transform.h"
#include "patchdb/store/connection.h"
#include "tests/support/made_up_patches.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

class MergeTest : public testing::Test {
 protected:
  PatchDatabase Other(const std::string& source, const std::string& date,
                      std::vector<Patch> patches) {
    PatchDatabase other = PatchDatabase::Create(
        folder_ / ("other" + std::to_string(others_++) + ".gpkg"), MadeUpCrs());
    PatchSource made = MadeUpSource(source, date);
    other.AddSource(made, patches);
    return other;
  }
  // Patch 1 of own.tif; witness.tif shows it at (10, 20), (0.5, 0.25) from where it is computed.
  PatchDatabase OnePatchSeenByAWitness() {
    PatchDatabase here = PatchDatabase::Create(folder_ / "here.gpkg", MadeUpCrs());
    PatchSource witness = MadeUpSource("witness.tif", "1991");
    PatchSource own = MadeUpSource("own.tif", "1991");
    std::vector<Patch> none, patches = MadeUpPatches(1, 1, 100);
    here.AddSource(witness, none);
    patches[0].evidence = {{witness.id, Eigen::Vector2d(10, 20), Eigen::Vector2d(0.5, 0.25)}};
    here.AddSource(own, patches);
    return here;
  }
  void ExpectSound() { EXPECT_TRUE(CheckDatabase(database_, {}).empty()); }

  TemporaryFolder folder_;
  int others_ = 0;
  PatchDatabase database_ = MadeUpDatabase(folder_ / "patches.gpkg", 4, 3);
};

TEST_F(MergeTest, DuplicatesByPlaceAndLookAreOnePatchWithBothHistories) {
  // Row 0 again, half a pixel off; and one place with another look.
  std::vector<Patch> patches = MadeUpPatches(4, 1, 100, 500000.25, 5000000.25);
  patches.push_back(MadeUpPatch(500000, 5000100, 999));
  patches[1].quality = 0.9;
  PatchDatabase other = Other("other.tif", "1991", patches);
  other.RecordAttempts({MadeUpAttempt(1, "there", false), MadeUpAttempt(1, "both", true)});
  database_.RecordAttempts({MadeUpAttempt(1, "here", true), MadeUpAttempt(1, "both", true)});

  const MergeResult result = MergeDatabase(database_, other, {});
  EXPECT_EQ(result.duplicates, 4);
  EXPECT_EQ(result.improved, 1);
  EXPECT_EQ(result.added, 1);
  EXPECT_EQ(database_.Info().patches, 13);
  EXPECT_EQ(database_.Info().attempts, 3);
  const Patch joined = *database_.ReadPatch(1);
  EXPECT_EQ(joined.views, 2);
  EXPECT_EQ(joined.success_weight, 2);
  EXPECT_EQ(joined.failure_weight, 1);
  EXPECT_EQ(database_.ReadPatch(2)->quality, 0.9);
  EXPECT_EQ(database_.ReadPatch(2)->ground_m.x(), 500100.25);
  ExpectSound();
}

TEST_F(MergeTest, AgainItChangesNothing) {
  PatchDatabase other = Other("other.tif", "1991", MadeUpPatches(3, 2, 130, 510000));
  other.RecordAttempts({MadeUpAttempt(2, "there", false)});
  EXPECT_EQ(MergeDatabase(database_, other, {}).added, 6);
  const MergeResult again = MergeDatabase(database_, other, {});
  EXPECT_EQ(again.added, 0);
  EXPECT_EQ(again.duplicates, 6);
  EXPECT_EQ(again.attempts, 0);
  EXPECT_EQ(database_.Info().patches, 18);
  EXPECT_EQ(database_.Info().sources, 2);
  ExpectSound();
}

TEST_F(MergeTest, AnotherFileOfTheSameNameIsAnotherSource) {
  const PatchDatabase other = Other("1990.tif", "2001", MadeUpPatches(1, 1, 1, 600000));
  MergeDatabase(database_, other, {});
  EXPECT_TRUE(database_.FindSource(MadeUpSource("1990.tif (2)", "2001")).harvested);
  EXPECT_EQ(MergeDatabase(database_, other, {}).sources, 0);
}

TEST_F(MergeTest, StateSuccessorAndReasonComeAlong) {
  PatchDatabase other = Other("other.tif", "1991", MadeUpPatches(2, 1, 100, 510000));
  RetirePatches(other, {2}, "a roof");
  MergeDatabase(database_, other, {});
  EXPECT_EQ(database_.ReadPatch(14)->life, PatchLife::kRetired);
  EXPECT_EQ(database_.ReadPatch(14)->retired_reason, "a roof");
  ExpectSound();
}

TEST_F(MergeTest, NewerViewsSupersedeAndLoseNothing) {
  std::vector<Patch> patches = {MadeUpPatch(500102, 5000001, 77), MadeUpPatch(505000, 5000000, 78)};
  const PatchDatabase other = Other("2020.tif", "2020-05-01", patches);
  MergeOptions options;
  options.policy = MergePolicy::kReplace;
  const MergeResult result = MergeDatabase(database_, other, options);
  EXPECT_EQ(result.added, 2);
  EXPECT_EQ(result.superseded, 1);
  const Patch old = *database_.ReadPatch(2);
  EXPECT_EQ(old.life, PatchLife::kRetired);
  EXPECT_EQ(old.superseded_by, 13);
  EXPECT_EQ(database_.Info().patches, 14);
  const MergeResult again = MergeDatabase(database_, other, options);
  EXPECT_EQ(again.added, 0);
  EXPECT_EQ(again.not_newer, 2);
  ExpectSound();
  RestorePatches(database_, {2});
  EXPECT_EQ(database_.ReadPatch(2)->superseded_by, 0);
  ExpectSound();
}

TEST_F(MergeTest, OlderViewsDoNotSupersede) {
  const PatchDatabase other = Other("1961.tif", "1961", MadeUpPatches(4, 3, 100));
  MergeOptions options;
  options.policy = MergePolicy::kReplace;
  const MergeResult result = MergeDatabase(database_, other, options);
  EXPECT_EQ(result.added, 0);
  EXPECT_EQ(result.not_newer, 12);
}

TEST_F(MergeTest, AddKeepsBothViews) {
  const PatchDatabase other = Other("2020.tif", "2020", {MadeUpPatch(500102, 5000001, 77)});
  MergeOptions options;
  options.policy = MergePolicy::kAdd;
  EXPECT_EQ(MergeDatabase(database_, other, options).added, 1);
  EXPECT_EQ(database_.Info().retired, 0);
}

// The same place and look in another source.
TEST_F(MergeTest, ActivePatchIsNotLostOnARetiredTwin) {
  RetirePatches(database_, {1}, "a roof");
  const PatchDatabase other = Other("other.tif", "1991", MadeUpPatches(1, 1, 100));
  EXPECT_EQ(MergeDatabase(database_, other, {}).added, 1);
  EXPECT_EQ(database_.ReadPatch(1)->life, PatchLife::kRetired);
  EXPECT_EQ(database_.ReadPatch(13)->life, PatchLife::kActive);
  EXPECT_EQ(MergeDatabase(database_, other, {}).added, 0);
  RetirePatches(database_, {13}, "wrong season");  // retired here, it does not come again
  EXPECT_EQ(MergeDatabase(database_, other, {}).added, 0);
  EXPECT_EQ(database_.ReadPatch(13)->life, PatchLife::kRetired);
  ExpectSound();
}

TEST_F(MergeTest, RetiredPatchDoesNotRetireItsTwinOfAnotherSource) {
  PatchDatabase other = Other("other.tif", "1991", MadeUpPatches(1, 1, 100));
  RetirePatches(other, {1}, "a roof");
  for (int time = 0; time < 2; ++time) MergeDatabase(database_, other, {});
  EXPECT_EQ(database_.ReadPatch(1)->life, PatchLife::kActive);
  EXPECT_EQ(database_.ReadPatch(13)->retired_reason, "a roof");
  EXPECT_EQ(database_.Info().patches, 13);
  ExpectSound();
}

// Two copies of one database, of which each goes on by itself.
TEST_F(MergeTest, OfOneHistoryTheLaterStateHolds) {
  PatchDatabase other = Other("1990.tif", "1990-07-01", MadeUpPatches(4, 3, 100));
  RetirePatches(database_, {1, 2}, "a roof");
  RetirePatches(other, {2, 3}, "a crown");
  RestorePatches(other, {2});
  EXPECT_EQ(MergeDatabase(database_, other, {}).duplicates, 12);
  EXPECT_EQ(database_.ReadPatch(1)->life, PatchLife::kRetired);
  EXPECT_EQ(database_.ReadPatch(2)->life, PatchLife::kActive) << "restored there";
  EXPECT_EQ(database_.ReadPatch(2)->epoch, 2);
  EXPECT_EQ(database_.ReadPatch(3)->retired_reason, "a crown");
  EXPECT_EQ(database_.Info().patches, 12);
  ExpectSound();
}

TEST_F(MergeTest, SupersededPatchesComeOnce) {
  PatchDatabase other = Other("1980.tif", "1980", MadeUpPatches(2, 1, 100, 510000));
  std::vector<Patch> newer = {MadeUpPatch(510000, 5000000, 77), MadeUpPatch(510100, 5000000, 78)};
  PatchSource source = MadeUpSource("1985.tif", "1985");
  other.AddSource(source, newer);
  other.Write("test", [](Connection& connection) {
    return connection.Database().exec(
        "UPDATE patches SET state = 'retired', retired_reason = 'x', retired_on = '1986-01-02', "
        "superseded_by = id + 2 WHERE id < 3");
  });
  for (int time = 0; time < 2; ++time) {
    EXPECT_EQ(MergeDatabase(database_, other, {}).added, time == 0 ? 4 : 0);
    EXPECT_EQ(database_.Info().patches, 16);
    EXPECT_EQ(database_.ReadPatch(13)->superseded_by, 15);
    EXPECT_EQ(database_.ReadPatch(14)->retired_on, "1986-01-02");
  }
  ExpectSound();
}

TEST_F(MergeTest, WhatWasSupersededHereDoesNotComeAgain) {
  PatchDatabase older = Other("1990.tif", "1990-07-01", MadeUpPatches(4, 3, 100));
  const PatchDatabase newer = Other("2020.tif", "2020", {MadeUpPatch(500100, 5000000, 77)});
  MergeOptions update;
  update.policy = MergePolicy::kReplace;
  EXPECT_EQ(MergeDatabase(database_, newer, update).superseded, 1);
  EXPECT_EQ(MergeDatabase(database_, older, {}).added, 0);
  EXPECT_EQ(database_.ReadPatch(2)->superseded_by, 13);
}

// Killed after the first source's transaction.
TEST_F(MergeTest, InterruptedMergeLinksSuccessorsLater) {
  PatchDatabase other = Other("1980.tif", "1980", MadeUpPatches(1, 1, 100, 510000));
  std::vector<Patch> newer = {MadeUpPatch(510000, 5000000, 77)};
  PatchSource source = MadeUpSource("1985.tif", "1985");
  other.AddSource(source, newer);
  other.Write("test", [](Connection& connection) {
    return connection.Database().exec(
        "UPDATE patches SET state = 'retired', retired_reason = 'x', superseded_by = 2 WHERE id = "
        "1");
  });
  const auto killed = [](int, int) { throw std::runtime_error("killed"); };
  EXPECT_THROW(MergeDatabase(database_, other, {}, killed), std::runtime_error);
  EXPECT_EQ(database_.ReadPatch(13)->superseded_by, 0);
  MergeDatabase(database_, other, {});
  EXPECT_EQ(database_.ReadPatch(13)->superseded_by, 14);
  ExpectSound();
}

TEST_F(MergeTest, MeasuredEvidenceStays) {
  PatchDatabase here = OnePatchSeenByAWitness();
  // The witness's own view of the place, not as good.
  std::vector<Patch> seen = MadeUpPatches(1, 1, 100);
  seen[0].quality = 0.5;
  const PatchDatabase other = Other("witness.tif", "1991", seen);
  EXPECT_EQ(MergeDatabase(here, other, {}).duplicates, 1);
  const Patch joined = *here.ReadPatch(1);
  ASSERT_EQ(joined.evidence.size(), 1u);
  EXPECT_EQ(joined.evidence[0].pixel, Eigen::Vector2d(10, 20));
  EXPECT_EQ(joined.evidence[0].residual_px, Eigen::Vector2d(0.5, 0.25));
  EXPECT_EQ(joined.views, 2);
}

TEST_F(MergeTest, ResidualsOfAnotherGroundPointAreForgotten) {
  PatchDatabase here = OnePatchSeenByAWitness();
  std::vector<Patch> better = MadeUpPatches(1, 1, 100, 500000.5);
  better[0].quality = 0.9;
  const PatchDatabase other = Other("better.tif", "1991", better);
  EXPECT_EQ(MergeDatabase(here, other, {}).improved, 1);
  const Patch joined = *here.ReadPatch(1);
  ASSERT_EQ(joined.evidence.size(), 2u);
  EXPECT_EQ(joined.evidence[0].pixel, Eigen::Vector2d(10, 20));
  EXPECT_FALSE(joined.evidence[0].residual_px);
  EXPECT_EQ(joined.views, 3);
}

TEST_F(MergeTest, EpochsOfAnotherHistoryAreCountedFromItsPresentOne) {
  PatchDatabase other = Other("other.tif", "1991", MadeUpPatches(1, 1, 100));
  other.RecordAttempts({MadeUpAttempt(1, "before", false)});
  RetirePatches(other, {1}, "x");
  RestorePatches(other, {1});
  other.RecordAttempts({MadeUpAttempt(1, "after", true)});
  MergeDatabase(database_, other, {});
  EXPECT_EQ(database_.ReadPatch(1)->epoch, 1);
  EXPECT_EQ(database_.ReadPatch(1)->failure_weight, 0.25);
  EXPECT_EQ(database_.ReadPatch(1)->success_weight, 1);
  ExpectSound();
}

TEST_F(MergeTest, SourceOfEvidenceAloneIsNotHarvested) {
  PatchDatabase other = PatchDatabase::Create(folder_ / "two.gpkg", MadeUpCrs());
  PatchSource witness = MadeUpSource("witness.tif", "1991"), own = MadeUpSource("own.tif", "1991");
  std::vector<Patch> seen = MadeUpPatches(1, 1, 100, 520000), patches = MadeUpPatches(1, 1, 100);
  other.AddSource(witness, seen);
  patches[0].evidence = {{witness.id, Eigen::Vector2d(10, 20), {}}};
  other.AddSource(own, patches);
  MergeOptions here;
  here.filter.bounds = Bounds{499000, 4999000, 501000, 5001000};
  EXPECT_EQ(MergeDatabase(database_, other, here).sources, 1);
  EXPECT_EQ(database_.ReadPatch(1)->evidence.size(), 2u);
  EXPECT_FALSE(database_.FindSource(witness).harvested);
  EXPECT_EQ(MergeDatabase(database_, other, {}).sources, 1);
  EXPECT_TRUE(database_.FindSource(witness).harvested);
  ExpectSound();
}

TEST_F(MergeTest, DamagedPatchIsNamedAndNothingOfItsSourceTaken) {
  PatchDatabase other = Other("other.tif", "1991", MadeUpPatches(2, 1, 100, 520000));
  other.Write("test", [](Connection& connection) {
    return connection.Database().exec("UPDATE patches SET bits = 16, gsd_m = 9e999 WHERE id = 2");
  });
  EXPECT_THROW(MergeDatabase(database_, other, {}), InputError);
  EXPECT_EQ(database_.Info().patches, 12);
  EXPECT_EQ(database_.Info().sources, 1);
}

TEST_F(MergeTest, NothingTakenLeavesNoSource) {
  const PatchDatabase older = Other("1961.tif", "1961", MadeUpPatches(4, 3, 100));
  for (const MergePolicy policy : {MergePolicy::kReplace, MergePolicy::kAdd}) {
    MergeOptions options;
    options.policy = policy;
    const MergeResult result = MergeDatabase(database_, older, options);
    EXPECT_EQ(result.not_newer, 12);
    EXPECT_EQ(result.sources, 0);
    EXPECT_EQ(database_.Info().sources, 1);
  }
}

TEST_F(MergeTest, PlacesAreToldApartByTheCoarserPixelAlone) {
  // 3 m off: beyond 3 pixels of 0.5 m, though the index's floats are half a metre coarse here.
  const PatchDatabase fine = Other("other.tif", "1991", MadeUpPatches(1, 1, 100, 500001.75));
  EXPECT_EQ(MergeDatabase(database_, fine, {}).duplicates, 0);
  MergeOptions update;  // a quarter of 15.5 m is 3.875 m
  update.policy = MergePolicy::kReplace;
  const PatchDatabase apart = Other("2020.tif", "2020", {MadeUpPatch(500204, 5000000, 77)});
  EXPECT_EQ(MergeDatabase(database_, apart, update).superseded, 0);
  // A finer newer chip within the older one's quarter, not within its own.
  const PatchDatabase inside = Other("2021.tif", "2021", {MadeUpPatch(500303, 5000000, 79, 0.125)});
  EXPECT_EQ(MergeDatabase(database_, inside, update).superseded, 1);
}

TEST_F(MergeTest, AddTakesWhatIsNewerOnly) {
  MergeOptions options;
  options.policy = MergePolicy::kAdd;
  const PatchDatabase year = Other("1990b.tif", "1990", {MadeUpPatch(500100, 5000000, 77)});
  EXPECT_EQ(MergeDatabase(database_, year, options).not_newer, 1) << "1990 may be before July";
  const PatchDatabase newer = Other("2020.tif", "2020", {MadeUpPatch(500100, 5000000, 77)});
  EXPECT_EQ(MergeDatabase(database_, newer, options).added, 1);
  EXPECT_EQ(MergeDatabase(database_, newer, options).not_newer, 1);
  EXPECT_EQ(database_.Info().retired, 0);
}

TEST_F(MergeTest, CopyOfAPartIsAWholeDatabase) {
  PatchDatabase part = PatchDatabase::Create(folder_ / "part.gpkg", MadeUpCrs());
  MergeOptions options;
  options.policy = MergePolicy::kCopy;
  options.filter.bounds = Bounds{499950, 4999950, 500150, 5000150};
  EXPECT_EQ(MergeDatabase(part, database_, options).added, 4);
  EXPECT_EQ(part.FindPatchesIn({0, 0, 1e7, 1e7}).size(), 4u);
  EXPECT_EQ(part.ListPatches(0, 1)[0].chip.values, database_.ListPatches(0, 1)[0].chip.values);
  EXPECT_TRUE(CheckDatabase(part, {}).empty());
}

// UTM 35 and 36 at their common border differ by several degrees and most of their coordinates.
TEST_F(MergeTest, AnotherCrsTurnsPlacePrecisionAndChip) {
  const Crs east = Crs::Parse("EPSG:32636", "test");
  const PatchTransform there(east, MadeUpCrs()), back(MadeUpCrs(), east);
  Patch patch = MadeUpPatch(730000, 5000000, 5);
  patch.chip = Image(61, 61);
  for (int row = 0; row < 61; ++row)  // smooth, so that bilinear keeps it
    for (int col = 0; col < 61; ++col)
      patch.chip.At(col, row) =
          static_cast<float>(128 + 60 * std::sin(col * 0.2) + 40 * std::cos(row * 0.15));
  patch.covariance_m2 = Eigen::Vector3d(0.01, 0.25, 1).asDiagonal();
  const auto moved = there(patch);
  ASSERT_TRUE(moved);
  EXPECT_LT(moved->chip.width, 61);
  EXPECT_NEAR(moved->covariance_m2.trace(), 1.26, 0.01);
  EXPECT_GT(std::abs(moved->covariance_m2(0, 1)), 0.005);
  const auto returned = back(*moved);
  ASSERT_TRUE(returned);
  EXPECT_LT((returned->ground_m - patch.ground_m).norm(), 0.002);
  EXPECT_LT((returned->covariance_m2 - patch.covariance_m2).norm(), 1e-3);
  EXPECT_NEAR(returned->gsd_m, patch.gsd_m, 1e-4);
  const int cut = (61 - returned->chip.width) / 2;
  for (int row = 0; row < returned->chip.height; row += 5)
    for (int col = 0; col < returned->chip.width; col += 5)
      EXPECT_NEAR(returned->chip.At(col, row), patch.chip.At(col + cut, row + cut), 3);

  PatchDatabase target = PatchDatabase::Create(folder_ / "east.gpkg", east);
  PatchDatabase other = Other("a.tif", "1991", {patch});
  EXPECT_EQ(MergeDatabase(target, other, {}).added, 1);
  EXPECT_EQ(MergeDatabase(target, other, {}).duplicates, 1);
}

}  // namespace
}  // namespace orient::patchdb
