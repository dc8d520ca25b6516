#include "interior/constellation/film_search.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <tuple>

#include "core/base/side_by_side.h"
#include "interior/constellation/marks_beyond_windows.h"
#include "interior/constellation/rival_readings.h"
#include "interior/constellation/set_evidence.h"
#include "interior/locators/locator.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kUserSigma = 0.004;
constexpr double kTagSigma = 0.008;  // tags of desktop scans are right within about 1 %
constexpr double kLadderStep = 0.06;
constexpr double kLadderSigma = 0.025;

struct Setting {
  ScanRegion region;
  PixelSizeGuess pixel_size;
  OrientationClass orientations;
  OrientationClass alike = {};  // of FilmReading
  SearchRange range = SearchRange::kWhole;
};

std::vector<OrientationClass> ClassesToTry(const CameraFile& camera, const MarkShapes& shapes,
                                           const InteriorOptions& options) {
  if (options.orientation) return {{*options.orientation}};
  return OrientationClasses(camera.fiducials, shapes);
}

// For each class, all scan orientations that the marks cannot distinguish from it.
std::vector<OrientationClass> AlikeToEach(const CameraFile& camera, const MarkShapes& shapes,
                                          const InteriorOptions& options,
                                          const std::vector<OrientationClass>& classes) {
  if (options.orientation) return classes;
  std::vector<OrientationClass> alike;
  for (const OrientationClass& members : classes)
    alike.push_back(IndistinguishableOrientations(camera.fiducials, shapes, members.front()));
  return alike;
}

class Reader {
 public:
  Reader(const Raster& scan, const CameraFile& camera, const MarkShapes& shapes,
         std::optional<LocatorKind> locator)
      : windows_(scan),
        locator_(locator),
        camera_(camera),
        shapes_(shapes),
        likeness_(shapes),
        rectangle_(RectangleOfMarks(camera.fiducials)),
        scan_px_(scan.Width(), scan.Height()) {
    for (const LocatorKind kind : {LocatorKind::kHough, LocatorKind::kNcc, LocatorKind::kLines})
      locators_[kind] = MakeLocator(kind);
  }

  // The same readings, with marks that lie outside their windows added.
  std::vector<FilmReading> BeyondWindows(const std::vector<FilmReading>& readings) {
    return ReadingsBeyondWindows(readings, camera_, shapes_, locator_, &windows_);
  }

  // Readings of one setting: both polarities, as the one that the user excluded may show that the
  // other was stated wrongly, and both kinds of scanner, unless the user named one.
  std::vector<FilmReading> Read(const Setting& setting, const InteriorOptions& options) {
    const std::vector<Place> places = Places(setting);
    const auto found = Candidates(places);
    std::vector<PixelWindow> windows;
    for (const Place& place : places) windows.push_back(place.search.window);
    std::vector<FilmReading> readings;
    for (const Polarity polarity : {Polarity::kPositive, Polarity::kNegative}) {
      for (const Scanner scanner : {Scanner::kPhotogrammetric, Scanner::kDesktop})
        if (options.scanner.value_or(scanner) == scanner)
          readings.push_back(ReadAs(setting, found, polarity, scanner, options.assignment));
    }
    for (FilmReading& reading : readings) reading.windows = windows;
    return readings;
  }

 private:
  // Mark, window, pixel size, and the orientation where the drawing looks different in it.
  using SearchKey = std::tuple<std::string, int, int, int, int, double, int>;

  Vector2d RectangleOnScan(ScanOrientation orientation) const {
    return (PhotoFromPixelAxes(orientation).transpose() * rectangle_.size_mm).cwiseAbs();
  }

  // Where a mark is searched for, and the key that distinguishes this search from others.
  struct Place {
    SearchKey key;
    const MarkShape* shape;
    MarkSearch search;
  };

