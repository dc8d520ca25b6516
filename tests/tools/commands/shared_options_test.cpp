#include "tools/commands/shared_options.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

ScanOptions Parsed(std::vector<std::string> arguments) {
  CLI::App app;
  ScanOptions scan;
  AddScanOptions(app, &scan);
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
  return scan;
}

TEST(SharedOptions, PhotosAreNamedOrListedOrBoth) {
  const TemporaryFolder folder;
  for (const char* file : {"a.tif", "b.tif", "c.tif"}) WriteFileAtomically(folder / file, "");
  WriteFileAtomically(folder / "list.txt", (folder / "b.tif") + "\n" + (folder / "c.tif") + "\n");
  std::vector<std::string> patterns;
  CLI::App app;
  AddPhotosOption(app, &patterns);
  ExpectError<UsageError>([&] { PhotosOf(patterns); }, {"PHOTO is required"});
  app.parse(
      std::vector<std::string>{folder / "list.txt", "--files-from", folder / "a.tif"});  // reversed
  EXPECT_EQ(PhotosOf(patterns),
            (std::vector<std::string>{folder / "a.tif", folder / "b.tif", folder / "c.tif"}));
}

TEST(RefuseToReplaceInputs, AnInputIsKnownByWhateverPathAndThroughLinks) {
  namespace fs = std::filesystem;
  const TemporaryFolder folder;
  for (const char* name : {"out", "else"}) fs::create_directory(folder / name);
  for (const char* file : {"out/camera.toml", "else/camera.toml"})
    WriteFileAtomically(folder / file, "");
  fs::create_symlink(folder / "out/camera.toml", folder / "else/link.toml");
  fs::create_directory_symlink(folder / "out", folder / "also_out");
  const std::vector<std::string> results = {folder / "out/camera.toml", folder / "out/block.json"};
  for (const char* input :
       {"out/camera.toml", "else/../out/camera.toml", "else/link.toml", "also_out/camera.toml"})
    ExpectError<UsageError>([&] { RefuseToReplaceInputs(results, {folder / input}); },
                            {folder / input, "is an input"});
  EXPECT_NO_THROW(
      RefuseToReplaceInputs(results, {"", folder / "else/camera.toml", folder / "out", "none"}));
  ExpectError<UsageError>([&] { RefuseToReplaceInputs({folder / "out"}, {folder / "out/"}); },
                          {"is an input"});
}

TEST(SharedOptions, ScanOptionsThatAreAutoOrAbsentAreEmpty) {
  for (const auto& arguments :
       std::vector<std::vector<std::string>>{{}, {"--polarity", "auto", "--orientation", "auto"}}) {
    const ScanOptions scan = Parsed(arguments);
    EXPECT_FALSE(scan.pixel_size_um);
    EXPECT_FALSE(scan.polarity);
    EXPECT_FALSE(scan.orientation);
  }
}

TEST(SharedOptions, ScanOptionsThatAreGivenHold) {
  const ScanOptions scan =
      Parsed({"--pixel-size-um", "12.5", "--polarity", "negative", "--orientation", "m270"});
  EXPECT_EQ(scan.pixel_size_um, 12.5);
  EXPECT_EQ(scan.polarity, Polarity::kNegative);
  EXPECT_EQ(scan.orientation, ScanOrientation::kM270);
}

TEST(SharedOptions, ImpossibleScanOptionsAreRefused) {
  EXPECT_THROW(Parsed({"--pixel-size-um", "-1"}), CLI::ValidationError);
  EXPECT_THROW(Parsed({"--pixel-size-um", "0.025"}), CLI::ValidationError) << "millimetres";
  EXPECT_THROW(Parsed({"--polarity", "inverted"}), CLI::ValidationError);
  EXPECT_THROW(Parsed({"--orientation", "r45"}), CLI::ValidationError);
}

TEST(SharedOptions, ALinkThatLeadsNowhereIsNotReplacedEither) {
  const TemporaryFolder folder;
  std::filesystem::create_symlink("nowhere", folder / "a");
  EXPECT_THROW(RefuseToOverwrite({folder / "a"}, false), UsageError);
}

TEST(SharedOptions, ResultsAreNotOverwrittenWithoutBeingAsked) {
  const TemporaryFolder folder;
  const std::string there = folder / "a.json", absent = folder / "b.json";
  WriteFileAtomically(there, "{}");
  EXPECT_NO_THROW(RefuseToOverwrite({absent}, false));
  EXPECT_NO_THROW(RefuseToOverwrite({absent, there}, true));
  try {
    RefuseToOverwrite({absent, there}, false, "--resume");
    FAIL() << "the existing file went unnoticed";
  } catch (const UsageError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find(there), std::string::npos) << message;
    EXPECT_NE(message.find("--overwrite"), std::string::npos) << message;
    EXPECT_NE(message.find("--resume"), std::string::npos) << message;
  }
}

TEST(SharedOptions, OutputFoldersAreMadeWithThoseAboveThem) {
  const TemporaryFolder folder;
  MakeOutputDirectory(folder / "a/b");
  MakeOutputDirectory(folder / "a/b");
  EXPECT_TRUE(std::filesystem::is_directory(folder / "a/b"));
  WriteFileAtomically(folder / "file", "");
  EXPECT_THROW(MakeOutputDirectory(folder / "file"), InputError);
  EXPECT_THROW(MakeOutputDirectory(folder / "file/below"), InputError);
}

}  // namespace
}  // namespace orient
