// Several programs at one patch database, and the files that they leave.
#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "patchdb/store/patch_database.h"
#include "patchdb/store/selection.h"
#include "tests/support/made_up_patches.h"
#include "tests/support/ordinary_user.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

namespace fs = std::filesystem;
using Mode = PatchDatabase::Mode;

class ReadersAndWritersTest : public testing::Test {
 protected:
  void Add(PatchDatabase& database, const std::string& name) {
    PatchSource source = MadeUpSource(name);
    std::vector<Patch> patches = {MadeUpPatch(600000, 5000000, 1)};
    database.AddSource(source, patches);
  }
  std::vector<std::string> Files() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.Path()))
      names.push_back(entry.path().filename().string());
    return names;
  }
  static std::int64_t Count(const std::string& path) {
    return PatchDatabase::Open(path, Mode::kRead).Info().patches;
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "patches.gpkg";
};

TEST_F(ReadersAndWritersTest, ReaderInTheMiddleBlocksNoWriter) {
  MadeUpDatabase(path_, 4, 3);
  {
    const PatchDatabase reader = PatchDatabase::Open(path_, Mode::kRead);
    int seen = 0;
    VisitPatches(reader, {}, [&](const PatchSummary&) {
      if (seen++ == 5) {
        PatchDatabase writer = PatchDatabase::Open(path_, Mode::kWrite, 0);
        Add(writer, "more.tif");
      }
    });
    EXPECT_EQ(seen, 12) << "the state before the writer";
    EXPECT_EQ(Count(path_), 13);
  }
  EXPECT_EQ(Files(), std::vector<std::string>{"patches.gpkg"});
  fs::copy_file(path_, folder_ / "copy.gpkg");
  EXPECT_EQ(Count(folder_ / "copy.gpkg"), 13);
}

TEST_F(ReadersAndWritersTest, ReadersLeaveNothingBehind) {
  MadeUpDatabase(path_, 4, 3);
  {
    const PatchDatabase one = PatchDatabase::Open(path_, Mode::kRead);
    EXPECT_EQ(Count(path_), 12);
    EXPECT_EQ(one.Info().patches, 12);
  }
  EXPECT_EQ(Files(), std::vector<std::string>{"patches.gpkg"});
}

// What a killed writer leaves: the file and its log.
TEST_F(ReadersAndWritersTest, LogOfAKilledWriterIsTakenIn) {
  MadeUpDatabase(path_, 4, 3);
  const std::string left = folder_ / "left.gpkg";
  {
    PatchDatabase writer = PatchDatabase::Open(path_, Mode::kWrite);
    Add(writer, "more.tif");
    fs::copy_file(path_, left);
    fs::copy_file(path_ + "-wal", left + "-wal");
  }
  ASSERT_GT(fs::file_size(left + "-wal"), 0u);
  EXPECT_EQ(Count(left), 13);
  EXPECT_FALSE(fs::exists(left + "-wal"));
  EXPECT_EQ(Count(left), 13);
}

// What one leaves that was killed while it had no write-ahead log: compacting an old file.
TEST_F(ReadersAndWritersTest, JournalOfAKilledWriterIsUndoneByAReader) {
  MadeUpDatabase(path_, 4, 3);
  const std::string left = folder_ / "left.gpkg";
  {
    SQLite::Database raw(path_, SQLite::OPEN_READWRITE);
    raw.exec("PRAGMA journal_mode = DELETE");
    raw.exec("PRAGMA cache_size = 1");  // so that some of it is in the file before it is through
    raw.exec(
        "BEGIN IMMEDIATE; DELETE FROM orient_schema; DELETE FROM sources; "
        "CREATE TABLE more AS SELECT randomblob(3000000)");
    fs::copy_file(path_, left);
    fs::copy_file(path_ + "-journal", left + "-journal");
    raw.exec("ROLLBACK");
  }
  ASSERT_GT(fs::file_size(left + "-journal"), 0u);
  EXPECT_EQ(Count(left), 12);
  EXPECT_EQ(PatchDatabase::Open(left, Mode::kRead).Info().sources, 1);
  EXPECT_FALSE(fs::exists(left + "-journal"));
}

TEST_F(ReadersAndWritersTest, ReadOnlyFolderCanBeRead) {
  const std::string folder = folder_ / "only read & 100%?#";
  fs::create_directory(folder);
  const std::string path = folder + "/patches.gpkg";
  MadeUpDatabase(path, 4, 3);
  chmod(path.c_str(), 0444);
  chmod(folder.c_str(), 0555);
  {
    const OrdinaryUser user(folder_.Path());
    EXPECT_EQ(Count(path), 12);
    EXPECT_EQ(PatchDatabase::Open(path, Mode::kRead).FindPatchesIn({0, 0, 1e7, 1e7}).size(), 12u);
    EXPECT_ANY_THROW(PatchDatabase::Open(path, Mode::kWrite));
  }
  chmod(folder.c_str(), 0755);
}

}  // namespace
}  // namespace orient::patchdb