  std::vector<Place> Places(const Setting& setting) {
    const ScanOrientation orientation = setting.orientations.front();
    const double p = setting.pixel_size.pixel_mm;
    const Vector2d size = RectangleOnScan(orientation);
    const double slack = 3.0 + 1.5 * setting.pixel_size.sigma * size.maxCoeff();
    const Matrix2d axes = PhotoFromPixelAxes(orientation).transpose();
    const Matrix2d turn = PhotoFromPixelAxes(ScanOrientation::kR0) * axes;
    std::vector<Place> places;
    for (const Fiducial& mark : camera_.fiducials) {
      const Vector2d at = PlaceOnScan(mark.position_mm, rectangle_, orientation);
      const MarkShape& shape = shapes_.at(mark.mark);
      const PixelWindow w =
          setting.range == SearchRange::kWhole
              ? SearchWindow(at, size, scan_px_, setting.region, p, slack)
              : SearchWindow(at, size, scan_px_, {setting.region.centre_px, size / p}, p, 0);
      const bool alike = likeness_.Same(mark.mark, mark.mark, turn);
      const int look = alike ? -1 : static_cast<int>(orientation);
      places.push_back(
          {{mark.mark, w.col, w.row, w.width, w.height, p, look}, &shape, {w, axes / p}});
      // Not worth the effort for a pixel size that is only a guess.
      places.back().search.interpolate = setting.pixel_size.sigma < kLadderSigma;
    }
    return places;
  }

  // If one mark distinguishes a layout's scan orientations, these have the other windows in common:
  // each window is searched only once.
  std::vector<MarkCandidates> Candidates(const std::vector<Place>& places) {
    std::vector<const Place*> fresh;
    for (const Place& place : places)
      if (searched_.try_emplace(place.key).second) fresh.push_back(&place);
    SideBySide(fresh.size(), [&](size_t i) {
      const Place& place = *fresh[i];
      const Locator& locator = *locators_.at(LocatorFor(*place.shape, locator_));
      searched_.at(place.key) = locator.Find(windows_, *place.shape, place.search);
    });
    std::vector<MarkCandidates> found;
    found.reserve(places.size());
    for (const Place& place : places) found.push_back(searched_.at(place.key));
    return found;
  }

  FilmReading ReadAs(const Setting& setting, const std::vector<MarkCandidates>& found,
                     Polarity polarity, Scanner scanner, AssignmentMethod assignment) const {
    FilmReading reading;
    reading.pixel_size = setting.pixel_size;
    reading.orientations = setting.orientations;
    reading.alike = setting.alike;
    reading.polarity = polarity;
    reading.scanner = scanner;
    reading.assignment = assignment;
    const ScanOrientation orientation = setting.orientations.front();
    const double p = setting.pixel_size.pixel_mm;
    const Vector2d middle = setting.region.centre_px;
    reading.middle_px = middle;
    double coarse = 0;
    for (size_t i = 0; i < found.size(); ++i) {
      const auto& candidates = polarity == Polarity::kPositive ? found[i].bright : found[i].dark;
      AssignmentMark mark;
      mark.place_mm = PlaceOnScan(camera_.fiducials[i].position_mm, rectangle_, orientation);
      mark.window_mm2 = std::max(found[i].searched_mm2, 1.0);
      const std::vector<double> nats = ScoreNats(candidates);
      for (size_t j = 0; j < candidates.size(); ++j)
        mark.candidates.push_back({(candidates[j].pixel - middle) * p, nats[j]});
      coarse = std::max(coarse, found[i].coarse_pixel_mm);
      reading.marks.push_back(std::move(mark));
      reading.candidates.push_back(candidates);
    }
    const Vector2d free =
        0.5 * (setting.region.size_px * p - RectangleOnScan(orientation)).cwiseAbs();
    reading.free_mm = free;
    reading.coarse_pixel_mm = coarse;
    reading.prior = PriorIn(reading, scanner, DepartureOf(camera_.fiducials, setting.orientations));
    Assign(&reading);
    return reading;
  }

  ScanWindows windows_;
  std::optional<LocatorKind> locator_;
  std::map<LocatorKind, std::unique_ptr<Locator>> locators_;
  const CameraFile& camera_;
  const MarkShapes& shapes_;
  MarkLikeness likeness_;
  MarkRectangle rectangle_;
  Eigen::Vector2i scan_px_;
  std::map<SearchKey, MarkCandidates> searched_;
};

}  // namespace

