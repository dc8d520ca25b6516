#include "tools/report/report.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/shared_data.h"
#include "tests/tools/report/example_block.h"
#include "tests/tools/report/report_page.h"
#include "tools/report/run_record.h"

namespace orient {
namespace {

TEST(Report, SaysWhatAPersonAsks) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  for (const char* part :
       {"Look at this first", "only 3 patches agree on a pose", "the matches leave the tilt open",
        "EPSG:32635", "UTM zone 35N", "does not agree with the other patches", "312.41",
        "1\u202F823.75", "Iterations", "at 200 times the frame’s scale", ">200\xE2\x80\xAFm<",
        "scan orientation r0", "from its approximation, enlarged",
        "the 2 projection centres moved by X 12.50 m, Y −4.00 m, Z −1.00 m in the mean"})
    EXPECT_TRUE(Contains(html, part)) << part;
}

TEST(Report, SaysWhatTheBlockAdjustmentSays) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  for (const char* part : {"Block adjustment", "2 tie points", "1 held out", "0.50 px (RMS of 2",
                           "0.30 / 0.40 / 0.80 m", "tie image", ">1.20<",
                           "Photo 4713 is adjusted apart from the rest of the block.", "1.5e-08",
                           "is not used: &lt;4713&gt;.", "tie point</span>", "p-tie"})
    EXPECT_TRUE(Contains(html, part)) << part;
}

// What a reader opens does not grow with every photo.
TEST(Report, OfAThousandPhotosThePageIsSmall) {
  constexpr int kPhotos = 1002;
  const TemporaryFolder folder;
  AdjustmentResult adjusted = ExampleAdjustment();
  ASSERT_FALSE(adjusted.ties.empty());
  PointResult tie = adjusted.ties[0];
  tie.seen.resize(1);
  adjusted.ties.clear();
  adjusted.control.clear();
  for (int i = 0; i < kPhotos; ++i) {
    ExteriorResult photo = ExampleExterior(fmt::format("p{:04}", i), Status::kOk);
    photo.patches.clear();
    WriteExteriorResult(folder.Path(), photo);
    tie.seen[0].photo = photo.photo;
    tie.seen[0].residual_px = Eigen::Vector2d(0, 0.001 * i);
    adjusted.ties.push_back(tie);
  }
  WriteAdjustmentResult(folder.Path(), adjusted);
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  EXPECT_LT(html.size(), 700 * kPhotos);
  EXPECT_TRUE(Contains(html, "and 2 more with smaller residuals"));
  EXPECT_TRUE(Contains(html, "<td>p1001</td>"));
  EXPECT_FALSE(Contains(html, "<td>p0001</td>")) << "the second smallest";
  EXPECT_FALSE(Contains(html, "<polygon class=\"fp"));
  EXPECT_TRUE(Contains(html, "<path class=\"fp fp-ok\""));
}

TEST(Report, SaysHowTheFilmLies) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_TRUE(Contains(html, "3 of 6 marks used"));
  EXPECT_TRUE(Contains(html, "25.000 ± 0.000"));
}

TEST(Report, NamesEachPrecisionApartAndLeadsWithTheProjections) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  WriteExampleCamera(folder.Path());
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  ExteriorResult worst = ExampleExterior("4712", Status::kWeak);
  worst.projection_sigma = ProjectionSigma{0.82, 0.41};
  worst.covariance->topLeftCorner<3, 3>() *= 4;
  WriteExteriorResult(folder.Path(), worst);
  const std::string html = ReadFile(WriteReport(folder.Path()));
  const std::string tiles = html.substr(0, html.find("Look at this first"));
  // 4711: 0.4 m and 1e-4 rad of 1424 m make some 0.43 m a coordinate; 4712: twice 0.4 m.
  for (const char* part : {">1.3<small>\u202Fm<", "worst 1.8\u202Fm", "CE90 on the ground",
                           "LE90 of a tie point", ">0.62<small>\u202Fpx · 0.31\u202Fm<",
                           "worst 0.82\u202Fpx", "projection σ anywhere in the frame, median"})
    EXPECT_TRUE(Contains(tiles, part)) << part << tiles;
  EXPECT_FALSE(Contains(tiles, ">0.31<")) << "a match's precision is not the pose's";
  for (const char* part : {"sigma0 of the matches 0.31 px", "projection σ at worst 0.42 px, 0.21 m",
                           "sigma0 of the marks 4.1 µm", "residuals 0.93 times what was"})
    EXPECT_TRUE(Contains(html, part)) << part;
}

