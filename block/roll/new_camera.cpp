#include "block/roll/new_camera.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "block/roll/mark_looks.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/geometry/transform2d.h"

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

const interior::MarkClick* ClickOn(const ClickedScan& scan, const std::string& mark) {
  const auto found = std::find_if(scan.clicks.begin(), scan.clicks.end(),
                                  [&](const auto& click) { return click.mark == mark; });
  return found == scan.clicks.end() ? nullptr : &*found;
}

// The linear part of photo mm from the scan's pixels, as the stated positions have it.
Matrix2d ByPositions(const ClickedScan& scan, const std::vector<StatedPosition>& positions) {
  constexpr double kLargest_mm = 3;  // a print curls by millimetres
  std::vector<PointPair2d> pairs;
  std::vector<std::string> names;
  for (const StatedPosition& stated : positions)
    if (const auto* click = ClickOn(scan, stated.mark)) {
      pairs.push_back({click->pixel, stated.position_mm});
      names.push_back(stated.mark);
    }
  if (pairs.size() < 3)
    throw InputError(
        fmt::format("photo {} has {} clicked marks with stated positions; three are "
                    "needed on every scan",
                    scan.photo, pairs.size()));
  const auto straight = FitSimilarity(pairs, false), mirrored = FitSimilarity(pairs, true);
  if (!straight || !mirrored)
    throw InputError(fmt::format("photo {}: the clicked marks lie at one place", scan.photo));
  const TransformFit& fit = straight->sigma0 <= mirrored->sigma0 ? *straight : *mirrored;
  size_t worst = 0;
  for (size_t i = 0; i < pairs.size(); ++i)
    if (fit.residuals[i].norm() > fit.residuals[worst].norm()) worst = i;
  if (fit.residuals[worst].norm() > kLargest_mm)
    throw InputError(
        fmt::format("photo {}: the clicks contradict the stated positions; mark {} is "
                    "{:.1f} mm off. Are two marks confused?",
                    scan.photo, names[worst], fit.residuals[worst].norm()));
  return fit.transform.A;
}

// Millimetres a pixel, as the stated distances have it.
std::optional<double> PixelByDistances(const ClickedScan& scan,
                                       const std::vector<StatedDistance>& distances) {
  constexpr double kLargestDeviation = 0.05;  // prints shrink by up to 2.5 % in one direction
  std::vector<double> sizes;
  std::vector<const StatedDistance*> stated;
  for (const StatedDistance& d : distances) {
    const auto *from = ClickOn(scan, d.from), *to = ClickOn(scan, d.to);
    if (from == nullptr || to == nullptr) continue;
    const double length_px = (to->pixel - from->pixel).norm();
    if (!(length_px > 1))
      throw InputError(fmt::format("photo {}: marks {} and {} are clicked at one place", scan.photo,
                                   d.from, d.to));
    sizes.push_back(d.distance_mm / length_px);
    stated.push_back(&d);
  }
  if (sizes.empty()) return std::nullopt;
  const double median = Median(sizes);
  for (size_t i = 0; i < sizes.size(); ++i)
    if (std::abs(sizes[i] / median - 1) > kLargestDeviation)
      throw InputError(fmt::format(
          "photo {}: the distance from {} to {}, {:.3f} mm, contradicts the others by {:.0f} %: "
          "mistyped, or marks confused?",
          scan.photo, stated[i]->from, stated[i]->to, stated[i]->distance_mm,
          100 * std::abs(sizes[i] / median - 1)));
  return median;
}

Matrix2d MmFromPixel(const ClickedScan& scan, const NewCameraOptions& options) {
  if (!options.positions.empty()) return ByPositions(scan, options.positions);
  std::optional<double> pixel_mm = PixelByDistances(scan, options.distances);
  if (!pixel_mm && options.pixel_size_um) pixel_mm = *options.pixel_size_um / 1000;
  if (const auto dpi = scan.raster.DpiTag(); !pixel_mm && dpi) pixel_mm = 25.4 / *dpi;
  if (!pixel_mm)
    throw InputError(scan.photo +
                     ": nothing tells the scale; give --positions, --distances or "
                     "--pixel-size-um");
  return *pixel_mm * PhotoFromPixelAxes(options.orientation);
}

// A mark's surroundings on all scans that show it.
std::vector<Sighting> Cut(const std::vector<ClickedScan>& scans, const std::string& id,
                          const std::vector<Matrix2d>& pixel_from_mm, Polarity polarity) {
  std::vector<Sighting> sightings;
  for (size_t s = 0; s < scans.size(); ++s) {
    for (const interior::MarkClick& click : scans[s].clicks) {
      if (click.mark != id) continue;
      const double pixels_per_mm = std::sqrt(std::abs(pixel_from_mm[s].determinant()));
      Sighting sighting;
      sighting.scan = s;
      sighting.place = click.pixel;
      sighting.seen.reach_px = click.exact ? 0.0 : std::max(4.0, 3 * click.sigma_px);
      const int half = static_cast<int>(std::ceil(
          1.1 * interior::kLargestFittedRadius_mm * pixels_per_mm + sighting.seen.reach_px + 2));
      const int col = static_cast<int>(std::floor(click.pixel.x())) - half;
      const int row = static_cast<int>(std::floor(click.pixel.y())) - half;
      const ImageWindow window = scans[s].raster.ReadGrey({col, row, 2 * half + 1, 2 * half + 1});
      sighting.seen.image = window.image;
      if (polarity == Polarity::kNegative)
        for (float& value : sighting.seen.image.values) value = -value;
      sighting.origin = window.origin;
      sighting.seen.near = click.pixel - window.origin;
      sighting.seen.pixel_from_mm = pixel_from_mm[s];
      sightings.push_back(std::move(sighting));
    }
  }
  return sightings;
}

