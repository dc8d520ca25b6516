// Every format: written, read back, and the same projection; numbers that others published.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/exchange/asp_pinhole.h"
#include "core/exchange/colmap.h"
#include "core/exchange/frame_adjustments.h"
#include "core/exchange/metashape.h"
#include "core/exchange/micmac_orientation.h"
#include "core/exchange/opensfm.h"
#include "core/geometry/collinearity.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

double Uniform(double low, double high) {
  constexpr int kSteps = 1000000;
  return low + (high - low) * *rc::gen::inRange(0, kSteps + 1) / kSteps;
}

Camera AnyCamera() {
  Camera camera;
  camera.name = "camera A";
  camera.kind = CameraKind::kDigital;
  camera.image_px = Eigen::Vector2i(*rc::gen::inRange(500, 20000), *rc::gen::inRange(500, 20000));
  const double pixel_mm = Uniform(0.003, 0.03);
  camera.frame_mm = pixel_mm * camera.image_px->cast<double>();
  const double side = camera.frame_mm.maxCoeff();
  camera.principal_distance_mm = Uniform(0.5, 3) * side;
  camera.principal_point_mm = {Uniform(-0.02, 0.02) * side, Uniform(-0.02, 0.02) * side};
  const double c2 = camera.principal_distance_mm * camera.principal_distance_mm;
  BrownDistortion lens;
  lens.k = {Uniform(-0.1, 0.1) / c2, Uniform(-0.02, 0.02) / (c2 * c2),
            Uniform(-0.005, 0.005) / (c2 * c2 * c2)};
  lens.p = {Uniform(-1e-3, 1e-3) / camera.principal_distance_mm,
            Uniform(-1e-3, 1e-3) / camera.principal_distance_mm};
  camera.lens = lens;
  return camera;
}

// Any attitude, so that every sign and every branch of a quaternion is met.
ExchangePhoto AnyPhoto(const std::string& image) {
  ExchangePhoto photo;
  photo.image = image;
  photo.centre = {Uniform(-2000, 2000), Uniform(-2000, 2000), Uniform(500, 5000)};
  SetPose({photo.centre, {Uniform(-3.14, 3.14), Uniform(-1.57, 1.57), Uniform(-3.14, 3.14)}},
          &photo);
  return photo;
}

struct Scene {
  Camera camera;
  ExchangeBlock block;
};

Scene AnyScene() {
  Scene scene;
  scene.camera = AnyCamera();
  scene.block.cameras = {ExchangeCameraOf(scene.camera).camera};
  for (const char* image : {"101.tif", "102.tif", "103.tif"})
    scene.block.photos.push_back(AnyPhoto(image));
  scene.block.reference_lla = Eigen::Vector3d(47.5, 8.5, 400);
  ExchangePoint point;
  point.name = "7";
  point.control = true;
  point.ground = {10, 20, 30};
  point.observations = {{0, {100.25, 200.5}}, {2, {7, 8}}};
  scene.block.points = {point};
  return scene;
}

// A ground point in front of a photo, somewhere in its image.
Eigen::Vector3d PointBefore(const ExchangePhoto& photo, const ExchangeCamera& camera) {
  const Eigen::Vector2d size(camera.width, camera.height);
  const Eigen::Vector2d pixel = size.cwiseProduct(Eigen::Vector2d(Uniform(0, 1), Uniform(0, 1)));
  const Eigen::Vector2d ray = (pixel - camera.principal_px).cwiseQuotient(camera.focal_px);
  return photo.centre +
         GroundFromCamera(photo) * Eigen::Vector3d(ray.x(), ray.y(), 1) * Uniform(100, 3000);
}

// Doubles are written in full. What remains is the conversion's own rounding: about 20 000 px times
// 1e-13.
constexpr double kExact_px = 1e-8;

// One format.
struct RoundTrip {
  std::string name;
  void (*write)(const std::string& folder, const ExchangeBlock& block);
  ExchangeBlock (*read)(const std::string& folder);
  bool poses_only = false;  // the camera is the caller's
  double tolerance_px = kExact_px;
};

void CompareProjections(const RoundTrip& format) {
  const Scene scene = AnyScene();
  const TemporaryFolder folder;
  const ExchangeBlock& block = scene.block;
  format.write(folder.Path(), block);
  ExchangeBlock read = format.read(folder.Path());
  if (format.poses_only) read.cameras = block.cameras;
  RC_ASSERT(read.photos.size() == block.photos.size());
  for (std::size_t i = 0; i < block.photos.size(); ++i) {
    const Eigen::Vector3d ground = PointBefore(block.photos[i], block.cameras[0]);
    const auto before = PixelFromGround(block, i, ground), after = PixelFromGround(read, i, ground);
    RC_ASSERT(before && after);
    RC_ASSERT((*before - *after).norm() < format.tolerance_px);
    RC_ASSERT(read.photos[i].image.substr(0, 3) == block.photos[i].image.substr(0, 3));
  }
}

