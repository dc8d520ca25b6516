#include "interior/constellation/layout.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <stdexcept>

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kLargestAffinity = 0.025;  // difference of a desktop scanner's two scales
constexpr double kSamePlaceMm = 1;          // no two marks are this close together
constexpr double kSameLayoutMm = 0.35;      // what an affine may leave between equal layouts

// Could a scanner's affinity make the layout look like its own permutation?
bool IsSameLayout(const std::vector<PointPair2d>& pairs) {
  const auto small = [](double value) { return std::abs(value) <= kLargestAffinity; };
  const auto fit = FitAffine(pairs);
  if (!fit) {  // collinear or fewer than three: compare as they are
    for (const PointPair2d& p : pairs)
      if ((p.target - p.source).norm() > kSameLayoutMm) return false;
    return true;
  }
  for (const Vector2d& v : fit->residuals)
    if (v.norm() > kSameLayoutMm) return false;
  const Matrix2d& A = fit->transform.A;
  return small(A(0, 0) - A(1, 1)) && small(A(0, 1) + A(1, 0)) && small(A(0, 0) - 1) &&
         small(A(1, 1) - 1) && small(A(0, 1) - A(1, 0));
}

int NearestMark(const std::vector<Fiducial>& fiducials, const Vector2d& photo_mm) {
  int nearest = -1;
  double best = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < fiducials.size(); ++i) {
    const double distance = (fiducials[i].position_mm - photo_mm).norm();
    if (distance < best) {
      best = distance;
      nearest = static_cast<int>(i);
    }
  }
  return nearest;
}

// same(mark, other mark, turn): whether the one looks like the other after the turn.
template <typename Same>
std::optional<std::vector<int>> RelabelWhere(const std::vector<Fiducial>& fiducials,
                                             ScanOrientation base, ScanOrientation other,
                                             const Same& same) {
  const Vector2d centre = RectangleOfMarks(fiducials).centre_mm;
  const Matrix2d turn = PhotoTurn(base, other);
  std::vector<int> relabel;
  std::vector<bool> taken(fiducials.size(), false);
  std::vector<PointPair2d> pairs;
  for (const Fiducial& mark : fiducials) {
    const Vector2d turned = turn * (mark.position_mm - centre) + centre;
    const int i = NearestMark(fiducials, turned);
    if (taken[i]) return std::nullopt;
    taken[i] = true;
    relabel.push_back(i);
    pairs.push_back({turned, fiducials[i].position_mm});
  }
  if (!IsSameLayout(pairs)) return std::nullopt;
  for (size_t i = 0; i < fiducials.size(); ++i)  // last: drawings take longer than positions
    if (!same(fiducials[i].mark, fiducials[relabel[i]].mark, turn)) return std::nullopt;
  return relabel;
}

}  // namespace

MarkRectangle RectangleOfMarks(const std::vector<Fiducial>& fiducials) {
  if (fiducials.empty()) throw std::invalid_argument("RectangleOfMarks: no marks");
  Eigen::AlignedBox2d box;
  for (const Fiducial& f : fiducials) box.extend(f.position_mm);
  return {box.center(), box.sizes()};
}

Vector2d PlaceOnScan(const Vector2d& photo_mm, const MarkRectangle& rectangle,
                     ScanOrientation orientation) {
  return PhotoFromPixelAxes(orientation).transpose() * (photo_mm - rectangle.centre_mm);
}

Matrix2d PhotoTurn(ScanOrientation base, ScanOrientation other) {
  return PhotoFromPixelAxes(other) * PhotoFromPixelAxes(base).transpose();
}

std::optional<std::vector<int>> Relabel(const std::vector<Fiducial>& fiducials,
                                        const MarkShapes& shapes, ScanOrientation base,
                                        ScanOrientation other) {
  MarkLikeness likeness(shapes);
  return RelabelWhere(
      fiducials, base, other,
      [&](const std::string& mark, const std::string& turned, const Matrix2d& turn) {
        return shapes.at(mark).picture || shapes.at(turned).picture ||
               likeness.Same(mark, turned, turn);
      });
}

OrientationClass IndistinguishableOrientations(const std::vector<Fiducial>& fiducials,
                                               const MarkShapes& shapes,
                                               ScanOrientation orientation) {
  OrientationClass ways = {orientation};
  for (const ScanOrientation other : kAllScanOrientations)
    if (other != orientation && Relabel(fiducials, shapes, orientation, other))
      ways.push_back(other);
  return ways;
}

