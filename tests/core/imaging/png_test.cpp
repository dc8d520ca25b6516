#include <filesystem>
#include <fstream>
#include <random>

#include "core/error.h"
#include "core/imaging/raster.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

std::vector<unsigned char> Gradient(int width, int height, int channels) {
  std::vector<unsigned char> values;
  for (int i = 0; i < width * height * channels; ++i)
    values.push_back(static_cast<unsigned char>((i * 7) % 256));
  return values;
}

TEST(Png, GreyRoundTripIsLossless) {
  const auto values = Gradient(31, 17, 1);
  const Image image = DecodePng(EncodePng(31, 17, 1, values));
  ASSERT_EQ(image.width, 31);
  ASSERT_EQ(image.height, 17);
  for (size_t k = 0; k < values.size(); ++k) EXPECT_EQ(image.values[k], values[k]);
}

TEST(Png, SixteenBitRoundTripIsLossless) {
  const std::vector<uint16_t> values = {0, 1, 255, 256, 32768, 65535};
  const Image image = DecodePng(EncodePng16(3, 2, values));
  for (size_t k = 0; k < values.size(); ++k) EXPECT_EQ(image.values[k], values[k]);
}

TEST(Png, ColoursKeepTheirOrder) {
  const Image image = DecodePng(EncodePng(1, 1, 3, {200, 100, 50}));
  EXPECT_NEAR(image.At(0, 0), 0.299 * 200 + 0.587 * 100 + 0.114 * 50, 1e-4);
}

TEST(Png, EncodingIsDeterministic) {
  const auto values = Gradient(64, 64, 3);
  EXPECT_EQ(EncodePng(64, 64, 3, values), EncodePng(64, 64, 3, values));
}

TEST(Png, WrongCountOfValuesIsTheCallersFault) {
  EXPECT_THROW(EncodePng(4, 4, 1, Gradient(4, 3, 1)), std::invalid_argument);
  EXPECT_THROW(EncodePng(4, 4, 2, Gradient(4, 4, 2)), std::invalid_argument);
  EXPECT_THROW(EncodePng16(0, 0, {}), std::invalid_argument);
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

TEST(Png, HostileBytesAreRefusedWithoutNoise) {
  testing::internal::CaptureStderr();
  const std::vector<unsigned char> good = EncodePng(40, 30, 1, Gradient(40, 30, 1));
  EXPECT_THROW(DecodePng({}), InputError);
  EXPECT_THROW(DecodePng({'G', 'I', 'F', '8', '9', 'a'}), InputError);
  EXPECT_THROW(DecodePng(std::vector<unsigned char>(good.begin(), good.begin() + 60)), InputError);
  std::vector<unsigned char> huge = good;
  huge[16] = 0x7f;  // width
  EXPECT_THROW(DecodePng(huge), InputError);
  std::mt19937 random(TestSeed());
  for (int i = 0; i < 500; ++i) {
    std::vector<unsigned char> bad = good;
    for (int k = 0; k < 3; ++k) bad[random() % bad.size()] = static_cast<unsigned char>(random());
    bad.resize(bad.size() - random() % 20);
    try {
      const Image image = DecodePng(bad);
      EXPECT_LE(image.values.size(), 4096u * 4096u);
    } catch (const InputError&) {
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace orient
