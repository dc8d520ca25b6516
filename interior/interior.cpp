#include "interior/interior.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/base/error.h"
#include "interior/constellation/clicked_film.h"
#include "interior/constellation/film_search.h"
#include "interior/constellation/guided_search.h"
#include "interior/constellation/layout.h"
#include "interior/judge.h"
#include "interior/orientation/film_orientation.h"
#include "interior/orientation/film_transform.h"
#include "interior/orientation/layout_vote.h"
#include "interior/orientation/measured_places.h"
#include "interior/orientation/reseau.h"
#include "interior/orientation/reseau_result.h"
#include "interior/orientation/vote_names.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

InteriorResult OrientDigital(const Raster& scan, const Camera& camera) {
  InteriorResult result;
  result.width = scan.Width();
  result.height = scan.Height();
  const auto other_size = JudgeImageSize({result.width, result.height}, camera.image_px.value());
  if (other_size) {
    result.findings = {*other_size};
    return result;
  }
  result.status = Status::kOk;
  result.photo_from_pixel = DigitalPhotoFromPixel(camera);
  result.pixel_size_um = 1e3 * std::sqrt(std::abs(result.photo_from_pixel->A.determinant()));
  result.polarity = Polarity::kPositive;
  result.orientation = ScanOrientation::kR0;
  result.possible_orientations = {ScanOrientation::kR0};
  return result;
}

void CheckFilmCamera(const CameraFile& camera, const MarkShapes& shapes) {
  if (camera.fiducials.empty())
    throw InputError("Camera \"" + camera.camera.name +
                     "\" is a film camera without fiducials: add [[fiducials]] to its file.");
  for (const Fiducial& f : camera.fiducials)
    if (!shapes.contains(f.mark))
      throw std::invalid_argument("OrientInterior: no drawing for mark " + f.mark);
}

void FillTransform(const FilmTransform& film, const FilmMarks& marks, InteriorResult* result) {
  result->photo_from_pixel = film.photo_from_pixel;
  result->pixel_size_um = film.pixel_um;
  if (film.affine) result->sigma0_um = film.sigma0_um;
  size_t used = 0;
  for (size_t i = 0; i < marks.size(); ++i)
    if (marks[i].state == MarkState::kUsed) result->marks[i].residual_um = film.residual_um[used++];
}

std::vector<MarkResult> MarkResults(const CameraFile& camera, const FilmReading& reading,
                                    const FilmMarks& marks) {
  std::vector<MarkResult> results;
  for (size_t i = 0; i < marks.size(); ++i) {
    MarkResult mark;
    mark.id = camera.fiducials[i].id;
    mark.state = marks[i].state;
    if (marks[i].position) {
      mark.pixel = marks[i].position->pixel;
      mark.sigma_px = Vector2d(marks[i].position->covariance.diagonal().cwiseSqrt());
      mark.score = marks[i].position->correlation;
    }
    if (mark.state != MarkState::kUsed && !reading.windows.empty()) {
      const PixelWindow& w = reading.windows.at(i);
      if (w.width > 0) mark.window = {w.col, w.row, w.width, w.height};
    }
    results.push_back(mark);
  }
  return results;
}

// Whether the scan has only two grey values around all used marks.
bool IsBlackAndWhite(const Raster& scan, const std::vector<MarkResult>& marks) {
  constexpr int kHalf = 24;
  for (const MarkResult& mark : marks) {
    if (mark.state != MarkState::kUsed) continue;
    const int col = static_cast<int>(mark.pixel->x()), row = static_cast<int>(mark.pixel->y());
    const Image around =
        scan.ReadGrey({col - kHalf, row - kHalf, 2 * kHalf + 1, 2 * kHalf + 1}).image;
    std::vector<float> tones;
    for (const float value : around.values) {
      if (!std::isfinite(value) || std::find(tones.begin(), tones.end(), value) != tones.end())
        continue;
      tones.push_back(value);
      if (tones.size() > 2) return false;
    }
  }
  return true;
}

std::vector<std::string> Unused(const CameraFile& camera, const FilmMarks& marks) {
  std::vector<std::string> ids;
  for (size_t i = 0; i < marks.size(); ++i)
    if (marks[i].state != MarkState::kUsed) ids.push_back(camera.fiducials[i].id);
  return ids;
}

// One reading, its marks measured and judged.
struct JudgedFilm {
  FilmMarks marks;
  InteriorResult result;  // without the scan orientation
};

