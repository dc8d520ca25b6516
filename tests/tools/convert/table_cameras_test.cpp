// Tables of orientations that name cameras.
#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"
#include "tests/tools/convert/two_photos.h"

namespace orient {
namespace {

class TableCameras : public testing::Test {
 protected:
  std::string Table(const std::string& text) const {
    WriteFileAtomically(folder_ / "opk.csv", text);
    return folder_ / "opk.csv";
  }

  const TemporaryFolder folder_;
};

TEST_F(TableCameras, AreThoseOfTheColumnCamera) {
  using Names = std::set<std::string>;
  EXPECT_EQ(
      ReadOrientationTable(Table("name,x,y,z,o,p,k,camera\na,1,2,3,4,5,6,c1\nb,1,2,3,4,5,6,c2\n"
                                 "d,1,2,3,4,5,6,c1\ne,1,2,3,4,5,6,\n"))
          .cameras,
      Names({"c1", "c2"}));
  EXPECT_EQ(ReadOrientationTable(Table("#Label;X;Y;Z;Omega;Phi;Kappa;Camera\na;1;2;3;4;5;6; c1\n"))
                .cameras,
            Names({"c1"}));
  EXPECT_TRUE(
      ReadOrientationTable(Table("name,x,y,z,o,p,k\ncamera,1,2,3,4,5,6\n")).cameras.empty());
}

TEST_F(TableCameras, OfTwoAreNotConvertedWithOne) {
  WriteCameraFile(folder_ / "camera.toml", {LargeFrameCamera(), {}, {}, std::nullopt, {}});
  ConvertSourceOptions options;
  options.input = Table("name,x,y,z,o,p,k,camera\na,1,2,3,4,5,6,c1\nb,1,2,3,4,5,6,c2\n");
  options.camera = folder_ / "camera.toml";
  ExpectError<InputError>([&] { ReadOrientResults(options); },
                          {"opk.csv", "2 cameras", "c1, c2", "one by one"});
  Table("name,x,y,z,o,p,k,camera\na,1,2,3,4,5,6,c1\nb,1,2,3,4,5,6,c1\n");
  EXPECT_EQ(ReadOrientResults(options).block.photos.size(), 2u);
}

}  // namespace
}  // namespace orient
