#include "tests/interior/bad_scans.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <sstream>

#include "core/base/error.h"
#include "interior/orientation/reseau.h"
#include "tests/support/film_frame.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kMarkTolerance_px = 1, kTransformTolerance_px = 2;
constexpr size_t kShortestReason = 20;

// Photo places of the hand marks: corners (TL TR BR BL) or middles of the sides (T R B L).
std::optional<Vector2d> HandPlace(const std::string& mark, double corner_mm, double side_mm) {
  const std::map<std::string, Vector2d> corners = {
      {"TL", {-1, 1}}, {"TR", {1, 1}}, {"BR", {1, -1}}, {"BL", {-1, -1}}};
  const std::map<std::string, Vector2d> sides = {
      {"T", {0, 1}}, {"R", {1, 0}}, {"B", {0, -1}}, {"L", {-1, 0}}};
  if (corner_mm > 0 && corners.contains(mark)) return corner_mm * corners.at(mark);
  if (side_mm > 0 && sides.contains(mark)) return side_mm * sides.at(mark);
  return std::nullopt;
}

// Largest distance, px, of the transform from the truth at the marks of the camera it was read with
// and at the film's corners; over the ways the result leaves open the least.
double TransformError(const Trial& trial, const InteriorResult& found, const CameraFile& camera) {
  std::vector<Vector2d> places;
  for (const Fiducial& f : camera.fiducials) places.push_back(f.position_mm);
  const Vector2d half = 0.5 * trial.of->camera.camera.frame_mm;
  for (const Vector2d& sign : {Vector2d(-1, -1), Vector2d(1, -1), Vector2d(1, 1), Vector2d(-1, 1)})
    places.push_back(sign.cwiseProduct(half));
  double least = std::numeric_limits<double>::infinity();
  for (const ScanOrientation possible : found.possible_orientations) {
    const auto turned = InOrientation(found, camera, ShapesOf(camera), possible);
    if (!turned) continue;
    const Affine2d pixel_from_photo = turned->photo_from_pixel->Inverse();
    for (const ScanOrientation way : kAllScanOrientations) {
      if (!trial.of->any_way && way != ScanOrientation::kR0) continue;
      const Matrix2d turn = PhotoFromPixelAxes(way) * PhotoFromPixelAxes(ScanOrientation::kR0);
      double worst = 0;
      for (const Vector2d& place : places)
        worst = std::max(
            worst,
            (pixel_from_photo * place - trial.scan.pixel_from_photo * (turn * place)).norm());
      least = std::min(least, worst);
    }
  }
  return least;
}

// How far the worst used mark is from a true one, in units of what is allowed.
double WorstMark(const Trial& trial, const InteriorResult& found) {
  double worst = 0;
  for (const MarkResult& mark : found.marks) {
    if (mark.state != MarkState::kUsed) continue;
    double least = std::numeric_limits<double>::infinity();
    for (const TruePlace& place : trial.scan.marks) {
      const double sigma = std::hypot(mark.sigma_px->maxCoeff(), place.sigma_px);
      const double allowed = std::max(kMarkTolerance_px, 3 * sigma);
      least = std::min(least, (*mark.pixel - place.pixel).norm() / allowed);
    }
    worst = std::max(worst, least);
  }
  return worst;
}

// ORIENT_VERBOSE: every result with its reason.
void Say(const std::string& what, const Trial& trial, const InteriorResult& found, double off,
         double mark) {
  if (std::getenv("ORIENT_VERBOSE") == nullptr) return;
  std::cout << "  " << trial.of->name << ", " << what << ": " << Name(found.status);
  if (found.status != Status::kFailed) std::cout << " (off " << off << " px, marks " << mark << ")";
  for (const std::string& message : Sentences(found.findings)) std::cout << " | " << message;
  std::cout << std::endl;
}

}  // namespace

CameraFile LibraryCamera(const std::string& name) {
  return ReadCameraFile(ProjectFile("data/cameras/" + name + ".toml"));
}

