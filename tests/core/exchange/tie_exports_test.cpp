// Tie points in other programs' files: what each file says, taken as its program takes it, is where
// the photos show the points.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/exchange/colmap.h"
#include "core/exchange/frame_adjustments.h"
#include "core/exchange/metashape_markers.h"
#include "core/exchange/micmac_homologues.h"
#include "core/exchange/opensfm.h"
#include "core/exchange/text_lines.h"
#include "core/exchange/xml_elements.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr double kExact_px = 1e-6;

// Three photos one after another, a control point and two ties at the pixels that show them.
ExchangeBlock ThreePhotos() {
  ExchangeBlock block;
  ExchangeCamera camera;
  camera.name = "camera A";
  camera.width = 3000;
  camera.height = 2000;
  camera.pixel_mm = 0.01;
  camera.focal_px = {2500, 2500};
  camera.principal_px = {1510, 990};
  camera.k = {-0.03, 0.01, 0};
  camera.p = {1e-4, -2e-4};
  block.cameras = {camera};
  for (int i = 0; i < 3; ++i) {
    ExchangePhoto photo;
    photo.image = std::to_string(101 + i) + ".tif";
    SetPose({{300.0 * i, 20, 1500}, {0.02, -0.01 * i, 0.1 + i}}, &photo);
    block.photos.push_back(photo);
  }
  block.reference_lla = Eigen::Vector3d(47.5, 8.5, 400);
  block.origin = {600000, 5000000, 0};
  const auto add = [&](const char* name, bool control, const Eigen::Vector3d& ground,
                       const std::vector<std::size_t>& photos) {
    ExchangePoint point{name, control, ground, {}};
    for (const std::size_t photo : photos)
      point.observations.push_back({photo, *PixelFromGround(block, photo, ground)});
    block.points.push_back(point);
  };
  add("17", true, {100, 30, 310}, {0, 1});
  add("1001", false, {280, -40, 290}, {0, 1, 2});
  add("1002", false, {420, 80, 305}, {1, 2});
  return block;
}

const ExchangePoint& PointNamed(const ExchangeBlock& block, const std::string& name) {
  for (const ExchangePoint& point : block.points)
    if (point.name == name) return point;
  throw std::invalid_argument("no point " + name);
}

std::size_t PhotoNamed(const ExchangeBlock& block, const std::string& image) {
  for (std::size_t i = 0; i < block.photos.size(); ++i)
    if (block.photos[i].image == image) return i;
  throw std::invalid_argument("no photo " + image);
}

Eigen::Vector2d Seen(const ExchangeBlock& block, const std::string& point, std::size_t photo) {
  for (const ExchangeObservation& seen : PointNamed(block, point).observations)
    if (seen.photo == photo) return seen.pixel;
  throw std::invalid_argument("point " + point + " is not seen there");
}

// points3D.txt's tracks point into images.txt's second lines, which point back.
TEST(TieExports, ColmapsTracksAndImagesNameOneAnother) {
  const TemporaryFolder folder;
  const ExchangeBlock block = ThreePhotos();
  WriteColmap(folder.Path(), block);
  const auto images = ReadAllTextLines(folder / "images.txt", "#");
  const auto points = ReadTextLines(folder / "points3D.txt");
  ASSERT_EQ(points.size(), 3u);
  int observations = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(points[i].Number(1 + k, "XYZ"), block.points[i].ground[static_cast<int>(k)]);
    ASSERT_EQ(points[i].Size(), 8 + 2 * block.points[i].observations.size());
    for (std::size_t at = 8; at < points[i].Size(); at += 2, ++observations) {
      const auto photo = static_cast<std::size_t>(points[i].Count(at, "IMAGE_ID")) - 1;
      const auto place = static_cast<std::size_t>(points[i].Count(at + 1, "POINT2D_IDX"));
      const TextLine& points2d = images[2 * photo + 1];
      EXPECT_EQ(points2d.Number(3 * place + 2, "POINT3D_ID"), points[i].Number(0, "POINT3D_ID"));
      const Eigen::Vector2d pixel(points2d.Number(3 * place, "X"),
                                  points2d.Number(3 * place + 1, "Y"));
      EXPECT_LT((pixel - Seen(block, block.points[i].name, photo)).norm(), kExact_px);
    }
  }
  EXPECT_EQ(observations, 7);
}

// opensfm's features.normalized_image_coordinates: (x + 0.5 - width / 2) / max(width, height) of
// pixels whose centres are whole.
TEST(TieExports, OpensfmsTracksAreNormalisedAsItsFeaturesAre) {
  const TemporaryFolder folder;
  const ExchangeBlock block = ThreePhotos();
  WriteOpensfm(folder.Path(), block);
  std::istringstream text(ReadFile(folder / "tracks.csv"));
  std::string line;
  std::getline(text, line);
  EXPECT_EQ(line, "OPENSFM_TRACKS_VERSION_v2");
  std::map<std::string, int> features;
  int rows = 0;
  for (; std::getline(text, line); ++rows) {
    std::vector<std::string> cells;
    std::istringstream words(line);
    for (std::string word; std::getline(words, word, '\t');) cells.push_back(word);
    ASSERT_EQ(cells.size(), 11u) << line;
    EXPECT_EQ(std::stoi(cells[2]), features[cells[0]]++) << "features are numbered in each image";
    const Eigen::Vector2d whole_centre =
        Eigen::Vector2d(std::stod(cells[3]), std::stod(cells[4])) * 3000 +
        Eigen::Vector2d(1500 - 0.5, 1000 - 0.5);
    const Eigen::Vector2d pixel = whole_centre + Eigen::Vector2d(0.5, 0.5);
    EXPECT_LT((pixel - Seen(block, cells[1], PhotoNamed(block, cells[0]))).norm(), kExact_px);
    EXPECT_DOUBLE_EQ(std::stod(cells[5]), 1.0 / 3000);
    EXPECT_NE(ReadFile(folder / "reconstruction.json").find("\"" + cells[1] + "\""),
              std::string::npos)
        << "every track is a point of the reconstruction";
  }
  EXPECT_EQ(rows, 7);
}

