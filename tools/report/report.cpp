#include "tools/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/output_directory.h"
#include "core/base/side_by_side.h"
#include "tools/report/block_map.h"
#include "tools/report/block_section.h"
#include "tools/report/film_section.h"
#include "tools/report/html_text.h"
#include "tools/report/ortho_section.h"
#include "tools/report/overlap_map.h"
#include "tools/report/overview.h"
#include "tools/report/photo_links.h"
#include "tools/report/photo_section.h"
#include "tools/report/picture.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr size_t kMostOnOnePage = 100;  // photos
constexpr size_t kMostRows = 500;       // of a list
// In the head of each page below, see report.html.
constexpr const char* kGenerator = "<meta name=\"generator\" content=\"orient report\"/>";
// A page that can be mailed, and that a browser opens at once.
constexpr size_t kLargestPage = 4 * 1024 * 1024;

// Pictures of the output folder, which is `up` ("../") from the page; embedded in the page while
// there is room, in the order of requests.
class PictureAlbum {
 public:
  PictureAlbum(std::string directory, std::string up)
      : directory_(std::move(directory)), up_(std::move(up)) {}

  Markup Figure(const std::string& file_name, const std::string& alt) {
    std::vector<Filling> fillings = {
        {"alt", alt}, {"href", up_ + PercentEncodedPath(file_name)}, {"file", file_name}};
    if (full_) return Fill("report.html#picture_beside", fillings);
    const auto picture = LoadPicture((fs::path(directory_) / file_name).string());
    if (!picture) return Fill("report.html#no_picture", fillings);
    full_ = used_ + picture->data_uri.size() > kLargestPage;
    if (full_) return Fill("report.html#picture_beside", fillings);
    used_ += picture->data_uri.size();
    fillings.emplace_back("width", picture->width);
    fillings.emplace_back("height", picture->height);
    fillings.emplace_back("data_uri", Markup(picture->data_uri));
    return Fill("report.html#picture", fillings);
  }

  bool Full() const { return full_; }

 private:
  std::string directory_, up_;
  size_t used_ = 0;
  bool full_ = false;
};

Markup InputsTable(const RunRecord& run) {
  if (run.inputs.empty()) return {};
  Markup rows;
  for (const RunInput& input : run.inputs)
    rows += Fill("report.html#run_input",
                 {{"what", input.what}, {"path", input.path}, {"digest", input.digest}});
  return Fill("report.html#run_inputs", {{"rows", rows}});
}

Markup MadeSection(const BlockRecord& block) {
  Markup runs;
  for (const auto& [stage, run] : block.runs)
    runs += Fill("report.html#run", {{"program", run.program},
                                     {"started", run.started},
                                     {"seconds", Decimal(run.seconds, 0)},
                                     {"command", run.command},
                                     {"inputs", InputsTable(run)}});
  if (runs.Empty()) return {};
  return Fill("report.html#made", {{"runs", runs}});
}

class Report {
 public:
  Report(const BlockRecord& block, const BlockVerdict& verdict)
      : block_(block), verdict_(verdict) {}

  std::string Write() {
    const fs::path pages = fs::path(block_.directory) / kPhotoPages;
    PictureAlbum album(block_.directory, "");
    const Markup orthophotos = OrthophotoSection(block_, FiguresOf(&album));
    const Markup photos = block_.photos.size() <= kMostOnOnePage ? PhotoSections(&album) : Markup();
    links_.apart = block_.photos.size() > kMostOnOnePage || album.Full();
    if (links_.apart) WritePages(pages);
    const std::string path = (fs::path(block_.directory) / "report.html").string();
    WriteFileAtomically(path,
                        FirstPage(orthophotos, links_.apart ? Markup() : photos).Text() + "\n");
    RemoveOthers(pages);
    return path;
  }

