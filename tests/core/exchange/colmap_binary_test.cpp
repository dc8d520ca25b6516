// COLMAP's binary model, as its own programs write it.
#include "core/exchange/colmap_binary.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/exchange/colmap.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

class Bytes {
 public:
  template <typename Value>
  Bytes& Add(Value value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof(value));
    return *this;
  }
  Bytes& Name(const std::string& name) {
    text_ += name;
    text_ += '\0';
    return *this;
  }
  const std::string& Text() const { return text_; }

 private:
  std::string text_;
};

// A vertical photo from 1000 m with a principal distance of 1000 px, and one point seen in it.
class BinaryModel : public testing::Test {
 protected:
  BinaryModel() {
    cameras_.Add<std::uint64_t>(1).Add<std::int32_t>(7).Add<std::int32_t>(1);  // PINHOLE
    cameras_.Add<std::uint64_t>(1200).Add<std::uint64_t>(1000);
    for (const double value : {1000.0, 1001.0, 600.0, 500.0}) cameras_.Add(value);
    images_.Add<std::uint64_t>(1).Add<std::int32_t>(3);
    // Half a turn about x: y down, z forward.
    for (const double value : {0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1000.0}) images_.Add(value);
    images_.Add<std::int32_t>(7).Name("strip 1/photo 4.tif").Add<std::uint64_t>(2);
    images_.Add(700.0).Add(399.9).Add<std::uint64_t>(11);
    images_.Add(5.0).Add(6.0).Add<std::int64_t>(-1);
    points_.Add<std::uint64_t>(1).Add<std::uint64_t>(11);
    for (const double value : {100.0, 100.0, 0.0}) points_.Add(value);
    points_.Add<std::uint8_t>(1).Add<std::uint8_t>(2).Add<std::uint8_t>(3).Add(0.5);
    points_.Add<std::uint64_t>(1).Add<std::int32_t>(3).Add<std::int32_t>(0);
    Write("cameras.bin", cameras_.Text());
    Write("images.bin", images_.Text());
    Write("points3D.bin", points_.Text());
  }

  void Write(const std::string& file, const std::string& text) const {
    WriteFileAtomically(folder_ / file, text);
  }

  const TemporaryFolder folder_;
  Bytes cameras_, images_, points_;
};

TEST_F(BinaryModel, IsReadWithItsMeasurements) {
  const ColmapModel model = ReadColmap(folder_.Path());
  const ExchangeBlock block = ExchangeFromColmap(model);
  ASSERT_EQ(block.photos.size(), 1u);
  EXPECT_EQ(block.photos[0].image, "strip 1/photo 4.tif");
  EXPECT_LT((block.photos[0].centre - Eigen::Vector3d(0, 0, 1000)).norm(), 1e-9);
  const auto observations = ReadColmapObservations(folder_.Path());
  ASSERT_EQ(observations.size(), 1u);
  const auto pixel = PixelFromGround(block, 0, observations[0].ground);
  ASSERT_TRUE(pixel);
  EXPECT_LT((*pixel - observations[0].pixel).norm(), 1e-9);
}

TEST_F(BinaryModel, GoesBeforeTheTextBesideIt) {
  Write("cameras.txt", "1 PINHOLE 10 10 1 1 5 5\n");
  Write("images.txt", "");
  EXPECT_EQ(ReadColmap(folder_.Path()).images.size(), 1u);
}

TEST_F(BinaryModel, CutOffAnywhereItIsRefused) {
  for (const auto& [file, text] :
       {std::pair<std::string, std::string>("cameras.bin", cameras_.Text()),
        {"images.bin", images_.Text()},
        {"points3D.bin", points_.Text()}}) {
    for (std::size_t size = 0; size < text.size(); ++size) {
      Write(file, text.substr(0, size));
      const auto read = [&] {
        ReadColmap(folder_.Path());
        ReadColmapObservations(folder_.Path());
      };
      EXPECT_THROW(read(), InputError) << file << " of " << size << " bytes";
    }
    Write(file, text);
  }
}

TEST_F(BinaryModel, CountsTooSmallForTheFileAreNamed) {
  Write("images.bin", images_.Text() + "more");
  ExpectError<InputError>([&] { ReadColmap(folder_.Path()); }, {"images.bin", "4 bytes follow"});
}

TEST_F(BinaryModel, IsTakenAwayByAnExportToItsFolder) {
  ExchangeBlock block = ExchangeFromColmap(ReadColmap(folder_.Path()));
  block.photos[0].image = "other.tif";
  WriteColmap(folder_.Path(), block);
  EXPECT_EQ(ReadColmap(folder_.Path()).images.at(0).name, "other.tif");
}

TEST_F(BinaryModel, CountsBeyondTheFileAreNamed) {
  Write("images.bin", Bytes().Add<std::uint64_t>(1ull << 60).Text());
  ExpectError<InputError>([&] { ReadColmap(folder_.Path()); },
                          {"images.bin, byte 8", "1152921504606846976"});
}

TEST_F(BinaryModel, CamerasThatCannotBeRepresentedAreNamed) {
  Write("cameras.bin", Bytes()
                           .Add<std::uint64_t>(1)
                           .Add<std::int32_t>(1)
                           .Add<std::int32_t>(5)
                           .Add<std::uint64_t>(10)
                           .Add<std::uint64_t>(10)
                           .Text());
  ExpectError<InputError>([&] { ReadColmap(folder_.Path()); }, {"OPENCV_FISHEYE", "undistort"});
}

}  // namespace
}  // namespace orient
