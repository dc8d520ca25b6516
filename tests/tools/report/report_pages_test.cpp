// The report as files: one page or many, with its pictures, safe to open and to mail.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "core/base/atomic_write.h"
#include "tests/support/shared_data.h"
#include "tests/tools/report/example_block.h"
#include "tests/tools/report/report_page.h"
#include "tools/report/report.h"

namespace orient {
namespace {

TEST(ReportPages, NeedsNoNetworkAndNoScript) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  const std::string html = ReadFile(WriteReport(folder.Path()));
  for (const char* part : {"http:", "https:", "<script", "<link", "@import", "url("})
    EXPECT_FALSE(Contains(html, part)) << part;
}

TEST(ReportPages, IsTheSameEveryTime) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  const std::string first = ReadFile(WriteReport(folder.Path()));
  EXPECT_EQ(ReadFile(WriteReport(folder.Path())), first);
}

TEST(ReportPages, HostileTextStaysText) {
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

TEST(ReportPages, PicturesAreInsideThePage) {
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

TEST(ReportPages, FileThatIsNoPictureIsSaidToBeNone) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  std::ofstream(folder / "4712.marks.png") << "no picture";
  EXPECT_TRUE(Contains(ReadFile(WriteReport(folder.Path())), "is not a readable image"));
}

TEST(ReportPages, HundredsOfPatchesStaySmall) {
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

TEST(ReportPages, ManyPhotosHaveAPageEach) {
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
TEST(ReportPages, PagesStayInTheirFolderAndLeaveOthersFilesAlone) {
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

TEST(ReportPages, PicturesThatWouldMakeThePageTooLargeGoToPages) {
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

}  // namespace
}  // namespace orient
