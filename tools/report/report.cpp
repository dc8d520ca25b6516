#include "tools/report/report.h"

#include <algorithm>
#include <filesystem>
#include <numeric>

#include "core/files/atomic_write.h"
#include "tools/report/block_map.h"
#include "tools/report/block_section.h"
#include "tools/report/html_text.h"
#include "tools/report/overview.h"
#include "tools/report/photo_section.h"
#include "tools/report/picture.h"
#include "tools/report/style.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// A page that a browser opens at once. Photos that deserve a look get their pictures first.
constexpr size_t kPictureBudget = 48 * 1024 * 1024;  // bytes of HTML

class PictureAlbum {
 public:
  explicit PictureAlbum(std::string directory) : directory_(std::move(directory)) {}

  std::string Figure(const std::string& file_name, const std::string& alt) {
    const std::string link =
        "<a href=\"" + PercentEncoded(file_name) + "\">" + Escape(file_name) + "</a>";
    if (used_ > kPictureBudget)
      return "<p class=\"note\">" + Escape(alt) + ": " + link + " beside this report.</p>\n";
    const auto picture = LoadPicture((fs::path(directory_) / file_name).string());
    if (!picture)
      return "<p class=\"note\">" + Escape(alt) + ": " + link + " is no readable picture.</p>\n";
    used_ += picture->data_uri.size();
    return "<figure><img alt=\"" + Escape(alt) + "\" width=\"" + std::to_string(picture->width) +
           "\" height=\"" + std::to_string(picture->height) + "\" src=\"" + picture->data_uri +
           "\"/><figcaption>" + Escape(alt) + ". In full: " + link + "</figcaption></figure>\n";
  }

 private:
  std::string directory_;
  size_t used_ = 0;
};

std::string QuicklookSection(const BlockRecord& block, PictureAlbum* album) {
  if (block.quicklook_picture.empty()) return "";
  std::string html = "<section>\n<h2>Orthophotos</h2>\n" +
                     album->Figure(block.quicklook_picture,
                                   "Reduced orthophotos, each place from the photo that sees it "
                                   "nearest to its middle; seams in yellow");
  if (!block.seams_picture.empty())
    html += album->Figure(block.seams_picture,
                          "Places along the seams at full resolution, the two photos in turn like "
                          "a chequerboard, with the shift between them. A line that breaks where "
                          "fields meet is an error, or stands above the DEM");
  return html + "</section>\n";
}

// Sections in the photos' order, made in the order of need while the album has room.
std::string PhotoSections(const BlockRecord& block, const BlockVerdict& verdict,
                          PictureAlbum* album) {
  std::vector<size_t> order;
  for (const Concern& concern : verdict.concerns) order.push_back(concern.photo);
  for (size_t i = 0; i < block.photos.size(); ++i)
    if (std::find(order.begin(), order.end(), i) == order.end()) order.push_back(i);
  const PictureHtml picture = [&](const std::string& file_name, const std::string& alt) {
    return album->Figure(file_name, alt);
  };
  std::vector<std::string> sections(block.photos.size());
  for (const size_t i : order)
    sections[i] = PhotoSection(block.photos[i], verdict.photos[i], i + 1, picture);
  return std::accumulate(sections.begin(), sections.end(), std::string());
}

}  // namespace

std::string WriteReport(const BlockRecord& block) {
  const BlockVerdict verdict = Judge(block);
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>" +
      Escape(block.title) + " – orientation report</title>\n<style>";
  html += kReportStyle;
  html += "</style>\n</head>\n<body>\n";
  html += SummarySection(block, verdict) + ConcernsSection(block, verdict);
  html += "<section>\n<h2>Map</h2>\n" + BlockMap(block, verdict) + "</section>\n";
  PictureAlbum album(block.directory);
  html += QuicklookSection(block, &album) + AdjustmentSection(block) + FilmSection(block);
  html += PhotosSection(block, verdict) + PhotoSections(block, verdict, &album);
  html += "</body>\n</html>\n";
  const std::string path = (fs::path(block.directory) / "report.html").string();
  WriteFileAtomically(path, html);
  return path;
}

std::string WriteReport(const std::string& directory) {
  return WriteReport(ReadBlockRecord(directory));
}

}  // namespace orient
