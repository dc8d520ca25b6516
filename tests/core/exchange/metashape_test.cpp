// Metashape's cameras XML as its releases write it: components, disabled and unaligned cameras,
// references.
#include "core/exchange/metashape.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr const char* kSensor = R"(<sensors><sensor id="0" label="s">
  <resolution width="1000" height="800"/>
  <calibration class="adjusted"><f>900</f></calibration></sensor></sensors>)";
constexpr const char* kPose = "<transform>1 0 0 1 0 1 0 2 0 0 1 3 0 0 0 1</transform>";
constexpr const char* kTransform = "<transform><translation>10 20 30</translation></transform>";

std::string CameraOf(const std::string& attributes, const std::string& content = kPose) {
  return fmt::format("<camera sensor_id=\"0\" {}>{}</camera>", attributes, content);
}

class Metashape : public testing::Test {
 protected:
  MetashapeChunk Read(const std::string& cameras, const std::string& more = kTransform,
                      const std::string& after = "") const {
    WriteFileAtomically(
        folder_ / "cameras.xml",
        fmt::format("<document><chunk>{}<cameras>{}</cameras>{}</chunk>{}</document>", sensors_,
                    cameras, more, after));
    return ReadMetashape(folder_.Path());
  }

  const TemporaryFolder folder_;
  std::string sensors_ = kSensor;
};

TEST_F(Metashape, TheTransformOfTheActiveComponentIsTheChunks) {
  const MetashapeChunk chunk =
      Read(CameraOf(R"(label="a" component_id="4")") + CameraOf(R"(label="b" component_id="7")"),
           fmt::format("<components active_id=\"7\"><component id=\"4\"/><component id=\"7\">{}"
                       "</component></components>",
                       kTransform));
  ASSERT_EQ(chunk.cameras.size(), 1u);
  EXPECT_EQ(chunk.cameras[0].label, "b");
  EXPECT_EQ(chunk.of_other_components, 1u);
  EXPECT_TRUE(chunk.placed);
  EXPECT_EQ(ExchangeFromMetashape(chunk).photos[0].centre, Eigen::Vector3d(11, 22, 33));
}

TEST_F(Metashape, DisabledAndUnalignedCamerasAreLeftOutAndCounted) {
  const MetashapeChunk chunk =
      Read(CameraOf(R"(label="a" enabled="0")") + CameraOf(R"(label="b" enabled="false")") +
           CameraOf(R"(label="c" enabled="true")", "") + CameraOf(R"(label="d")"));
  ASSERT_EQ(chunk.cameras.size(), 1u);
  EXPECT_EQ(chunk.cameras[0].label, "d");
  EXPECT_EQ(chunk.disabled, 2u);
  EXPECT_EQ(chunk.not_aligned, 1u);
  ExpectError<InputError>([&] { Read(CameraOf(R"(label="a" enabled="0")")); }, {"1 are disabled"});
}

std::string OlderSensor(const std::string& elements) {
  return fmt::format(R"(<sensors><sensor id="0" label="s"><resolution width="1000" height="800"/>
    <calibration class="adjusted">{}</calibration></sensor></sensors>)",
                     elements);
}

TEST_F(Metashape, PhotoScansTwoFocalLengthsAreOneAndB1AndItsPrincipalPointIsAPixel) {
  sensors_ = OlderSensor("<fx>903</fx><fy>900</fy><cx>505</cx><cy>398</cy><skew>0</skew>");
  const ExchangeBlock block = ExchangeFromMetashape(Read(CameraOf("label=\"a\"")));
  EXPECT_EQ(block.cameras[0].focal_px, Eigen::Vector2d(903, 900));
  EXPECT_EQ(block.cameras[0].principal_px, Eigen::Vector2d(505, 398));
}

TEST_F(Metashape, PhotoScansSkewAndWhatIsNoPixelNearTheMiddleAreRefused) {
  const std::string focal = "<fx>900</fx><fy>900</fy>";
  for (const auto& [wrong, complaint] :
       {std::pair("<cx>500</cx><cy>400</cy><skew>0.5</skew>", "skew"),
        std::pair("<cx>5</cx><cy>-2</cy>", "far from its middle"),
        std::pair("<cx>500</cx><cy>400</cy><p1>1e-4</p1>", "p1 and p2"),
        std::pair("<cx>500</cx>", "<cy>")}) {
    sensors_ = OlderSensor(focal + wrong);
    ExpectError<InputError>([&] { Read(CameraOf("label=\"a\"")); }, {complaint});
  }
}

TEST_F(Metashape, FurtherChunksAreCounted) {
  EXPECT_EQ(Read(CameraOf("label=\"a\"")).other_chunks, 0u);
  EXPECT_EQ(Read(CameraOf("label=\"a\""), kTransform, "<chunk/><chunk/>").other_chunks, 2u);
}

TEST_F(Metashape, OnlyEnabledReferencesWithAPositionAreRead) {
  const std::string pose = kPose;
  const MetashapeChunk chunk =
      Read(CameraOf("label=\"a\"", pose + R"(<reference x="1" y="2" z="3" enabled="1"/>)") +
               CameraOf("label=\"b\"", pose + R"(<reference x="1" y="2" z="3" enabled="0"/>)") +
               CameraOf("label=\"c\"", pose + R"(<reference yaw="1" pitch="2" roll="3"/>)"),
           R"(<settings><property name="accuracy_cameras" value="10"/></settings>)");
  ASSERT_EQ(chunk.cameras.size(), 3u);
  EXPECT_EQ(chunk.cameras[0].reference, Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(chunk.cameras[1].reference);
  EXPECT_FALSE(chunk.cameras[2].reference);
  EXPECT_EQ(chunk.accuracy_m, 10);
  EXPECT_FALSE(chunk.placed);
}

}  // namespace
}  // namespace orient