JudgedFilm JudgeReading(const Raster& scan, const CameraFile& camera, const MarkShapes& shapes,
                        const InteriorOptions& options, const FilmReading& reading,
                        MeasuredPlaces* known) {
  JudgedFilm judged;
  InteriorResult& result = judged.result;
  result.width = scan.Width();
  result.height = scan.Height();
  judged.marks = MeasureMarks(scan, camera, shapes, reading, options.locator, known);
  if (!options.clicks.empty()) TakeExactClicks(camera, reading, options.clicks, &judged.marks);
  const bool mirrored = IsMirrored(reading.orientations.front());
  const auto film = FitFilm(UsedMarks(camera, judged.marks), mirrored);
  const Findings findings = Judge(reading, judged.marks, film, Unused(camera, judged.marks));
  result.status = Status::kOk;
  Add(findings, &result);
  if (result.status != Status::kFailed) {
    std::vector<std::string> perhaps_wrong;
    for (const size_t i : SuspectMarks(reading, judged.marks))
      perhaps_wrong.push_back(camera.fiducials[i].id);
    Add(JudgeRejected(perhaps_wrong), &result);
  }
  result.margin = std::max(reading.margin, 0.0);
  result.marks = MarkResults(camera, reading, judged.marks);
  if (result.status == Status::kFailed) return judged;
  FillTransform(*film, judged.marks, &result);
  CorrectFilm(camera, mirrored, &result);
  Add(JudgeReseau(result), &result);
  if (IsBlackAndWhite(scan, result.marks)) Add(Findings{BlackAndWhite()}, &result);
  result.polarity = reading.polarity;
  return judged;
}

// Evidence of the marks' calibrated positions, in all scan orientations that look alike, against
// the one that the user gave, which is the first of them.
std::optional<Finding> CheckByLayout(const OrientationClass& alike, const OrientationVote& vote) {
  const auto best = std::max_element(vote.nats.begin(), vote.nats.end());
  return JudgeGivenByLayout(alike.front(), alike[best - vote.nats.begin()],
                            *best - vote.nats.front());
}

// The user's scan orientation is kept; evidence on the film against it is reported.
InteriorResult WithOrientationGiven(const Raster& scan, const CameraFile& camera,
                                    const MarkShapes& shapes, const InteriorOptions& options,
                                    const FilmReading& reading, const JudgedFilm& judged) {
  const ScanOrientation orientation = options.orientation.value();
  InteriorResult result = judged.result;
  result.possible_orientations = {orientation};
  result.orientation = orientation;
  const OrientationClass alike =
      IndistinguishableOrientations(camera.fiducials, shapes, orientation);
  Add(CheckByLayout(alike, VoteOfLayout(camera, reading, judged.marks, alike, options.scanner)),
      &result);
  const auto votes = VotesOfFilm(scan, camera, shapes, result, alike);
  const auto decision = Decide(alike, votes);
  result.orientation_evidence =
      VoteNames(camera, shapes, orientation, orientation).Evidence(votes, alike);
  Add(JudgeGivenBySigns(orientation, decision.possible), &result);
  return result;
}

// Layouts that depart less than this from symmetry are judged alike in all ways.
bool IsJudgedAlike(const LayoutDeparture& departure) {
  return departure.point_mm < 0.002 && departure.affinity < 2e-5;
}

// Out of the scan orientations that the layout leaves open, those left by symbols, border and the
// marks' calibrated positions. Marks are measured and judged again in the likeliest one, if the
// calibrated layout differs there.
InteriorResult WithOrientationFound(const Raster& scan, const CameraFile& camera,
                                    const MarkShapes& shapes, const InteriorOptions& options,
                                    FilmReading* reading, JudgedFilm* judged,
                                    MeasuredPlaces* known) {
  const OrientationClass open = reading->orientations;
  InteriorResult result = judged->result;
  result.possible_orientations = open;
  auto votes = VotesOfFilm(scan, camera, shapes, result, open);
  votes.push_back(VoteOfLayout(camera, *reading, judged->marks, open, options.scanner));
  auto decision = Decide(open, votes);
  AddRivals(reading->rival_orientations, &decision);
  const ScanOrientation chosen = decision.possible.front();
  if (!decision.contradictory && !IsJudgedAlike(DepartureOf(camera.fiducials, open))) {
    *reading = ReadingIn(camera, *reading, chosen, options.scanner);
    *judged = JudgeReading(scan, camera, shapes, options, *reading, known);
    result = judged->result;
    if (!result.photo_from_pixel) return result;
  } else if (const auto likeliest = InOrientation(result, camera, shapes, chosen)) {
    result = *likeliest;
    result.orientation = std::nullopt;
  }
  result.possible_orientations = decision.possible;
  result.orientation_nats = decision.nats;
  const VoteNames names(camera, shapes, open.front(), chosen);
  result.orientation_evidence = names.Evidence(votes, open);
  Add(JudgeFound(decision.contradictory, names.Of(votes, decision.dissenting), decision.possible),
      &result);
  Add(JudgeOffScan(names.OffScan(votes), decision.possible), &result);
  if (decision.possible.size() == 1) result.orientation = chosen;
  return result;
}

