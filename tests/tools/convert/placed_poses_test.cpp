// Other programs' poses that lack their origin or their transform, and those that are where their
// references say.
#include "tools/convert/placed_poses.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/exchange/metashape.h"
#include "core/terrain/geocentric.h"
#include "tests/support/expect_error.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"
#include "tests/tools/convert/two_photos.h"
#include "tools/convert/metashape_ground.h"

namespace orient {
namespace {
namespace fs = std::filesystem;
using Eigen::Vector3d;

// An export that another program has written anew: without export.json.
class PlacedPoses : public testing::Test {
 protected:
  void Write(ExchangeFormat format) {
    const auto written = WriteExports(TwoPhotos(), {{format}, folder_.Path(), 0, {}}).front();
    input_ = written.directory;
    fs::remove(fs::path(input_) / "export.json");
    format_ = format;
  }

  void Replace(const char* file, const std::string& from, const std::string& to) const {
    const std::string path = (fs::path(input_) / file).string();
    std::string text = ReadFile(path);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    WriteFileAtomically(path, text.replace(at, from.size(), to));
  }

  ConvertSource Read(const std::optional<Vector3d>& origin = {},
                     const std::string& crs = "EPSG:32635") const {
    ConvertSourceOptions options;
    options.input = input_;
    options.crs = crs;
    options.origin = origin;
    options.ground_height_m = 300;
    return ReadForeign(format_, options);
  }

  static bool Says(const ConvertSource& read, const std::string& part) {
    for (const std::string& message : read.messages)
      if (message.find(part) != std::string::npos) return true;
    return false;
  }

  const TemporaryFolder folder_;
  std::string input_;
  ExchangeFormat format_ = ExchangeFormat::kOpk;
};

void ExpectWhereTheyWere(const ConvertSource& read) {
  const ConvertSource written = TwoPhotos();
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_LT((read.block.photos[i].centre - written.block.photos[i].centre).norm(), 1e-3);
}

TEST_F(PlacedPoses, OfColmapNeedTheOriginThatWasSubtracted) {
  Write(ExchangeFormat::kColmap);
  ExpectWhereTheyWere(Read());  // the comments say it
  Replace("images.txt", "# origin, subtracted from ground coordinates:", "# ");
  ExpectError<InputError>([&] { Read(); }, {"far outside the area of EPSG:32635", "--origin"});
  ExpectWhereTheyWere(Read(Vector3d(501000, 5000000, 0)));
  const ConvertSource local = Read({}, "+proj=tmerc +lon_0=27 +datum=WGS84 +units=m");
  EXPECT_TRUE(Says(local, "states no origin"));
}

TEST_F(PlacedPoses, OfMetashapeNeedTheChunksTransform) {
  Write(ExchangeFormat::kMetashape);
  ExpectWhereTheyWere(Read());
  EXPECT_TRUE(Says(Read(), "the block's own coordinates"));
  Replace("cameras.xml", "    <transform>\n      <rotation locked",
          "    <other>\n      <rotation locked");
  Replace("cameras.xml", "    </transform>\n  </chunk>", "    </other>\n  </chunk>");
  ExpectError<InputError>([&] { Read(); },
                          {"far outside the area of EPSG:32635", "the chunk has no transform"});
  Replace("cameras.xml", "LOCAL_CS[", "GEOGCS[");
  ExpectError<InputError>([&] { Read(); }, {"the chunk has no transform", "georeference"});
}

TEST_F(PlacedPoses, WhichAreNotGeocentricAreRefusedWhereTheyShouldBe) {
  Write(ExchangeFormat::kMetashape);
  Replace("cameras.xml", "LOCAL_CS[", "GEOGCS[");
  ExpectError<InputError>([&] { Read(); }, {"geocentric", "km from the earth's centre"});
}

TEST_F(PlacedPoses, OfMetashapeAwayFromTheirReferencesAreRefused) {
  Write(ExchangeFormat::kMetashape);
  const auto refer = [&](const char* from, double x) {
    Replace("cameras.xml", from,
            fmt::format("<reference x=\"{}\" y=\"5000321\" z=\"3800\"/></camera>", x));
  };
  refer("</camera>", 500153.4);
  EXPECT_TRUE(Says(Read(), "cameras lie 30.0 m from their references"));
  Replace("cameras.xml", "500153.4", "500923.4");
  ExpectError<InputError>([&] { Read(); }, {"median difference in plan", "800 m"});
  const ProgramRun checked = RunOrient({"convert", input_, "--check", "--from", "metashape"});
  EXPECT_EQ(checked.exit_code, 2);
  EXPECT_NE(checked.err.find("800 m"), std::string::npos) << checked.err;
}

// A chunk of one camera, geocentric at 27 E 45 N.
MetashapeChunk GeocentricChunk(const char* reference, const Vector3d& at) {
  MetashapeChunk chunk;
  chunk.placed = true;
  chunk.reference = Crs::Parse("EPSG:32635", "test").Wkt1();
  if (reference != nullptr) chunk.reference = reference;
  chunk.translation = GeocentricFromGeodetic({RadFromDeg(45), RadFromDeg(27), 3800});
  chunk.cameras.emplace_back().reference = at;
  return chunk;
}

constexpr const char* kWgs84 =
    R"(GEOGCS["WGS 84",DATUM["World Geodetic System 1984",SPHEROID["WGS 84",6378137,298.257223563]],)"
    R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433],AUTHORITY["EPSG","4326"]])";

TEST(MetashapeReferences, AreComparedInTheChunksOwnCoordinateSystem) {
  const auto degrees = FitToReferences(GeocentricChunk(kWgs84, {27, 45.001, 3700}));
  ASSERT_TRUE(degrees);
  EXPECT_NEAR(degrees->median_m, 111.1, 0.2);
  const auto utm = FitToReferences(GeocentricChunk(nullptr, {500020, 4982950.4, 3700}));
  ASSERT_TRUE(utm);
  EXPECT_NEAR(utm->median_m, 20, 1);
  EXPECT_FALSE(FitToReferences(GeocentricChunk("GEOCCS[...]", {27, 45, 0})));
}

TEST(MetashapeReferences, OfAStatedAccuracyMayBeFurtherAway) {
  MetashapeChunk chunk = GeocentricChunk(kWgs84, {27, 45.001, 3700});
  ExpectError<InputError>([&] { NotesOnMetashape(chunk, "a.xml"); }, {"a.xml", "111 m"});
  chunk.accuracy_m = 40;
  EXPECT_EQ(NotesOnMetashape(chunk, "a.xml").size(), 1u);
}

TEST(MetashapeReferences, AreNotesWithWhatWasLeftOut) {
  MetashapeChunk chunk = GeocentricChunk(kWgs84, {27, 45, 3700});
  chunk.other_chunks = 1;
  chunk.disabled = 3;
  chunk.not_aligned = 4;
  const auto notes = NotesOnMetashape(chunk, "a.xml");
  ASSERT_EQ(notes.size(), 4u);
  EXPECT_EQ(notes[0], "the first of 2 chunks was read; export the others one by one");
  EXPECT_EQ(notes[1], "cameras left out: 3 disabled");
  EXPECT_EQ(notes[2], "cameras left out: 4 not aligned");
}

}  // namespace
}  // namespace orient
