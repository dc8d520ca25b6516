// What other programs' files may not hold.
#include "core/exchange/exchange_block.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/base/error.h"
#include "tests/support/expect_error.h"

namespace orient {
namespace {

ExchangeBlock OnePhoto() {
  ExchangeBlock block;
  block.cameras.emplace_back();
  block.cameras[0].focal_px = {1000, 1000};
  block.photos.emplace_back();
  block.photos[0].image = "4711.tif";
  return block;
}

void ExpectRefused(const ExchangeBlock& block, const std::string& word) {
  ExpectError<InputError>([&] { RequireSound(block, "folder"); }, {"folder", word});
}

TEST(SoundExchangeBlock, OfARotationAndACameraIsTaken) {
  EXPECT_NO_THROW(RequireSound(OnePhoto(), "folder"));
}

TEST(SoundExchangeBlock, IsNotOneOfAMirroredPhoto) {
  ExchangeBlock block = OnePhoto();
  block.photos[0].ground_from_photo(2, 2) = -1;
  ExpectRefused(block, "4711.tif");
}

TEST(SoundExchangeBlock, IsNotOneOfAStretchedPhoto) {
  ExchangeBlock block = OnePhoto();
  block.photos[0].ground_from_photo *= 1.01;
  ExpectRefused(block, "not a rotation");
}

TEST(SoundExchangeBlock, IsNotOneWithoutFiniteNumbers) {
  ExchangeBlock block = OnePhoto();
  block.photos[0].centre.z() = std::numeric_limits<double>::infinity();
  ExpectRefused(block, "4711.tif");
  block = OnePhoto();
  block.photos[0].ground_from_photo(0, 1) = std::numeric_limits<double>::quiet_NaN();
  ExpectRefused(block, "4711.tif");
}

TEST(SoundExchangeBlock, IsNotOneOfAnImpossibleCamera) {
  ExchangeBlock block = OnePhoto();
  block.cameras[0].name = "A";
  block.cameras[0].focal_px.x() = -1000;
  ExpectRefused(block, "'A'");
  block = OnePhoto();
  block.cameras[0].width = block.cameras[0].height = 1000;
  block.cameras[0].focal_px.x() = 0;
  ExpectRefused(block, "focal length");
  block = OnePhoto();
  block.cameras[0].width = 1000;  // and no height
  ExpectRefused(block, "size");
}

}  // namespace
}  // namespace orient
