#include "tools/report/report.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "block/inputs/block_files.h"
#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/files/camera_file.h"
#include "tests/support/shared_data.h"
#include "tests/tools/report/example_block.h"
#include "tools/report/report_json.h"
#include "tools/report/run_record.h"

namespace orient {
namespace {

// What makes the text no well-formed XML as far as elements go; empty where it is.
std::string Malformed(const std::string& html) {
  std::vector<std::string> open;
  for (size_t i = html.find('<'); i != std::string::npos; i = html.find('<', i + 1)) {
    if (html.compare(i, 2, "<!") == 0) continue;  // the document type
    const size_t end = html.find_first_of("<>", i + 1);
    if (end == std::string::npos || html[end] == '<')
      return "a < that opens nothing: " + html.substr(i, 60);
    const bool closing = html[i + 1] == '/';
    const size_t first = i + (closing ? 2 : 1);
    const std::string name = html.substr(first, html.find_first_of(" />\n", first) - first);
    if (name.empty() || std::isalpha(static_cast<unsigned char>(name[0])) == 0)
      return "no element: " + html.substr(i, 60);
    if (closing) {
      if (open.empty() || open.back() != name) return "unexpected </" + name + ">";
      open.pop_back();
    } else if (html[end - 1] != '/') {
      open.push_back(name);
    }
  }
  return open.empty() ? "" : "<" + open.back() + "> is never closed";
}

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

void WritePng(const std::string& path, int width, int height, bool noise) {
  GDALAllRegister();
  const GDALDatasetUniquePtr memory(GetGDALDriverManager()->GetDriverByName("MEM")->Create(
      "", width, height, 3, GDT_Byte, nullptr));
  std::vector<unsigned char> row(static_cast<size_t>(width));
  unsigned state = TestSeed();
  for (int y = 0; y < height; ++y)
    for (int band = 1; band <= 3; ++band) {
      for (unsigned char& value : row)
        value = noise ? static_cast<unsigned char>((state = state * 1664525u + 1013904223u) >> 24)
                      : static_cast<unsigned char>(y);
      ASSERT_EQ(memory->GetRasterBand(band)->RasterIO(GF_Write, 0, y, width, 1, row.data(), width,
                                                      1, GDT_Byte, 0, 0),
                CE_None);
    }
  const GDALDatasetUniquePtr png(GetGDALDriverManager()->GetDriverByName("PNG")->CreateCopy(
      path.c_str(), memory.get(), FALSE, nullptr, nullptr, nullptr));
  ASSERT_TRUE(png);
}

TEST(Report, SaysWhatAPersonAsks) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  for (const char* part :
       {"Look at this first", "only 3 patches agree on a pose", "the matches leave the tilt open",
        "EPSG:32635", "UTM zone 35N", "does not agree with the other patches", "312.41",
        "1\u202F823.75", "Rounds of the loop", "at 200 times the frame’s scale",
        ">200\xE2\x80\xAFm<", "scan orientation r0", "from its approximation, enlarged",
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
                           "Photo 4713 is not connected to any other photo.", "1.5e-08",
                           "is not used: &lt;4713&gt;.", "tie point</span>", "p-tie"})
    EXPECT_TRUE(Contains(html, part)) << part;
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
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  ExteriorResult worst = ExampleExterior("4712", Status::kWeak);
  worst.projection_sigma = ProjectionSigma{0.82, 0.41};
  WriteExteriorResult(folder.Path(), worst);
  const std::string html = ReadFile(WriteReport(folder.Path()));
  const std::string tiles = html.substr(0, html.find("Look at this first"));
  for (const char* part : {">0.67<small>\u202Fm<", "worst 0.88\u202Fm", "CE90 on the ground",
                           "LE90 of a tie point", ">0.62<small>\u202Fpx · 0.31\u202Fm<",
                           "worst 0.82\u202Fpx", "projection σ anywhere in the frame, median"})
    EXPECT_TRUE(Contains(tiles, part)) << part << tiles;
  EXPECT_FALSE(Contains(tiles, ">0.31<")) << "a match's precision is not the pose's";
  for (const char* part : {"sigma0 of the matches 0.31 px", "projection σ at worst 0.42 px, 0.21 m",
                           "sigma0 of the marks 4.1 µm", "residuals 0.93 times what was"})
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

TEST(Report, NeedsNoNetworkAndNoScript) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  const std::string html = ReadFile(WriteReport(folder.Path()));
  for (const char* part : {"http:", "https:", "<script", "<link", "@import", "url("})
    EXPECT_FALSE(Contains(html, part)) << part;
}

TEST(Report, IsTheSameEveryTime) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  const std::string first = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(ReadFile(WriteReport(folder.Path())), first);
}

