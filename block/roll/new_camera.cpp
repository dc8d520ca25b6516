#include "block/roll/new_camera.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "block/roll/clicked_scale.h"
#include "block/roll/mark_layout.h"
#include "block/roll/mark_looks.h"
#include "core/base/error.h"
#include "core/geometry/transform2d.h"
#include "interior/constellation/clicked_film.h"

namespace orient::block {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

std::vector<std::string> MarkIds(const std::vector<ClickedScan>& scans) {
  std::vector<std::string> ids;
  for (const ClickedScan& scan : scans)
    for (const interior::MarkClick& click : scan.clicks) {
      const Vector2d& at = click.pixel;
      if (at.minCoeff() < 0 || at.x() > scan.raster.Width() || at.y() > scan.raster.Height())
        throw InputError(fmt::format(
            "mark {} of photo {} at {:.1f}, {:.1f} is outside the scan "
            "({} x {} pixels)",
            click.mark, scan.photo, at.x(), at.y(), scan.raster.Width(), scan.raster.Height()));
      if (std::find(ids.begin(), ids.end(), click.mark) == ids.end()) ids.push_back(click.mark);
    }
  if (ids.size() < 3)
    throw InputError(fmt::format("{} marks are clicked; a camera needs three or more", ids.size()));
  return ids;
}

size_t IndexOf(const std::string& id, const std::vector<std::string>& ids) {
  const auto found = std::find(ids.begin(), ids.end(), id);
  if (found == ids.end())
    throw InputError(fmt::format("a distance names mark {}, which is clicked on no scan", id));
  return static_cast<size_t>(found - ids.begin());
}

// How far around a click its mark is looked for. Throws InputError where the click is too vague.
double ReachOf(const interior::MarkClick& click, const std::string& photo) {
  constexpr double kLeast_px = 4, kMostSigma_px = 4;
  if (click.sigma_px > kMostSigma_px)
    throw InputError(
        fmt::format("mark {} of photo {} is clicked with a sigma of {:g} px; at most {:g} px "
                    "is allowed, so that no neighbour is mistaken for it",
                    click.mark, photo, click.sigma_px, kMostSigma_px));
  return click.exact ? 0.0 : std::max(kLeast_px, 3 * click.sigma_px);
}

// A mark's surroundings on a scan, in pixels of 10 um or coarser.
Sighting Cut(const ClickedScan& scan, const interior::MarkClick& click,
             const Matrix2d& mm_from_pixel, const NewCameraOptions& options) {
  constexpr double kFinest_mm = 0.01;
  const double pixel_mm = std::sqrt(std::abs(mm_from_pixel.determinant()));
  interior::CutOptions cut;
  cut.radius_mm = std::max(cut.radius_mm, 1.5 * options.template_radius_mm);
  cut.reach_px = ReachOf(click, scan.photo);
  cut.reduction = std::max(1.0, kFinest_mm / pixel_mm);
  cut.negative = options.polarity == Polarity::kNegative;
  Sighting sighting;
  sighting.photo = scan.photo;
  sighting.seen =
      interior::CutMark(scan.raster, click.pixel, mm_from_pixel.inverse(), cut, &sighting.window);
  sighting.place = click.pixel;
  return sighting;
}

std::vector<MarkSeen> CutMarks(const std::vector<ClickedScan>& scans,
                               const std::vector<std::string>& ids,
                               const std::vector<Matrix2d>& mm_from_pixel,
                               const NewCameraOptions& options) {
  std::vector<MarkSeen> marks;
  for (const std::string& id : ids) {
    MarkSeen mark{id, {}, 0, 0};
    for (size_t s = 0; s < scans.size(); ++s)
      if (const auto* click = interior::ClickOn(scans[s].clicks, id)) {
        mark.sightings.push_back(Cut(scans[s], *click, mm_from_pixel[s], options));
        mark.sightings.back().scan = s;
      }
    marks.push_back(std::move(mark));
  }
  return marks;
}

// Places of the clicks on every scan in millimetres, by its scale and orientation alone.
std::vector<ScanOfMarks> ClickedPlaces(const std::vector<ClickedScan>& scans,
                                       const std::vector<Matrix2d>& mm_from_pixel,
                                       const std::vector<std::string>& ids) {
  std::vector<ScanOfMarks> places;
  for (size_t s = 0; s < scans.size(); ++s) {
    places.push_back({scans[s].photo, std::vector<std::optional<Vector2d>>(ids.size())});
    for (size_t i = 0; i < ids.size(); ++i)
      if (const auto* click = interior::ClickOn(scans[s].clicks, ids[i]))
        places.back().place_mm[i] = Vector2d(mm_from_pixel[s] * click->pixel);
  }
  return places;
}

// The same for the marks as measured.
std::vector<ScanOfMarks> MeasuredPlaces(std::vector<ScanOfMarks> places,
                                        const std::vector<Matrix2d>& mm_from_pixel,
                                        const std::vector<MarkSeen>& marks) {
  for (size_t i = 0; i < marks.size(); ++i)
    for (const Sighting& sighting : marks[i].sightings)
      places[sighting.scan].place_mm[i] = Vector2d(mm_from_pixel[sighting.scan] * sighting.place);
  return places;
}

// Throws InputError that names the contradiction found by the adjustment of the places.
[[noreturn]] void ThrowContradiction(const LayoutContradiction& found,
                                     const std::vector<ScanOfMarks>& places,
                                     const std::vector<std::string>& ids,
                                     const NewCameraOptions& options) {
  if (found.distance) {
    const StatedDistance& d = options.distances[*found.distance];
    throw InputError(fmt::format(
        "the distance from {} to {}, {:.3f} mm, contradicts the scans and the other distances by "
        "{:.2f} mm: mistyped, or marks confused?",
        d.from, d.to, d.distance_mm, found.off_mm));
  }
  throw InputError(fmt::format(
      "mark {} of photo {} lies {:.1f} mm from where the other marks, scans and distances put it: "
      "are two marks confused, or a distance mistyped?",
      ids[found.mark.value()], places[found.scan.value()].name, found.off_mm));
}

// `clicks_mm`: uncertainty of the places as clicks; 0 for measured places.
MarkLayout LayoutOf(const std::vector<ScanOfMarks>& places, const std::vector<std::string>& ids,
                    const NewCameraOptions& options, double clicks_mm) {
  // Desktop scans and prints have two scales that differ by up to 1.4 % or more.
  constexpr double kPhotogrammetric_mm = 0.02, kDesktop_mm = 0.5;
  std::vector<MarkDistance> distances;
  for (const StatedDistance& d : options.distances)
    distances.push_back({IndexOf(d.from, ids), IndexOf(d.to, ids), d.distance_mm, d.sigma_mm});
  // Errors that a scanner makes alike in all scans do not average out with their number.
  const double scanner_mm = (options.photogrammetric ? kPhotogrammetric_mm : kDesktop_mm) *
                            std::sqrt(static_cast<double>(places.size()));
  const auto layout = EstimateLayout(places, distances, std::hypot(scanner_mm, clicks_mm));
  if (!layout)
    throw InputError(
        "the clicked marks do not give a layout: every scan needs two marks that are "
        "also clicked on another one");
  if (layout->contradiction) ThrowContradiction(*layout->contradiction, places, ids, options);
  return *layout;
}

// mm_from_pixel of every scan, rotated to the marks' layout.
std::vector<Matrix2d> Upright(const std::vector<ScanOfMarks>& places, const MarkLayout& layout,
                              const std::vector<Matrix2d>& mm_from_pixel) {
  std::vector<Matrix2d> upright;
  for (size_t s = 0; s < places.size(); ++s) {
    std::vector<PointPair2d> pairs;
    for (size_t i = 0; i < layout.position_mm.size(); ++i)
      if (places[s].place_mm[i]) pairs.push_back({*places[s].place_mm[i], layout.position_mm[i]});
    const auto fit = FitSimilarity(pairs, false);
    upright.emplace_back(fit ? Matrix2d(fit->transform.A * mm_from_pixel[s]) : mm_from_pixel[s]);
  }
  return upright;
}

Vector2d StatedFor(const std::string& id, const std::vector<StatedPosition>& positions) {
  const auto found = std::find_if(positions.begin(), positions.end(),
                                  [&](const auto& stated) { return stated.mark == id; });
  if (found == positions.end())
    throw InputError(fmt::format("mark {} is clicked, but has no stated position", id));
  return found->position_mm;
}

MarkDrawing DrawingOf(const Look& look) {
  if (!look.elements.empty()) return {look.elements, look.background, std::nullopt};
  return {{}, MarkBackground::kDark, MarkImage{"", look.pixel_mm, look.centre_px}};
}

// To a ten thousandth of a millimetre, so that the file can be read.
Vector2d Rounded(const Vector2d& mm) { return (mm * 1e4).array().round() / 1e4; }

// Twice the marks' largest distances from the axes through the origin, to a tenth of a millimetre.
Vector2d ExtentOf(const std::vector<Fiducial>& fiducials) {
  Vector2d half = Vector2d::Zero();
  for (const Fiducial& f : fiducials) half = half.cwiseMax(f.position_mm.cwiseAbs());
  return (20 * half).array().round() / 10;
}

// The camera file's marks and drawings.
void AddMarks(const std::vector<MarkSeen>& marks, const std::vector<Look>& looks,
              const MarkLayout& layout, NewCamera* made) {
  for (const Look& look : looks) {
    made->file.marks[look.name] = DrawingOf(look);
    if (look.elements.empty()) made->pictures[look.name] = look.picture;
  }
  for (size_t i = 0; i < marks.size(); ++i) {
    const MarkSeen& seen = marks[i];
    Fiducial fiducial{seen.id, Rounded(layout.position_mm[i]), looks[seen.look].name, std::nullopt};
    if (!layout.sigma_mm.empty()) fiducial.sigma_mm = Rounded(layout.sigma_mm[i]);
    made->file.fiducials.push_back(fiducial);
    const Sighting& first = seen.sightings.front();
    made->marks.push_back({seen.id, fiducial.mark, seen.correlation,
                           static_cast<int>(seen.sightings.size()),
                           first.scan == 0 ? std::optional(first.place) : std::nullopt});
  }
}

// Throws InputError for two marks at one place, or all on one line.
void RequireApart(const std::vector<Vector2d>& positions, const std::vector<std::string>& ids) {
  constexpr double kLeast_mm = 1;
  double widest = 0;
  for (size_t i = 0; i < ids.size(); ++i)
    for (size_t j = i + 1; j < ids.size(); ++j) {
      const Vector2d side = positions[j] - positions[i];
      if (side.norm() < kLeast_mm)
        throw InputError(fmt::format("marks {} and {} lie at one place", ids[i], ids[j]));
      for (const Vector2d& other : positions) {
        const Vector2d to = other - positions[i];
        widest = std::max(widest, std::abs(side.x() * to.y() - side.y() * to.x()) / side.norm());
      }
    }
  if (widest < 5 * kLeast_mm) throw InputError("all marks lie on one line; click others, too");
}

}  // namespace

