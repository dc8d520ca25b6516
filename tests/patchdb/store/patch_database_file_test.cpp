// The file of a patch database: made, opened, refused, damaged, read by others.
#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "patchdb/maintenance/life.h"
#include "patchdb/store/patch_database.h"
#include "patchdb/store/schema.h"
#include "tests/patchdb/store/valid_geopackage.h"
#include "tests/support/ordinary_user.h"
#include "tests/support/patch_database_fixture.h"

namespace orient::patchdb {
namespace {

namespace fs = std::filesystem;
using Mode = PatchDatabase::Mode;

class PatchDatabaseFileTest : public PatchDatabaseTest {};

TEST_F(PatchDatabaseFileTest, ReadOnlyRefusesToWrite) {
  Filled(1);
  PatchDatabase database = PatchDatabase::Open(path_, Mode::kRead);
  EXPECT_THROW(database.RecordAttempts({}), std::invalid_argument);
}

// SQLite itself would say so at the first row only.
TEST_F(PatchDatabaseFileTest, WhatMayOnlyBeReadIsNamedWhenItIsOpenedForWriting) {
  Filled(3);
  const OrdinaryUser user(folder_.Path());
  for (const std::string& locked : {folder_.Path(), path_}) {
    fs::permissions(locked, fs::perms::owner_write, fs::perm_options::remove);
    const std::string message = WhatIsWrong([&] { PatchDatabase::Open(path_, Mode::kWrite); });
    EXPECT_NE(message.find(path_), std::string::npos) << message;
    EXPECT_NE(message.find("writable"), std::string::npos) << message;
    EXPECT_EQ(PatchDatabase::Open(path_, Mode::kRead).Info().patches, 3);
    fs::permissions(locked, fs::perms::owner_write, fs::perm_options::add);
  }
  EXPECT_EQ(PatchDatabase::Open(path_, Mode::kWrite).Info().patches, 3);
}

TEST_F(PatchDatabaseFileTest, MistypedPathNeverMakesAFile) {
  for (const Mode mode : {Mode::kRead, Mode::kWrite})
    EXPECT_NE(WhatIsWrong([&] { PatchDatabase::Open(path_, mode); }).find(path_),
              std::string::npos);
  EXPECT_FALSE(fs::exists(path_));
  EXPECT_TRUE(fs::is_empty(folder_.Path()));
}

TEST_F(PatchDatabaseFileTest, OfManyThatCreateItAtOnceOneSucceeds) {
  std::atomic<int> made = 0;
  std::vector<std::thread> creators;
  for (int i = 0; i < 4; ++i)
    creators.emplace_back([&] {
      if (WhatIsWrong([&] { PatchDatabase::Create(path_, Utm()); }).empty()) ++made;
    });
  for (std::thread& creator : creators) creator.join();
  EXPECT_EQ(made, 1);
  EXPECT_EQ(PatchDatabase::Open(path_, Mode::kRead).Info().patches, 0);
}

TEST_F(PatchDatabaseFileTest, WhatIsFilledBeforeItHasItsNameAppearsWholeOrNotAtAll) {
  const auto fail = [](PatchDatabase& database) {
    PatchSource source = Photo("4711.tif");
    std::vector<Patch> patches = {SomePatch(500000, 5000000)};
    database.AddSource(source, patches);
    throw InputError("half way");
  };
  EXPECT_EQ(WhatIsWrong([&] { PatchDatabase::Create(path_, Utm(), fail); }), "half way");
  EXPECT_TRUE(fs::is_empty(folder_.Path()));
  PatchDatabase::Create(path_, Utm(), [](PatchDatabase& database) {
    PatchSource source = Photo("4711.tif");
    std::vector<Patch> patches = {SomePatch(500000, 5000000)};
    database.AddSource(source, patches);
  });
  EXPECT_EQ(PatchDatabase::Open(path_, Mode::kRead).Info().patches, 1);
}

// A view that never ends in the place of a table of ours.
TEST_F(PatchDatabaseFileTest, AStrangersViewIsNotRun) {
  Filled(3);
  Execute("DROP TABLE attempts");
  Execute(
      "CREATE VIEW attempts AS WITH RECURSIVE n(patch_id) AS (SELECT 1 UNION ALL SELECT patch_id + "
      "1 FROM n) SELECT patch_id FROM n");
  EXPECT_NE(WhatIsWrong([&] { PatchDatabase::Open(path_, Mode::kRead).Info(); }).find(path_),
            std::string::npos);
}

TEST_F(PatchDatabaseFileTest, AStrangersTriggerIsNamedAndNotRun) {
  Filled(3);
  Execute("CREATE TRIGGER surprise AFTER UPDATE ON patches BEGIN DELETE FROM sources; END");
  const std::string message = WhatIsWrong([&] { PatchDatabase::Open(path_, Mode::kWrite); });
  EXPECT_NE(message.find("surprise"), std::string::npos) << message;
  EXPECT_EQ(PatchDatabase::Open(path_, Mode::kRead).Info().patches, 3);
}

TEST_F(PatchDatabaseFileTest, AStrangersTriggerInAnothersNameDoesNotRun) {
  Filled(3);
  Execute("DROP TRIGGER orient_content_update");
  for (const char* name : {"orient_content_update", "rtree_patches_geom_more"}) {
    Execute(std::string("CREATE TRIGGER ") + name +
            " AFTER UPDATE ON patches BEGIN DELETE FROM attempts; DELETE FROM sources; END");
    auto database = PatchDatabase::Open(path_, Mode::kWrite);
    const std::string message = WhatIsWrong([&] { RetirePatches(database, {1}, "by hand"); });
    EXPECT_NE(message.find("trigger"), std::string::npos) << message;
    EXPECT_EQ(database.Info().retired, 0);
    EXPECT_EQ(database.Info().sources, 1);
    Execute(std::string("DROP TRIGGER ") + name);
  }
}

TEST_F(PatchDatabaseFileTest, CreateNeverOverwrites) {
  Filled(2);
  EXPECT_NE(WhatIsWrong([&] { PatchDatabase::Create(path_, Utm()); }).find("exists already"),
            std::string::npos);
  EXPECT_EQ(PatchDatabase::Open(path_, Mode::kRead).Info().patches, 2);
}

TEST_F(PatchDatabaseFileTest, CreateInAMissingFolderSaysSo) {
  const std::string path = folder_ / "nowhere/patches.gpkg";
  EXPECT_NE(WhatIsWrong([&] { PatchDatabase::Create(path, Utm()); }).find(path), std::string::npos);
}

TEST_F(PatchDatabaseFileTest, ClosedFileLeavesNothingBesideIt) {
  Filled(2);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.Path()), fs::directory_iterator()), 1);
}