TEST(Report, MapSaysTheCe90OfEachPhoto) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  EXPECT_FALSE(Contains(ReadFile(WriteReport(folder.Path())), "name · CE90")) << "no camera";
  WriteExampleCamera(folder.Path());
  const std::string html = ReadFile(WriteReport(folder.Path()));
  for (const char* part : {"name · CE90", "4711: ok, CE90 0.9", ">4711 · 0.9"})
    EXPECT_TRUE(Contains(html, part)) << part;
}

TEST(Report, SaysHowFarControlAndChecksAreOff) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  for (const char* part :
       {"Control patches lie 0.10 / 0.00 / 0.20 m (X / Y / Z, RMS of 1 used; CE90 0.11 m, LE90 "
        "0.33",
        "RMS of 1 seen in two photos or more; CE90 0.75 m, LE90 1.32 m", "1 control patch ·"})
    EXPECT_TRUE(Contains(html, part)) << part;
}

// The mean of two cameras' pixel sizes is no camera's.
TEST(Report, PhotosOfOtherCamerasOrPixelSizesHaveFilmTablesOfTheirOwn) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  InteriorResult other = ExampleInterior("4712");
  other.made_from["camera"] = "another";
  WriteInteriorResult(folder.Path(), other);
  InteriorResult coarse = ExampleInterior("4714");
  coarse.photo_from_pixel = Affine2d{Eigen::Vector2d(0.05, -0.05).asDiagonal(), {-25, 25}};
  WriteInteriorResult(folder.Path(), coarse);
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  for (const char* part : {"2 photos, 4711 to 4713 · 2 of 4 marks used", "1 photo, 4712 · 1 of 2",
                           "1 photo, 4714 · 1 of 2", ">50.000<", ">25.000<"})
    EXPECT_TRUE(Contains(html, part)) << part;
}

TEST(Report, DamagedBlockFileIsNamedAndTheRestIsShown) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  WriteFileAtomically(folder / "block.json", "{\"converged\": 1}");
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_TRUE(Contains(html, "field converged must be true or false"));
  EXPECT_FALSE(Contains(html, "<h2>Block adjustment"));
}

TEST(Report, IsWellFormedOnlyIfTheCheckerCanFail) {
  EXPECT_EQ(Malformed("<p>a<br/></p>"), "");
  EXPECT_NE(Malformed("<p>a<b></p>"), "");
  EXPECT_NE(Malformed("<p>a < b</p>"), "");
  EXPECT_NE(Malformed("<p>"), "");
}

TEST(Report, ShowsEveryTemplateFilledIn) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  const std::string html = ReadFile(WriteReport(folder.Path()));
  for (const char* part : {"{{", "<!-- part"}) EXPECT_FALSE(Contains(html, part)) << part;
}

TEST(Report, SaysWhatGnssSays) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  AdjustmentResult adjusted = ExampleAdjustment();
  adjusted.converged = false;
  adjusted.gnss = {{"4711", "used", Eigen::Vector3d(0.3, -0.4, 0.5), 1.0},
                   {"4712", "rejected", Eigen::Vector3d(9, 9, 9), 9.0}};
  const Eigen::Vector3d shift(1, -2, 3), sigma(0.1, 0.2, 0.3);
  adjusted.gnss_strips = {{"east", shift, sigma, std::nullopt, std::nullopt}};
  WriteAdjustmentResult(folder.Path(), adjusted);
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  for (const char* part : {"The adjustment did not converge.", "1 of 2 positions are used",
                           "residuals 0.30 / 0.40 / 0.50 m", "1.00 ± 0.10 / −2.00 ± 0.20"})
    EXPECT_TRUE(Contains(html, part)) << part;
}