namespace {

// Pixel size, mm, at which the marks fill the scan. Whichever way the film lies, its longer side
// fits on the scan's longer side.
double FillingPixel(const Eigen::Vector2i& scan_px, const MarkRectangle& rectangle) {
  const Vector2d scan(scan_px.minCoeff(), scan_px.maxCoeff());
  const Vector2d marks(rectangle.size_mm.minCoeff(), rectangle.size_mm.maxCoeff());
  return (marks.array() / scan.array()).maxCoeff();
}

}  // namespace

bool MarksFitScan(const Eigen::Vector2i& scan_px, const MarkRectangle& rectangle, double pixel_mm) {
  constexpr double kCutOff = 0.8, kMostBed = 2.0;
  const double filling = FillingPixel(scan_px, rectangle);
  return pixel_mm > kCutOff * filling && pixel_mm < kMostBed * filling;
}

std::vector<PixelSizeGuess> GuessPixelSize(const Eigen::Vector2i& scan_px,
                                           std::optional<double> dpi_tag,
                                           const MarkRectangle& rectangle,
                                           std::optional<double> pixel_size_um) {
  if (pixel_size_um) return {{*pixel_size_um * 1e-3, kUserSigma}};
  if (dpi_tag && *dpi_tag > 0 && MarksFitScan(scan_px, rectangle, 25.4 / *dpi_tag))
    return {{25.4 / *dpi_tag, kTagSigma}};
  std::vector<PixelSizeGuess> ladder;
  constexpr double kFullest = 0.99, kEmptiest = 0.70;
  for (double filled = kFullest; filled > kEmptiest; filled *= 1 - kLadderStep)
    ladder.push_back({FillingPixel(scan_px, rectangle) / filled, kLadderSigma});
  return ladder;
}

namespace {

// A scan this much larger than the marks' rectangle shows the film on a scanner bed.
constexpr double kRebateMm = 60;
// The region found on the bed may be the film or only the exposed frame.
constexpr double kLeastOfRectangle = 0.85;
constexpr size_t kMostRegions = 4;

Vector2d Sorted(const Vector2d& size) { return {size.minCoeff(), size.maxCoeff()}; }

// Readings of one scan, region by region.
class FilmReadings {
 public:
  FilmReadings(const Raster& scan, const CameraFile& camera, const MarkShapes& shapes,
               const InteriorOptions& options)
      : whole_(WholeScan({scan.Width(), scan.Height()})),
        rectangle_(RectangleOfMarks(camera.fiducials)),
        scan_(scan),
        options_(options),
        classes_(ClassesToTry(camera, shapes, options)),
        alike_(AlikeToEach(camera, shapes, options, classes_)),
        reader_(scan, camera, shapes, options.locator) {}

  FilmReading Best(SearchRange first) {
    const bool on_bed = LiesOnBed();
    if (on_bed) AddFilmOnBed();
    if (readings_.empty() && first == SearchRange::kNearby && Guesses(whole_).size() == 1) {
      Add(whole_, SearchRange::kNearby);
      FilmReading nearby = Choose();
      if (IsBeyondRivals(nearby)) return nearby;
      readings_.clear();
      excluded_.clear();
    }
    if (readings_.empty()) Add(whole_);
    FilmReading best = ChooseAlsoBeyondWindows();
    const bool sure = best.best.nats >= MinSetNats(4) && best.margin > kMinMarginNats;
    if (on_bed || sure) return best;
    AddFilmOnBed();
    return ChooseAlsoBeyondWindows();
  }

  // The best reading, and all that differ from it; every reading's second set of marks is another
  // reading.
  std::vector<FilmReading> AllWays() {
    std::vector<FilmReading> ways = {Best(SearchRange::kWhole)};
    std::vector<FilmReading> others = readings_;
    for (const FilmReading& reading : readings_) {
      others.push_back(reading);
      others.back().best = reading.second;
    }
    std::stable_sort(others.begin(), others.end(), [](const FilmReading& a, const FilmReading& b) {
      return a.best.nats > b.best.nats;
    });
    for (FilmReading& other : others)
      if (std::none_of(ways.begin(), ways.end(),
                       [&](const FilmReading& way) { return ReadingsAgree(way, other); }))
        ways.push_back(std::move(other));
    return ways;
  }

