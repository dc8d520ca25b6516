#include "interior/orientation/layout_vote.h"

#include <algorithm>
#include <cmath>

#include "interior/constellation/rival_readings.h"
#include "interior/orientation/reseau.h"

namespace orient::interior {
namespace {

constexpr double kSymmetricMm = 1e-6;  // smaller departures from symmetry are none
constexpr double kScatters_mm[] = {0.02, 0.035, 0.06, 0.12};

// The used marks' measured positions in place of the candidates: one candidate per mark.
struct Constellation {
  std::vector<AssignmentMark> marks;
  std::vector<int> choice;
  double sigma_mm = 0;  // of a coordinate, measured less stated
};

// The camera file's variance of a mark's coordinates, mean of both, mm^2; 0: not stated.
double StatedVariance(const Fiducial& mark) {
  return mark.sigma_mm ? 0.5 * mark.sigma_mm->squaredNorm() : 0;
}

Constellation Measured(const CameraFile& camera, const FilmReading& reading,
                       const FilmMarks& marks) {
  Constellation result{reading.marks, std::vector<int>(marks.size(), -1), 0};
  const double p = reading.pixel_size.pixel_mm;
  double variance = 0;
  int used = 0;
  for (size_t i = 0; i < marks.size(); ++i) {
    if (marks[i].state != MarkState::kUsed) continue;
    result.marks[i].candidates = {{(marks[i].position->pixel - reading.middle_px) * p, 0}};
    result.choice[i] = 0;
    variance +=
        0.5 * marks[i].position->covariance.trace() * p * p + StatedVariance(camera.fiducials[i]);
    ++used;
  }
  if (used > 0) result.sigma_mm = std::sqrt(variance / used);
  return result;
}

// Places as calibrated if the film lay in `orientation`; the marks keep their order.
void PlaceIn(const CameraFile& camera, ScanOrientation orientation, const std::vector<int>& relabel,
             std::vector<AssignmentMark>* marks) {
  const MarkRectangle rectangle = RectangleOfMarks(camera.fiducials);
  for (size_t i = 0; i < marks->size(); ++i)
    (*marks)[i].place_mm =
        PlaceOnScan(camera.fiducials[relabel[i]].position_mm, rectangle, orientation);
}

double Evidence(const Constellation& seen, const FilmReading& reading,
                std::optional<Scanner> scanner) {
  const bool photogrammetric = scanner == Scanner::kPhotogrammetric;
  ConstellationPrior prior = reading.prior;
  // A film's own two scales differ by more than the prior's 1.5e-4: they must not decide.
  prior.affinity = photogrammetric ? 0.001 : PriorAffinity(Scanner::kDesktop);
  double best = -std::numeric_limits<double>::infinity();
  for (const double scatter_mm : kScatters_mm) {
    prior.point_mm = std::hypot(scatter_mm, seen.sigma_mm);
    best = std::max(best, NatsOfSet(seen.marks, prior, seen.choice));
  }
  return best;
}

}  // namespace

OrientationVote VoteOfLayout(const CameraFile& camera, const FilmReading& reading,
                             const FilmMarks& marks, const OrientationClass& open,
                             std::optional<Scanner> scanner) {
  OrientationVote vote{std::vector<double>(open.size(), 0)};
  vote.layout = true;
  const LayoutDeparture departure = DepartureOf(camera.fiducials, open);
  if (departure.point_mm < kSymmetricMm && departure.affinity < kSymmetricMm) return vote;
  Constellation seen = Measured(camera, reading, marks);
  for (size_t o = 0; o < open.size(); ++o) {
    PlaceIn(camera, open[o], RelabelAlike(camera.fiducials, open.front(), open[o]), &seen.marks);
    vote.nats[o] = Evidence(seen, reading, scanner);
  }
  const auto [least, most] = std::minmax_element(vote.nats.begin(), vote.nats.end());
  const double middle = 0.5 * (*least + *most);
  for (double& nats : vote.nats) nats -= middle;
  return vote;
}

FilmReading ReadingIn(const CameraFile& camera, const FilmReading& reading,
                      ScanOrientation orientation, std::optional<Scanner> scanner) {
  const std::vector<int> relabel =
      RelabelAlike(camera.fiducials, reading.orientations.front(), orientation);
  std::vector<AssignmentMark> placed = reading.marks;
  PlaceIn(camera, orientation, relabel, &placed);
  FilmReading renamed = reading;
  renamed.orientations = {orientation};
  for (size_t i = 0; i < relabel.size(); ++i) {
    renamed.marks[relabel[i]] = placed[i];
    renamed.candidates[relabel[i]] = reading.candidates[i];
    if (!reading.windows.empty()) renamed.windows[relabel[i]] = reading.windows[i];
    renamed.best.choice[relabel[i]] = reading.best.choice[i];
  }
  if (std::ssize(renamed.marks) >= kLeastReseauMarks) {
    renamed.prior = PriorIn(renamed, renamed.scanner, {});
    renamed.best.nats = NatsOfSet(renamed.marks, renamed.prior, renamed.best.choice);
    return renamed;
  }
  std::vector<FilmReading> readings;
  for (const Scanner one : {Scanner::kPhotogrammetric, Scanner::kDesktop}) {
    if (scanner.value_or(one) != one) continue;
    readings.push_back(renamed);
    readings.back().scanner = one;
    readings.back().scanner_margin = std::numeric_limits<double>::infinity();
    readings.back().prior = PriorIn(renamed, one, {});
    Assign(&readings.back());
  }
  FilmReading best = BestOf(readings);
  best.margin = std::min(best.margin, reading.margin);
  return best;
}

}  // namespace orient::interior