// Orientation by the marks that the program finds.
InteriorResult OrientBySearch(const Raster& scan, const CameraFile& camera,
                              const MarkShapes& shapes, const InteriorOptions& options,
                              double* nats) {
  const bool reseau = std::ssize(camera.fiducials) >= kLeastReseauMarks;
  FilmReading reading = reseau ? ReadFilmByAnchors(scan, camera, shapes, options)
                               : ReadFilm(scan, camera, shapes, options,
                                          nats ? SearchRange::kWhole : SearchRange::kNearby);
  // Orientations that only pictures of marks distinguish are left open.
  if (!reseau) reading.orientations = reading.alike;
  MeasuredPlaces measured;
  JudgedFilm judged = JudgeReading(scan, camera, shapes, options, reading, &measured);
  InteriorResult result = judged.result;
  if (result.photo_from_pixel)
    result =
        options.orientation
            ? WithOrientationGiven(scan, camera, shapes, options, reading, judged)
            : WithOrientationFound(scan, camera, shapes, options, &reading, &judged, &measured);
  if (nats)
    *nats = NatsOfUsed(reading, judged.marks);
  else  // with several cameras, the function that compares them judges it
    Add(JudgePixelSize(reading, result), &result);
  return result;
}

// Orientation by the marks that a person clicked and those found from them; empty if that fails.
std::optional<InteriorResult> OrientByClicks(const Raster& scan, const CameraFile& camera,
                                             const MarkShapes& shapes,
                                             const InteriorOptions& options) {
  const auto reading = ReadFilmByClicks(scan, camera, shapes, options);
  if (!reading) return std::nullopt;
  MeasuredPlaces measured;
  const JudgedFilm judged = JudgeReading(scan, camera, shapes, options, *reading, &measured);
  if (!judged.result.photo_from_pixel) return std::nullopt;
  InteriorOptions named = options;
  named.orientation = reading->orientations.front();
  InteriorResult result = WithOrientationGiven(scan, camera, shapes, named, *reading, judged);
  Add(JudgePixelSize(*reading, result), &result);
  return result;
}

// For marks that the search found: they are measured, whatever the clicks say.
std::vector<MarkClick> Inexact(std::vector<MarkClick> clicks) {
  for (MarkClick& click : clicks) click.exact = false;
  return clicks;
}

// The result in the possible scan orientation in which most clicks name the right marks, with the
// wrong clicks reported; unchanged if no click does, or several orientations are equally good.
InteriorResult AsClicked(const InteriorResult& found, const CameraFile& camera,
                         const MarkShapes& shapes, const std::vector<MarkClick>& clicks) {
  InteriorResult best = found;
  std::ptrdiff_t most = 0;
  bool alike = false;
  const auto& possible = found.possible_orientations;
  const bool all_mirrored = std::all_of(possible.begin(), possible.end(), IsMirrored);
  for (const ScanOrientation orientation : possible) {
    if (IsMirrored(orientation) && !all_mirrored) continue;  // confused marks look mirrored
    const auto turned = InOrientation(found, camera, shapes, orientation);
    if (!turned) continue;
    const auto agreeing =
        std::count_if(turned->marks.begin(), turned->marks.end(), [&](const MarkResult& mark) {
          const MarkClick* click = ClickOn(clicks, mark.id);
          return click && mark.pixel && (*mark.pixel - click->pixel).norm() < ClickReach_px(*click);
        });
    alike = agreeing == most || (alike && agreeing < most);
    if (agreeing <= most) continue;
    most = agreeing;
    best = *turned;
  }
  if (most == 0 || alike) best = found;
  Add(most > 0 && alike ? Findings{AllClicksContradicted(clicks)}
                        : JudgeClicks(Inexact(clicks), best),
      &best);
  return best;
}