TEST(Report, PoseOfTheTableAloneIsShown) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  std::filesystem::remove(folder / "4711.exterior.json");
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  EXPECT_TRUE(Contains(html, "From orientation.csv."));
}

TEST(Report, InteriorAloneIsEnough) {
  const TemporaryFolder folder;
  WriteInteriorResult(folder.Path(), ExampleInterior("4711"));
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  EXPECT_TRUE(Contains(html, "No photo has a position on the ground yet."));
}

TEST(Report, DamagedResultDoesNotHideTheOthers) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  std::ofstream(folder / "4714.exterior.json") << "{ \"photo\": ";
  std::ofstream(folder / "orientation.csv") << "nonsense\n";
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  EXPECT_TRUE(Contains(html, "4714.exterior.json is not valid JSON"));
  EXPECT_TRUE(Contains(html, "the header has no column"));
  EXPECT_TRUE(Contains(html, "4711"));
}

TEST(Report, AbsurdGroundCoordinatesDoNotBreakTheMap) {
  const TemporaryFolder folder;
  ExteriorResult exterior = ExampleExterior("4711", Status::kOk);
  exterior.footprint_m[1].x() = 1e300;
  exterior.pose->position_m.y() = -1e300;
  WriteExteriorResult(folder.Path(), exterior);
  EXPECT_EQ(Malformed(ReadFile(WriteReport(folder.Path()))), "");
}

TEST(Report, SaysHowItWasMade) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  WriteRunRecord(folder.Path(), "interior",
                 {"orient 0.1.0", "orient interior", "2026-01-01", 1, {}});
  WriteRunRecord(folder.Path(), "block",
                 {"orient 0.1.0",
                  "orient block '<b>.toml'",
                  "2026-01-02T03:04:05Z",
                  12,
                  {{"DEM", "dem & more.tif", "0123456789abcdef"}}});
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  for (const char* part :
       {"How it was made", "orient block &#39;&lt;b&gt;.toml&#39;", "12 s", "2026-01-02T03:04:05Z",
        "dem &amp; more.tif", "0123456789abcdef", "orient interior"})
    EXPECT_TRUE(Contains(html, part)) << part;
  std::ofstream(folder / "run.json") << "{";
  EXPECT_FALSE(Contains(ReadFile(WriteReport(folder.Path())), "How it was made"));
}

TEST(Report, SaysAtWhatScaleTheCameraSawTheGround) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  EXPECT_FALSE(Contains(ReadFile(WriteReport(folder.Path())), "Camera and flight"));
  WriteExampleCamera(folder.Path());
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  // 1423.75 m above the ground: 1 : 14 238, 25 micrometres a pixel.
  for (const char* part : {"Camera and flight", "an &lt;old&gt; camera", "14\u202F238", "0.356"})
    EXPECT_TRUE(Contains(html, part)) << part;
  const auto json = ReportJsonOf(folder.Path());
  EXPECT_NEAR(json["photos"][0]["seen_at"]["gsd_m"].get<double>(), 0.35594, 1e-5);
  EXPECT_TRUE(json["photos"][2]["seen_at"].is_null());
  EXPECT_EQ(json["camera"]["principal_distance_mm"], 100.0);
}

TEST(Report, EmptyFolderIsAnInputError) {
  const TemporaryFolder folder;
  EXPECT_THROW(WriteReport(folder.Path()), InputError);
  EXPECT_THROW(WriteReport(folder / "absent"), InputError);
}

}  // namespace
}  // namespace orient
