#include "tools/report/overview.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/report/html_text.h"

namespace orient {
namespace {

constexpr size_t kMostConcerns = 200;

// `unit` is shown smaller behind the value, if there is one.
Markup Tile(const std::string& value, const std::string& unit, const char* name,
            const Markup& note = {}, std::string_view css_class = "") {
  const bool with_unit = value != kNoValue && !unit.empty();
  return Fill("overview.html#tile",
              {{"class", css_class},
               {"value", value},
               {"unit", with_unit ? Fill("overview.html#tile_unit", {{"unit", unit}}) : Markup()},
               {"name", name},
               {"note", note}});
}

Markup PrecisionTile(const BlockRecord& block, const BlockVerdict& verdict,
                     const PhotoLinks& links) {
  if (!verdict.least_precise) return Tile(kNoValue, "", "σ of a projection centre, worst");
  const size_t photo = *verdict.least_precise;
  const double sigma_m = verdict.photos[photo].sigma->head<3>().maxCoeff();
  return Tile(Decimal(sigma_m, DecimalsForSigma(sigma_m)), kThinSpace + std::string("m"),
              "σ of a projection centre, worst",
              Fill("overview.html#tile_photo",
                   {{"href", links.To(block, photo)}, {"photo", block.photos[photo].name}}));
}

// Precision of the poses: the median and the worst photo.
Markup ProjectionTile(const BlockRecord& block, const BlockVerdict& verdict,
                      const PhotoLinks& links) {
  const char* name = "projection σ anywhere in the frame, median";
  if (!verdict.median_projection) return Tile(kNoValue, "", name);
  const auto [px, m] = *verdict.median_projection;
  const std::string space = kThinSpace;
  const size_t worst = *verdict.worst_projection;
  return Tile(Decimal(px, 2),
              fmt::format("{}px · {}{}m", space, Decimal(m, DecimalsForSigma(m)), space), name,
              Fill("overview.html#tile_worst",
                   {{"value", Decimal(verdict.photos[worst].projection->px, 2) + space + "px"},
                    {"href", links.To(block, worst)},
                    {"photo", block.photos[worst].name}}));
}

std::string Metres(double value_m) { return Decimal(value_m, DecimalsForSigma(value_m)); }

// Accuracy of a map made with the poses.
Markup GroundTile(const BlockRecord& block, const BlockVerdict& verdict, const PhotoLinks& links) {
  const char* name = "CE90 on the ground, median photo";
  if (!verdict.median_ce90_m) return Tile(kNoValue, "", name);
  const std::string metres = kThinSpace + std::string("m");
  const size_t worst = *verdict.worst_ce90;
  return Tile(Metres(*verdict.median_ce90_m), metres, name,
              Fill("overview.html#tile_worst",
                   {{"value", Metres(verdict.photos[worst].ce90->worst_m) + metres},
                    {"href", links.To(block, worst)},
                    {"photo", block.photos[worst].name}}));
}

Markup HeightTile(double le90_m) {
  return Tile(Decimal(le90_m, DecimalsForSigma(le90_m)), kThinSpace + std::string("m"),
              "LE90 of a tie point, median");
}

Markup StatusTile(int count, Status status) {
  const std::string name(Name(status));
  return Tile(std::to_string(count), "", name.c_str(), {}, count > 0 ? name : "none");
}

Markup PatchesTile(const BlockVerdict& verdict) {
  Markup percent;
  if (verdict.searched > 0)
    percent = Fill("overview.html#tile_note",
                   {{"note", Decimal(100.0 * verdict.matched / verdict.searched, 0) + kThinSpace +
                                 std::string("%")}});
  return Tile(std::to_string(verdict.matched), fmt::format(" / {}", verdict.searched),
              "patches matched / searched", percent);
}

// x / y / z with the decimals that the largest one needs.
std::string Sigmas(const Eigen::Vector3d& sigma, int most_decimals) {
  return Decimals(sigma, std::min(DecimalsForSigma(sigma.maxCoeff()), most_decimals));
}

std::string PartOf(int part, int whole) { return fmt::format("{} / {}", part, whole); }

Markup ExteriorCells(const PhotoVerdict& photo, bool searched) {
  const auto& projection = photo.projection;
  return Fill(
      "overview.html#photo_exterior",
      {{"matched", searched ? PartOf(photo.matched, photo.Searched()) : kNoValue},
       {"rejected", searched ? std::to_string(photo.rejected) : kNoValue},
       {"sigma0_px", Decimal(photo.sigma0_px, 2)},
       {"projection_px", projection ? Decimal(projection->px, 2) : kNoValue},
       {"projection_m",
        projection ? Decimal(projection->m, DecimalsForSigma(projection->m)) : kNoValue},
       {"ce90", photo.ce90 ? Metres(photo.ce90->median_m) : kNoValue},
       {"ce90_worst", photo.ce90 ? Metres(photo.ce90->worst_m) : kNoValue},
       {"sigma_m", photo.sigma ? Sigmas(photo.sigma->head<3>(), 4) : kNoValue},
       {"sigma_deg", photo.sigma ? Sigmas(DegFromRad(1) * photo.sigma->tail<3>(), 6) : kNoValue}});
}

Markup PhotoRow(const BlockRecord& block, const PhotoVerdict& photo, size_t i, bool with_exterior,
                const std::string& href) {
  Markup more;
  if (photo.reasons.size() > 1)
    more = Fill("overview.html#more_messages", {{"count", photo.reasons.size() - 1}});
  const bool searched = block.photos[i].exterior.has_value();
  return Fill("overview.html#photo",
              {{"href", href},
               {"photo", block.photos[i].name},
               {"status", Name(photo.status)},
               {"marks", photo.marks > 0 ? PartOf(photo.marks_used, photo.marks) : kNoValue},
               {"sigma0_um", Decimal(photo.sigma0_um, 1)},
               {"exterior_cells", with_exterior ? ExteriorCells(photo, searched) : Markup()},
               {"message", photo.reasons.empty() ? "" : photo.reasons.front()},
               {"more", more}});
}

Markup BlockConcern(const char* css_class, const char* kind, const std::string& text) {
  return Fill("overview.html#block_concern",
              {{"class", css_class}, {"kind", kind}, {"text", text}});
}

std::string Facts(const BlockRecord& block) {
  const size_t n = block.photos.size();
  std::string facts = fmt::format("{} {}", n, n == 1 ? "photo" : "photos");
  if (!block.crs) return facts;
  facts += " · " + block.crs->Name();
  if (const auto epsg = block.crs->Epsg()) facts += fmt::format(" (EPSG:{})", *epsg);
  return facts;
}

}  // namespace

Markup SummarySection(const BlockRecord& block, const BlockVerdict& verdict,
                      const PhotoLinks& links) {
  const std::string space = kThinSpace;
  Markup tiles = StatusTile(verdict.ok, Status::kOk);
  tiles += StatusTile(verdict.weak, Status::kWeak);
  tiles += StatusTile(verdict.failed, Status::kFailed);
  if (block.HasExterior()) {
    tiles += GroundTile(block, verdict, links);
    if (verdict.median_le90_m) tiles += HeightTile(*verdict.median_le90_m);
    tiles += ProjectionTile(block, verdict, links);
    tiles += PatchesTile(verdict);
  }
  if (verdict.median_sigma0_um)
    tiles +=
        Tile(Decimal(verdict.median_sigma0_um, 1), space + "µm", "sigma0 of the marks, median");
  if (block.HasExterior() || verdict.least_precise) tiles += PrecisionTile(block, verdict, links);
  return Fill("overview.html", {{"title", block.title}, {"facts", Facts(block)}, {"tiles", tiles}});
}

Markup ConcernsSection(const BlockRecord& block, const BlockVerdict& verdict,
                       const PhotoLinks& links) {
  Markup concerns;
  for (const std::string& problem : block.unreadable)
    concerns += BlockConcern("failed", "file", problem);
  for (const std::string& note : block.notes) concerns += BlockConcern("look", "block", note);
  const size_t shown = std::min(verdict.concerns.size(), kMostConcerns);
  for (size_t i = 0; i < shown; ++i) {
    const Concern& concern = verdict.concerns[i];
    const Status status = verdict.photos[concern.photo].status;
    const std::string_view kind = status == Status::kOk ? "look" : Name(status);
    concerns += Fill("overview.html#photo_concern", {{"class", kind},
                                                     {"kind", kind},
                                                     {"href", links.To(block, concern.photo)},
                                                     {"photo", block.photos[concern.photo].name},
                                                     {"text", concern.text}});
  }
  if (shown < verdict.concerns.size())
    concerns +=
        Fill("overview.html#more_concerns",
             {{"photos", verdict.concerns.size() - shown == 1
                             ? "1 more photo"
                             : fmt::format("{} more photos", verdict.concerns.size() - shown)},
              {"href", "#photos"}});
  if (concerns.Empty()) return Fill("overview.html#no_concerns");
  return Fill("overview.html#concerns", {{"concerns", concerns}});
}

Markup PhotosSection(const BlockRecord& block, const BlockVerdict& verdict, const PhotoRows& rows) {
  const bool with_exterior =
      std::any_of(verdict.photos.begin(), verdict.photos.end(),
                  [](const PhotoVerdict& photo) { return photo.pose.has_value(); }) ||
      block.HasExterior();
  Markup lines;
  for (size_t i = rows.begin; i < rows.end; ++i)
    lines += PhotoRow(block, verdict.photos[i], i, with_exterior, rows.href(i));
  const Markup columns = with_exterior ? Fill("overview.html#photos_exterior") : Markup();
  return Fill("overview.html#photos",
              {{"exterior_columns", columns}, {"rows", lines}, {"pages", rows.pages}});
}

}  // namespace orient
