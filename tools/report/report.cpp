#include "tools/report/report.h"

#include <algorithm>
#include <filesystem>

#include "core/base/atomic_write.h"
#include "tools/report/block_map.h"
#include "tools/report/block_section.h"
#include "tools/report/film_section.h"
#include "tools/report/html_text.h"
#include "tools/report/overview.h"
#include "tools/report/photo_section.h"
#include "tools/report/picture.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// A page that a browser opens at once. Photos that deserve a look get their pictures first.
constexpr size_t kPictureBudget = 48 * 1024 * 1024;  // bytes of HTML

class PictureAlbum {
 public:
  explicit PictureAlbum(std::string directory) : directory_(std::move(directory)) {}

  Markup Figure(const std::string& file_name, const std::string& alt) {
    std::vector<Filling> fillings = {
        {"alt", alt}, {"href", PercentEncoded(file_name)}, {"file", file_name}};
    if (used_ > kPictureBudget) return Fill("report.html#picture_beside", fillings);
    const auto picture = LoadPicture((fs::path(directory_) / file_name).string());
    if (!picture) return Fill("report.html#no_picture", fillings);
    used_ += picture->data_uri.size();
    fillings.emplace_back("width", picture->width);
    fillings.emplace_back("height", picture->height);
    fillings.emplace_back("data_uri", Markup(picture->data_uri));
    return Fill("report.html#picture", fillings);
  }

 private:
  std::string directory_;
  size_t used_ = 0;
};

Markup QuicklookSection(const BlockRecord& block, PictureAlbum* album) {
  if (block.quicklook_picture.empty()) return {};
  Markup pictures = album->Figure(block.quicklook_picture,
                                  "Reduced orthophotos, each place from the photo that sees it "
                                  "nearest to its centre; seams in yellow");
  if (!block.seams_picture.empty())
    pictures += album->Figure(
        block.seams_picture,
        "Places along the seams at full resolution, the two photos alternating like a "
        "chequerboard, "
        "with the shift between them. A line that breaks where squares meet is an error, or an "
        "object above the DEM");
  return Fill("report.html#orthophotos", {{"pictures", pictures}});
}

// Sections in the photos' order, made in the order of need while the album has room.
Markup PhotoSections(const BlockRecord& block, const BlockVerdict& verdict, PictureAlbum* album) {
  std::vector<size_t> order;
  for (const Concern& concern : verdict.concerns) order.push_back(concern.photo);
  for (size_t i = 0; i < block.photos.size(); ++i)
    if (std::find(order.begin(), order.end(), i) == order.end()) order.push_back(i);
  const PictureHtml picture = [&](const std::string& file_name, const std::string& alt) {
    return album->Figure(file_name, alt);
  };
  std::vector<Markup> sections(block.photos.size());
  for (const size_t i : order)
    sections[i] = PhotoSection(block.photos[i], verdict.photos[i], i + 1, picture);
  Markup all;
  for (const Markup& section : sections) all += section;
  return all;
}

}  // namespace

std::string WriteReport(const BlockRecord& block) {
  const BlockVerdict verdict = Judge(block);
  PictureAlbum album(block.directory);
  // The album fills up in the order of this list.
  const Markup page =
      Fill("report.html", {{"title", block.title},
                           {"style", Markup(std::string(ReportFile("report.css")))},
                           {"summary", SummarySection(block, verdict)},
                           {"concerns", ConcernsSection(block, verdict)},
                           {"map", BlockMap(block, verdict)},
                           {"orthophotos", QuicklookSection(block, &album)},
                           {"adjustment", AdjustmentSection(block)},
                           {"film", FilmSection(block)},
                           {"photos", PhotosSection(block, verdict)},
                           {"photo_by_photo", PhotoSections(block, verdict, &album)}});
  const std::string path = (fs::path(block.directory) / "report.html").string();
  WriteFileAtomically(path, page.Text() + "\n");
  return path;
}

std::string WriteReport(const std::string& directory) {
  return WriteReport(ReadBlockRecord(directory));
}

}  // namespace orient
