#include "tools/report/photo_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "interior/orientation/film_transform.h"
#include "tools/report/html_text.h"
#include "tools/report/residual_plot.h"

namespace orient {
namespace {

std::string Component(const std::optional<Eigen::Vector2d>& vector, int i, int decimals) {
  return vector ? Decimal((*vector)[i], decimals) : kNoValue;
}

Markup Messages(const PhotoVerdict& verdict) {
  if (verdict.reasons.empty()) return {};
  Markup messages;
  for (const std::string& reason : verdict.reasons)
    messages += Fill("photo.html#message", {{"text", reason}});
  return Fill("photo.html#messages", {{"status", Name(verdict.status)}, {"messages", messages}});
}

// By how much a pose's element (index) departs from the approximation, in its unit of the file.
std::string FromApproximation(const PhotoVerdict& verdict, const StartingPose* start, int i,
                              int digits) {
  if (start == nullptr) return kNoValue;
  const double moved = verdict.pose->AsVector()[i] - start->pose.AsVector()[i];
  if (i < 3) return Decimal(moved, digits);
  constexpr double kUnknown = 0.99 * std::numbers::pi;
  return start->sigma[i] > kUnknown ? kNoValue : Decimal(DegFromRad(NormalizeAngle(moved)), digits);
}

Markup PoseTable(const PhotoVerdict& verdict, const StartingPose* start) {
  if (!verdict.pose) return Fill("photo.html#no_pose");
  constexpr std::array kNames = {"X", "Y", "Z", "omega", "phi", "kappa"};
  Markup rows;
  const Vector6d values = verdict.pose->AsVector();
  for (int i = 0; i < 6; ++i) {
    const bool angle = i >= 3;
    const auto in_file_unit = [&](double v) { return angle ? DegFromRad(v) : v; };
    const double value = in_file_unit(angle ? NormalizeAngle(values[i]) : values[i]);
    std::optional<double> sigma;
    if (verdict.sigma) sigma = in_file_unit((*verdict.sigma)[i]);
    // A digit more than the sigma shows lets two solutions be compared.
    const int digits = sigma ? std::min(DecimalsForSigma(*sigma), angle ? 7 : 4) : angle ? 5 : 2;
    rows += Fill("photo.html#pose_element",
                 {{"element", kNames[static_cast<size_t>(i)]},
                  {"value", angle ? Decimal(value, digits) : Grouped(value, digits)},
                  {"sigma", Decimal(sigma, digits)},
                  {"moved", FromApproximation(verdict, start, i, std::min(digits, 3))},
                  {"unit", angle ? "°" : "m"}});
  }
  const Markup origin = verdict.from_table ? Fill("photo.html#pose_of_table") : Markup();
  return Fill("photo.html#pose", {{"rows", rows}, {"origin", origin}});
}

Markup RoundsTable(const ExteriorResult& exterior) {
  if (exterior.iterations.empty()) return {};
  Markup rows;
  for (size_t i = 0; i < exterior.iterations.size(); ++i) {
    const LoopRound& round = exterior.iterations[i];
    rows += Fill("photo.html#round", {{"round", i + 1},
                                      {"searched", round.searched},
                                      {"matched", round.matched},
                                      {"reduction", round.reduction},
                                      {"window", Decimal(round.window_px, 1)},
                                      {"rms", Decimal(round.rms_px, 2)}});
  }
  return Fill("photo.html#rounds", {{"rows", rows}});
}

// RMS of the matched patches' residuals: over both coordinates, then of each.
std::string ResidualStatistics(const ExteriorResult& exterior) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double largest = 0;
  int n = 0;
  for (const PatchResult& patch : exterior.patches) {
    if (patch.state != PatchState::kMatched || !patch.residual_px) continue;
    sum += patch.residual_px->cwiseAbs2();
    largest = std::max(largest, patch.residual_px->norm());
    ++n;
  }
  if (n == 0) return "";
  const Eigen::Vector2d rms = (sum / n).cwiseSqrt();
  return fmt::format("RMS of {} residuals {} px (col {}, row {}), largest {} px", n,
                     Decimal(rms.norm(), 2), Decimal(rms.x(), 2), Decimal(rms.y(), 2),
                     Decimal(largest, 2));
}

// How often each reason was given: a few lines where there may be hundreds of patches.
Markup PatchesTable(const ExteriorResult& exterior) {
  if (exterior.patches.empty()) return {};
  std::map<std::pair<PatchState, std::string>, int> counts;
  for (const PatchResult& patch : exterior.patches)
    ++counts[{patch.state, JoinedSentences(patch.findings)}];
  Markup rows;
  const auto add_row = [&](PatchState state, int count, const std::string& reason) {
    std::string name(Name(state));
    std::replace(name.begin(), name.end(), '_', ' ');
    rows += Fill("photo.html#patches_of_reason",
                 {{"state", name}, {"count", count}, {"reason", reason}});
  };
  constexpr size_t kMostReasons = 12;  // reasons that name numbers differ for every patch
  std::map<PatchState, std::pair<size_t, int>> lines;
  for (const auto& [key, count] : counts) {
    auto& [shown, rest] = lines[key.first];
    if (++shown > kMostReasons)
      rest += count;
    else
      add_row(key.first, count, key.second);
  }
  for (const auto& [state, line] : lines)
    if (line.second > 0) add_row(state, line.second, "other reasons");
  return Fill("photo.html#patches", {{"rows", rows}});
}

Markup MarksTable(const InteriorResult& interior) {
  if (interior.marks.empty()) return {};
  Markup rows;
  for (const MarkResult& mark : interior.marks)
    rows += Fill("photo.html#mark", {{"mark", mark.id},
                                     {"state", Name(mark.state)},
                                     {"col", Component(mark.pixel, 0, 2)},
                                     {"row", Component(mark.pixel, 1, 2)},
                                     {"sigma_col", Component(mark.sigma_px, 0, 3)},
                                     {"sigma_row", Component(mark.sigma_px, 1, 3)},
                                     {"v_x", Component(mark.residual_um, 0, 1)},
                                     {"v_y", Component(mark.residual_um, 1, 1)},
                                     {"score", Decimal(mark.score, 2)}});
  return Fill("photo.html#marks", {{"rows", rows}});
}

// "25.01 × 25.03 µm per pixel, axes 0.002° off square".
std::string FilmShapeFact(const Affine2d& photo_from_pixel) {
  const interior::FilmShape shape = interior::ShapeOf(photo_from_pixel);
  return fmt::format("{} × {} µm per pixel, axes {}° off square", Decimal(shape.column_um, 3),
                     Decimal(shape.row_um, 3), Decimal(DegFromRad(std::abs(shape.shear_rad)), 3));
}

std::string InteriorFacts(const InteriorResult& interior) {
  std::vector<std::string> facts;
  facts.push_back(
      fmt::format("scan {} × {} px", Grouped(interior.width, 0), Grouped(interior.height, 0)));
  if (interior.photo_from_pixel) facts.push_back(FilmShapeFact(*interior.photo_from_pixel));
  facts.push_back(fmt::format("scan orientation {}",
                              interior.orientation ? Name(*interior.orientation) : "open"));
  if (interior.polarity) facts.push_back(std::string(Name(*interior.polarity)));
  if (interior.sigma0_um)
    facts.push_back(fmt::format("sigma0 of the marks {} µm", Decimal(*interior.sigma0_um, 1)));
  if (interior.margin)
    facts.push_back(
        fmt::format("second-best assignment {} nats worse", Decimal(*interior.margin, 1)));
  return Joined(facts, " · ");
}

// Nothing for a photo without this picture.
Markup PictureOf(const std::string& file_name, const char* alt, const PictureHtml& picture) {
  return file_name.empty() ? Markup() : picture(file_name, alt);
}

// The whole scan of a photo that is not ok, with what was searched for on it.
Markup OverviewPart(Status status, const std::string& file_name, const char* part,
                    const PictureHtml& picture) {
  if (status == Status::kOk || file_name.empty()) return {};
  return Fill(part, {{"picture", picture(file_name, "The whole scan with the search windows")}});
}

Markup InteriorPart(const PhotoRecord& photo, const PictureHtml& picture) {
  if (!photo.interior) return {};
  return Fill("photo.html#interior",
              {{"status", Name(photo.interior->status)},
               {"facts", InteriorFacts(*photo.interior)},
               {"marks", MarksTable(*photo.interior)},
               {"picture",
                PictureOf(photo.marks_picture, "Fiducial marks with the centres found", picture)},
               {"overview", OverviewPart(photo.interior->status, photo.marks_overview,
                                         "photo.html#marks_overview", picture)}});
}

std::string TiesFact(const TieCount& ties) {
  std::string fact = fmt::format("{} of {} ties used", ties.used, ties.measured);
  if (ties.rms_px) fact += fmt::format(", RMS {} px", Decimal(*ties.rms_px, 2));
  return fact;
}

std::string ExteriorFacts(const ExteriorResult& exterior, const PhotoVerdict& verdict) {
  std::vector<std::string> facts = {
      fmt::format("{} of {} patches matched", verdict.matched, verdict.Searched())};
  if (exterior.sigma0_px)
    facts.push_back(fmt::format("sigma0 of the matches {} px", Decimal(*exterior.sigma0_px, 2)));
  if (const auto& sigma = exterior.projection_sigma)
    facts.push_back(fmt::format("projection σ at worst {} px, {} m", Decimal(sigma->px, 2),
                                Decimal(sigma->m, DecimalsForSigma(sigma->m))));
  if (std::string statistics = ResidualStatistics(exterior); !statistics.empty())
    facts.push_back(std::move(statistics));
  if (exterior.ties && exterior.ties->measured > 0) facts.push_back(TiesFact(*exterior.ties));
  if (exterior.orientation)
    facts.push_back(fmt::format("scan orientation {}", Name(*exterior.orientation)));
  return Joined(facts, " · ");
}

Markup ExteriorPart(const PhotoRecord& photo, const PhotoVerdict& verdict,
                    const PictureHtml& picture) {
  if (!photo.exterior && !verdict.pose) return {};
  if (!photo.exterior)
    return Fill("photo.html#exterior_of_table", {{"pose", PoseTable(verdict, nullptr)}});
  const ExteriorResult& exterior = *photo.exterior;
  const bool scan_known = exterior.width > 0 && exterior.height > 0;
  const int width = scan_known || !photo.interior ? exterior.width : photo.interior->width;
  const int height = scan_known || !photo.interior ? exterior.height : photo.interior->height;
  return Fill(
      "photo.html#exterior",
      {{"status", Name(exterior.status)},
       {"facts", ExteriorFacts(exterior, verdict)},
       {"pose", PoseTable(verdict, exterior.approximation ? &*exterior.approximation : nullptr)},
       {"rounds", RoundsTable(exterior)},
       {"patches", PatchesTable(exterior)},
       {"residuals", ResidualPlot(exterior, width, height)},
       {"picture", PictureOf(photo.patches_picture, "Patches beside their matches", picture)},
       {"overview", OverviewPart(exterior.status, photo.patches_overview,
                                 "photo.html#patches_overview", picture)}});
}

}  // namespace

Markup PhotoSection(const PhotoRecord& photo, const PhotoVerdict& verdict, const PhotoPlace& place,
                    const PictureHtml& picture) {
  return Fill("photo.html",
              {{"number", place.number},
               {"all", place.all},
               {"photo", photo.name},
               {"status", Name(verdict.status)},
               {"thumbnail", PictureOf(photo.thumbnail, "The scan, reduced", picture)},
               {"messages", Messages(verdict)},
               {"exterior", ExteriorPart(photo, verdict, picture)},
               {"interior", InteriorPart(photo, picture)}});
}

}  // namespace orient