 private:
  // Pages of an earlier run, of photos that are not in the block any more.
  void RemoveOthers(const fs::path& pages) const {
    std::error_code ignored;
    if (!fs::is_directory(fs::symlink_status(pages, ignored))) return;
    std::set<fs::path> ours;
    for (size_t i = 0; links_.apart && i < block_.photos.size(); ++i)
      ours.insert(pages / PhotoPageFile(block_, i));
    for (size_t first = kMostRows; links_.apart && first < block_.photos.size(); first += kMostRows)
      ours.insert(ListPath(pages, first));
    for (const fs::path& folder : {pages / "lists", pages}) {
      std::vector<fs::path> others;
      std::error_code error;
      for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
           entry.increment(error))
        if (!ours.contains(entry->path()) && IsPageOfOurs(entry->path()))
          others.push_back(entry->path());
      for (const fs::path& other : others) fs::remove(other, ignored);
      fs::remove(folder, ignored);  // where it is empty
    }
  }

  // Recognised by its head; a person may have put something of their own beside.
  static bool IsPageOfOurs(const fs::path& path) {
    std::error_code ignored;
    if (path.extension() != ".html" || !fs::is_regular_file(fs::symlink_status(path, ignored)))
      return false;
    constexpr size_t kHead = 400;
    std::string head(kHead, ' ');
    std::ifstream(path).read(head.data(), kHead);
    return head.find(kGenerator) != std::string::npos;
  }

  static fs::path ListPath(const fs::path& pages, size_t first) {
    return pages / "lists" / fmt::format("{}.html", first / kMostRows);
  }

  Markup FirstPage(const Markup& orthophotos, const Markup& photos) const {
    return Fill("report.html", {{"title", block_.title},
                                {"style", Style()},
                                {"summary", SummarySection(block_, verdict_, links_)},
                                {"concerns", ConcernsSection(block_, verdict_, links_)},
                                {"map", BlockMap(block_, verdict_, links_)},
                                {"overlap", OverlapMap(block_, verdict_)},
                                {"orthophotos", orthophotos},
                                {"adjustment", AdjustmentSection(block_)},
                                {"camera", CameraSection(block_)},
                                {"film", FilmSection(block_)},
                                {"photos", Rows(
                                               0, [&](size_t i) { return links_.To(block_, i); },
                                               fmt::format("{}/lists/", kPhotoPages))},
                                {"made", MadeSection(block_)},
                                {"photo_by_photo", photos}});
  }

  // Sections in the photos' order, made in the order of need while the album has room.
  Markup PhotoSections(PictureAlbum* album) const {
    std::vector<size_t> order;
    for (const Concern& concern : verdict_.concerns) order.push_back(concern.photo);
    for (size_t i = 0; i < block_.photos.size(); ++i)
      if (std::find(order.begin(), order.end(), i) == order.end()) order.push_back(i);
    std::vector<Markup> sections(block_.photos.size());
    for (const size_t i : order) sections[i] = PhotoPart(i, "#photos", album);
    Markup all;
    for (const Markup& section : sections) all += section;
    return all;
  }

  static PictureHtml FiguresOf(PictureAlbum* album) {
    return [album](const std::string& file, const std::string& alt) {
      return album->Figure(file, alt);
    };
  }

  Markup PhotoPart(size_t i, const std::string& all, PictureAlbum* album) const {
    return PhotoSection(block_.photos[i], verdict_.photos[i], {i + 1, all}, FiguresOf(album));
  }

  // The rows of one list; `lists` is where the other lists lie, from the page.
  Markup Rows(size_t begin, const std::function<std::string(size_t)>& href,
              const std::string& lists) const {
    const size_t count = block_.photos.size();
    Markup links;
    for (size_t first = kMostRows; count > kMostRows && first < count; first += kMostRows)
      links += Fill("overview.html#photo_page",
                    {{"href", fmt::format("{}{}.html", lists, first / kMostRows)},
                     {"first", first + 1},
                     {"last", std::min(first + kMostRows, count)}});
    const Markup pages =
        links.Empty() ? Markup() : Fill("overview.html#photo_pages", {{"links", links}});
    return PhotosSection(block_, verdict_,
                         {begin, std::min(begin + kMostRows, count), href, pages});
  }

  void WritePages(const fs::path& pages) const {
    if (fs::is_symlink(pages))
      throw InputError(pages.string() + " is a link; remove it: the report's pages belong there");
    MakeOutputDirectory(pages.string());
    SideBySide(block_.photos.size(), [&](size_t i) { WritePhotoPage(pages, i); });
    if (block_.photos.size() <= kMostRows) return;
    MakeOutputDirectory((pages / "lists").string());
    for (size_t first = kMostRows; first < block_.photos.size(); first += kMostRows) {
      const Markup rows = Rows(
          first,
          [&](size_t i) { return fmt::format("../{}", PercentEncoded(PhotoPageFile(block_, i))); },
          "");
      WriteBelow(ListPath(pages, first).string(), "../../report.html", "photos", rows);
    }
  }

  void WritePhotoPage(const fs::path& pages, size_t i) const {
    PictureAlbum album(block_.directory, "../");
    Markup contents = PhotoPart(i, "../report.html#photos", &album);
    const auto neighbour = [&](size_t other) {
      return Fill("report.html#neighbour", {{"href", PercentEncoded(PhotoPageFile(block_, other))},
                                            {"text", block_.photos[other].name}});
    };
    contents += Fill("report.html#neighbours",
                     {{"before", i > 0 ? neighbour(i - 1) : Markup()},
                      {"after", i + 1 < block_.photos.size() ? neighbour(i + 1) : Markup()}});
    WriteBelow((pages / PhotoPageFile(block_, i)).string(), "../report.html", block_.photos[i].name,
               contents);
  }

  void WriteBelow(const std::string& path, const std::string& report, const std::string& title,
                  const Markup& contents) const {
    WriteFileAtomically(path, Fill("report.html#below", {{"title", title},
                                                         {"style", Style()},
                                                         {"report", report},
                                                         {"block", block_.title},
                                                         {"contents", contents}})
                                      .Text() +
                                  "\n");
  }

  static Markup Style() { return Markup(std::string(ReportFile("report.css"))); }

  const BlockRecord& block_;
  const BlockVerdict& verdict_;
  PhotoLinks links_;
};

}  // namespace

std::string WriteReport(const BlockRecord& block, const BlockVerdict& verdict) {
  return Report(block, verdict).Write();
}

std::string WriteReport(const std::string& directory) {
  const BlockRecord block = ReadBlockRecord(directory);
  return WriteReport(block, Judge(block));
}

}  // namespace orient
