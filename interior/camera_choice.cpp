#include "interior/camera_choice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/files/used_marks.h"
#include "interior/constellation/film_search.h"
#include "interior/constellation/layout.h"
#include "interior/constellation/set_evidence.h"
#include "interior/judge.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kMinAheadNats = 3.0;
// About one resolution tag in fifty is wrong.
constexpr double kWrongTagNats = 4.0;
// Pixel sizes that differ from the stated one by more than this contradict it.
constexpr double kTagTolerance = 0.05;
// Tags and desktop scanners are right within a per cent (real frames: 0.8 %); what is farther off
// may be the marks of an unknown camera in a similar place.
constexpr double kSurePixelSize = 0.012;
// Fewer used marks fit the shapes of other cameras as well: fours and fives come in many sizes.
constexpr int kMarksOfShape = 6;
// Every mark of one shape has one of the other nearer than this, in units of the marks' mean
// distance from the layout's middle.
constexpr double kSameShape = 0.01;
constexpr double kSameTransformMm = 0.25;
constexpr double kMostDistortionMm = 0.6;
constexpr int kCandidatesSaid = 4;

std::vector<InteriorResult> InEveryOrientation(const InteriorResult& result,
                                               const KnownCamera& camera) {
  std::vector<InteriorResult> all;
  for (const ScanOrientation orientation : result.possible_orientations)
    if (auto turned = InOrientation(result, *camera.file, *camera.shapes, orientation))
      all.push_back(std::move(*turned));
  return all;
}

// Largest distance, mm, between the scan's corners as transformed by each of the two.
double Difference(const Affine2d& a, const Affine2d& b, int width, int height) {
  double most = 0;
  for (const double x : {0.0, 1.0})
    for (const double y : {0.0, 1.0}) {
      const Vector2d pixel(x * width, y * height);
      most = std::max(most, (a * pixel - b * pixel).norm());
    }
  return most;
}

double DistortionMm(const InteriorResult& result) { return 1e-3 * result.sigma0_um.value_or(0.0); }

// The marks that a reading without a transform used (four of eight, say), where `transform` puts
// the other camera's film: at least three, all in their places.
bool MarksFit(const Affine2d& transform, const CameraReading& reading,
              const std::vector<KnownCamera>& cameras, double tolerance_mm) {
  constexpr int kFewest = 3;
  const auto& fiducials = cameras[reading.camera].file->fiducials;
  int fitting = 0;
  for (size_t i = 0; i < reading.result.marks.size(); ++i) {
    const MarkResult& mark = reading.result.marks[i];
    if (mark.state != MarkState::kUsed || !mark.pixel) continue;
    if ((transform * *mark.pixel - fiducials[i].position_mm).norm() > tolerance_mm) return false;
    ++fitting;
  }
  return fitting >= kFewest;
}

// Whether two cameras give the same transform (`a` has one) in a scan orientation that both leave
// open. With a distorted print the transform depends on the marks that determine it.
bool Agree(const CameraReading& a, const CameraReading& b,
           const std::vector<KnownCamera>& cameras) {
  if (!a.result.photo_from_pixel) return false;
  if (b.result.photo_from_pixel && a.result.polarity != b.result.polarity) return false;
  const double tolerance =
      kSameTransformMm +
      2 * std::min(std::max(DistortionMm(a.result), DistortionMm(b.result)), kMostDistortionMm);
  const auto others = InEveryOrientation(b.result, cameras[b.camera]);
  for (const InteriorResult& one : InEveryOrientation(a.result, cameras[a.camera])) {
    if (!b.result.photo_from_pixel && MarksFit(*one.photo_from_pixel, b, cameras, tolerance))
      return true;
    for (const InteriorResult& other : others)
      if (Difference(*one.photo_from_pixel, *other.photo_from_pixel, one.width, one.height) <
          tolerance)
        return true;
  }
  return false;
}

// Mark positions with their middle at 0 and a mean radius of 1, and that radius.
std::vector<Vector2d> Shape(const CameraFile& camera, double* radius_mm) {
  const Vector2d middle = RectangleOfMarks(camera.fiducials).centre_mm;
  std::vector<Vector2d> shape;
  *radius_mm = 0;
  for (const Fiducial& f : camera.fiducials) {
    shape.emplace_back(f.position_mm - middle);
    *radius_mm += shape.back().norm() / static_cast<double>(camera.fiducials.size());
  }
  for (Vector2d& p : shape) p /= *radius_mm;
  return shape;
}

