#include "tools/report/block_map.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "tools/report/approximation_moves.h"
#include "tools/report/html_text.h"
#include "tools/report/map_sheet.h"
#include "tools/report/svg_shapes.h"

namespace orient {
namespace {

using Eigen::Vector2d;
using Box = Eigen::AlignedBox2d;

constexpr double kLabelSize = 12;  // of the CSS class; a character is about this part as wide:
constexpr double kLabelAdvance = 0.58 * kLabelSize;

// No projected CRS has larger coordinates; a damaged result must not blow up the map.
constexpr double kLargestCoordinate_m = 1e8;

void Extend(const Eigen::Vector3d& point_m, Box* box) {
  if (point_m.head<2>().cwiseAbs().maxCoeff() < kLargestCoordinate_m)
    box->extend(point_m.head<2>().eval());
}

void ExtendByPhoto(const PhotoRecord& photo, const PhotoVerdict& verdict, Box* box) {
  if (photo.exterior)
    for (const Eigen::Vector3d& corner : photo.exterior->footprint_m) Extend(corner, box);
  if (verdict.pose) Extend(verdict.pose->position_m, box);
}

// Extent of the photos that did not fail, or of the failed ones if there are no others.
Box GroundExtent(const BlockRecord& block, const BlockVerdict& verdict) {
  Box box;
  for (size_t i = 0; i < block.photos.size(); ++i)
    if (verdict.photos[i].status != Status::kFailed)
      ExtendByPhoto(block.photos[i], verdict.photos[i], &box);
  for (size_t i = 0; i < block.photos.size() && box.isEmpty(); ++i)
    ExtendByPhoto(block.photos[i], verdict.photos[i], &box);
  return box;
}

// "0.19 m"; empty where it is not known.
std::string Ce90Text(const PhotoVerdict& verdict) {
  if (!verdict.ce90) return "";
  const double ce90_m = verdict.ce90->median_m;
  return Decimal(ce90_m, DecimalsForSigma(ce90_m)) + kThinSpace + "m";
}

// `corners_only`: of a ring with equally many points on each of four sides, if there are so many
// footprints that relief along their sides cannot be seen. Omits the last point (the first again).
std::vector<Vector2d> RingOf(const std::vector<Eigen::Vector3d>& ring, const Sheet& sheet,
                             bool corners_only) {
  std::vector<Vector2d> corners;
  if (ring.size() < 3) return corners;
  const size_t step = corners_only ? std::max<size_t>(1, (ring.size() - 1) / 4) : 1;
  for (size_t i = 0; i + 1 < ring.size(); i += step)
    corners.emplace_back(sheet.At(ring[i].head<2>()));
  return corners;
}

std::string Footprint(const std::vector<Vector2d>& ring, const PhotoVerdict& verdict,
                      const std::string& name) {
  if (ring.empty()) return "";
  std::vector<std::string> points;
  points.reserve(ring.size());
  for (const Vector2d& at : ring) points.push_back(SvgNumber(at.x()) + "," + SvgNumber(at.y()));
  return fmt::format(
      "<polygon class=\"fp fp-{0}\" points=\"{1}\"><title>{2}: {0}{3}</title></polygon>\n",
      Name(verdict.status), Joined(points, " "), Escape(name),
      verdict.ce90 ? ", CE90 " + Ce90Text(verdict) : "");
}

// For each patch, its best outcome in any photo.
using Outcomes = std::map<std::int64_t, const PatchResult*>;

Outcomes BestOutcomes(const BlockRecord& block) {
  const auto rank = [](PatchState state) {
    return state == PatchState::kMatched    ? 0
           : state == PatchState::kRejected ? 1
           : state == PatchState::kNotFound ? 2
                                            : 3;
  };
  Outcomes best;
  for (const PhotoRecord& photo : block.photos) {
    if (!photo.exterior) continue;
    for (const PatchResult& patch : photo.exterior->patches) {
      if (!patch.ground_m) continue;
      const PatchResult*& known = best[patch.id];
      if (known == nullptr || rank(patch.state) < rank(known->state)) known = &patch;
    }
  }
  return best;
}

constexpr size_t kManyPhotos = 1000;

// More dots than that cannot be told apart, and make the page slow.
constexpr size_t kMostDots = 20000;

// Every how many-th of them is drawn.
size_t DotStep(size_t count) { return count / (kMostDots + 1) + 1; }

// Smaller where there are many, so that the map under them can still be seen.
double DotSize(size_t count, const Sheet& sheet) {
  constexpr double kSmallest = 1.2, kLargest = 5, kPartOfSpacing = 0.3;
  const double spacing = std::sqrt(sheet.width * sheet.height / static_cast<double>(count + 1));
  return std::clamp(kPartOfSpacing * spacing, kSmallest, kLargest);
}

std::string DotsOfSize(double dot, const std::string& shapes) {
  return fmt::format("<g style=\"--dot:{}px\">{}</g>\n", SvgNumber(dot), shapes);
}

std::string Patches(const Outcomes& outcomes, const Sheet& sheet) {
  const double dot = DotSize(outcomes.size(), sheet);
  SvgPath matched, rejected, not_found, not_visible;
  const size_t step = DotStep(outcomes.size());
  size_t number = 0;
  for (const auto& [id, patch] : outcomes) {
    if (number++ % step != 0) continue;
    const Vector2d xy = patch->ground_m->head<2>();
    if (!sheet.ground.contains(xy)) continue;
    const Vector2d at = sheet.At(xy);
    if (patch->state == PatchState::kMatched) matched.AddDot(at);
    if (patch->state == PatchState::kRejected) rejected.AddCross(at, 0.52 * dot);
    if (patch->state == PatchState::kNotFound) not_found.AddDot(at);
    if (patch->state == PatchState::kNotVisible) not_visible.AddDot(at);
  }
  return DotsOfSize(dot, not_visible.Element("p-not_visible") + not_found.Element("p-not_found") +
                             rejected.Element("p-rejected") + matched.Element("p-matched"));
}

std::string Ties(const BlockRecord& block, const Sheet& sheet) {
  if (!block.adjusted) return "";
  const std::vector<PointResult>& ties = block.adjusted->ties;
  SvgPath dots;
  const size_t step = DotStep(ties.size());
  for (size_t i = 0; i < ties.size(); i += step) {
    const PointResult& tie = ties[i];
    if (!tie.ground_m) continue;
    const Vector2d xy = tie.ground_m->head<2>();
    if (sheet.ground.contains(xy)) dots.AddDot(sheet.At(xy));
  }
  return DotsOfSize(DotSize(ties.size(), sheet), dots.Element("p-tie"));
}

// "photos share '3324c_2015_'" : the part of all names up to a separator, left out in the map.
size_t SharedPrefix(const BlockRecord& block) {
  if (block.photos.size() < 2) return 0;
  const std::string& first = block.photos.front().name;
  size_t shared = first.size();
  for (const PhotoRecord& photo : block.photos) {
    const auto end = std::mismatch(first.begin(), first.begin() + static_cast<long>(shared),
                                   photo.name.begin(), photo.name.end());
    shared = static_cast<size_t>(end.first - first.begin());
  }
  const size_t separator = first.substr(0, shared).find_last_of("_- .");
  constexpr size_t kWorthwhile = 4;
  return separator == std::string::npos || separator + 1 < kWorthwhile ? 0 : separator + 1;
}

std::optional<Vector2d> LabelPlace(const PhotoRecord& photo, const PhotoVerdict& verdict) {
  if (photo.exterior && photo.exterior->footprint_m.size() >= 3) {
    Box box;
    for (const Eigen::Vector3d& corner : photo.exterior->footprint_m)
      box.extend(corner.head<2>().eval());
    return box.center();
  }
  if (verdict.pose) return verdict.pose->position_m.head<2>();
  return std::nullopt;
}

struct Labels {
  std::string svg;
  int left_out = 0;
  std::vector<std::string> nowhere, outside;  // photos
};

// Places names such that they do not overlap; some are shifted, some left out.
class LabelLayout {
 public:
  explicit LabelLayout(const Sheet& sheet) : sheet_(sheet) {}