std::vector<int> RelabelAlike(const std::vector<Fiducial>& fiducials, ScanOrientation base,
                              ScanOrientation other) {
  const Vector2d centre = RectangleOfMarks(fiducials).centre_mm;
  const Matrix2d turn = PhotoTurn(base, other);
  std::vector<int> relabel;
  for (const Fiducial& mark : fiducials)
    relabel.push_back(NearestMark(fiducials, turn * (mark.position_mm - centre) + centre));
  return relabel;
}

std::vector<int> RelabelInCommon(const std::vector<Fiducial>& fiducials, ScanOrientation base,
                                 ScanOrientation other) {
  const Vector2d centre = RectangleOfMarks(fiducials).centre_mm;
  const Matrix2d turn = PhotoTurn(base, other);
  std::vector<int> relabel = RelabelAlike(fiducials, base, other);
  for (size_t i = 0; i < relabel.size(); ++i) {
    const Vector2d turned = turn * (fiducials[i].position_mm - centre) + centre;
    if ((turned - fiducials[relabel[i]].position_mm).norm() > kSamePlaceMm) relabel[i] = -1;
  }
  return relabel;
}

std::vector<OrientationClass> OrientationClasses(const std::vector<Fiducial>& fiducials,
                                                 const MarkShapes& shapes) {
  MarkLikeness likeness(shapes);
  const auto same = [&](const std::string& mark, const std::string& turned, const Matrix2d& turn) {
    return likeness.Same(mark, turned, turn);
  };
  std::vector<OrientationClass> classes;
  for (const ScanOrientation orientation : kAllScanOrientations) {
    const auto known = std::find_if(classes.begin(), classes.end(), [&](const auto& members) {
      return RelabelWhere(fiducials, members.front(), orientation, same).has_value();
    });
    if (known != classes.end())
      known->push_back(orientation);
    else
      classes.push_back({orientation});
  }
  return classes;
}

LayoutDeparture DepartureOf(const std::vector<Fiducial>& fiducials,
                            const OrientationClass& orientations) {
  const Vector2d centre = RectangleOfMarks(fiducials).centre_mm;
  LayoutDeparture departure;
  for (const ScanOrientation other : orientations) {
    const Matrix2d turn = PhotoTurn(orientations.front(), other);
    const std::vector<int> relabel = RelabelAlike(fiducials, orientations.front(), other);
    std::vector<PointPair2d> pairs;
    for (size_t i = 0; i < fiducials.size(); ++i)
      pairs.push_back(
          {turn * (fiducials[i].position_mm - centre) + centre, fiducials[relabel[i]].position_mm});
    const auto fit = FitAffine(pairs);
    double squares = 0;
    for (size_t i = 0; i < pairs.size(); ++i)
      squares +=
          (fit ? fit->residuals[i] : Vector2d(pairs[i].target - pairs[i].source)).squaredNorm();
    departure.point_mm = std::max(departure.point_mm,
                                  std::sqrt(squares / (2.0 * static_cast<double>(pairs.size()))));
    if (!fit) continue;
    const Matrix2d& A = fit->transform.A;
    departure.affinity =
        std::max({departure.affinity, std::abs(A(0, 0) - A(1, 1)), std::abs(A(0, 1) + A(1, 0))});
  }
  return departure;
}

PixelWindow SearchWindow(const Vector2d& place_mm, const Vector2d& rectangle_mm,
                         const Eigen::Vector2i& scan_px, const ScanRegion& region,
                         double pixel_size_mm, double slack_mm) {
  const Vector2d scan = scan_px.cast<double>();
  const Vector2d middle = place_mm / pixel_size_mm + region.centre_px;
  const Vector2d free = 0.5 * (region.size_px - rectangle_mm / pixel_size_mm).cwiseAbs();
  const Vector2d half =
      (free.array() + slack_mm / pixel_size_mm).max(0.5 * kSmallestWindowMm / pixel_size_mm);
  const Vector2d low = (middle - half).cwiseMax(0.0).array().floor();
  const Vector2d high = (middle + half).cwiseMin(scan).array().ceil();
  const Vector2d size = (high - low).cwiseMax(0.0);
  return {static_cast<int>(low.x()), static_cast<int>(low.y()), static_cast<int>(size.x()),
          static_cast<int>(size.y())};
}

PixelWindow SearchWindow(const Vector2d& place_mm, const Vector2d& rectangle_mm,
                         const Eigen::Vector2i& scan_px, double pixel_size_mm, double slack_mm) {
  return SearchWindow(place_mm, rectangle_mm, scan_px, WholeScan(scan_px), pixel_size_mm, slack_mm);
}

}  // namespace orient::interior
