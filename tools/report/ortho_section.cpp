#include "tools/report/ortho_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "block/inputs/approximations.h"
#include "tools/report/html_text.h"

namespace orient {
namespace {

std::string Metres(double value_m) { return Decimal(value_m, DecimalsForSigma(value_m)); }

std::string Text(const std::optional<GroundAccuracy>& ce90) {
  if (!ce90) return "";
  return fmt::format(" · CE90 {} m, at worst {} m", Metres(ce90->median_m), Metres(ce90->worst_m));
}

Markup Row(const OrthoFigures& photo) {
  return Fill("ortho.html#photo",
              {{"href", PercentEncodedPath(photo.file)},
               {"photo", photo.photo},
               {"gsd", photo.gsd_m ? fmt::format("{:g}", *photo.gsd_m) : kNoValue},
               {"width", photo.width},
               {"height", photo.height},
               {"ce90", photo.ce90 ? Metres(photo.ce90->median_m) : kNoValue},
               {"ce90_worst", photo.ce90 ? Metres(photo.ce90->worst_m) : kNoValue}});
}

// More rows than anybody reads; report.json has them all.
constexpr std::size_t kMostRows = 200;

Markup Table(const OrthoFolder& ortho) {
  if (ortho.photos.empty()) return {};
  Markup rows;
  const std::size_t shown = std::min(ortho.photos.size(), kMostRows);
  for (std::size_t i = 0; i < shown; ++i) rows += Row(ortho.photos[i]);
  if (shown < ortho.photos.size())
    rows += Fill("ortho.html#more", {{"count", ortho.photos.size() - shown}});
  return Fill("ortho.html#photos", {{"rows", rows}});
}

// Facts common to all orthophotos, without those that differ, e.g. after partial runs.
std::string Facts(const OrthoFolder& ortho) {
  const std::size_t n = ortho.photos.size();
  if (n == 0) return "A mosaic alone";
  const OrthoFigures& first = ortho.photos.front();
  const auto all = [&](const auto& is_alike) {
    return std::all_of(ortho.photos.begin(), ortho.photos.end(), is_alike);
  };
  std::string text = fmt::format("{} {}", n, n == 1 ? "orthophoto" : "orthophotos");
  if (first.gsd_m && all([&](const OrthoFigures& one) { return one.gsd_m == first.gsd_m; }))
    text += fmt::format(" of {:g} m a pixel", *first.gsd_m);
  if (!first.dem.empty() &&
      all([&](const OrthoFigures& one) { return one.dem.empty() || one.dem == first.dem; }))
    text += " over " + first.dem;
  return text + Text(AccuracyOfAll(ortho.photos));
}

Markup Link(const std::string& file, const char* what) {
  if (file.empty()) return {};
  return Fill("ortho.html#link", {{"href", PercentEncodedPath(file)}, {"what", what}});
}

Markup Changes(const MosaicChanges& changes) {
  Markup told;
  if (const auto& others = changes.others; !others.empty())
    told += Fill("ortho.html#mosaic_of_others",
                 {{"count", others.size()}, {"photos", block::Listed(others)}});
  if (const auto& lacking = changes.lacking; !lacking.empty())
    told += Fill("ortho.html#mosaic_lacks",
                 {{"count", lacking.size()}, {"photos", block::Listed(lacking)}});
  return told;
}

Markup Mosaic(const OrthoFolder& ortho, const PictureHtml& figure) {
  if (!ortho.mosaic) return {};
  const MosaicFigures& mosaic = *ortho.mosaic;
  Markup links = Link(ortho.seamlines, "its seamlines");
  links += Link(ortho.tones, "the photos’ tones");
  return Fill("ortho.html#mosaic", {{"picture", figure(mosaic.file, "The mosaic, reduced")},
                                    {"width", mosaic.width},
                                    {"height", mosaic.height},
                                    {"ce90", Text(mosaic.ce90)},
                                    {"changes", Changes(mosaic.changes)},
                                    {"links", links}});
}

Markup Quicklook(const BlockRecord& block, const PictureHtml& figure) {
  if (block.quicklook_picture.empty()) return {};
  Markup pictures = figure(block.quicklook_picture,
                           "Reduced orthophotos, each place from the photo that sees it nearest to "
                           "its centre; seams in yellow");
  if (!block.seams_picture.empty())
    pictures += figure(block.seams_picture,
                       "Places along the seams at full resolution, the two photos alternating like "
                       "a chequerboard, with the shift between them. A line that breaks where "
                       "squares meet is an error, or an object above the DEM");
  return pictures;
}

// Orthophotos that end where the DEM ends.
Markup CutOff(const OrthoFolder& ortho) {
  std::vector<std::string> photos;
  for (const OrthoFigures& photo : ortho.photos)
    if (photo.with_heights && *photo.with_heights < kWholeFrame)
      photos.push_back(fmt::format("{} ({:.0f} %)", photo.photo, 100 * *photo.with_heights));
  if (photos.empty()) return {};
  return Fill("ortho.html#cut_off", {{"count", photos.size()}, {"photos", block::Listed(photos)}});
}

}  // namespace

Markup OrthophotoSection(const BlockRecord& block, const PictureHtml& figure) {
  Markup contents;
  if (block.ortho) {
    contents += Fill("ortho.html#facts", {{"facts", Facts(*block.ortho)}});
    if (const auto& other = block.ortho->of_other_poses; !other.empty())
      contents += Fill("ortho.html#of_other_poses",
                       {{"count", other.size()}, {"photos", block::Listed(other)}});
    if (const auto& without = block.ortho->without_pose; !without.empty())
      contents += Fill("ortho.html#without_pose",
                       {{"count", without.size()}, {"photos", block::Listed(without)}});
    contents += CutOff(*block.ortho);
    for (const std::string& problem : block.ortho->unreadable)
      contents += Fill("ortho.html#unreadable", {{"problem", problem}});
    contents += Mosaic(*block.ortho, figure);
    contents += Table(*block.ortho);
  }
  contents += Quicklook(block, figure);
  if (contents.Empty()) return {};
  return Fill("ortho.html", {{"contents", contents}});
}

}  // namespace orient