class Format : public testing::TestWithParam<RoundTrip> {};

// Twelve blocks of three photos: every one writes and flushes files.
TEST_P(Format, ReadsWhatItWrote) {
  rc::detail::TestParams params = rc::detail::configuration().testParams;
  params.maxSuccess = 12;
  const auto result = rc::detail::checkTestable([&] { CompareProjections(GetParam()); },
                                                rc::detail::TestMetadata(), params);
  std::ostringstream text;
  rc::detail::printResultMessage(result, text);
  EXPECT_TRUE(result.is<rc::detail::SuccessResult>()) << text.str();
}

RC_GTEST_PROP(Exchange, CameraProjectsAsOrientsCollinearityDoes, ()) {
  const Scene scene = AnyScene();
  const ExchangePhoto& photo = scene.block.photos[0];
  const Eigen::Vector3d ground = PointBefore(photo, scene.block.cameras[0]);
  const auto photo_mm = PhotoFromGround(scene.camera, PoseOf(photo), ground);
  RC_PRE(photo_mm.has_value());
  const Eigen::Vector2d own = DigitalPhotoFromPixel(scene.camera).Inverse() * *photo_mm;
  RC_ASSERT((*PixelFromGround(scene.block, 0, ground) - own).norm() < kExact_px);
  // And back: the digital camera of the exchange camera is the one it was made from.
  const Camera again = CameraOf(scene.block.cameras[0]);
  const auto again_mm = PhotoFromGround(again, PoseOf(photo), ground);
  RC_ASSERT(again_mm.has_value());
  RC_ASSERT((DigitalPhotoFromPixel(again).Inverse() * *again_mm - own).norm() < kExact_px);
}

using Folder = const std::string&;
// Its columns are sixteen wide; all others write numbers in full.
constexpr double kPatb_px = 1e-5;

INSTANTIATE_TEST_SUITE_P(
    Exchange, Format,
    testing::Values(
        RoundTrip{"Colmap", WriteColmap,
                  [](Folder at) { return ExchangeFromColmap(ReadColmap(at)); }},
        RoundTrip{"Opensfm", WriteOpensfm,
                  [](Folder at) { return ExchangeFromOpensfm(ReadOpensfm(at)); }},
        RoundTrip{"Micmac",
                  [](Folder at, const ExchangeBlock& block) {
                    WriteMicmacOrientation(at, "Test", block);
                  },
                  [](Folder at) { return ExchangeFromMicmac(ReadMicmacOrientation(at)); }},
        RoundTrip{"Metashape", WriteMetashape,
                  [](Folder at) { return ExchangeFromMetashape(ReadMetashape(at)); }},
        RoundTrip{"Asp", WriteAsp, [](Folder at) { return ExchangeFromAsp(ReadAsp(at)); }},
        RoundTrip{"Bingo", WriteBingo,
                  [](Folder at) { return ExchangeFromBingo(ReadBingo(at), ReadPhotoNumbers(at)); },
                  true},
        RoundTrip{"Ori", WriteOri, [](Folder at) { return ExchangeFromOri(ReadOri(at)); }, true},
        RoundTrip{"Patb", WritePatb,
                  [](Folder at) { return ExchangeFromPatb(ReadPatb(at), ReadPhotoNumbers(at)); },
                  true, kPatb_px}),
    [](const auto& format) { return format.param.name; });

TEST(Exchange, RadialTableIsFittedAndTheDifferenceSaid) {
  Camera camera;
  camera.kind = CameraKind::kDigital;
  camera.image_px = Eigen::Vector2i(9000, 9000);
  camera.frame_mm = {225, 225};
  camera.principal_distance_mm = 152;
  RadialTable table;
  for (int i = 0; i <= 16; ++i) {  // 2e-8 r^3 at every centimetre
    table.radius_mm.push_back(10.0 * i);
    table.dr_um.push_back(1e3 * 2e-8 * std::pow(10.0 * i, 3));
  }
  camera.lens = table;
  const FittedExchangeCamera fitted = ExchangeCameraOf(camera);
  EXPECT_NEAR(fitted.camera.k[0], 2e-8 * 152 * 152, 2e-5);
  EXPECT_GT(fitted.largest_difference_px, 0);
  // Straight pieces of 1 cm sag by 1/8 h^2 f'' = 0.24 um at the rim, a hundredth of a 25 um pixel.
  EXPECT_LT(fitted.largest_difference_px, 0.02);
}

