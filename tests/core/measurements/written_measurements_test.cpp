#include "core/measurements/written_measurements.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

Measurements Example() {
  Measurements measurements;
  measurements.image_points = {{"a", "p", Eigen::Vector2d(1, 2), std::nullopt, 1}};
  measurements.points = {{"p", {1, 2, 3}, {1, 1, 1}, PointRole::kControl}};
  return measurements;
}

TEST(WrittenMeasurements, AreOfWhatThereIsAndReadAgain) {
  const TemporaryFolder folder;
  WriteMeasurements(folder.Path(), Example());
  EXPECT_EQ(FilesOf(Example()), (std::vector<std::string>{"image_points.csv", "points.csv"}));
  const Measurements read = ReadMeasurements(folder.Path());
  EXPECT_EQ(read.image_points.size(), 1u);
  EXPECT_EQ(read.points.size(), 1u);
  EXPECT_FALSE(fs::exists(folder / "marks.csv"));
}

TEST(WrittenMeasurements, LeaveTheFolderAsItWasWhereOneOfThemCannotBeWritten) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "points.csv");  // nothing can take its name
  EXPECT_THROW(WriteMeasurements(folder.Path(), Example()), InputError);
  EXPECT_FALSE(fs::exists(folder / "image_points.csv"));
  std::ofstream(folder / "image_points.csv") << "before";
  EXPECT_THROW(WriteMeasurements(folder.Path(), Example()), InputError);
  EXPECT_EQ(ReadFile(folder / "image_points.csv"), "before");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.Path()), fs::directory_iterator()), 2)
      << "no partial files stay";
}

TEST(WrittenMeasurements, InPixelsAndMillimetresAreNotWritten) {
  const TemporaryFolder folder;
  Measurements measurements = Example();
  measurements.image_points.push_back({"a", "q", std::nullopt, Eigen::Vector2d(1, 2), 1});
  EXPECT_THROW(WriteMeasurements(folder.Path(), measurements), std::invalid_argument);
  EXPECT_TRUE(fs::is_empty(folder.Path()));
}

}  // namespace
}  // namespace orient