// Whether one layout is the other one, larger or smaller.
bool SameShapeOfAnotherSize(const CameraFile& a, const CameraFile& b) {
  double radius_a = 0, radius_b = 0;
  const auto shape_a = Shape(a, &radius_a), shape_b = Shape(b, &radius_b);
  if (shape_a.size() != shape_b.size()) return false;
  if (std::abs(radius_a / radius_b - 1) < 1e-3) return false;
  return std::all_of(shape_a.begin(), shape_a.end(), [&](const Vector2d& p) {
    return std::any_of(shape_b.begin(), shape_b.end(),
                       [&](const Vector2d& q) { return (p - q).norm() < kSameShape; });
  });
}

// Whether no other camera has this layout at another size, so that it determines the pixel size.
bool ShapeTellsSize(const std::vector<KnownCamera>& cameras, const CameraReading& best) {
  if (CountUsedMarks(best.result) < kMarksOfShape) return false;
  return std::none_of(cameras.begin(), cameras.end(), [&](const KnownCamera& other) {
    return SameShapeOfAnotherSize(*cameras[best.camera].file, *other.file);
  });
}

void JudgePixelSize(const std::vector<KnownCamera>& cameras, const CameraReading& best,
                    std::optional<double> stated_um, InteriorResult* result) {
  const double found_um = result->pixel_size_um.value_or(0.0);
  const double off = stated_um ? found_um / *stated_um - 1 : 1;
  if (std::abs(off) < kSurePixelSize) return;
  if (stated_um && std::abs(off) < kTagTolerance)
    Add(Findings{{Reason::kCameraPixelSizeOff, Status::kWeak, 100 * std::abs(off),
                  100 * kSurePixelSize, off > 0 ? "larger" : "smaller"}},
        result);
  else if (!ShapeTellsSize(cameras, best))
    Add(Findings{PixelSizeIsUnsure(*result)}, result);
}

// Readings by evidence, the strongest first; contradicting the stated pixel size is penalised.
std::vector<CameraReading> ByEvidence(std::vector<CameraReading> readings,
                                      std::optional<double> stated_um) {
  for (CameraReading& r : readings)
    if (stated_um && r.result.pixel_size_um &&
        std::abs(*r.result.pixel_size_um / *stated_um - 1) > kTagTolerance)
      r.nats -= kWrongTagNats;
  std::stable_sort(readings.begin(), readings.end(),
                   [](const auto& a, const auto& b) { return a.nats > b.nats; });
  return readings;
}

std::string CandidateList(const std::vector<KnownCamera>& cameras,
                          const std::vector<CameraReading>& sorted) {
  std::string list;
  for (size_t i = 0; i < sorted.size() && i < kCandidatesSaid; ++i) {
    if (i > 0) list += ", ";
    list += cameras[sorted[i].camera].name;
    list += " (";
    list += Name(sorted[i].result.status);
    list += i == 0 ? fmt::format(", {:.1f} nats)", sorted[i].nats)
                   : fmt::format(", {:.1f} behind)", sorted.front().nats - sorted[i].nats);
  }
  return list;
}

bool IsFilm(const KnownCamera& camera) { return camera.file->camera.kind == CameraKind::kFilm; }

bool HasTooManyMarks(const KnownCamera& camera) {
  return camera.file->fiducials.size() > kMostMarksOfUnknownCamera;
}

// The film cameras without a reading, and why they have none: sentences, each after a blank.
std::string NotTried(const std::vector<KnownCamera>& cameras,
                     const std::vector<CameraReading>& readings) {
  std::vector<std::string> many, unlike;
  for (size_t i = 0; i < cameras.size(); ++i) {
    const bool tried = std::any_of(readings.begin(), readings.end(),
                                   [&](const CameraReading& r) { return r.camera == i; });
    if (!tried && IsFilm(cameras[i]))
      (HasTooManyMarks(cameras[i]) ? many : unlike).push_back(cameras[i].name);
  }
  std::string said;
  if (!many.empty())
    said += fmt::format(" Not tried, as they have more than {} marks: {}.",
                        kMostMarksOfUnknownCamera, fmt::join(many, ", "));
  if (!unlike.empty())
    said += fmt::format(
        " Not tried, because at the stated pixel size their marks do not fit on the scan or "
        "their films are a small part of it: {}.",
        fmt::join(unlike, ", "));
  return said;
}