// COLMAP's documented example (https://colmap.github.io/format.html): its numbers are read as
// printed.
TEST(Colmap, DocumentedExample) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "cameras.txt",
                      "# Camera list with one line of data per camera:\n"
                      "1 SIMPLE_PINHOLE 3072 2304 2559.81 1536 1152\n"
                      "2 PINHOLE 3072 2304 2560.56 2560.56 1536 1152\n");
  WriteFileAtomically(
      folder / "images.txt",
      "# Image list with two lines of data per image:\n"
      "1 0.851773 0.0165051 0.503764 -0.142941 -0.737434 1.02973 3.74354 1 P1180141.JPG\n"
      "2362.39 248.498 58396 1784.7 268.254 59027 1784.7 268.254 -1\n"
      "2 0.851773 0.0165051 0.503764 -0.142941 -0.737434 1.02973 3.74354 2 P1180142.JPG\n"
      "\n");
  const ColmapModel model = ReadColmap(folder.Path());
  ASSERT_EQ(model.images.size(), 2u);
  const ExchangeBlock block = ExchangeFromColmap(model);
  EXPECT_EQ(block.photos[1].image, "P1180142.JPG");
  EXPECT_EQ(block.cameras[0].focal_px, Eigen::Vector2d(2559.81, 2559.81));
  EXPECT_EQ(block.cameras[1].principal_px, Eigen::Vector2d(1536, 1152));
  // "The coordinates of the projection/camera center are given by -R^t * T"; R from the quaternion
  // by hand: the third row of R is the viewing direction.
  const Eigen::Vector3d t(-0.737434, 1.02973, 3.74354);
  const Eigen::Vector3d ground = block.photos[0].centre;
  const Eigen::Matrix3d r = GroundFromCamera(block.photos[0]).transpose();
  EXPECT_NEAR((r * ground + t).norm(), 0, 1e-12);
  const double w = 0.851773, x = 0.0165051, y = 0.503764, z = -0.142941;
  EXPECT_NEAR(r(2, 0), 2 * (x * z - w * y), 2e-6);
  EXPECT_NEAR(r(2, 1), 2 * (y * z + w * x), 2e-6);
  EXPECT_NEAR(r(2, 2), 1 - 2 * (x * x + y * y), 2e-6);
}

TEST(Colmap, VerticalPhotoLooksDown) {
  // A vertical photo at 1000 m, x to the east: the camera's x is east, y south, z down. A point 100
  // m to the north-east lies right of and above the middle.
  ExchangeBlock block;
  block.cameras.resize(1);
  block.cameras[0].width = block.cameras[0].height = 1000;
  block.cameras[0].focal_px.setConstant(1000);
  block.cameras[0].principal_px.setConstant(500);
  block.photos.resize(1);
  block.photos[0].image = "a.tif";
  block.photos[0].centre = {0, 0, 1000};
  const auto pixel = PixelFromGround(block, 0, {100, 100, 0});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR((*pixel - Eigen::Vector2d(600, 400)).norm(), 0, 1e-12);
}

// The sample of "Frame camera models" in the documentation of Ames Stereo Pipeline, section "File
// formats".
TEST(Asp, DocumentedExample) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "sample.tsai",
                      "VERSION_4\nPINHOLE\nfu = 28.429\nfv = 28.429\ncu = 17.9712\ncv = 11.9808\n"
                      "u_direction = 1  0  0\nv_direction = 0  1  0\nw_direction = 0  0  1\n"
                      "C = 266.943 -105.583 -2.14189\n"
                      "R = 0.0825447 0.996303 -0.0238243 -0.996008 0.0832884 0.0321213 0.0339869 "
                      "0.0210777 0.9992\npitch = 0.0064\nTSAI\nk1 = -0.094196634563\n"
                      "k2 = 0.115036424262\nk3 = -0.032238313341\np1 = -0.000256622541\n"
                      "p2 = -0.000353613460\n");
  const auto photos = ReadAsp(folder.Path());
  ASSERT_EQ(photos.size(), 1u);
  const ExchangeBlock block = ExchangeFromAsp(photos);
  // A point on the optical axis is seen at (cu, cv) / pitch, counted from the first pixel's centre.
  const Eigen::Vector3d axis(-0.0238243, 0.0321213, 0.9992);
  const auto pixel = PixelFromGround(block, 0, photos[0].c + 100 * axis);
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 17.9712 / 0.0064 + 0.5, 0.02);  // R is rounded to 1e-6
  EXPECT_NEAR(pixel->y(), 11.9808 / 0.0064 + 0.5, 0.02);
  EXPECT_DOUBLE_EQ(block.cameras[0].p[0], -0.000353613460) << "OpenCV's p2";
}