NewCamera MakeCamera(const std::vector<ClickedScan>& scans, const NewCameraOptions& options) {
  constexpr double kClick_px = 2;
  const std::vector<std::string> ids = MarkIds(scans);
  std::vector<Matrix2d> mm_from_pixel;
  NewCamera made;
  for (const ClickedScan& scan : scans) {
    const ClickedScale scale = ScaleOf(scan, options);
    if (mm_from_pixel.empty()) made.scale_from = scale.from;
    mm_from_pixel.push_back(scale.mm_from_pixel);
  }
  made.pixel_size_um = 1e3 * std::sqrt(std::abs(mm_from_pixel.front().determinant()));
  // Errors in the input are found before the fit, which takes a while.
  const auto clicked = ClickedPlaces(scans, mm_from_pixel, ids);
  const bool stated = !options.positions.empty();
  MarkLayout layout;
  for (const std::string& id : ids)
    if (stated) layout.position_mm.push_back(StatedFor(id, options.positions));
  if (!stated) layout = LayoutOf(clicked, ids, options, 1e-3 * kClick_px * made.pixel_size_um);
  RequireApart(layout.position_mm, ids);
  const std::vector<Matrix2d> upright =
      stated ? mm_from_pixel : Upright(clicked, layout, mm_from_pixel);

  std::vector<MarkSeen> marks = CutMarks(scans, ids, upright, options);
  const std::vector<Look> looks = FindLooks(options.template_radius_mm, &marks);
  if (!stated) layout = LayoutOf(MeasuredPlaces(clicked, mm_from_pixel, marks), ids, options, 0);
  made.file.camera.name = options.name;
  made.file.camera.kind = CameraKind::kFilm;
  made.file.camera.principal_distance_mm = options.principal_distance_mm;
  AddMarks(marks, looks, layout, &made);
  made.file.camera.frame_mm = options.frame_mm ? *options.frame_mm : ExtentOf(made.file.fiducials);
  made.distance_residual_mm = layout.distance_residual_mm;
  made.origin_known = layout.origin_known;
  made.scale_difference = layout.scale_difference;
  made.first_mm_from_pixel = upright.front();
  return made;
}

}  // namespace orient::block
