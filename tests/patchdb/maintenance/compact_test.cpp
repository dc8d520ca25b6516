#include "patchdb/maintenance/compact.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "patchdb/maintenance/check.h"
#include "patchdb/maintenance/life.h"
#include "patchdb/store/connection.h"
#include "tests/support/made_up_patches.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

using Mode = PatchDatabase::Mode;

class CompactTest : public testing::Test {
 protected:
  CompactTest() { MadeUpDatabase(path_, 4, 3); }

  // As a file of a program before pages had today's size.
  void GiveOldPages() const {
    SQLite::Database raw(path_, SQLite::OPEN_READWRITE);
    raw.exec("PRAGMA journal_mode = DELETE");
    raw.exec("PRAGMA page_size = 4096");
    raw.exec("VACUUM");
    raw.exec("PRAGMA journal_mode = WAL");
  }
  std::string Pragma(const std::string& name) const {
    SQLite::Database raw(path_, SQLite::OPEN_READONLY);
    return raw.execAndGet("PRAGMA " + name).getString();
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "patches.gpkg";
};

TEST_F(CompactTest, GivesSpaceBackAndKeepsEverything) {
  PatchDatabase database = PatchDatabase::Open(path_, Mode::kWrite);
  PatchSource source = MadeUpSource("many.tif");
  std::vector<Patch> many = MadeUpPatches(40, 40, 10, 600000);
  database.AddSource(source, many);
  std::vector<std::int64_t> ids;
  for (const Patch& patch : many) ids.push_back(patch.id);
  RetirePatches(database, ids, "test");
  DeleteRetiredPatches(database, ids);
  const CompactResult result = CompactDatabase(database);
  EXPECT_LT(2 * result.after, result.before);
  EXPECT_FALSE(result.old_pages);
  EXPECT_EQ(database.Info().patches, 12);
  EXPECT_TRUE(CheckDatabase(database, {}).empty());
}

TEST_F(CompactTest, GivesAnOldFileTodaysPages) {
  GiveOldPages();
  ASSERT_EQ(Pragma("page_size"), "4096");
  {
    PatchDatabase database = PatchDatabase::Open(path_, Mode::kWrite);
    EXPECT_EQ(database.Info().patches, 12);  // statements in use are no hindrance
    EXPECT_FALSE(CompactDatabase(database).old_pages);
    EXPECT_TRUE(CheckDatabase(database, {}).empty());
    EXPECT_EQ(database.Info().patches, 12);
  }
  // Before anybody else looks at it: one file, whole by itself.
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.Path()), {}), 1);
  EXPECT_EQ(Pragma("page_size"), std::to_string(kPageSize));
  EXPECT_EQ(Pragma("journal_mode"), "wal");
}

TEST_F(CompactTest, KeepsOldPagesWhileSomebodyElseReads) {
  GiveOldPages();
  PatchDatabase database = PatchDatabase::Open(path_, Mode::kWrite, 0.1);
  const PatchDatabase reader = PatchDatabase::Open(path_, Mode::kRead);
  EXPECT_EQ(reader.Info().patches, 12);
  EXPECT_TRUE(CompactDatabase(database).old_pages);
  EXPECT_EQ(reader.Info().patches, 12);
  EXPECT_TRUE(CheckDatabase(database, {}).empty());
  EXPECT_EQ(Pragma("journal_mode"), "wal");
}

}  // namespace
}  // namespace orient::patchdb