TEST(MetashapeFiles, ALabelWithACommaIsOneCellOfTheReferenceTable) {
  const TemporaryFolder folder;
  ExchangeBlock block;
  block.cameras.resize(1);
  block.cameras[0].width = block.cameras[0].height = 1000;
  block.cameras[0].focal_px.setConstant(7500);
  block.photos.resize(1);
  block.photos[0].image = "4711, west.tif";
  block.photos[0].centre = {1, 2, 3};
  WriteMetashape(folder.Path(), block);
  EXPECT_NE(ReadFile(folder / "reference.txt").find("\n\"4711, west\",1,2,3,"), std::string::npos)
      << ReadFile(folder / "reference.txt");
}

TEST(Patb, RecordsAreSixteenColumnsWide) {
  const TemporaryFolder folder;
  ExchangeBlock block;
  block.cameras.resize(1);
  block.cameras[0].width = block.cameras[0].height = 1000;
  block.cameras[0].pixel_mm = 0.02;
  block.cameras[0].focal_px.setConstant(7500);
  block.photos.resize(1);
  block.photos[0].image = "4711.tif";
  block.photos[0].centre = {500123.4567, 5900321.1234, 1823.9};
  WritePatb(folder.Path(), block);
  const std::string text = ReadFile(folder / "patb.ori");
  EXPECT_EQ(text.substr(0, text.find('\n')),
            "            4711      150.000000 500123.45670000 5900321.1234000 1823.9000000000");
  const auto photos = ReadPatb(folder.Path());
  ASSERT_EQ(photos.size(), 1u);
  EXPECT_EQ(photos[0].number, "4711");
  EXPECT_DOUBLE_EQ(photos[0].principal_distance_mm, 150);
}

TEST(Patb, ImageCoordinatesAreReducedAndInMicrometres) {
  const TemporaryFolder folder;
  ExchangeBlock block;
  block.cameras.resize(1);
  block.cameras[0].width = block.cameras[0].height = 1000;
  block.cameras[0].pixel_mm = 0.02;
  block.cameras[0].focal_px.setConstant(7500);
  block.cameras[0].principal_px = {490, 520};
  block.photos.resize(1);
  block.photos[0].image = "first.tif";
  block.points = {{"12", true, {1, 2, 3}, {{0, {590, 420}}}}};
  WritePatb(folder.Path(), block);
  // 100 px right of and 100 px above the principal point: +2000 um in x and in y.
  EXPECT_NE(ReadFile(folder / "patb.im").find("12    2000.000000    2000.000000 1\n"),
            std::string::npos)
      << ReadFile(folder / "patb.im");
  EXPECT_NE(ReadFile(folder / "photo_numbers.txt").find("1 first\n"), std::string::npos);
}

TEST(Bingo, CamerasAreThoseThatTheImageCoordinatesName) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "itera.dat",
                      "ORIA 11 1 2 3 0 0 0\nORIA 12 1 2 3 0 0 0\nORIA 13 1 2 3 0 0 0\n");
  EXPECT_EQ(ExchangeFromBingo(ReadBingo(folder.Path()), {}).cameras.size(), 1u) << "none is named";
  WriteFileAtomically(folder / "image.dat",
                      "11 rc10\n1001 34.2 -77.8 1\n-99\n12 rmk\n-99\n13 rc10\n1002 3 4\n-99\n");
  const ExchangeBlock block = ExchangeFromBingo(ReadBingo(folder / "itera.dat"), {});
  ASSERT_EQ(block.cameras.size(), 2u);
  EXPECT_EQ(block.cameras[0].name, "rc10");
  EXPECT_EQ(block.cameras[1].name, "rmk");
  EXPECT_EQ(block.photos[0].camera, 0u);
  EXPECT_EQ(block.photos[1].camera, 1u);
  EXPECT_EQ(block.photos[2].camera, 0u);
}

