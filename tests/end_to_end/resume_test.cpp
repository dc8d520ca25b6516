// A block that was killed goes on where it stopped, and ends as if nothing had happened.
#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include "block/inputs/block_files.h"
#include "block/inputs/digest.h"
#include "core/base/atomic_write.h"
#include "core/base/open_dataset.h"
#include "patchdb/store/patch_database.h"
#include "tests/end_to_end/simulated_block.h"
#include "tests/end_to_end/spoilt_block.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

int CountResults(const std::string& folder, const std::string& suffix) {
  int count = 0;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none))
    count += entry.path().string().ends_with(suffix) ? 1 : 0;
  return count;
}

// The real program in a process of its own, killed once `results` files of this kind are there.
// Returns how many there are then.
int RunAndKill(const std::string& block_file, const std::string& out, const std::string& suffix,
               int results) {
  const pid_t child = fork();
  if (child == 0) {
    execl(ORIENT_PROGRAM, "orient", "block", block_file.c_str(), "--resume", "--learn", "--jobs",
          "1", static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  while (CountResults(out, suffix) < results && waitpid(child, &status, WNOHANG) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  kill(child, SIGKILL);
  waitpid(child, &status, 0);
  return CountResults(out, suffix);
}

SimulationOptions FourFilmPhotos() {
  SimulationOptions options;
  options.photos = 4;
  options.gsd_m = 0.75;
  options.pixel_size_um = 75;
  options.objects = false;
  options.position_error_m = 3;
  options.attitude_error_deg = 0.5;
  return options;
}

// As a TIFF of blocks that cannot be decoded where a byte of them is lost.
void Compress(const std::string& path) {
  const std::string copy = path + ".copy";
  const char* const options[] = {"COMPRESS=DEFLATE", "TILED=YES", nullptr};
  const GDALDatasetUniquePtr original = OpenRasterDataset(path);
  GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  const GDALDatasetUniquePtr compressed(driver->CreateCopy(
      copy.c_str(), original.get(), FALSE, const_cast<char**>(options), nullptr, nullptr));
  if (!compressed) throw std::runtime_error("cannot write " + copy);
}

TEST_F(BadPhoto, DamagedScanReplacedByASoundOneThatLooksTheSameIsReadOnResume) {
  const std::string other = Path("scans/new_1_1.tif"), scan = Path("scans/new_1_2.tif");
  Compress(scan);
  fs::rename(scan + ".copy", scan);
  const std::string sound = ReadFile(scan), digest = block::DigestOfFile(scan);
  constexpr std::size_t kPiece = 1 << 16;  // of which the digest is made: first, middle and last
  ASSERT_GT(sound.size(), 4 * kPiece);
  WriteFileAtomically(scan, std::string(sound).replace(kPiece, 20000, 20000, '\0'));
  ASSERT_EQ(block::DigestOfFile(scan), digest);
  ExpectOnlyTheSecondFails(Both(), {scan});
  WriteFileAtomically(scan, sound);
  EXPECT_EQ(Exterior({other, scan, "--resume", "--plan"}).out,
            "keep  exterior  new_1_1\ndo    exterior  new_1_2\n");
  EXPECT_EQ(Exterior({other, scan, "--resume"}).exit_code, 0);
  EXPECT_EQ(ReadExteriorResult(ExteriorResultPath(Path("out"), "new_1_2")).status, Status::kOk);
}

// Otherwise a file of its name would be replaced unasked.
TEST_F(BadPhoto, EveryFileOfABlocksFolderIsListed) {
  Edit("block.toml", "[output]\n", "[ortho]\n[output]\n");
  const ProgramRun run = Block({"--quicklook"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out.find("has not ended"), std::string::npos) << run.out;
  std::vector<std::string> listed = block::BlockFiles(Path("out"));
  for (const std::string& file : block::PhotoFiles(Path("out"), {"new_1_1", "new_1_2"}))
    listed.push_back(file);
  for (const auto& entry : fs::directory_iterator(Path("out"))) {
    if (!entry.is_regular_file()) continue;
    EXPECT_NE(std::find(listed.begin(), listed.end(), entry.path()), listed.end()) << entry.path();
  }
}

// Files that the run would replace by, or remove as, its own.
TEST_F(BadInput, WhatARunReadsIsNeverReplaced) {
  fs::create_directory(Path("out"));
  const auto expect_kept = [&](const std::string& file, const std::string& key,
                               const std::string& name) {
    fs::copy(Path(file), Path("out/" + name));
    const std::string block = ReadFile(Path("block.toml")), before = ReadFile(Path(file));
    Edit("block.toml", key + " = \"" + file, key + " = \"out/" + name);
    for (const char* option : {"--resume", "--overwrite"}) {
      ExpectRefused(Block({option}), 1, {Path("out/" + name)});
      EXPECT_EQ(ReadFile(Path("out/" + name)), before) << name << option;
    }
    Write("block.toml", block);
    fs::remove(Path("out/" + name));
  };
  expect_kept("camera.toml", "camera", "calibrated_camera.toml");
  expect_kept("camera.toml", "camera", "block_camera.toml");
  expect_kept("approx.csv", "approximations", "orientation.csv");
  expect_kept("patches.gpkg", "patchdb", "block.gpkg");
  Write("out/marks.csv", "photo,mark,col,row,sigma\n");
  Write("block.toml", "measurements = \"out\"\n" + ReadFile(Path("block.toml")));
  ExpectRefused(Block({"--overwrite"}), 1, {Path("out/marks.csv"), "is an input"});
  fs::remove(Path("out/marks.csv"));
  Edit("block.toml", "measurements = \"out\"\n", "");
  fs::copy(Path("camera.toml"), Path("out/block_camera.toml"));
  ExpectRefused(
      RunOrient({"exterior", Path("scans/new_1_2.tif"), "--camera", Path("out/block_camera.toml"),
                 "--approximations", Path("approx.csv"), "--dem", Path("dem.tif"), "--patchdb",
                 Path("patches.gpkg"), "--out", Path("out"), "--overwrite"}),
      1, {Path("out/block_camera.toml"), "is an input"});
  fs::remove(Path("out/block_camera.toml"));
  fs::copy(Path("scans/new_1_2.tif"), Path("out/contact_sheet.png"));
  ExpectRefused(RunOrient({"interior", Path("out/contact_sheet.png"), "--camera", "auto", "--out",
                           Path("out")}),
                1, {Path("out/contact_sheet.png"), "is an input"});
  fs::remove(Path("out/contact_sheet.png"));
  Write("out/control_points.csv", "a surveyor's");
  ExpectRefused(Block(), 1, {Path("out/control_points.csv"), "exists already"});
  EXPECT_EQ(ReadFile(Path("out/control_points.csv")), "a surveyor's");
}

TEST(SlowResume, KilledBlockEndsAsAnUndisturbedOne) {
  const TemporaryFolder folder;
  Simulate(FourFilmPhotos(), folder / "block");
  HarvestOldPhotos(folder / "block", folder / "block/patches.gpkg", 200);
  fs::copy(folder / "block", folder / "killed", fs::copy_options::recursive);

  const ProgramRun undisturbed = RunOrient({"block", folder / "block/block.toml", "--learn"});
  ASSERT_EQ(undisturbed.exit_code, 0) << undisturbed.out << undisturbed.err;

  const std::string out = folder / "killed/out";
  const std::string block = folder / "killed/block.toml";
  EXPECT_LT(RunAndKill(block, out, ".interior.json", 1), 4);
  EXPECT_EQ(CountResults(out + "/stages/exterior", ".exterior.json"), 0);
  // Later kills leave their traces in the stages of single photos and of ties.
  for (int results = 1; results <= 3; ++results)
    EXPECT_LT(RunAndKill(block, out + "/stages/exterior", ".exterior.json", results), 4);
  EXPECT_LT(RunAndKill(block, out + "/stages/ties", ".ties.json", 1), 4);
  EXPECT_FALSE(fs::exists(out + "/orientation.csv"));

  // An interrupted run goes on without being asked to.
  const ProgramRun resumed = RunOrient({"block", block, "--learn"});
  EXPECT_EQ(resumed.exit_code, 0) << resumed.out << resumed.err;
  EXPECT_EQ(resumed.out.find("oriented again"), std::string::npos) << resumed.out;
  const std::string expected = ReadFile(folder / "block/out/orientation.csv");
  EXPECT_EQ(std::count(expected.begin(), expected.end(), '\n'), 5);
  EXPECT_EQ(ReadFile(out + "/orientation.csv"), expected);
  EXPECT_EQ(ReadFile(out + "/block.json"), ReadFile(folder / "block/out/block.json"));
  for (const char* name : {"orientation.prj", "report.html", "block.gpkg"})
    EXPECT_TRUE(fs::exists(out + "/" + name)) << name;
  for (const char* photo : {"new_1_1", "new_1_2", "new_1_3", "new_1_4"})
    EXPECT_EQ(ReadFile(ExteriorResultPath(out, photo)),
              ReadFile(ExteriorResultPath(folder / "block/out", photo)))
        << photo;
  // Every result says itself what it was made from; nothing beside it does.
  for (const auto& entry : fs::recursive_directory_iterator(out + "/stages")) {
    const std::string extension = entry.path().extension().string();
    EXPECT_TRUE(extension != ".made_from" && extension != ".sought") << entry.path();
    if (extension != ".json") continue;
    EXPECT_TRUE(ReadMadeFrom(entry.path().string())) << entry.path();
  }
  // What the patches learnt is the same, too: no attempt is lost or counted twice.
  const auto attempts = [&](const std::string& name) {
    return patchdb::PatchDatabase::Open(folder / (name + "/patches.gpkg"),
                                        patchdb::PatchDatabase::Mode::kRead)
        .Info()
        .attempts;
  };
  EXPECT_GT(attempts("block"), 0);
  EXPECT_EQ(attempts("killed"), attempts("block"));
}

}  // namespace
}  // namespace orient