// Clicks take precedence. If they explain no film, and the program finds one, the
// clicks are reported as wrong.
InteriorResult OrientFilm(const Raster& scan, const CameraFile& camera, const MarkShapes& shapes,
                          const InteriorOptions& options, double* nats) {
  if (options.clicks.empty()) return OrientBySearch(scan, camera, shapes, options, nats);
  InteriorOptions without = options;
  without.clicks.clear();
  const auto clicked = OrientByClicks(scan, camera, shapes, options);
  if (!clicked)
    return AsClicked(OrientBySearch(scan, camera, shapes, without, nats), camera, shapes,
                     options.clicks);
  InteriorResult result = *clicked;
  Add(JudgeClicks(options.clicks, result), &result);
  return result;
}

// Where the transform predicts the marks that are not used.
void SetExpected(const CameraFile& camera, InteriorResult* result) {
  if (!result->photo_from_pixel) return;
  const Affine2d pixel_from_photo = result->photo_from_pixel->Inverse();
  for (size_t i = 0; i < result->marks.size(); ++i) {
    MarkResult& mark = result->marks[i];
    mark.expected.reset();
    if (mark.state != MarkState::kUsed)
      mark.expected = Vector2d(pixel_from_photo * camera.fiducials[i].position_mm);
  }
}

// Measured marks under their new names: the fiducial each one is in the other orientation, if any.
std::vector<MarkResult> Renamed(const std::vector<MarkResult>& marks, const CameraFile& camera,
                                const std::vector<int>& relabel) {
  std::vector<MarkResult> renamed(marks.size());
  for (size_t i = 0; i < marks.size(); ++i)
    if (relabel[i] >= 0) renamed[relabel[i]] = marks[i];
  for (size_t i = 0; i < marks.size(); ++i) renamed[i].id = camera.fiducials[i].id;
  return renamed;
}

}  // namespace

MarkShapes ShapesOf(const CameraFile& camera, const std::map<std::string, Image>& pictures) {
  MarkShapes shapes;
  for (const auto& [name, drawing] : camera.marks) {
    MarkShape shape{drawing, std::nullopt};
    if (drawing.image) {
      const auto picture = pictures.find(name);
      if (picture == pictures.end())
        throw std::invalid_argument("ShapesOf: the picture of mark " + name + " is missing");
      shape.picture = picture->second;
    }
    shapes.emplace(name, std::move(shape));
  }
  return shapes;
}

InteriorResult OrientInterior(const Raster& scan, const CameraFile& camera,
                              const MarkShapes& shapes, const InteriorOptions& options,
                              double* nats) {
  if (nats) *nats = 0;
  if (camera.camera.kind == CameraKind::kDigital) return OrientDigital(scan, camera.camera);
  CheckFilmCamera(camera, shapes);
  InteriorResult result = OrientFilm(scan, camera, shapes, options, nats);
  SetExpected(camera, &result);
  return result;
}

std::optional<InteriorResult> InOrientation(const InteriorResult& result, const CameraFile& camera,
                                            const MarkShapes& shapes, ScanOrientation orientation) {
  const auto& possible = result.possible_orientations;
  if (!result.photo_from_pixel || possible.empty()) return std::nullopt;
  if (std::find(possible.begin(), possible.end(), orientation) == possible.end())
    return std::nullopt;
  InteriorResult turned = result;
  turned.possible_orientations = {orientation};
  turned.orientation_nats = {};
  turned.orientation = orientation;
  if (camera.camera.kind == CameraKind::kDigital || orientation == possible.front()) return turned;

  if (result.marks.size() != camera.fiducials.size()) return std::nullopt;
  const auto alike = Relabel(camera.fiducials, shapes, possible.front(), orientation);
  // In a rival orientation of a reseau most crosses are in common, not all.
  if (!alike && std::ssize(camera.fiducials) < kLeastReseauMarks) return std::nullopt;
  const std::vector<int> relabel =
      alike ? *alike : RelabelInCommon(camera.fiducials, possible.front(), orientation);
  turned.marks = Renamed(result.marks, camera, relabel);
  const bool mirrored = IsMirrored(orientation);
  if (!FitUsedMarks(camera, mirrored, &turned)) return std::nullopt;
  CorrectFilm(camera, mirrored, &turned);
  if (result.reseau && !turned.reseau) return std::nullopt;  // no smooth film in this orientation
  SetExpected(camera, &turned);
  RenameSymbols(camera, relabel, &turned.orientation_evidence);
  return turned;
}

}  // namespace orient::interior
