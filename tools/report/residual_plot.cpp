#include "tools/report/residual_plot.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "tools/report/html_text.h"
#include "tools/report/svg_shapes.h"

namespace orient {
namespace {

using Eigen::Vector2d;

constexpr double kSide = 520;         // the frame's longer side in the SVG's units
constexpr double kMargin = 26;        // for tick labels
constexpr double kUsualArrow = 36;    // most residuals' arrows are no longer
constexpr double kLongestArrow = 64;  // longer ones are cut
constexpr double kLegendHeight = 30;

struct Frame {
  Vector2d origin_px = Vector2d::Zero();
  Vector2d size_px = Vector2d::Zero();
  double scale = 1;         // units per px
  double exaggeration = 0;  // of residuals beyond the frame's own scale; 0: no residuals

  Vector2d At(const Vector2d& pixel) const { return scale * (pixel - origin_px); }
  Vector2d Arrow(const Vector2d& residual_px) const { return scale * exaggeration * residual_px; }
};

std::vector<double> ResidualLengths(const ExteriorResult& result, PatchState state) {
  std::vector<double> lengths;
  for (const PatchResult& patch : result.patches)
    if (patch.state == state && patch.pixel && patch.residual_px && patch.residual_px->norm() > 0)
      lengths.push_back(patch.residual_px->norm());
  return lengths;
}

// Nine tenths of the matched patches' residuals (of the rejected ones' if none matched) get arrows
// of the usual length at most; the others say more about themselves than about the frame.
double Exaggeration(const ExteriorResult& result, double scale) {
  std::vector<double> lengths = ResidualLengths(result, PatchState::kMatched);
  if (lengths.empty()) lengths = ResidualLengths(result, PatchState::kRejected);
  if (lengths.empty()) return 0;
  const auto usual = lengths.begin() + static_cast<long>(9 * lengths.size() / 10);
  std::nth_element(lengths.begin(), usual, lengths.end());
  return RoundNumberBelow(kUsualArrow / (*usual * scale));
}

std::optional<Frame> MakeFrame(const ExteriorResult& result, int width, int height) {
  Eigen::AlignedBox2d box;
  if (width > 0 && height > 0)
    box = Eigen::AlignedBox2d(Vector2d(0, 0), Vector2d(width, height));
  else
    for (const PatchResult& patch : result.patches)
      if (patch.pixel) box.extend(*patch.pixel);
  if (box.isEmpty() || !(box.sizes().minCoeff() > 0)) return std::nullopt;
  Frame frame{box.min(), box.sizes(), kSide / box.sizes().maxCoeff(), 0};
  frame.exaggeration = Exaggeration(result, frame.scale);
  return frame;
}

struct Arrows {
  SvgPath matched, matched_start, matched_cut, rejected, rejected_start, rejected_cut, not_found;
  int cut_count = 0;
};

void AddResidual(const Frame& frame, const PatchResult& patch, Arrows* arrows) {
  const bool matched = patch.state == PatchState::kMatched;
  const Vector2d from = frame.At(*patch.pixel);
  if (matched)
    arrows->matched_start.AddDot(from);
  else
    arrows->rejected_start.AddCross(from, 2.2);
  if (!patch.residual_px) return;
  Vector2d arrow = frame.Arrow(*patch.residual_px);
  if (const double length = arrow.norm(); length > kLongestArrow) {
    arrow *= kLongestArrow / length;
    (matched ? arrows->matched_cut : arrows->rejected_cut).AddArrow(from, from + arrow);
    ++arrows->cut_count;
  } else {
    (matched ? arrows->matched : arrows->rejected).AddArrow(from, from + arrow);
  }
}

Arrows MakeArrows(const ExteriorResult& result, const Frame& frame) {
  Arrows arrows;
  for (const PatchResult& patch : result.patches) {
    const bool measured =
        patch.state == PatchState::kMatched || patch.state == PatchState::kRejected;
    if (measured && patch.pixel)
      AddResidual(frame, patch, &arrows);
    else if (patch.state == PatchState::kNotFound && patch.predicted)
      arrows.not_found.AddDot(frame.At(*patch.predicted));
  }
  return arrows;
}

std::string Axes(const Frame& frame) {
  SvgPath grid;
  std::string labels;
  const double step = RoundNumberBelow(frame.size_px.maxCoeff() / 3);
  const Vector2d size = frame.scale * frame.size_px;
  for (double col = step; col < frame.size_px.x(); col += step) {
    const double x = frame.scale * col;
    grid.AddLine({x, 0}, {x, size.y()});
    labels += SvgText("tick", {x, -7}, Grouped(frame.origin_px.x() + col, 0), kCentred);
  }
  for (double row = step; row < frame.size_px.y(); row += step) {
    const double y = frame.scale * row;
    grid.AddLine({0, y}, {size.x(), y});
    labels += fmt::format("<g transform=\"translate(-7 {}) rotate(-90)\">{}</g>", SvgNumber(y),
                          SvgText("tick", {0, 0}, Grouped(frame.origin_px.y() + row, 0), kCentred));
  }
  return grid.Element("grid") + labels;
}

// An arrow of a round residual under the frame, so that lengths can be read.
std::string Legend(const Frame& frame, double y) {
  if (frame.exaggeration == 0) return "";
  const double residual_px = RoundNumberBelow(60 / (frame.scale * frame.exaggeration));
  const double length = frame.Arrow({residual_px, 0}).x();
  SvgPath arrow;
  arrow.AddArrow({0, y}, {length, y});
  return arrow.Element("r-matched") +
         SvgText("tick", {length + 8, y + 4}, SvgNumber(residual_px, 6) + kThinSpace + "px");
}

std::string Shapes(const Frame& frame, const Arrows& arrows) {
  return arrows.not_found.Element("p-not_found") + arrows.rejected_cut.Element("r-rejected cut") +
         arrows.matched_cut.Element("r-matched cut") + arrows.rejected.Element("r-rejected") +
         arrows.rejected_start.Element("p-rejected") + arrows.matched.Element("r-matched") +
         arrows.matched_start.Element("r-start") +
         Legend(frame, frame.scale * frame.size_px.y() + kMargin);
}

std::string What(const Frame& frame) {
  if (frame.exaggeration == 0) return "Patches over the frame; no residuals are known.";
  return fmt::format("Residuals (measured minus computed) at {} times the frame’s scale.",
                     Grouped(frame.exaggeration, frame.exaggeration < 1 ? 3 : 0));
}

std::string Cut(const Arrows& arrows) {
  if (arrows.cut_count == 0) return "";
  return fmt::format("Dashed: longer than can be shown ({}).", arrows.cut_count);
}

}  // namespace

Markup ResidualPlot(const ExteriorResult& result, int width, int height) {
  const auto frame = MakeFrame(result, width, height);
  if (!frame || result.patches.empty()) return {};
  const Arrows arrows = MakeArrows(result, *frame);
  const Vector2d size = frame->scale * frame->size_px;
  // Arrows may leave the frame a little: the drawing has a margin around it.
  return Fill("residuals.html", {{"page_width", SvgNumber(size.x() + 2 * kMargin)},
                                 {"page_height", SvgNumber(size.y() + 2 * kMargin + kLegendHeight)},
                                 {"margin", SvgNumber(kMargin)},
                                 {"width", SvgNumber(size.x())},
                                 {"height", SvgNumber(size.y())},
                                 {"grid", Markup(Axes(*frame))},
                                 {"shapes", Markup(Shapes(*frame, arrows))},
                                 {"what", What(*frame)},
                                 {"cut", Cut(arrows)}});
}

}  // namespace orient
