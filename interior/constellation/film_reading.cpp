#include "interior/constellation/film_reading.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "interior/constellation/softassign.h"

namespace orient::interior {

using Eigen::Vector2d;

double PriorAffinity(Scanner scanner) {
  return scanner == Scanner::kPhotogrammetric ? 1.5e-4 : 0.0125;
}

ConstellationPrior PriorOf(Scanner scanner, const PixelSizeGuess& pixel_size,
                           const Vector2d& free_mm, double coarse_pixel_mm) {
  const bool photogrammetric = scanner == Scanner::kPhotogrammetric;
  ConstellationPrior prior;
  prior.shift_mm = 0.6 * free_mm + Vector2d::Constant(2.0);
  prior.turn_rad = 0.03;
  prior.scale = std::hypot(pixel_size.sigma, photogrammetric ? 0.001 : 0.006);
  prior.affinity = PriorAffinity(scanner);
  prior.point_mm = std::hypot(photogrammetric ? 0.02 : 0.12, 0.35 * coarse_pixel_mm);
  return prior;
}

double OrientationMargin(const FilmReading& reading) {
  double margin = std::numeric_limits<double>::infinity();
  for (const RivalOrientation& rival : reading.rival_orientations)
    margin = std::min(margin, rival.nats);
  return margin;
}

ConstellationPrior PriorIn(const FilmReading& reading, Scanner scanner,
                           const LayoutDeparture& departure) {
  ConstellationPrior prior =
      PriorOf(scanner, reading.pixel_size, reading.free_mm, reading.coarse_pixel_mm);
  prior.point_mm = std::hypot(prior.point_mm, reading.bend_mm, departure.point_mm);
  prior.affinity = std::hypot(prior.affinity, departure.affinity);
  return prior;
}

namespace {

// In millimetres; the temperatures follow from the prior as the paper's from its search range and
// the candidates' precision.
std::vector<int> ChoiceBySoftassign(const FilmReading& reading) {
  std::vector<SoftassignMark> marks;
  for (const AssignmentMark& mark : reading.marks) {
    SoftassignMark one{mark.place_mm, {}};
    for (const AssignmentCandidate& candidate : mark.candidates)
      one.candidates.push_back(candidate.position_mm);
    marks.push_back(std::move(one));
  }
  SoftassignOptions options;
  options.first_temperature = std::pow(2 * (reading.prior.shift_mm.maxCoeff() + 1), 2);
  options.last_temperature = std::pow(2 * reading.prior.point_mm, 2);
  return Softassign(marks, options).choice;
}

AssignmentAnswer AnswerOf(const FilmReading& reading) {
  AssignmentAnswer answer = AssignMarks(reading.marks, reading.prior);
  if (reading.assignment == AssignmentMethod::kExact) return answer;
  const std::vector<int> choice = ChoiceBySoftassign(reading);
  if (choice == answer.best.choice) return answer;
  answer.second = answer.best;
  answer.best = {choice, NatsOfSet(reading.marks, reading.prior, choice)};
  return answer;
}

}  // namespace

void Assign(FilmReading* reading) {
  const AssignmentAnswer answer = AnswerOf(*reading);
  reading->best = answer.best;
  reading->second = answer.second;
  reading->proven = answer.proven;
  reading->margin = answer.proven ? answer.best.nats - std::max(answer.second.nats, 0.0) : 0;
}

}  // namespace orient::interior