// Places of the marks on every scan in millimetres, by its scale and orientation alone.
std::vector<ScanOfMarks> PlacesOf(const std::vector<ClickedScan>& scans,
                                  const std::vector<Matrix2d>& mm_from_pixel,
                                  const std::vector<MarkSeen>& marks) {
  std::vector<ScanOfMarks> places;
  for (const ClickedScan& scan : scans)
    places.push_back({scan.photo, std::vector<std::optional<Vector2d>>(marks.size())});
  for (size_t i = 0; i < marks.size(); ++i)
    for (const Sighting& sighting : marks[i].sightings)
      places[sighting.scan].place_mm[i] = Vector2d(mm_from_pixel[sighting.scan] * sighting.place);
  return places;
}

MarkLayout LayoutOf(const std::vector<ScanOfMarks>& places, const std::vector<std::string>& ids,
                    const NewCameraOptions& options) {
  constexpr double kPhotogrammetric_mm = 0.02, kDesktop_mm = 0.15;
  std::vector<MarkDistance> distances;
  for (const StatedDistance& d : options.distances)
    distances.push_back({IndexOf(d.from, ids), IndexOf(d.to, ids), d.distance_mm, d.sigma_mm});
  const auto layout = EstimateLayout(places, distances,
                                     options.photogrammetric ? kPhotogrammetric_mm : kDesktop_mm);
  if (!layout)
    throw InputError(
        "the clicked marks do not give a layout: every scan needs two marks that are "
        "clicked on another one, too, and no two marks may lie at one place");
  return *layout;
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

// As far as the marks are from the axes through the origin, to a tenth of a millimetre.
Vector2d ExtentOf(const std::vector<Fiducial>& fiducials) {
  Vector2d half = Vector2d::Zero();
  for (const Fiducial& f : fiducials) half = half.cwiseMax(f.position_mm.cwiseAbs());
  return (20 * half).array().round() / 10;
}

}  // namespace

NewCamera MakeCamera(const std::vector<ClickedScan>& scans, const NewCameraOptions& options) {
  const std::vector<std::string> ids = MarkIds(scans);
  for (const StatedDistance& d : options.distances) IndexOf(d.from, ids), IndexOf(d.to, ids);
  std::vector<Matrix2d> mm_from_pixel, pixel_from_mm;
  for (const ClickedScan& scan : scans) {
    mm_from_pixel.push_back(MmFromPixel(scan, options));
    pixel_from_mm.emplace_back(mm_from_pixel.back().inverse());
  }
  std::vector<MarkSeen> marks;
  for (const std::string& id : ids)
    marks.push_back({id, Cut(scans, id, pixel_from_mm, options.polarity), 0, 0});
  const std::vector<Look> looks = FindLooks(options.template_radius_mm, &marks);

  NewCamera made;
  made.file.camera.name = options.name;
  made.file.camera.kind = CameraKind::kFilm;
  made.file.camera.principal_distance_mm = options.principal_distance_mm;
  for (const Look& look : looks) {
    made.file.marks[look.name] = DrawingOf(look);
    if (look.elements.empty()) made.pictures[look.name] = look.picture;
  }
  MarkLayout layout;
  if (options.positions.empty())
    layout = LayoutOf(PlacesOf(scans, mm_from_pixel, marks), ids, options);
  for (size_t i = 0; i < ids.size(); ++i) {
    Fiducial fiducial{ids[i], Vector2d::Zero(), looks[marks[i].look].name, std::nullopt};
    if (options.positions.empty()) {
      fiducial.position_mm = Rounded(layout.position_mm[i]);
      fiducial.sigma_mm = Rounded(layout.sigma_mm[i]);
    } else {
      fiducial.position_mm = StatedFor(ids[i], options.positions);
    }
    made.file.fiducials.push_back(fiducial);
    NewMark mark{ids[i], fiducial.mark, marks[i].correlation,
                 static_cast<int>(marks[i].sightings.size()), std::nullopt};
    if (marks[i].sightings.front().scan == 0) mark.first_place = marks[i].sightings.front().place;
    made.marks.push_back(std::move(mark));
  }
  made.file.camera.frame_mm = options.frame_mm ? *options.frame_mm : ExtentOf(made.file.fiducials);
  made.distance_residual_mm = layout.distance_residual_mm;
  made.first_mm_from_pixel = mm_from_pixel.front();
  made.pixel_size_um = 1e3 * std::sqrt(std::abs(mm_from_pixel.front().determinant()));
  return made;
}

}  // namespace orient::block
