#include "tools/report/block_section.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/median.h"
#include "interior/film_transform.h"
#include "tools/report/html_table.h"
#include "tools/report/html_text.h"

namespace orient {
namespace {

// Sightings of one photo: how many there are and what they are worth.
struct PhotoSightings {
  int ties = 0, ties_used = 0, control = 0, control_used = 0;
  double squares_px2 = 0;  // of used ones' residuals
  double redundancy = 0;   // of used ones, of both coordinates
  double largest_w = 0;

  int Used() const { return ties_used + control_used; }
  std::optional<double> RmsPx() const {
    if (Used() == 0) return std::nullopt;
    return std::sqrt(squares_px2 / Used());
  }
  std::optional<double> MeanRedundancy() const {
    if (Used() == 0) return std::nullopt;
    return 0.5 * redundancy / Used();
  }
};

using SightingsByPhoto = std::map<std::string, PhotoSightings>;

void Count(const std::vector<PointResult>& points, bool ties, SightingsByPhoto* photos) {
  for (const PointResult& point : points)
    for (const SightingResult& sighting : point.seen) {
      PhotoSightings& photo = (*photos)[sighting.photo];
      const bool used = sighting.state == "used";
      ++(ties ? photo.ties : photo.control);
      if (!used) continue;
      ++(ties ? photo.ties_used : photo.control_used);
      if (sighting.residual_px) photo.squares_px2 += sighting.residual_px->squaredNorm();
      photo.redundancy += sighting.redundancy.value_or(0);
      photo.largest_w = std::max(photo.largest_w, sighting.w.value_or(0));
    }
}

std::string Facts(const AdjustmentResult& adjusted) {
  const auto n = adjusted.ties.size();
  std::size_t manifold = 0;
  for (const PointResult& tie : adjusted.ties) manifold += tie.rays >= 3;
  std::string text = adjusted.converged ? "" : "<strong>The adjustment did not converge.</strong> ";
  text += std::to_string(n) + (n == 1 ? " tie point (" : " tie points (") +
          std::to_string(manifold) + " in three photos or more) · " +
          std::to_string(adjusted.control.size()) + " control patches · sigma0 " +
          Decimal(adjusted.sigma0, 2) + " with " + Decimal(adjusted.redundancy, 0) +
          " degrees of freedom";
  return "<p class=\"facts\">" + text + "</p>\n";
}

std::string Components(const AdjustmentResult& adjusted) {
  HtmlTable table({"Group", "#σ<sub>0</sub> px", "#σ / stated σ", "#Degrees<br/>of freedom", ""});
  for (const ComponentResult& component : adjusted.components) {
    std::optional<double> factor;
    if (component.factor) factor = std::sqrt(*component.factor);
    const bool image = component.sigma0_px.value_or(0) > 0;
    table.AddRow({Escape(component.group), image ? Decimal(component.sigma0_px, 2) : kNoValue,
                  Decimal(factor, 2), Decimal(component.redundancy, 0),
                  component.estimated ? "estimated" : "as stated"});
  }
  return "<h3>Groups of observations</h3>\n" + table.Html();
}

std::string Photos(const AdjustmentResult& adjusted) {
  SightingsByPhoto photos;
  Count(adjusted.ties, true, &photos);
  Count(adjusted.control, false, &photos);
  HtmlTable table({"Photo", "#Ties<br/>used", "#Control<br/>used", "#RMS px",
                   "#Mean<br/>redundancy", "#Largest w"});
  for (const auto& [name, photo] : photos)
    table.AddRow({Escape(name),
                  std::to_string(photo.ties_used) + " / " + std::to_string(photo.ties),
                  std::to_string(photo.control_used) + " / " + std::to_string(photo.control),
                  Decimal(photo.RmsPx(), 2), Decimal(photo.MeanRedundancy(), 2),
                  photo.Used() > 0 ? Decimal(photo.largest_w, 1) : kNoValue});
  return "<h3>Observations by photo</h3>\n" + table.Html() +
         "<p class=\"note\">Used of all. RMS: both coordinates. Redundancy: the share of an error "
         "that shows in the observation’s own residual, 0 to 1; below 0.3 errors of some pixels "
         "stay unseen. w: residual over its standard deviation.</p>\n";
}

std::string ThreeMetres(const std::optional<Eigen::Vector3d>& value,
                        const std::optional<Eigen::Vector3d>& sigma) {
  if (!value || !sigma) return kNoValue;
  std::string text;
  for (int i = 0; i < 3; ++i)
    text += (i > 0 ? " / " : "") + Decimal((*value)[i], 2) + " ± " + Decimal((*sigma)[i], 2);
  return text;
}

std::string Gnss(const AdjustmentResult& adjusted) {
  if (adjusted.gnss.empty()) return "";
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  int used = 0;
  for (const PoseObservationResult& position : adjusted.gnss) {
    if (position.state != "used" || !position.residual_m) continue;
    squares += position.residual_m->cwiseAbs2();
    ++used;
  }
  std::string text =
      std::to_string(used) + " of " + std::to_string(adjusted.gnss.size()) + " positions are used";
  if (used > 0) {
    const Eigen::Vector3d rms = (squares / used).cwiseSqrt();
    text += "; residuals " + Decimal(rms.x(), 2) + " / " + Decimal(rms.y(), 2) + " / " +
            Decimal(rms.z(), 2) + " m (X / Y / Z, RMS)";
  }
  text = "<h3>GNSS</h3>\n<p>" + text + ".</p>\n";
  if (adjusted.gnss_strips.empty()) return text;
  HtmlTable table({"Strip", "Shift m (X / Y / Z)", "Drift m, from the middle to the end"});
  for (const GnssStripResult& strip : adjusted.gnss_strips)
    table.AddRow({strip.strip.empty() ? kNoValue : Escape(strip.strip),
                  ThreeMetres(strip.shift_m, strip.shift_sigma_m),
                  ThreeMetres(strip.drift_m, strip.drift_sigma_m)});
  return text + table.Html();
}

std::string Checks(const AdjustmentResult& adjusted) {
  if (adjusted.checks.empty())
    return "<p class=\"note\">No patches were held out to check the result: check_share in the "
           "block file does that.</p>\n";
  std::vector<double> lengths;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  int ground = 0;
  for (const CheckResult& check : adjusted.checks) {
    for (const Eigen::Vector2d& residual : check.image_residuals_px)
      lengths.push_back(residual.norm());
    if (!check.ground_residual_m) continue;
    squares += check.ground_residual_m->cwiseAbs2();
    ++ground;
  }
  std::string text = std::to_string(adjusted.checks.size()) + " held out. Their sightings lie " +
                     Decimal(adjusted.CheckRmsPx(), 2) + " px (RMS of " +
                     std::to_string(lengths.size()) + ", median " +
                     Decimal(lengths.empty() ? std::nullopt : std::optional(Median(lengths)), 2) +
                     " px) from where the block puts them";
  if (ground > 0) {
    const Eigen::Vector3d rms = (squares / ground).cwiseSqrt();
    text += "; on the ground " + Decimal(rms.x(), 2) + " / " + Decimal(rms.y(), 2) + " / " +
            Decimal(rms.z(), 2) + " m (X / Y / Z, RMS of " + std::to_string(ground) +
            " seen in two photos or more)";
  }
  return "<h3>Check patches</h3>\n<p>" + text + ".</p>\n";
}

std::string Parts(const AdjustmentResult& adjusted) {
  const bool all_said = std::all_of(adjusted.parts.begin(), adjusted.parts.end(),
                                    [](const PartResult& part) { return part.message.empty(); });
  if (adjusted.parts.size() < 2 && all_said) return "";
  HtmlTable table({"Part", "#Photos", "#Control", "Message"});
  for (const PartResult& part : adjusted.parts) {
    constexpr std::size_t kMostNames = 6;
    std::string names;
    for (std::size_t i = 0; i < std::min(part.photos.size(), kMostNames); ++i)
      names += (i > 0 ? ", " : "") + Escape(part.photos[i]);
    if (part.photos.size() > kMostNames) names += ", …";
    table.AddRow({names, std::to_string(part.photos.size()), std::to_string(part.control_points),
                  Escape(part.message)});
  }
  return "<h3>Parts of the block</h3>\n" + table.Html();
}

std::string Calibration(const AdjustmentResult& adjusted) {
  if (adjusted.calibration.empty()) return "";
  HtmlTable table({"Parameter", "#Correction", "#Sigma", "#t", ""});
  const auto number = [](const std::optional<double>& value) {
    if (!value) return std::string(kNoValue);
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", *value);
    return std::string(text);
  };
  for (const CalibrationResult& parameter : adjusted.calibration)
    table.AddRow({Escape(parameter.parameter), number(parameter.correction),
                  number(parameter.sigma), Decimal(parameter.t, 1), Escape(parameter.state)});
  return "<h3>Self-calibration</h3>\n" + table.Html();
}

// "25.003 ± 0.004": mean and standard deviation.
std::string MeanAndSpread(const std::vector<double>& values, int decimals) {
  if (values.empty()) return kNoValue;
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  if (values.size() < 2) return Decimal(mean, decimals);
  return Decimal(mean, decimals) + " ± " + Decimal(std::sqrt(squares / (n - 1)), decimals);
}

}  // namespace

std::string AdjustmentSection(const BlockRecord& block) {
  if (!block.adjusted) return "";
  const AdjustmentResult& adjusted = *block.adjusted;
  return "<section>\n<h2>Block adjustment</h2>\n" + Facts(adjusted) + Checks(adjusted) +
         Photos(adjusted) + Components(adjusted) + Gnss(adjusted) + Parts(adjusted) +
         Calibration(adjusted) + "</section>\n";
}

std::string FilmSection(const BlockRecord& block) {
  std::vector<double> column, row, difference, shear, sigma0;
  int used = 0, marks = 0;
  for (const PhotoRecord& photo : block.photos) {
    if (!photo.interior || !photo.interior->photo_from_pixel) continue;
    const FilmShape shape = ShapeOf(*photo.interior->photo_from_pixel);
    column.push_back(shape.column_um);
    row.push_back(shape.row_um);
    difference.push_back(1e6 * shape.scale_difference);
    shear.push_back(1e6 * shape.shear_rad);
    if (photo.interior->sigma0_um) sigma0.push_back(*photo.interior->sigma0_um);
    for (const MarkResult& mark : photo.interior->marks) {
      ++marks;
      used += mark.state == MarkState::kUsed;
    }
  }
  if (column.empty()) return "";
  HtmlTable table({"Of " + std::to_string(column.size()) + " photos", "#Mean ± spread", "Unit"});
  table.AddRow({"Pixel along columns", MeanAndSpread(column, 3), "µm"});
  table.AddRow({"Pixel along rows", MeanAndSpread(row, 3), "µm"});
  table.AddRow({"Columns over rows, less one", MeanAndSpread(difference, 0), "10<sup>−6</sup>"});
  table.AddRow({"Axes off square", MeanAndSpread(shear, 0), "10<sup>−6</sup> rad"});
  table.AddRow({"σ<sub>0</sub> of the marks", MeanAndSpread(sigma0, 1), "µm"});
  return "<section>\n<h2>Film</h2>\n<p class=\"facts\">" + std::to_string(used) + " of " +
         std::to_string(marks) + " marks used</p>\n" + table.Html() +
         "<p class=\"note\">Film shrinks by some 10<sup>−4</sup> and unequally along and across; "
         "a photo far from its roll’s mean was scanned or stored otherwise.</p>\n</section>\n";
}

}  // namespace orient
