#include "tools/report/overview.h"

#include <algorithm>

#include "tools/report/html_table.h"
#include "tools/report/html_text.h"

namespace orient {
namespace {

std::string PhotoLink(const BlockRecord& block, size_t photo) {
  return "<a href=\"#photo-" + std::to_string(photo + 1) + "\">" +
         Escape(block.photos[photo].name) + "</a>";
}

std::string Tile(const std::string& value, const std::string& name, const std::string& note = "",
                 const std::string& css_class = "") {
  return "<div class=\"tile " + css_class + "\"><div class=\"value\">" + value +
         "</div><div class=\"name\">" + name + "</div>" +
         (note.empty() ? "" : "<div class=\"tile-note\">" + note + "</div>") + "</div>\n";
}

std::string Unit(const std::string& number, const std::string& unit) {
  return number == kNoValue ? number : number + "<small>\xE2\x80\xAF" + unit + "</small>";
}

std::string PrecisionTile(const BlockRecord& block, const BlockVerdict& verdict) {
  if (!verdict.least_precise) return Tile(kNoValue, "worst precision");
  const Vector6d& sigma = *verdict.photos[*verdict.least_precise].sigma;
  const double sigma_m = sigma.head<3>().maxCoeff();
  return Tile(Unit(Decimal(sigma_m, DecimalsForSigma(sigma_m)), "m"), "worst sigma of a coordinate",
              PhotoLink(block, *verdict.least_precise));
}

std::string StatusTile(int count, Status status) {
  const std::string name(Name(status));
  return Tile(std::to_string(count), name, "", count > 0 ? name : "none");
}

std::string Percent(int part, int whole) {
  return whole > 0 ? Decimal(100.0 * part / whole, 0) + "\xE2\x80\xAF%" : "";
}

// x / y / z with the decimals that the largest one needs.
std::string Triple(const Eigen::Vector3d& sigma, int most_decimals) {
  const int decimals = std::min(DecimalsForSigma(sigma.maxCoeff()), most_decimals);
  return Decimal(sigma[0], decimals) + " / " + Decimal(sigma[1], decimals) + " / " +
         Decimal(sigma[2], decimals);
}

std::string Degrees(const Vector6d& sigma) {
  const Eigen::Vector3d degrees(DegFromRad(sigma[3]), DegFromRad(sigma[4]), DegFromRad(sigma[5]));
  return Triple(degrees, 6);
}

std::string FirstReason(const PhotoVerdict& photo) {
  if (photo.reasons.empty()) return "";
  const size_t more = photo.reasons.size() - 1;
  return Escape(photo.reasons.front()) +
         (more > 0 ? " <span class=\"more\">+" + std::to_string(more) + "</span>" : "");
}

std::vector<std::string> PhotoRow(const BlockRecord& block, const PhotoVerdict& photo, size_t i,
                                  bool with_exterior) {
  std::vector<std::string> cells = {
      PhotoLink(block, i), StatusPill(photo.status),
      photo.marks > 0 ? std::to_string(photo.marks_used) + " / " + std::to_string(photo.marks)
                      : kNoValue,
      Decimal(photo.sigma0_um, 1)};
  if (with_exterior) {
    const bool searched = block.photos[i].exterior.has_value();
    cells.push_back(searched
                        ? std::to_string(photo.matched) + " / " + std::to_string(photo.Searched())
                        : kNoValue);
    cells.push_back(searched ? std::to_string(photo.rejected) : kNoValue);
    cells.push_back(Decimal(photo.sigma0_px, 2));
    cells.push_back(photo.sigma ? Triple(photo.sigma->head<3>(), 4) : kNoValue);
    cells.push_back(photo.sigma ? Degrees(*photo.sigma) : kNoValue);
  }
  cells.push_back(FirstReason(photo));
  return cells;
}

}  // namespace

std::string SummarySection(const BlockRecord& block, const BlockVerdict& verdict) {
  const auto n = block.photos.size();
  std::string html = "<header>\n<p class=\"program\">Orientation report</p>\n<h1>" +
                     Escape(block.title) + "</h1>\n<p class=\"facts\">" + std::to_string(n) +
                     (n == 1 ? " photo" : " photos");
  if (block.crs) {
    html += " · " + Escape(block.crs->Name());
    if (const auto epsg = block.crs->Epsg()) html += " (EPSG:" + std::to_string(*epsg) + ")";
  }
  html += "</p>\n</header>\n<div class=\"tiles\">\n" + StatusTile(verdict.ok, Status::kOk) +
          StatusTile(verdict.weak, Status::kWeak) + StatusTile(verdict.failed, Status::kFailed);
  if (block.HasExterior()) {
    html += Tile(Unit(Decimal(verdict.median_sigma0_px, 2), "px"), "median sigma0") +
            Tile(std::to_string(verdict.matched) + "<small> / " + std::to_string(verdict.searched) +
                     "</small>",
                 "patches matched / searched", Percent(verdict.matched, verdict.searched));
  }
  if (verdict.median_sigma0_um)
    html += Tile(Unit(Decimal(verdict.median_sigma0_um, 1), "µm"), "median sigma0 of the marks");
  if (block.HasExterior() || verdict.least_precise) html += PrecisionTile(block, verdict);
  return html + "</div>\n";
}

std::string ConcernsSection(const BlockRecord& block, const BlockVerdict& verdict) {
  std::string items;
  for (const std::string& problem : block.unreadable)
    items +=
        "<li><span class=\"pill failed\">file</span><span>" + Escape(problem) + "</span></li>\n";
  for (const std::string& note : block.notes)
    items += "<li><span class=\"pill look\">block</span><span>" + Escape(note) + "</span></li>\n";
  for (const Concern& concern : verdict.concerns) {
    const Status status = verdict.photos[concern.photo].status;
    const std::string pill =
        status == Status::kOk ? "<span class=\"pill look\">look</span>" : StatusPill(status);
    items += "<li>" + pill + "<span>" + PhotoLink(block, concern.photo) + "<br/>" +
             Escape(concern.text) + "</span></li>\n";
  }
  if (items.empty())
    return "<section>\n<h2>Look at this first</h2>\n<p class=\"note\">Every photo is ok and none "
           "stands out from the others.</p>\n</section>\n";
  return "<section>\n<h2>Look at this first</h2>\n<ul class=\"concerns\">\n" + items +
         "</ul>\n</section>\n";
}

std::string PhotosSection(const BlockRecord& block, const BlockVerdict& verdict) {
  const bool with_exterior =
      std::any_of(verdict.photos.begin(), verdict.photos.end(),
                  [](const PhotoVerdict& photo) { return photo.pose.has_value(); }) ||
      block.HasExterior();
  std::vector<std::string> header = {"Photo", "Status", "#Marks<br/>used",
                                     "#Marks<br/>σ<sub>0</sub> µm"};
  if (with_exterior)
    header.insert(header.end(),
                  {"#Patches<br/>matched", "#Patches<br/>rejected", "#Patches<br/>σ<sub>0</sub> px",
                   "#σ<sub>X</sub> / σ<sub>Y</sub> / σ<sub>Z</sub><br/>m",
                   "#σ<sub>ω</sub> / σ<sub>φ</sub> / σ<sub>κ</sub><br/>°"});
  header.push_back("Message");
  HtmlTable table(header, "photos");
  for (size_t i = 0; i < block.photos.size(); ++i)
    table.AddRow(PhotoRow(block, verdict.photos[i], i, with_exterior));
  return "<section id=\"photos\">\n<h2>All photos</h2>\n" + table.Html() +
         "<p class=\"note\">Marks used of all marks, patches matched of those searched. σ: one "
         "standard deviation. σ<sub>0</sub> of marks in the photo system; "
         "px are pixels of the photo at full resolution.</p>\n</section>\n";
}

}  // namespace orient