TEST(TieExports, MicmacsHomologuesStandBothWays) {
  const TemporaryFolder folder;
  const ExchangeBlock block = ThreePhotos();
  WriteMicmacHomologues(folder.Path(), block);
  const auto pair = [&](const std::string& one, const std::string& other) {
    return ReadTextLines(folder / ("Homol/Pastis" + one + "/" + other + ".txt"));
  };
  EXPECT_EQ(pair("101.tif", "103.tif").size(), 1u);
  EXPECT_EQ(pair("102.tif", "103.tif").size(), 2u);
  const auto there = pair("101.tif", "102.tif"), back = pair("102.tif", "101.tif");
  ASSERT_EQ(there.size(), 2u);
  ASSERT_EQ(back.size(), 2u);
  const char* const names[] = {"17", "1001"};
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector2d pixel = Seen(block, names[i], k / 2);
      EXPECT_NEAR(there[i].Number(k, "x y x y") + 0.5, pixel[static_cast<int>(k % 2)], kExact_px);
      EXPECT_EQ(there[i].Number(k, "x"), back[i].Number((k + 2) % 4, "x"));
    }
}

TEST(TieExports, OfAnEarlierBlockAreNotReadWithThoseOfANewOne) {
  const TemporaryFolder folder;
  ExchangeBlock block = ThreePhotos();
  WriteMicmacHomologues(folder.Path(), block);
  WriteOpensfm(folder.Path(), block);
  block.points.pop_back();
  block.points.pop_back();
  WriteMicmacHomologues(folder.Path(), block);
  EXPECT_TRUE(std::filesystem::exists(folder / "Homol/Pastis101.tif/102.tif.txt"));
  EXPECT_FALSE(std::filesystem::exists(folder / "Homol/Pastis102.tif/103.tif.txt"));
  block.points.clear();
  WriteOpensfm(folder.Path(), block);
  EXPECT_FALSE(std::filesystem::exists(folder / "tracks.csv"));
  EXPECT_FALSE(std::filesystem::exists(folder / "gcp_list.txt"));
}

TEST(TieExports, MetashapesMarkersHoldGroundForControlOnly) {
  const TemporaryFolder folder;
  const ExchangeBlock block = ThreePhotos();
  WriteMetashapeMarkers(folder.Path(), block);
  const XmlElement chunk = ReadXml(folder / "markers.xml").At("chunk");
  const auto cameras = chunk.At("cameras").All("camera");
  const auto markers = chunk.At("markers").All("marker");
  const auto seen = chunk.At("frames").At("frame").At("markers").All("marker");
  ASSERT_EQ(markers.size(), 3u);
  ASSERT_EQ(seen.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const ExchangePoint& point = PointNamed(block, markers[i]->Attribute("label"));
    const XmlElement* reference = markers[i]->Find("reference");
    ASSERT_EQ(reference != nullptr, point.control);
    if (reference != nullptr) {
      EXPECT_EQ(std::stod(reference->Attribute("x")), 600100);
      EXPECT_EQ(std::stod(reference->Attribute("z")), 310);
    }
    EXPECT_EQ(seen[i]->Attribute("marker_id"), markers[i]->Attribute("id"));
    const auto locations = seen[i]->All("location");
    ASSERT_EQ(locations.size(), point.observations.size());
    for (const XmlElement* location : locations) {
      const std::size_t camera = std::stoul(location->Attribute("camera_id"));
      const std::string image = cameras.at(camera)->Attribute("label") + ".tif";
      const Eigen::Vector2d pixel(std::stod(location->Attribute("x")),
                                  std::stod(location->Attribute("y")));
      EXPECT_LT((pixel - Seen(block, point.name, PhotoNamed(block, image))).norm(), kExact_px);
    }
  }
}

// x = -c d0 / d2, y = -c d1 / d2, whatever the lens does.
TEST(TieExports, PatbAndBingoHoldTiesFreeOfDistortion) {
  const TemporaryFolder folder;
  const ExchangeBlock block = ThreePhotos();
  WritePatb(folder.Path(), block);
  WriteBingo(folder.Path(), block);
  for (const auto& [file, unit_mm] :
       std::map<std::string, double>{{"patb.im", 1e-3}, {"image.dat", 1}}) {
    std::size_t photo = 0;
    bool heading = true;
    int points = 0;
    for (const TextLine& line : ReadTextLines(folder / file)) {
      const std::string name = line.Word(0, "point");
      if (std::exchange(heading, name == "-99")) continue;
      if (name == "-99") {
        ++photo;
        continue;
      }
      const Pose pose = PoseOf(block.photos[photo]);
      const Eigen::Vector3d d =
          pose.GroundFromPhoto().transpose() * (PointNamed(block, name).ground - pose.position_m);
      EXPECT_NEAR(unit_mm * line.Number(1, "x"), -25 * d[0] / d[2], 1e-5) << file;
      EXPECT_NEAR(unit_mm * line.Number(2, "y"), -25 * d[1] / d[2], 1e-5) << file;
      ++points;
    }
    EXPECT_EQ(points, 7) << file;
  }
}

}  // namespace
}  // namespace orient