// The strongest evidence of the film's marks against the stated polarity if far beyond `nats`,
// whichever camera's marks they are.
std::optional<Finding> AgainstPolarity(const std::vector<CameraReading>& readings, double nats) {
  std::optional<Finding> strongest;
  for (const CameraReading& reading : readings)
    for (const Finding& finding : reading.result.findings)
      if (finding.reason == Reason::kPolarityUnlikeMarks &&
          reading.nats + *finding.value >= nats + *finding.limit &&
          (!strongest || *finding.value > *strongest->value))
        strongest = finding;
  if (strongest) strongest->at_best = Status::kWeak;
  return strongest;
}

CameraChoice Unknown(const std::vector<KnownCamera>& cameras,
                     const std::vector<CameraReading>& sorted, const std::string& why) {
  CameraChoice choice;
  choice.result.findings = {{.reason = Reason::kCameraUnknown,
                             .at_best = Status::kFailed,
                             .where = why + NotTried(cameras, sorted)}};
  if (sorted.empty()) return choice;
  if (const auto polarity = AgainstPolarity(sorted, sorted.front().nats))
    choice.result.findings.push_back(*polarity);
  choice.result.width = sorted.front().result.width;
  choice.result.height = sorted.front().result.height;
  choice.result.findings.push_back(
      {.reason = Reason::kNearestCameras, .where = CandidateList(cameras, sorted)});
  return choice;
}

void SayCameras(const std::vector<KnownCamera>& cameras, const std::vector<size_t>& fitting,
                const std::string& not_tried, InteriorResult* result) {
  double least = 1e9, most = 0;
  std::string names;
  for (const size_t i : fitting) {
    const double distance = cameras[i].file->camera.principal_distance_mm;
    least = std::min(least, distance);
    most = std::max(most, distance);
    names += (names.empty() ? "" : ", ") + cameras[i].name;
    result->cameras.push_back(cameras[i].name);
  }
  std::string said = fitting.size() == 1
                         ? "Camera " + names + " of the library."
                         : "Cameras that fit equally well, with the same transform: " + names + ".";
  said +=
      most - least > 1
          ? " The marks do not determine the principal distance (" + fmt::format("{:.0f}", least) +
                " to " + fmt::format("{:.0f}", most) +
                " mm): exterior orientation needs the right one."
          : " Check that its principal distance is calibrated: exterior orientation needs that.";
  result->findings.push_back({.reason = Reason::kCamerasThatFit, .where = said + not_tried});
}

// Cameras with the same marks at the same places have the same reading of a scan.
bool HaveSameMarks(const KnownCamera& a, const KnownCamera& b) {
  if (a.file->fiducials.size() != b.file->fiducials.size()) return false;
  constexpr double kPixelPerMm = 20;
  const Matrix2d pixel_from_mm = Vector2d(kPixelPerMm, -kPixelPerMm).asDiagonal();
  for (size_t i = 0; i < a.file->fiducials.size(); ++i) {
    const Fiducial &one = a.file->fiducials[i], &other = b.file->fiducials[i];
    if (one.position_mm != other.position_mm || one.symbol.has_value() != other.symbol.has_value())
      return false;
    const MarkTemplate drawn = RenderMark(a.shapes->at(one.mark), pixel_from_mm);
    const MarkTemplate other_drawn = RenderMark(b.shapes->at(other.mark), pixel_from_mm);
    const auto same = [](float p, float q) { return p == q || (std::isnan(p) && std::isnan(q)); };
    if (!std::equal(drawn.values.values.begin(), drawn.values.values.end(),
                    other_drawn.values.values.begin(), other_drawn.values.values.end(), same))
      return false;
  }
  return true;
}