TEST(Report, HostileTextStaysText) {
  const TemporaryFolder folder;
  const std::string name = "a\"><script>alert('1')<&";
  ExteriorResult exterior = ExampleExterior("4711", Status::kWeak);
  exterior.photo = "x<img src=q onerror=1>";
  exterior.findings = {{.reason = Reason::kStated, .where = "<b>message</b>"}};
  exterior.patches[3].findings = {{.reason = Reason::kStated, .where = "<i>reason</i>"}};
  WriteExteriorResult(folder.Path(), exterior);
  InteriorResult interior = ExampleInterior(name.substr(0, name.find('/')));
  interior.marks[0].id = "<u>1</u>";
  interior.photo = "a\"><script>alert('1')<&";
  WriteInteriorResult(folder.Path(), interior);
  std::ofstream(folder / "x<img src=q onerror=1>.marks.png") << "no picture";
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  for (const char* part : {"<script", "<b>message", "<i>reason", "<u>1", "<img"})
    EXPECT_FALSE(Contains(html, part)) << part;
  EXPECT_TRUE(Contains(html, "a&quot;&gt;&lt;script&gt;alert(&#39;1&#39;)&lt;&amp;"));
}

TEST(Report, PicturesAreInsideThePage) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  WritePng(folder / "4711.marks.png", 60, 20, false);
  WritePng(folder / "4711.patches.png", 700, 500, true);  // noise: more than a megabyte
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  EXPECT_TRUE(Contains(html, "width=\"60\" height=\"20\" src=\"data:image/png;base64,iVBOR"));
  EXPECT_TRUE(Contains(html, "width=\"700\" height=\"500\" src=\"data:image/jpeg;base64,/9j/"));
  for (const auto& entry : std::filesystem::directory_iterator(folder.Path()))
    EXPECT_NE(entry.path().extension(), ".xml") << "GDAL left something beside the pictures";
}

TEST(Report, OrthophotosAreShown) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  WritePng(folder / block::kQuicklookFile, 60, 20, false);
  WritePng(folder / block::kSeamsFile, 50, 20, false);
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  EXPECT_TRUE(Contains(html, "<h2>Orthophotos</h2>"));
  EXPECT_TRUE(Contains(html, "width=\"50\" height=\"20\""));
}

TEST(Report, FileThatIsNoPictureIsSaidToBeNone) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  std::ofstream(folder / "4712.marks.png") << "no picture";
  EXPECT_TRUE(Contains(ReadFile(WriteReport(folder.Path())), "is not a readable image"));
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

TEST(Report, HundredsOfPatchesStaySmall) {
  constexpr size_t kLargest = 200 * 1024;
  const TemporaryFolder folder;
  ExteriorResult exterior = ExampleExterior("4711", Status::kOk);
  for (int i = 0; i < 1000; ++i)
    exterior.patches.push_back(ExamplePatch(100 + i, PatchState::kMatched,
                                            {10.0 + 1.9 * i, 37.0 * (i % 50) + 5}, {0.2, -0.1}));
  WriteExteriorResult(folder.Path(), exterior);
  EXPECT_LT(ReadFile(WriteReport(folder.Path())).size(), kLargest);
}

std::vector<std::string> HtmlIn(const std::string& folder) {
  std::vector<std::string> files;
  if (std::filesystem::exists(folder))
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
      if (entry.path().extension() == ".html") files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

// Every link to a file of ours leads somewhere.
void ExpectLinksLead(const std::string& page) {
  const std::string html = ReadFile(page);
  EXPECT_EQ(Malformed(html), "") << page;
  for (size_t at = html.find("href=\""); at != std::string::npos; at = html.find("href=\"", at)) {
    at += 6;
    const std::string link = html.substr(at, html.find_first_of("\"#", at) - at);
    if (link.empty()) continue;
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(page).parent_path() / link))
        << link << " of " << page;
  }
}

TEST(Report, ManyPhotosHaveAPageEach) {
  constexpr int kPhotos = 1100;
  const TemporaryFolder folder;
  ExteriorResult photo = ExampleExterior("", Status::kOk);
  for (int i = 0; i < kPhotos; ++i) {
    photo.photo = std::to_string(1000 + i);
    WriteExteriorResult(folder.Path(), photo);
  }
  WritePng(folder / "1007.patches.png", 60, 20, false);
  const std::string first = WriteReport(folder.Path());
  ExpectLinksLead(first);
  EXPECT_FALSE(Contains(ReadFile(first), "#photo-"));
  EXPECT_TRUE(Contains(ReadFile(first), "501 to 1000"));
  const auto pages = HtmlIn(folder / "report_photos");
  EXPECT_EQ(pages.size(), kPhotos + 2u);  // two lists
  for (const char* page : {"1000.html", "1007.html", "2099.html", "lists/1.html", "lists/2.html"})
    ExpectLinksLead(folder / ("report_photos/" + std::string(page)));
  EXPECT_TRUE(Contains(ReadFile(folder / "report_photos/1007.html"), "data:image/png"));
  // The same folder with three photos left.
  for (int i = 3; i < kPhotos; ++i)
    std::filesystem::remove(ExteriorResultPath(folder.Path(), std::to_string(1000 + i)));
  EXPECT_TRUE(Contains(ReadFile(WriteReport(folder.Path())), "#photo-1"));
  EXPECT_FALSE(std::filesystem::exists(folder / "report_photos"));
}

