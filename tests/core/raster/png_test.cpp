#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "core/base/error.h"
#include "core/raster/raster.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

std::vector<unsigned char> Gradient(int width, int height, int channels) {
  std::vector<unsigned char> values;
  for (int i = 0; i < width * height * channels; ++i)
    values.push_back(static_cast<unsigned char>((i * 7) % 256));
  return values;
}

TEST(Png, ColoursKeepTheirOrder) {
  const TemporaryFolder folder;
  WritePng(folder / "a.png", 1, 1, 3, {200, 100, 50});
  EXPECT_NEAR(Raster::Open(folder / "a.png").ReadGrey().image.At(0, 0),
              0.299 * 200 + 0.587 * 100 + 0.114 * 50, 1e-4);
}

TEST(Png, WrongCountOfValuesIsTheCallersFault) {
  EXPECT_THROW(WritePng("a.png", 4, 4, 1, Gradient(4, 3, 1)), std::invalid_argument);
  EXPECT_THROW(WritePng("a.png", 4, 4, 2, Gradient(4, 4, 2)), std::invalid_argument);
}

TEST(Png, WrittenFileOpensAsRasterAndLeavesNothingBeside) {
  const TemporaryFolder folder;
  WritePng(folder / "a.png", 31, 17, 1, Gradient(31, 17, 1));
  WritePng(folder / "a.png", 31, 17, 1, Gradient(31, 17, 1));  // over itself
  EXPECT_EQ(Raster::Open(folder / "a.png").ReadGrey().image.At(3, 0), 21);
  size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.Path()))
    ++files;
  EXPECT_EQ(files, 1u);
  EXPECT_THROW(WritePng(folder / "no/such/a.png", 1, 1, 1, {0}), InputError);
}

}  // namespace
}  // namespace orient