// Whether the camera's marks do not fit on the scan at the stated pixel size (MarksFitScan), or its
// film is a small part of the scan, on a scanner bed. Such a film is searched for everywhere, or at
// many pixel sizes, which takes as long as all other cameras together: worth it only where none of
// those fits.
bool IsTriedLast(const Raster& scan, const CameraFile& camera, std::optional<double> stated_um) {
  constexpr double kMostScanSides = 1.6;  // of the frame's side
  if (!stated_um) return false;
  const Eigen::Vector2i scan_px(scan.Width(), scan.Height());
  return 1e-3 * *stated_um * scan_px.maxCoeff() >
             kMostScanSides * camera.camera.frame_mm.maxCoeff() ||
         !MarksFitScan(scan_px, RectangleOfMarks(camera.fiducials), 1e-3 * *stated_um);
}

// Whether an `ok` reading may be this larger camera's film: the stated pixel size may be too small,
// and marks of the same shape do not show which of the two it is.
bool MayBeMistakenFor(const std::vector<KnownCamera>& cameras, size_t camera,
                      const std::vector<CameraReading>& readings) {
  const CameraFile& larger = *cameras[camera].file;
  return std::any_of(readings.begin(), readings.end(), [&](const CameraReading& r) {
    const CameraFile& found = *cameras[r.camera].file;
    return r.result.status == Status::kOk &&
           found.camera.frame_mm.maxCoeff() < larger.camera.frame_mm.maxCoeff() &&
           SameShapeOfAnotherSize(found, larger);
  });
}

// Adds the camera's reading; that of a camera with the same marks is taken over.
void ReadWith(const Raster& scan, const std::vector<KnownCamera>& cameras, size_t camera,
              const InteriorOptions& options, std::vector<CameraReading>* readings) {
  const auto alike = std::find_if(readings->begin(), readings->end(), [&](const auto& known) {
    return HaveSameMarks(cameras[known.camera], cameras[camera]);
  });
  if (alike != readings->end()) {
    readings->push_back({camera, alike->result, alike->nats});
    return;
  }
  double nats = 0;
  InteriorResult result =
      OrientInterior(scan, *cameras[camera].file, *cameras[camera].shapes, options, &nats);
  readings->push_back({camera, std::move(result), nats});
}

}  // namespace

CameraChoice ChooseCamera(const std::vector<KnownCamera>& cameras,
                          const std::vector<CameraReading>& readings,
                          std::optional<double> pixel_size_um) {
  const auto sorted = ByEvidence(readings, pixel_size_um);
  const auto best = std::find_if(sorted.begin(), sorted.end(),
                                 [](const auto& r) { return r.result.status == Status::kOk; });
  if (best == sorted.end())
    return Unknown(
        cameras, sorted,
        sorted.empty()
            ? "no camera could be tried."
            : fmt::format("none of the cameras tried ({}) fits with certainty.", sorted.size()));
  std::vector<size_t> fitting;
  for (const CameraReading& other : sorted) {
    if (other.nats <= best->nats - kMinAheadNats) continue;
    if (&other != &*best && !Agree(*best, other, cameras))
      return Unknown(cameras, sorted,
                     cameras[best->camera].name + " fits, and " + cameras[other.camera].name +
                         ", with other mark positions, nearly as well or better.");
    if (other.result.status == Status::kOk) fitting.push_back(other.camera);
  }
  CameraChoice choice{best->result, best->camera};
  Add(AgainstPolarity(sorted, best->nats), &choice.result);
  JudgePixelSize(cameras, *best, pixel_size_um, &choice.result);
  SayCameras(cameras, fitting, NotTried(cameras, sorted), &choice.result);
  return choice;
}

CameraChoice OrientWithUnknownCamera(const Raster& scan, const std::vector<KnownCamera>& cameras,
                                     const InteriorOptions& options) {
  std::optional<double> stated_um = options.pixel_size_um;
  if (!stated_um && scan.DpiTag() && *scan.DpiTag() > 0) stated_um = 25400 / *scan.DpiTag();
  std::vector<CameraReading> readings;
  for (const bool last : {false, true}) {
    const bool found = std::any_of(readings.begin(), readings.end(),
                                   [](const auto& r) { return r.result.status == Status::kOk; });
    for (size_t i = 0; i < cameras.size(); ++i)
      if (IsFilm(cameras[i]) && !HasTooManyMarks(cameras[i]) &&
          IsTriedLast(scan, *cameras[i].file, stated_um) == last &&
          (!found || MayBeMistakenFor(cameras, i, readings)))
        ReadWith(scan, cameras, i, options, &readings);
  }
  return ChooseCamera(cameras, readings, stated_um);
}

}  // namespace orient::interior