 private:
  // Does the stated pixel size make the scan much larger than the film?
  bool LiesOnBed() const {
    double pixel_mm = 0;
    if (options_.pixel_size_um) pixel_mm = 1e-3 * *options_.pixel_size_um;
    const auto dpi = scan_.DpiTag();
    if (pixel_mm == 0 && dpi && *dpi > 0) pixel_mm = 25.4 / *dpi;
    const Vector2d size = pixel_mm * Vector2d(scan_.Width(), scan_.Height());
    return ((Sorted(size) - Sorted(rectangle_.size_mm)).array() > kRebateMm).any();
  }

  void AddFilmOnBed() {
    size_t added = 0;
    for (const ScanRegion& region : FindFilmOnBed(scan_)) {
      if (added == kMostRegions) break;
      if (Add(region)) ++added;
    }
  }

  std::vector<PixelSizeGuess> Guesses(const ScanRegion& region) const {
    return GuessPixelSize(region.size_px.array().round().cast<int>(), scan_.DpiTag(), rectangle_,
                          options_.pixel_size_um);
  }

  // Every mark was found, well within its window, and so surely that nothing in the rest of the
  // range can compete: in clutter, the odds of a set against clutter exceed x with a probability
  // below 1/x (Markov), so there is a rival within 3 nats with probability e^-(nats - 3) at most.
  bool IsBeyondRivals(const FilmReading& reading) const {
    constexpr double kBeyondRivals = 30;
    constexpr double kInsideMm = 2.5;
    const auto all = static_cast<int>(reading.marks.size());
    if (reading.best.Matched() < std::max(4, all) || reading.best.nats < kBeyondRivals ||
        reading.best.nats < MinSetNats(all) || reading.margin <= kMinMarginNats ||
        reading.scanner_margin <= kMinMarginNats)
      return false;
    for (size_t i = 0; i < reading.marks.size(); ++i) {
      const AssignmentMark& mark = reading.marks[i];
      const Vector2d off = mark.candidates[reading.best.choice[i]].position_mm - mark.place_mm;
      if (off.cwiseAbs().maxCoeff() > 0.5 * kSmallestWindowMm - kInsideMm) return false;
    }
    return true;
  }

  // False where the marks cannot lie in the region at any possible pixel size.
  bool Add(const ScanRegion& region, SearchRange range = SearchRange::kWhole) {
    const size_t before = readings_.size();
    const Vector2d marks = Sorted(rectangle_.size_mm);
    for (const PixelSizeGuess& pixel_size : Guesses(region)) {
      const Vector2d size = Sorted(region.size_px) * pixel_size.pixel_mm;
      const bool whole = region.size_px == whole_.size_px;
      if (!whole && (size.array() < kLeastOfRectangle * marks.array()).any()) continue;
      for (size_t k = 0; k < classes_.size(); ++k)
        for (FilmReading& reading :
             reader_.Read({region, pixel_size, classes_[k], alike_[k], range}, options_)) {
          const bool wanted = options_.polarity.value_or(reading.polarity) == reading.polarity;
          (wanted ? readings_ : excluded_).push_back(std::move(reading));
        }
    }
    return readings_.size() > before;
  }

  FilmReading Choose() const { return BestOf(readings_, excluded_); }

  FilmReading ChooseAlsoBeyondWindows() {
    for (std::vector<FilmReading>* readings : {&readings_, &excluded_}) {
      std::vector<FilmReading> more = reader_.BeyondWindows(*readings);
      std::move(more.begin(), more.end(), std::back_inserter(*readings));
    }
    return Choose();
  }

  ScanRegion whole_;
  MarkRectangle rectangle_;
  const Raster& scan_;
  const InteriorOptions& options_;
  std::vector<OrientationClass> classes_, alike_;
  Reader reader_;
  std::vector<FilmReading> readings_;
  std::vector<FilmReading> excluded_;  // in the polarity that the user excluded
};

}  // namespace

FilmReading ReadFilm(const Raster& scan, const CameraFile& camera, const MarkShapes& shapes,
                     const InteriorOptions& options, SearchRange first) {
  return FilmReadings(scan, camera, shapes, options).Best(first);
}

std::vector<FilmReading> ReadFilmAllWays(const Raster& scan, const CameraFile& camera,
                                         const MarkShapes& shapes, const InteriorOptions& options) {
  return FilmReadings(scan, camera, shapes, options).AllWays();
}

}  // namespace orient::interior