TEST(Bingo, TwoCamerasOfOneNameStayTwo) {
  const TemporaryFolder folder;
  ExchangeBlock block;
  block.photos.resize(2);
  for (std::size_t i = 0; i < 2; ++i) {
    ExchangeCamera camera;
    camera.name = "Wild RC10";
    camera.width = camera.height = 1000;
    camera.focal_px.setConstant(1000 + 100.0 * static_cast<double>(i));
    block.cameras.push_back(camera);
    block.photos[i].camera = i;
    block.photos[i].image = std::to_string(11 + i);
  }
  WriteBingo(folder.Path(), block);
  const ExchangeBlock read = ExchangeFromBingo(ReadBingo(folder.Path()), {});
  ASSERT_EQ(read.cameras.size(), 2u);
  EXPECT_EQ(read.cameras[0].name, "Wild_RC10");
  EXPECT_EQ(read.photos[1].camera, 1u);
}

TEST(Patb, ExponentsMayBeFortrans) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "patb.ori",
                      "4711 1.53D+02 5.12345D+05 5.2d6 1.16D+03\n1.D+00 0.D+00 0 0 1\n0 0 0 1\n");
  const auto photos = ReadPatb(folder.Path());
  ASSERT_EQ(photos.size(), 1u);
  EXPECT_EQ(photos[0].principal_distance_mm, 153);
  EXPECT_EQ(photos[0].centre, Eigen::Vector3d(512345, 5.2e6, 1160));
  WriteFileAtomically(folder / "patb.ori", "4711 D+02 1 2 3\n1 0 0 0 1\n0 0 0 1\n");
  ExpectError<InputError>([&] { ReadPatb(folder.Path()); }, {"line 1", "D+02"});
}

TEST(Ori, BlanksTabsAndCommasSeparate) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "orientation.ori", "# a\n4711\t1 2,3 , 0.5\t-1 90\n");
  const auto photos = ReadOri(folder.Path());
  ASSERT_EQ(photos.size(), 1u);
  EXPECT_EQ(photos[0].centre, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(photos[0].opk_deg, Eigen::Vector3d(0.5, -1, 90));
  WriteFileAtomically(folder / "orientation.ori", "4711 1 2 3 0.5 -1 395.2\n");
  ExpectError<InputError>([&] { ReadOri(folder.Path()); }, {"line 1", "395.2", "degrees"});
}

TEST(Exchange, BrokenFilesAreNamedByLineAndValue) {
  const TemporaryFolder folder;
  for (const char* wrong : {"nan", "inf", "-INF", "1e999"}) {
    WriteFileAtomically(folder / "orientation.ori", std::string("4711 1 2 ") + wrong + " 0 0 90\n");
    ExpectError<InputError>([&] { ReadOri(folder.Path()); }, {"line 1", wrong});
  }
  WriteFileAtomically(folder / "cameras.txt", "1 PINHOLE 3072 2304 2560.56 x 1536 1152\n");
  ExpectError<InputError>([&] { ReadColmap(folder.Path()); }, {"cameras.txt, line 1", "\"x\""});
  WriteFileAtomically(folder / "cameras.txt", "1 THIN_PRISM_FISHEYE 3072 2304 1 2 3\n");
  ExpectError<InputError>([&] { ReadColmap(folder.Path()); }, {"line 1", "THIN_PRISM_FISHEYE"});
  WriteFileAtomically(folder / "a.tsai", "VERSION_4\nPINHOLE\nfu = 1\n");
  ExpectError<InputError>([&] { ReadAsp(folder.Path()); }, {"a.tsai", "fv"});
  WriteFileAtomically(folder / "patb.ori", "4711 1 2 3\n1 0 0 0 1\n");
  ExpectError<InputError>([&] { ReadPatb(folder.Path()); }, {"patb.ori, line 1", "three lines"});
  WriteFileAtomically(folder / "patb.ori", "4711 1 2 3\n1 0 0 0 2\n0 0 0 1\n");
  ExpectError<InputError>([&] { ReadPatb(folder.Path()); }, {"line 2", "not a rotation"});
  WriteFileAtomically(folder / "itera.dat", "ORIA 1 2 3 4 5 6\n");
  ExpectError<InputError>([&] { ReadBingo(folder.Path()); }, {"itera.dat, line 1", "an angle"});
  WriteFileAtomically(folder / "cameras.xml", "<document>\n<chunk>\n</document>");
  ExpectError<InputError>([&] { ReadMetashape(folder.Path()); }, {"line 3", "</document>"});
  WriteFileAtomically(folder / "reconstruction.json", "[{\"cameras\": {}}]");
  ExpectError<InputError>([&] { ReadOpensfm(folder.Path()); }, {"reconstruction.json", "shots"});
  WriteFileAtomically(folder / "Orientation-a.xml", "<OrientationConique></OrientationConique>");
  ExpectError<InputError>([&] { ReadMicmacOrientation(folder.Path()); },
                          {"Orientation-a.xml", "Externe"});
}

}  // namespace
}  // namespace orient