TEST_F(PatchDatabaseFileTest, ReaderSeesWholeSourcesWhileAWriterHasTheFileOpen) {
  PatchDatabase writer = Filled(5);
  const PatchDatabase reader = PatchDatabase::Open(path_, Mode::kRead);
  EXPECT_EQ(reader.Info().patches, 5);
  PatchSource more = Photo("4712.tif");
  std::vector<Patch> patches = {SomePatch(1000, 2000)};
  writer.AddSource(more, patches);
  EXPECT_EQ(reader.Info().patches, 6);
}

TEST_F(PatchDatabaseFileTest, NewerSchemaIsRefusedNamingBothVersions) {
  Filled(1);
  Execute("INSERT INTO orient_schema VALUES (7, 'from the future')");
  const std::string message = WhatIsWrong([&] { PatchDatabase::Open(path_, Mode::kWrite); });
  EXPECT_NE(message.find("version 7"), std::string::npos) << message;
  EXPECT_NE(message.find("knows " + std::to_string(CurrentSchemaVersion())), std::string::npos)
      << message;
}

TEST_F(PatchDatabaseFileTest, OtherFilesAreRefusedByName) {
  std::ofstream(path_) << "this is a text file, and long enough to look like something else";
  EXPECT_NE(WhatIsWrong([&] { PatchDatabase::Open(path_, Mode::kRead); }).find(path_),
            std::string::npos);
  std::ofstream(path_, std::ios::trunc).close();
  EXPECT_NE(WhatIsWrong([&] { PatchDatabase::Open(path_, Mode::kWrite); }).find("not a GeoPackage"),
            std::string::npos);
  EXPECT_NE(WhatIsWrong([&] { PatchDatabase::Open(folder_.Path(), Mode::kRead); }), "");
}

TEST_F(PatchDatabaseFileTest, TruncatedFileIsAnInputError) {
  Filled(100);
  const auto size = fs::file_size(path_);
  for (const double share : {0.01, 0.1, 0.3, 0.6, 0.9}) {
    const std::string copy = folder_ / "cut.gpkg";
    fs::copy_file(path_, copy, fs::copy_options::overwrite_existing);
    fs::resize_file(copy, static_cast<std::uintmax_t>(static_cast<double>(size) * share));
    EXPECT_THROW(PatchDatabase::Open(copy, Mode::kRead).ListPatches(0, 1000), InputError) << share;
  }
}

// Little-endian doubles, hexadecimal.
std::string Hexadecimal(std::initializer_list<double> numbers) {
  std::string text;
  for (const double number : numbers) {
    std::array<unsigned char, sizeof number> bytes{};
    std::memcpy(bytes.data(), &number, sizeof number);
    for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  }
  return text;
}

