// A small simulated block to spoil: what tests of bad input share.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/atomic_write.h"
#include "core/files/orientation_table.h"
#include "tests/end_to_end/simulated_block.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {

// `text` with its only `from` replaced.
inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::invalid_argument(from + " is not in " + text);
  return text.replace(at, from.size(), to);
}

// A digital block of two photos, made once for all tests of a process. Its photos are oriented when
// nothing is wrong, or so small that none could be.
inline std::string SoundBlock(bool photos_can_be_oriented) {
  static const TemporaryFolder folder;
  const std::string block = folder / (photos_can_be_oriented ? "oriented" : "small");
  if (std::filesystem::exists(block)) return block;
  SimulationOptions options;
  options.camera = CameraPreset::kDigital;
  options.photos = 2;
  options.gsd_m = 0.75;
  options.pixel_size_um = photos_can_be_oriented ? 60 : 400;  // 890 x 667 px
  options.objects = false;
  options.position_error_m = 3;
  options.attitude_error_deg = 0.5;
  Simulate(options, block);
  const std::string database = block + "/patches.gpkg";
  if (photos_can_be_oriented) {
    HarvestOldPhotos(block, database, 150);
    return block;
  }
  const ProgramRun run = RunOrient({"patchdb", "create", database, "--crs", "EPSG:32635"});
  if (run.exit_code != 0) throw std::runtime_error(run.err);
  return block;
}

// For what is refused before any photo is looked at.
class BadInput : public testing::Test {
 protected:
  explicit BadInput(bool photos_can_be_oriented = false) {
    std::filesystem::copy(SoundBlock(photos_can_be_oriented), block_,
                          std::filesystem::copy_options::recursive);
  }

  std::string Path(const std::string& name) const { return block_ + "/" + name; }
  std::string Write(const std::string& name, const std::string& text) const {
    WriteFileAtomically(Path(name), text);
    return Path(name);
  }
  // The block's own file with one thing replaced, under its own name.
  void Edit(const std::string& name, const std::string& from, const std::string& to) const {
    Write(name, Replaced(ReadFile(Path(name)), from, to));
  }
  ProgramRun Block(const std::vector<std::string>& further = {}) const {
    std::vector<std::string> arguments = {"block", Path("block.toml")};
    arguments.insert(arguments.end(), further.begin(), further.end());
    return RunOrient(arguments);
  }
  ProgramRun Exterior(const std::vector<std::string>& further) const {
    std::vector<std::string> arguments = {
        "exterior",           "--camera", Path("camera.toml"), "--approximations",
        Path("approx.csv"),   "--dem",    Path("dem.tif"),     "--patchdb",
        Path("patches.gpkg"), "--out",    Path("out")};
    arguments.insert(arguments.end(), further.begin(), further.end());
    return RunOrient(arguments);
  }

  // Refused before any photo: one line with all parts, and nothing on standard output.
  static void ExpectRefused(const ProgramRun& run, int exit_code,
                            const std::vector<std::string>& parts) {
    EXPECT_EQ(run.exit_code, exit_code) << run.out << run.err;
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(run.err.rfind("orient: ", 0), 0u) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_EQ(run.err.find("internal error"), std::string::npos) << run.err;
    for (const std::string& part : parts)
      EXPECT_NE(run.err.find(part), std::string::npos) << run.err << "lacks " << part;
  }

  TemporaryFolder folder_;
  std::string block_ = folder_ / "block";
};

// The same with photos that are oriented when nothing is wrong.
class BadPhoto : public BadInput {
 protected:
  BadPhoto() : BadInput(true) {}

  // Each by itself: in a block the one may find the other.
  ProgramRun Both() const {
    return Exterior({Path("scans/new_1_1.tif"), Path("scans/new_1_2.tif")});
  }

  // The photo new_1_2 failed for reasons that say all parts, new_1_1 is as it always is.
  void ExpectOnlyTheSecondFails(const ProgramRun& run, const std::vector<std::string>& parts) {
    EXPECT_EQ(run.exit_code, 3) << run.out << run.err;
    EXPECT_EQ(run.err, "");
    const ExteriorResult good = ReadExteriorResult(ExteriorResultPath(Path("out"), "new_1_1"));
    EXPECT_EQ(good.status, Status::kOk) << testing::PrintToString(Sentences(good.findings));
    const ExteriorResult bad = ReadExteriorResult(ExteriorResultPath(Path("out"), "new_1_2"));
    EXPECT_EQ(bad.status, Status::kFailed);
    EXPECT_FALSE(bad.pose.has_value());
    const std::string said = JoinedSentences(bad.findings);
    EXPECT_EQ(said.find('\n'), std::string::npos);
    for (const std::string& part : parts)
      EXPECT_NE(said.find(part), std::string::npos) << said << "\nlacks " << part;
    EXPECT_NE(run.out.find(parts.front()), std::string::npos) << run.out;
    const OrientationTable table = ReadOrientationTable(Path("out/orientation.csv"));
    ASSERT_EQ(table.rows.size(), 1u);
    EXPECT_EQ(table.rows[0].photo, "new_1_1");
  }
};

}  // namespace orient