  std::optional<Vector2d> Place(const Vector2d& wanted, double width) {
    for (const double shift : {0.0, -1.3, 1.3}) {
      const Vector2d at = wanted + Vector2d(0, shift * kLabelSize);
      const Vector2d half(0.5 * width + 2, 0.55 * kLabelSize);
      const Box box(Vector2d(at - half), Vector2d(at + half));
      const Box page(Vector2d(0, 0), Vector2d(sheet_.width, sheet_.height));
      const auto overlaps = [&](const Box& other) { return box.intersects(other); };
      if (!page.contains(box) || std::any_of(taken_.begin(), taken_.end(), overlaps)) continue;
      taken_.push_back(box);
      return at;
    }
    return std::nullopt;
  }

 private:
  const Sheet& sheet_;
  std::vector<Box> taken_;
};

size_t Characters(const std::string& text) {
  return static_cast<size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

Labels PhotoLabels(const BlockRecord& block, const BlockVerdict& verdict, const PhotoLinks& links,
                   const Sheet& sheet) {
  const size_t prefix = SharedPrefix(block);
  LabelLayout layout(sheet);
  Labels labels;
  for (size_t i = 0; i < block.photos.size(); ++i) {
    const PhotoRecord& photo = block.photos[i];
    const auto place = LabelPlace(photo, verdict.photos[i]);
    if (!place) {
      labels.nowhere.push_back(photo.name);
      continue;
    }
    if (!sheet.ground.contains(*place)) {
      labels.outside.push_back(photo.name);
      continue;
    }
    const std::string name = (prefix > 0 ? "…" : "") + ValidText(photo.name.substr(prefix));
    const std::string ce90 = Ce90Text(verdict.photos[i]);
    const auto fits = [&](const std::string& shown) {
      const double width = kLabelAdvance * static_cast<double>(Characters(shown));
      return layout.Place(sheet.At(*place), width);
    };
    std::string text = name;
    if (!ce90.empty()) text.append(" · ").append(ce90);
    auto at = fits(text);
    if (!at && !ce90.empty()) at = fits(text = name);
    if (!at) {
      ++labels.left_out;
      continue;
    }
    labels.svg +=
        fmt::format("<a href=\"{}\">{}</a>", Escape(links.To(block, i)),
                    SvgText("label", *at + Vector2d(0, 0.35 * kLabelSize), text, kCentred));
  }
  return labels;
}

// Photos that deserve attention are drawn on top.
std::string PhotoShapes(const BlockRecord& block, const BlockVerdict& verdict, const Sheet& sheet) {
  const bool many = block.photos.size() > kManyPhotos;
  std::string svg;
  SvgPath centres;
  for (const Status status : {Status::kOk, Status::kWeak, Status::kFailed}) {
    SvgPath together;  // of many photos: no text for each
    for (size_t i = 0; i < block.photos.size(); ++i) {
      if (verdict.photos[i].status != status) continue;
      const PhotoRecord& photo = block.photos[i];
      if (photo.exterior) {
        const auto ring = RingOf(photo.exterior->footprint_m, sheet, many);
        if (many)
          together.AddRing(ring);
        else
          svg += Footprint(ring, verdict.photos[i], photo.name);
      }
      if (many || !verdict.photos[i].pose) continue;
      const Vector2d at = sheet.At(verdict.photos[i].pose->position_m.head<2>());
      centres.AddLine(at - Vector2d(5, 0), at + Vector2d(5, 0));
      centres.AddLine(at - Vector2d(0, 5), at + Vector2d(0, 5));
    }
    svg += together.Element(fmt::format("fp fp-{}", Name(status)));
  }
  return svg + centres.Element("centre");
}

// Arrows from approximations to poses, enlarged until all but the longest can be seen well.
struct MoveArrows {
  std::string svg;
  double times = 0;  // 0: none
};

MoveArrows ArrowsOf(const std::vector<ApproximationMove>& moves, const Sheet& sheet) {
  constexpr double kLong = 60, kShortest = 1;  // SVG units
  constexpr double kShare = 0.9;               // of the moves
  if (moves.empty() || moves.size() > kManyPhotos) return {};
  std::vector<double> lengths_m;
  for (const ApproximationMove& move : moves)
    lengths_m.push_back((move.to_m - move.from_m).head<2>().norm());
  std::sort(lengths_m.begin(), lengths_m.end());
  const double long_m = lengths_m[static_cast<size_t>(kShare * static_cast<double>(moves.size()))];
  if (!(long_m > 0)) return {};
  MoveArrows arrows;
  arrows.times = std::max(1.0, RoundNumberBelow(kLong / (long_m * sheet.scale)));
  SvgPath path;
  for (const ApproximationMove& move : moves) {
    const Vector2d to = move.to_m.head<2>();
    const Vector2d from = to + arrows.times * (move.from_m.head<2>() - to);
    if ((sheet.At(from) - sheet.At(to)).norm() > kShortest)
      path.AddArrow(sheet.At(from), sheet.At(to));
  }
  arrows.svg = path.Element("halo") + path.Element("move");
  return arrows;
}

std::string MovesNote(const std::vector<ApproximationMove>& moves) {
  if (moves.empty()) return "";
  const CommonMove common = CommonMoveOf(moves);
  const auto metres = [](const Eigen::Vector3d& v) {
    return fmt::format("X {} m, Y {} m, Z {} m", Decimal(v.x(), 2), Decimal(v.y(), 2),
                       Decimal(v.z(), 2));
  };
  return fmt::format(
      "From the approximations the {}{} moved by {} in the mean, and by {} (RMS) about it. ",
      common.photos == 1 ? "one projection centre"
                         : fmt::format("{} projection centres", common.photos),
      common.photos == std::ssize(moves) ? ""
      : common.photos == 1               ? " that was known best"
                                         : " that were known best",
      metres(common.mean_m), metres(common.rms_about_mean_m));
}

std::string NamesNote(const char* before, std::vector<std::string> names) {
  constexpr size_t kMost = 12;
  if (names.empty()) return "";
  const size_t shown = std::min(names.size(), kMost), more = names.size() - shown;
  names.resize(shown);
  return fmt::format("{}: {}{}. ", before, Joined(names, ", "),
                     more > 0 ? fmt::format(" and {} more", more) : "");
}

// `patches`: how many there are.
std::string Notes(const BlockRecord& block, size_t patches, const Labels& labels) {
  std::string text;
  if (const size_t prefix = SharedPrefix(block); prefix > 0)
    text += fmt::format("Names are without their common beginning “{}”. ",
                        block.photos.front().name.substr(0, prefix));
  if (block.photos.size() > kManyPhotos)
    text += "Projection centres of so many photos are left out. ";
  if (DotStep(patches) > 1)
    text += fmt::format("Of {} patches every {}th is drawn. ", patches, DotStep(patches));
  const size_t ties = block.adjusted ? block.adjusted->ties.size() : 0;
  if (DotStep(ties) > 1)
    text += fmt::format("Of {} ties every {}th is drawn. ", ties, DotStep(ties));
  if (labels.left_out > 0)
    text += fmt::format(
        "{} left out where they would overlap. ",
        labels.left_out == 1 ? "One name is" : fmt::format("{} names are", labels.left_out));
  return text + NamesNote("Not in the map, without a pose", labels.nowhere) +
         NamesNote("Outside the map", labels.outside);
}

}  // namespace

Markup BlockMap(const BlockRecord& block, const BlockVerdict& verdict, const PhotoLinks& links) {
  const Box extent = GroundExtent(block, verdict);
  if (extent.isEmpty()) return Fill("map.html#empty");
  const Sheet sheet = MakeSheet(extent);
  const Labels labels = PhotoLabels(block, verdict, links, sheet);
  const Outcomes outcomes = BestOutcomes(block);
  const auto moves = ApproximationMoves(block, verdict);
  const MoveArrows arrows = ArrowsOf(moves, sheet);
  const Markup key_of_moves =
      arrows.times == 0 ? Markup()
                        : Fill("map.html#key_of_moves", {{"times", Grouped(arrows.times, 0)}});
  return Fill("map.html",
              {{"page_width", SvgNumber(kSheetPageWidth)},
               {"page_height", SvgNumber(sheet.height + kSheetTop + kSheetBottom)},
               {"left", SvgNumber(kSheetLeft)},
               {"top", SvgNumber(kSheetTop)},
               {"width", SvgNumber(sheet.width)},
               {"height", SvgNumber(sheet.height)},
               {"grid", Markup(SheetGrid(sheet))},
               {"shapes", Markup(PhotoShapes(block, verdict, sheet) + Ties(block, sheet) +
                                 Patches(outcomes, sheet) + arrows.svg + labels.svg +
                                 ScaleBar(sheet) + NorthArrow(sheet))},
               {"key_of_moves", key_of_moves},
               {"key_of_ties", block.adjusted ? Fill("map.html#key_of_ties") : Markup()},
               {"key_of_ce90", verdict.median_ce90_m ? Fill("map.html#key_of_ce90") : Markup()},
               {"crs", block.crs ? " in " + block.crs->Name() : ""},
               {"notes", MovesNote(moves) + Notes(block, outcomes.size(), labels)}});
}

}  // namespace orient
