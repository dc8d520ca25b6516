// What is missing, no image, cut off or overwritten ends in an InputError and never in grey.
#include <filesystem>
#include <fstream>

#include "core/base/error.h"
#include "core/raster/raster.h"
#include "tests/core/raster/gdal_writer.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

std::string MessageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

bool Has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class RasterDamage : public testing::Test {
 protected:
  std::string Write(const std::string& name, const RasterRecipe& recipe) {
    WriteRaster(folder_ / name, recipe);
    return folder_ / name;
  }
  TemporaryFolder folder_;
};

TEST_F(RasterDamage, MissingFileNamesPathAndRemedy) {
  testing::internal::CaptureStderr();
  const std::string message = MessageOf([&] { Raster::Open(folder_ / "none.tif"); });
  EXPECT_TRUE(Has(message, folder_ / "none.tif")) << message;
  EXPECT_TRUE(Has(message, "check the path")) << message;
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(RasterDamage, FileThatIsNoImage) {
  std::ofstream(folder_ / "text.tif") << "not a raster at all";
  testing::internal::CaptureStderr();
  const std::string message = MessageOf([&] { Raster::Open(folder_ / "text.tif"); });
  EXPECT_TRUE(Has(message, "text.tif")) << message;
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

void Truncate(const std::string& path, double part) {
  const auto size = static_cast<double>(std::filesystem::file_size(path));
  std::filesystem::resize_file(path, static_cast<uintmax_t>(size * part));
}

void ExpectDamageIsTold(const std::string& path) {
  testing::internal::CaptureStderr();
  const std::string message = MessageOf([&] {
    const Raster raster = Raster::Open(path);
    // Again and again: no decoder may hand out grey for what it reported once.
    EXPECT_TRUE(Has(MessageOf([&] { raster.ReadGrey(); }), "damaged"));
    EXPECT_TRUE(Has(MessageOf([&] { raster.ReadGrey(); }), "damaged"));
    raster.ReadGrey({0, 150, 200, 50}, 1.5);
  });
  EXPECT_TRUE(Has(message, path)) << message;
  EXPECT_TRUE(Has(message, "row 150") || Has(message, "not an image")) << message;
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

RasterRecipe NoisyRecipe(const std::string& driver, const std::vector<std::string>& options) {
  RasterRecipe recipe;
  recipe.driver = driver;
  recipe.options = options;
  recipe.type = GDT_Byte;
  recipe.width = recipe.height = 200;
  recipe.value = [](int, double x, double y) {
    return 128 + 100 * std::sin(x * 12.9898 + y * 78.233) * std::sin(x * y);
  };
  return recipe;
}

TEST_F(RasterDamage, TruncatedTiffTellsPathAndWindow) {
  const std::string path = Write("cut.tif", NoisyRecipe("GTiff", {"COMPRESS=LZW"}));
  // Cut inside the last strips: TIFF made by GDAL has its directory at the start.
  Truncate(path, 0.8);
  ExpectDamageIsTold(path);
}

TEST_F(RasterDamage, TruncatedJpegTellsPathAndWindow) {
  const std::string path = Write("cut.jpg", NoisyRecipe("JPEG", {"QUALITY=95"}));
  Truncate(path, 0.6);
  ExpectDamageIsTold(path);
}

TEST_F(RasterDamage, TruncatedProgressiveJpegTellsPathAndWindow) {
  const std::string path = Write("cut.jpg", NoisyRecipe("JPEG", {"PROGRESSIVE=YES"}));
  Truncate(path, 0.6);
  ExpectDamageIsTold(path);
}

TEST_F(RasterDamage, DamagedJpegInsideOfTiffTellsPathAndWindow) {
  const std::string path =
      Write("cut.tif", NoisyRecipe("GTiff", {"COMPRESS=JPEG", "BLOCKYSIZE=200"}));
  {  // zeros over the second half of the only strip
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    const auto size = static_cast<std::streamoff>(std::filesystem::file_size(path));
    file.seekp(size * 6 / 10);
    for (std::streamoff i = size * 6 / 10; i < size; ++i) file.put('\xff').put('\xd9');
  }
  ExpectDamageIsTold(path);
}

TEST_F(RasterDamage, TruncatedPngTellsPathAndWindow) {
  const std::string path = Write("cut.png", NoisyRecipe("PNG", {}));
  Truncate(path, 0.6);
  ExpectDamageIsTold(path);
}

}  // namespace
}  // namespace orient