KnownScan SimulatedOf(const std::string& name, const CameraFile& camera, double pixel_mm,
                      unsigned seed, bool marks, const std::vector<int>& missing) {
  KnownScan known{name, {}, camera, pixel_mm};
  FilmFrameSpec spec;
  spec.camera = known.camera;
  spec.pixel_mm = pixel_mm;
  spec.turn_rad = 0.006;
  spec.shift_px = {3.3, -2.6};
  spec.marks = marks;
  spec.missing = missing;
  spec.seed = seed;
  const auto crosses = std::count_if(
      camera.fiducials.begin(), camera.fiducials.end(), [&](const Fiducial& fiducial) {
        return camera.marks.at(fiducial.mark).background == MarkBackground::kImage;
      });
  spec.dark_corners = crosses < kLeastReseauMarks;
  const FilmFrame frame = RenderFilmFrame(spec);
  known.scan = {frame.scan, frame.pixel_from_photo, {}, Polarity::kPositive};
  for (const Vector2d& mark : frame.mark_pixels) known.scan.marks.push_back({mark, 0});
  return known;
}

KnownScan RealFrame(const std::string& folder, const std::string& frame, const std::string& camera,
                    double corner_mm, double side_mm) {
  KnownScan known{frame, {}, LibraryCamera(camera), 0.127, true};
  const Raster raster = Raster::Open(folder + "/" + frame + ".jpg");
  known.pixel_mm = 25.4 / raster.DpiTag().value();
  known.scan.image = raster.ReadGrey().image;
  std::ifstream file(folder + "/marks.csv");
  std::vector<PointPair2d> pairs;
  for (std::string line; std::getline(file, line);) {
    std::stringstream cells(line);
    std::string of_frame, name, col, row, sigma;
    for (std::string* cell : {&of_frame, &name, &col, &row, &sigma})
      std::getline(cells, *cell, ',');
    const auto place = HandPlace(name, corner_mm, side_mm);
    if (of_frame != frame || col.empty() || !place) continue;
    const Vector2d pixel(std::stod(col), std::stod(row));
    known.scan.marks.push_back({pixel, std::stod(sigma)});
    pairs.push_back({*place, pixel});
  }
  known.scan.pixel_from_photo = FitAffine(pairs).value().transform;
  return known;
}

Trial With(const KnownScan& known, TrueScan scan) {
  Trial trial;
  trial.scan = std::move(scan);
  trial.of = &known;
  return trial;
}
Trial Plain(const KnownScan& known) { return With(known, known.scan); }

int Pixels(const KnownScan& known, double mm) {
  return static_cast<int>(std::lround(mm / known.pixel_mm));
}

std::vector<std::pair<std::string, Margins>> Cuts(int px) {
  return {{"left", {px, 0, 0, 0}},        {"top", {0, px, 0, 0}},
          {"right", {0, 0, px, 0}},       {"bottom", {0, 0, 0, px}},
          {"upper left", {px, px, 0, 0}}, {"upper right", {0, px, px, 0}},
          {"lower left", {px, 0, 0, px}}, {"lower right", {0, 0, px, px}}};
}

std::vector<std::pair<std::string, Trial>> Ways(const KnownScan& known) {
  return {{"upside down", With(known, UpsideDown(known.scan))},
          {"mirrored", With(known, MirroredScan(known.scan))},
          {"negative", With(known, NegativeScan(known.scan))},
          {"upside down and negative", With(known, NegativeScan(UpsideDown(known.scan)))},
          {"mirrored, turned and negative",
           With(known, NegativeScan(TurnedScan(MirroredScan(known.scan), 90, kWhiteBed)))}};
}

std::vector<std::pair<std::string, std::optional<Vector2d>>> NonsenseTags(const KnownScan& known) {
  const double right = 25.4 / known.pixel_mm;
  return {{"no tag", Vector2d(0, 0)},
          {"1 dpi", Vector2d(1, 1)},
          {"72 dpi", Vector2d(72, 72)},
          {"25400 dpi", Vector2d(25400, 25400)},
          {"ten times the right dpi", Vector2d(10 * right, 10 * right)},
          {"a tenth of the right dpi", Vector2d(0.1 * right, 0.1 * right)},
          {"1.1 times the right dpi", Vector2d(1.1 * right, 1.1 * right)},
          {"0.9 times the right dpi", Vector2d(0.9 * right, 0.9 * right)},
          {"dpi of y half that of x", Vector2d(right, 0.5 * right)}};
}

