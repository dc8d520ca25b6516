#include "tools/report/photo_section.h"

#include <array>
#include <cmath>
#include <map>

#include "interior/film_transform.h"
#include "tools/report/html_table.h"
#include "tools/report/html_text.h"
#include "tools/report/residual_plot.h"

namespace orient {
namespace {

std::string Component(const std::optional<Eigen::Vector2d>& vector, int i, int decimals) {
  return vector ? Decimal((*vector)[i], decimals) : kNoValue;
}

std::string Reasons(const PhotoVerdict& verdict) {
  if (verdict.reasons.empty()) return "";
  std::string items;
  for (const std::string& reason : verdict.reasons) items += "<li>" + Escape(reason) + "</li>\n";
  return "<ul class=\"messages " + std::string(Name(verdict.status)) + "\">\n" + items + "</ul>\n";
}

std::string PoseTable(const PhotoVerdict& verdict) {
  if (!verdict.pose) return "<p class=\"note\">No pose.</p>\n";
  constexpr std::array kNames = {"X", "Y", "Z", "omega", "phi", "kappa"};
  HtmlTable table({"Element", "#Value", "#Sigma", "Unit"});
  const Vector6d values = verdict.pose->AsVector();
  for (int i = 0; i < 6; ++i) {
    const bool angle = i >= 3;
    const auto in_file_unit = [&](double v) { return angle ? DegFromRad(v) : v; };
    const double value = in_file_unit(angle ? NormalizeAngle(values[i]) : values[i]);
    std::optional<double> sigma;
    if (verdict.sigma) sigma = in_file_unit((*verdict.sigma)[i]);
    // A digit more than the sigma shows lets two solutions be compared.
    const int digits = sigma ? std::min(DecimalsForSigma(*sigma), angle ? 7 : 4) : angle ? 5 : 2;
    table.AddRow({kNames[static_cast<size_t>(i)],
                  angle ? Decimal(value, digits) : Grouped(value, digits), Decimal(sigma, digits),
                  angle ? "°" : "m"});
  }
  return "<h4>Pose</h4>\n" + table.Html() +
         (verdict.from_table ? "<p class=\"note\">From orientation.csv.</p>\n" : "");
}

std::string RoundsTable(const ExteriorResult& exterior) {
  if (exterior.iterations.empty()) return "";
  HtmlTable table({"Round", "#Searched", "#Matched", "#Window px", "#RMS px"});
  for (size_t i = 0; i < exterior.iterations.size(); ++i) {
    const LoopRound& round = exterior.iterations[i];
    table.AddRow({std::to_string(i + 1), std::to_string(round.searched),
                  std::to_string(round.matched), Decimal(round.window_px, 1),
                  Decimal(round.rms_px, 2)});
  }
  return "<h4>Rounds of the loop</h4>\n" + table.Html();
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
  return "RMS of " + std::to_string(n) + " residuals " + Decimal(rms.norm(), 2) + " px (col " +
         Decimal(rms.x(), 2) + ", row " + Decimal(rms.y(), 2) + "), largest " +
         Decimal(largest, 2) + " px";
}

// How often each reason was given: a few lines where there may be hundreds of patches.
std::string PatchesTable(const ExteriorResult& exterior) {
  if (exterior.patches.empty()) return "";
  std::map<std::pair<PatchState, std::string>, int> counts;
  for (const PatchResult& patch : exterior.patches) ++counts[{patch.state, patch.reason}];
  HtmlTable table({"Patches", "#Count", "Reason"});
  constexpr size_t kMostReasons = 12;  // reasons that name numbers differ for every patch
  std::map<PatchState, std::pair<size_t, int>> lines;
  for (const auto& [key, count] : counts) {
    auto& [shown, rest] = lines[key.first];
    std::string state(Name(key.first));
    if (const size_t gap = state.find('_'); gap != std::string::npos) state[gap] = ' ';
    if (++shown > kMostReasons)
      rest += count;
    else
      table.AddRow({state, std::to_string(count), Escape(key.second)});
  }
  for (const auto& [state, line] : lines)
    if (line.second > 0)
      table.AddRow({std::string(Name(state)), std::to_string(line.second), "other reasons"});
  return "<h4>Patches</h4>\n" + table.Html();
}

std::string MarksTable(const InteriorResult& interior) {
  if (interior.marks.empty()) return "";
  HtmlTable table({"Mark", "State", "#Col px", "#Row px", "#σ col px", "#σ row px",
                   "#v<sub>x</sub> µm", "#v<sub>y</sub> µm", "#Score"});
  for (const MarkResult& mark : interior.marks) {
    std::string state = "<span class=\"mark-";
    state.append(Name(mark.state)).append("\">").append(Name(mark.state)).append("</span>");
    table.AddRow({Escape(mark.id), state, Component(mark.pixel, 0, 2), Component(mark.pixel, 1, 2),
                  Component(mark.sigma_px, 0, 3), Component(mark.sigma_px, 1, 3),
                  Component(mark.residual_um, 0, 1), Component(mark.residual_um, 1, 1),
                  Decimal(mark.score, 2)});
  }
  return table.Html();
}

// "25.01 × 25.03 µm per pixel, axes 0.002° off square".
std::string FilmShapeFact(const Affine2d& photo_from_pixel) {
  const FilmShape shape = ShapeOf(photo_from_pixel);
  return Decimal(shape.column_um, 3) + " × " + Decimal(shape.row_um, 3) + " µm per pixel, axes " +
         Decimal(DegFromRad(std::abs(shape.shear_rad)), 3) + "° off square";
}

std::string InteriorFacts(const InteriorResult& interior) {
  std::vector<std::string> facts;
  facts.push_back("scan " + Grouped(interior.width, 0) + " × " + Grouped(interior.height, 0) +
                  " px");
  if (interior.photo_from_pixel) facts.push_back(FilmShapeFact(*interior.photo_from_pixel));
  facts.push_back("scan orientation " + (interior.orientation
                                             ? std::string(Name(*interior.orientation))
                                             : std::string("open")));
  if (interior.polarity) facts.push_back(std::string(Name(*interior.polarity)));
  if (interior.sigma0_um) facts.push_back("sigma0 " + Decimal(*interior.sigma0_um, 1) + " µm");
  if (interior.margin)
    facts.push_back("second-best assignment " + Decimal(*interior.margin, 1) + " nats worse");
  std::string text;
  for (const std::string& fact : facts) text += (text.empty() ? "" : " · ") + fact;
  return "<p class=\"facts\">" + text + "</p>\n";
}

std::string InteriorPart(const PhotoRecord& photo, const PictureHtml& picture) {
  if (!photo.interior) return "";
  std::string html = "<h3>Interior orientation " + StatusPill(photo.interior->status) + "</h3>\n" +
                     InteriorFacts(*photo.interior) + MarksTable(*photo.interior);
  if (!photo.marks_picture.empty())
    html += picture(photo.marks_picture, "Fiducial marks with the centres found");
  return html;
}

std::string ExteriorFacts(const ExteriorResult& exterior, const PhotoVerdict& verdict) {
  std::string text = std::to_string(verdict.matched) + " of " + std::to_string(verdict.Searched()) +
                     " patches matched";
  if (exterior.sigma0_px) text += " · sigma0 " + Decimal(*exterior.sigma0_px, 2) + " px";
  const std::string statistics = ResidualStatistics(exterior);
  if (!statistics.empty()) text += " · " + statistics;
  if (exterior.ties && exterior.ties->measured > 0) {
    text += " · " + std::to_string(exterior.ties->used) + " of " +
            std::to_string(exterior.ties->measured) + " ties used";
    if (exterior.ties->rms_px) text += ", RMS " + Decimal(*exterior.ties->rms_px, 2) + " px";
  }
  if (exterior.orientation)
    text += " · scan orientation " + std::string(Name(*exterior.orientation));
  return "<p class=\"facts\">" + text + "</p>\n";
}

std::string ExteriorPart(const PhotoRecord& photo, const PhotoVerdict& verdict,
                         const PictureHtml& picture) {
  if (!photo.exterior)
    return verdict.pose ? "<h3>Exterior orientation</h3>\n" + PoseTable(verdict) : "";
  const ExteriorResult& exterior = *photo.exterior;
  const bool scan_known = exterior.width > 0 && exterior.height > 0;
  const int width = scan_known || !photo.interior ? exterior.width : photo.interior->width;
  const int height = scan_known || !photo.interior ? exterior.height : photo.interior->height;
  std::string html = "<h3>Exterior orientation " + StatusPill(exterior.status) + "</h3>\n" +
                     ExteriorFacts(exterior, verdict) + "<div class=\"columns\"><div>\n" +
                     PoseTable(verdict) + RoundsTable(exterior) + PatchesTable(exterior) +
                     "</div><div>\n" + ResidualPlot(exterior, width, height) + "</div></div>\n";
  if (!photo.patches_picture.empty())
    html += picture(photo.patches_picture, "Patches beside their matches");
  return html;
}

}  // namespace

std::string PhotoSection(const PhotoRecord& photo, const PhotoVerdict& verdict, size_t number,
                         const PictureHtml& picture) {
  return "<section class=\"photo\" id=\"photo-" + std::to_string(number) + "\">\n<h2>" +
         Escape(photo.name) + " " + StatusPill(verdict.status) +
         "<a class=\"up\" href=\"#photos\">all photos</a></h2>\n" + Reasons(verdict) +
         ExteriorPart(photo, verdict, picture) + InteriorPart(photo, picture) + "</section>\n";
}

}  // namespace orient