TEST_F(PatchDatabaseFileTest, DamagedValuesAreAnInputErrorNamingThePatch) {
  const std::string damages[] = {"chip = x'89504e470d0a1a0a'",
                                 "chip_mask = x'00'",
                                 "heights = x'0000'",
                                 "heights_size = 2147483647",
                                 "covariance = x''",
                                 "gsd_m = -1",
                                 "geom = x'475000010000000001'",
                                 "chip = 'text'",
                                 "heights_step_m = 'a'",
                                 "heights_step_m = 1e308",
                                 "gsd_m = 1e300",
                                 "height_sigma_m = -5",
                                 "height_sigma_m = 9e999",
                                 "height_sigma_m = 99999",
                                 "gsd_m = '0.81x'",
                                 "state = 'ACTIVE'",
                                 "covariance = x'" + Hexadecimal({-1, 0, 0, -1, 0, -1}) + "'",
                                 "covariance = x'" + Hexadecimal({1e9, 0, 0, 1, 0, 1}) + "'",
                                 "height_effect = x'" + Hexadecimal({1e9, 0, 1}) + "'"};
  for (const std::string& damage : damages) {
    fs::remove(path_);
    Filled(2);
    // A shell without the spatial functions cannot run the index's triggers.
    std::string sql = "PRAGMA ignore_check_constraints = ON; ";
    if (damage.starts_with("geom"))
      sql +=
          "DROP TRIGGER rtree_patches_geom_update1; DROP TRIGGER rtree_patches_geom_update2; "
          "DROP TRIGGER rtree_patches_geom_update3; DROP TRIGGER rtree_patches_geom_update4; ";
    else
      sql += "DROP TRIGGER rtree_patches_geom_update3; DROP TRIGGER rtree_patches_geom_update4; ";
    sql += "UPDATE patches SET ";
    sql += damage;
    sql += " WHERE id = 2";
    Execute(sql);
    const std::string message =
        WhatIsWrong([&] { PatchDatabase::Open(path_, Mode::kRead).ListPatches(0, 10); });
    EXPECT_NE(message.find("patch 2"), std::string::npos) << damage << ": " << message;
    EXPECT_NE(message.find(path_), std::string::npos) << damage << ": " << message;
  }
}

TEST_F(PatchDatabaseFileTest, RandomDamageNeverCrashes) {
  Filled(30);
  std::mt19937 random(TestSeed());
  std::ifstream file(path_, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(file)), {});
  for (int round = 0; round < 60; ++round) {
    std::string bytes = whole;
    for (int i = 0; i < 40; ++i) bytes[random() % bytes.size()] = static_cast<char>(random());
    const std::string copy = folder_ / "damaged.gpkg";
    std::ofstream(copy, std::ios::binary | std::ios::trunc) << bytes;
    try {
      const PatchDatabase database = PatchDatabase::Open(copy, Mode::kRead);
      database.Info();
      database.FindPatchesIn({0, 0, 1e7, 1e7});
      database.ListPatches(0, 100);
    } catch (const InputError&) {
    }
  }
}

TEST_F(PatchDatabaseFileTest, IsAValidGeoPackage) {
  Filled(20).RecordAttempts({{1, "p", "matched", 0.9, Eigen::Vector2d(0, 1), ""}});
  ExpectValidGeoPackage(path_);
}

TEST_F(PatchDatabaseFileTest, SaysWhichProgramMadeItAndHowItIsDrawn) {
  Filled(1);
  SQLite::Database raw(path_, SQLite::OPEN_READONLY);
  const std::string metadata = raw.execAndGet("SELECT metadata FROM gpkg_metadata").getString();
  EXPECT_NE(metadata.find("orient_patchdb"), std::string::npos) << metadata;
  EXPECT_NE(metadata.find("program&quot;:&quot;orient "), std::string::npos) << metadata;
  EXPECT_EQ(raw.execAndGet("SELECT count(*) FROM gpkg_metadata_reference").getInt(), 1);
  const std::string style =
      raw.execAndGet(
             "SELECT styleQML FROM layer_styles WHERE f_table_name = 'patches' AND "
             "f_geometry_column = 'geom' AND useAsDefault = 1")
          .getString();
  EXPECT_NE(style.find("value=\"retired\""), std::string::npos) << style;
}

TEST_F(PatchDatabaseFileTest, GdalReadsThePatchesAsPoints) {
  if (!fs::exists("/usr/bin/ogrinfo")) GTEST_SKIP() << "ogrinfo is absent (Debian's gdal-bin)";
  Filled(20);
  const std::string log = folder_ / "log.txt";
  EXPECT_EQ(std::system(("ogrinfo -ro -al -so " + path_ + " > " + log + " 2>&1").c_str()), 0);
  std::ifstream file(log);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  EXPECT_NE(text.find("3D Point"), std::string::npos) << text;
  EXPECT_NE(text.find("Feature Count: 20"), std::string::npos) << text;
  EXPECT_NE(text.find("UTM zone 35N"), std::string::npos) << text;
  EXPECT_EQ(text.find("Warning"), std::string::npos) << text;
}

// As on a full disk: no file may grow beyond the limit.
TEST_F(PatchDatabaseFileTest, ANewOneThatTheDiskDoesNotHoldLeavesNothing) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{400000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::string why;  // the machine's fault, not the input's
  try {
    PatchDatabase::Create(folder_ / "new.gpkg", Utm());
  } catch (const EnvironmentError& error) {
    why = error.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(why.find("full"), std::string::npos) << why;
  for (const auto& entry : fs::directory_iterator(folder_ / "."))
    EXPECT_EQ(entry.path().filename().string().find("new.gpkg"), std::string::npos) << entry.path();
}

}  // namespace
}  // namespace orient::patchdb