Trial Tagged(const KnownScan& known, const std::optional<Vector2d>& dpi) {
  Trial trial = Plain(known);
  trial.dpi = dpi;
  return trial;
}

Trial OneBit(const KnownScan& known, std::optional<float> threshold) {
  Trial trial = With(known, Bilevel(known.scan, threshold));
  trial.one_bit = true;
  return trial;
}

// The next frame of the film to the right or below, half of it in view.
Trial WithNeighbour(const KnownScan& known, const Image& next, bool below, double share) {
  const int overlap = Pixels(known, 4);
  const int hidden = static_cast<int>((1 - share) * (below ? next.height : next.width));
  TrueScan both = below ? Above(known.scan, next, overlap) : Beside(known.scan, next, overlap);
  return With(known, Cut(both, {0, 0, below ? 0 : hidden, below ? hidden : 0}));
}

// The middle of two frames: half of either.
Trial HalfAndHalf(const KnownScan& known, const Image& next) {
  const TrueScan both = Beside(known.scan, next, Pixels(known, 4));
  Trial trial = With(known, Cut(both, {known.scan.image.width / 2, 0, next.width / 2, 0}));
  trial.no_answer = true;
  return trial;
}

void Row::Print(const std::string& name) const {
  std::printf("%-58s %4d scans: ok %4d, weak %3d (and %d off), failed %4d, ok and WRONG %d\n",
              name.c_str(), scans, ok_right, weak_right, weak_wrong, failed, ok_wrong);
  std::fflush(stdout);
}

BadScans::~BadScans() { row_.Print(testing::UnitTest::GetInstance()->current_test_info()->name()); }

void BadScans::Try(const std::string& what, const Trial& trial) {
  SCOPED_TRACE(trial.of->name + ": " + what);
  const std::string path = folder_ / "scan.tif";
  const double dpi = 25.4 / trial.of->pixel_mm;
  WriteTiffScan(path, trial.scan.image, {trial.dpi.value_or(Vector2d(dpi, dpi)), trial.one_bit});
  if (trial.share_of_file < 1) {
    const auto bytes = static_cast<double>(std::filesystem::file_size(path));
    std::filesystem::resize_file(path, static_cast<std::uintmax_t>(trial.share_of_file * bytes));
  }
  TryFile(what, path, trial);
}

void BadScans::TryFile(const std::string& what, const std::string& path, const Trial& trial) {
  const CameraFile& camera = trial.read_as ? *trial.read_as : trial.of->camera;
  ++row_.scans;
  InteriorResult found;
  try {
    found = OrientInterior(Raster::Open(path), camera, ShapesOf(camera), trial.options);
  } catch (const InputError& error) {
    found.findings.push_back({.reason = Reason::kScanUnusable, .where = error.what()});
  }
  Count(what, trial, camera, found);
}

void BadScans::Count(const std::string& what, const Trial& trial, const CameraFile& camera,
                     const InteriorResult& found) {
  if (found.status != Status::kOk) {
    ASSERT_FALSE(found.findings.empty());
    EXPECT_GT(Sentence(found.findings.at(0)).size(), kShortestReason)
        << Sentence(found.findings.at(0));
  }
  if (found.status == Status::kFailed) {
    ++row_.failed;
    Say(what, trial, found, 0, 0);
    return;
  }
  const double off = trial.no_answer ? std::numeric_limits<double>::infinity()
                                     : TransformError(trial, found, camera);
  const double mark = WorstMark(trial, found);
  const bool right =
      off <= kTransformTolerance_px && mark <= 1 && found.polarity == trial.scan.polarity;
  Say(what, trial, found, off, mark);
  if (found.status == Status::kOk) {
    EXPECT_TRUE(right) << "transform off by " << off << " px, marks by " << mark
                       << " of what is allowed";
    ++(right ? row_.ok_right : row_.ok_wrong);
  } else {
    ++(right ? row_.weak_right : row_.weak_wrong);
  }
}

}  // namespace orient::interior
