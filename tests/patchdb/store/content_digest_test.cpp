// The text that tells whether what photos were oriented from is still the same.
#include "patchdb/store/content_digest.h"

#include <filesystem>

#include "patchdb/maintenance/check.h"
#include "patchdb/maintenance/life.h"
#include "patchdb/store/geopackage_geometry.h"
#include "tests/support/patch_database_fixture.h"

namespace orient::patchdb {
namespace {

using Mode = PatchDatabase::Mode;

class ContentDigestTest : public PatchDatabaseTest {
 protected:
  void SetUp() override { Filled(20); }

  std::string Now() const { return ContentOf(PatchDatabase::Open(path_, Mode::kRead)); }

  // As another program would: the triggers are all that it knows of us.
  std::string After(const std::string& sql) const {
    SQLite::Database raw(path_, SQLite::OPEN_READWRITE);
    RegisterSpatialFunctions(raw.getHandle());
    raw.exec(sql);
    return Now();
  }

  void Attempt(std::int64_t patch, const std::string& photo, const std::string& state) const {
    MatchAttempt attempt;
    attempt.patch_id = patch;
    attempt.photo = photo;
    attempt.state = state;
    attempt.photo_status = "ok";
    PatchDatabase::Open(path_, Mode::kWrite).RecordAttempts({attempt});
  }
};

TEST_F(ContentDigestTest, StaysWhereNothingChanges) {
  const std::string before = Now();
  EXPECT_EQ(Now(), before);
  PatchDatabase::Open(path_, Mode::kWrite);
  EXPECT_EQ(Now(), before);
  std::filesystem::copy_file(path_, folder_ / "copy.gpkg");
  EXPECT_EQ(ContentOf(PatchDatabase::Open(folder_ / "copy.gpkg", Mode::kRead)), before);
}

TEST_F(ContentDigestTest, ChangesWithEveryColumnThatAPatchBringsAlong) {
  for (const char* change :
       {"geom = (SELECT geom FROM patches WHERE id = 4)", "gsd_m = gsd_m * 1.001", "bits = 16",
        "bands = 3", "covariance = zeroblob(48)", "height_effect = zeroblob(24)",
        "height_sigma_m = 0.3", "quality = 0.9", "distinctness = 0.5", "heights_size = 5",
        "heights_step_m = 7", "heights_base_m = 1", "heights_quantum_m = 0.5",
        "heights = (SELECT heights FROM patches WHERE id = 5)", "chip_mask = zeroblob(9)",
        "chip = (SELECT chip FROM patches WHERE id = 6)"}) {
    const std::string before = Now();
    EXPECT_NE(After(std::string("UPDATE patches SET ") + change + " WHERE id = 3"), before)
        << change;
  }
}

TEST_F(ContentDigestTest, ChangesWithPatchesThatComeAndGo) {
  std::string before = Now();
  PatchSource source = Photo("4712.tif");
  std::vector<Patch> patches = {SomePatch(500001, 5000001)};
  PatchDatabase::Open(path_, Mode::kWrite).AddSource(source, patches);
  EXPECT_NE(Now(), before);
  before = Now();
  EXPECT_NE(After("DELETE FROM patches WHERE id = 3"), before);
}

TEST_F(ContentDigestTest, OfTwoDatabasesMadeAlikeDiffers) {
  const std::string first = Now();
  std::filesystem::remove(path_);
  Filled(20);
  EXPECT_NE(Now(), first);
}

TEST_F(ContentDigestTest, ChangesWithRetiringAndRestoring) {
  std::string before = Now();
  {
    PatchDatabase database = PatchDatabase::Open(path_, Mode::kWrite);
    ASSERT_EQ(RetirePatches(database, {3}, "by hand"), 1);
  }
  EXPECT_NE(Now(), before);
  before = Now();
  {
    PatchDatabase database = PatchDatabase::Open(path_, Mode::kWrite);
    ASSERT_EQ(RestorePatches(database, {3}), 1);
  }
  EXPECT_NE(Now(), before);
}

TEST_F(ContentDigestTest, DoesNotChangeWithWhatAttemptsTeach) {
  const std::string before = Now();
  Attempt(3, "a", "matched");
  EXPECT_EQ(Now(), before);
}

TEST_F(ContentDigestTest, ChangesWithAnyRetirementByAnotherProgramWhateverItsWords) {
  const std::string before = Now();
  EXPECT_NE(
      After("UPDATE patches SET state = 'retired', retired_on = '2020-01-01', retired_reason = "
            "'failed in 3 photos where its neighbours matched' WHERE id = 3"),
      before);
}

TEST_F(ContentDigestTest, IsNotToBeHadWhereNobodyKeepsIt) {
  Execute("DROP TRIGGER orient_content_update");
  EXPECT_NE(WhatIsWrong([&] { Now(); }).find("--repair"), std::string::npos);
  CheckOptions options;
  options.repair = true;
  PatchDatabase database = PatchDatabase::Open(path_, Mode::kWrite);
  CheckDatabase(database, options);
  EXPECT_FALSE(ContentOf(database).empty());
  Execute("DROP TABLE orient_content");
  EXPECT_NE(WhatIsWrong([&] { Now(); }).find("--repair"), std::string::npos);
}

TEST_F(ContentDigestTest, IsMadeAgainByARepair) {
  Execute("DELETE FROM orient_content");
  EXPECT_NE(WhatIsWrong([&] { Now(); }).find("--repair"), std::string::npos);
  PatchDatabase database = PatchDatabase::Open(path_, Mode::kWrite);
  EXPECT_EQ(CheckDatabase(database, {}).size(), 1u);
  CheckOptions options;
  options.repair = true;
  CheckDatabase(database, options);
  EXPECT_TRUE(CheckDatabase(database, {}).empty());
  EXPECT_FALSE(ContentOf(database).empty());
}

}  // namespace
}  // namespace orient::patchdb