// orientation.csv may say anything, and a person may keep notes beside the pages.
TEST(Report, PagesStayInTheirFolderAndLeaveOthersFilesAlone) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "out");
  std::string table = "filename,x,y,z,omega,phi,kappa\n";
  for (int i = 0; i < 101; ++i) table += std::to_string(i) + ",1,2,3,0,0,0\n";
  WriteFileAtomically(folder / "out/orientation.csv", table + "../../evil,1,2,3,0,0,0\n");
  std::filesystem::create_directories(folder / "out/report_photos/mine");
  for (const char* note : {"report_photos/notes.html", "report_photos/mine/notes.html"})
    WriteFileAtomically(folder / ("out/" + std::string(note)), "<p>mine</p>");
  WriteReport(folder / "out");
  EXPECT_EQ(HtmlIn(folder.Path()).size(), 1u + 102u + 2u);
  EXPECT_FALSE(std::filesystem::exists(folder / "evil.html"));
  WriteFileAtomically(folder / "out/orientation.csv",
                      "filename,x,y,z,omega,phi,kappa\n1,1,2,3,0,0,0\n");
  WriteReport(folder / "out");
  EXPECT_EQ(HtmlIn(folder.Path()).size(), 1u + 2u);
}

TEST(Report, PicturesThatWouldMakeThePageTooLargeGoToPages) {
  constexpr size_t kLargest = 5 * 1024 * 1024;
  const TemporaryFolder folder;
  for (int i = 0; i < 40; ++i) {
    const std::string name = std::to_string(1000 + i);
    WriteExteriorResult(folder.Path(), ExampleExterior(name, Status::kOk));
    if (i == 0) WritePng(folder / (name + ".patches.png"), 700, 500, true);
    if (i > 0)
      std::filesystem::copy_file(folder / "1000.patches.png", folder / (name + ".patches.png"));
  }
  const std::string first = WriteReport(folder.Path());
  EXPECT_LT(ReadFile(first).size(), kLargest);
  EXPECT_EQ(HtmlIn(folder / "report_photos").size(), 40u);
  for (const std::string& page : HtmlIn(folder / "report_photos"))
    EXPECT_TRUE(Contains(ReadFile(page), "data:image/jpeg")) << page;
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

TEST(Report, TheSameFiguresForPrograms) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  const auto json =
      nlohmann::json::parse(ReadFile(WriteReportJson(ReadBlockRecord(folder.Path()))));
  EXPECT_EQ(json["ok"], 1);
  EXPECT_EQ(json["failed"], 1);
  EXPECT_NEAR(json["projection_sigma_median"]["px"].get<double>(), 0.42, 1e-12);
  EXPECT_NEAR(json["ground_ce90_m_median"].get<double>(), 2.146 * 0.21, 1e-12);
  EXPECT_NEAR(json["photos"][0]["ground_ce90_m"].get<double>(), 2.146 * 0.21, 1e-12);
  EXPECT_TRUE(json["ties_le90_m_median"].is_null()) << "no block adjustment";
  ASSERT_EQ(json["photos"].size(), 3u);
  EXPECT_EQ(json["photos"][0]["status"], "ok");
  EXPECT_EQ(json["photos"][0]["patches"]["matched"], 3);
  EXPECT_NEAR(json["photos"][0]["pose"]["sigma_x_m"].get<double>(), 0.4, 1e-12);
  EXPECT_TRUE(json["photos"][2]["pose"].is_null());
  EXPECT_EQ(json["moved_from_approximations"], nlohmann::json::parse(R"({"photos": 2,
      "mean_m": [12.5, -4.0, -1.0], "rms_about_mean_m": [0.0, 0.0, 1.0]})"));
  EXPECT_EQ(json["look_at_first"][0]["photo"], "4713");
}

TEST(Report, SaysAtWhatScaleTheCameraSawTheGround) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  EXPECT_FALSE(Contains(ReadFile(WriteReport(folder.Path())), "Camera and flight"));
  CameraFile camera;
  camera.camera.name = "an <old> camera";
  camera.camera.kind = CameraKind::kDigital;
  camera.camera.principal_distance_mm = 100;
  camera.camera.frame_mm = {50, 50};
  camera.camera.image_px = Eigen::Vector2i(2000, 2000);
  WriteCameraFile(folder / "block_camera.toml", camera);
  const std::string html = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(Malformed(html), "");
  // 1423.75 m above the ground: 1 : 14 238, 25 micrometres a pixel.
  for (const char* part : {"Camera and flight", "an &lt;old&gt; camera", "14\u202F238", "0.356"})
    EXPECT_TRUE(Contains(html, part)) << part;
  const auto json =
      nlohmann::json::parse(ReadFile(WriteReportJson(ReadBlockRecord(folder.Path()))));
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
