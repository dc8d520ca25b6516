// Speed of the assignment of marks: the exact search, and softassign for comparison.
//
//   assignment_speed [SOLVES]
//
// Prints the processor time of one solve, also as a multiple of a least-squares affine fit to the
// same number of points, measured in the same run; and how many solves were stopped before they
// were proven. Scenes are simulated: true marks displaced according to the prior, uniform clutter.
#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>

#include "core/geometry/transform2d.h"
#include "interior/constellation/assignment.h"
#include "interior/constellation/softassign.h"

namespace orient {
namespace {

using Eigen::Vector2d;

// Time of this process only: other work on the machine does not count.
double ProcessorMs() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Bench {
  const char* name;
  std::vector<Vector2d> places;
  double window_mm;
  int clutter;
  double found;  // probability that a mark's true place is among its candidates
  interior::ConstellationPrior prior;
};

std::vector<Vector2d> P31Marks() {
  return {{0, -53.1}, {-71.9, -18.7}, {0, 53.1}, {71.9, -18.7}, {0, -18.7}};
}

std::vector<Vector2d> CornersAndSides() {
  return {{-106, -106}, {106, -106}, {106, 106}, {-106, 106},
          {0, -106},    {106, 0},    {0, 106},   {-106, 0}};
}

std::vector<Vector2d> Reseau() {
  std::vector<Vector2d> places;
  for (int row = -2; row <= 2; ++row)
    for (int col = -2; col <= 2; ++col) places.emplace_back(50.0 * col, 50.0 * row);
  return places;
}

std::vector<interior::AssignmentMark> MakeScene(const Bench& bench, std::mt19937* random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-0.5 * bench.window_mm, 0.5 * bench.window_mm);
  std::bernoulli_distribution is_there(bench.found);
  const Vector2d shift = 0.12 * bench.window_mm * Vector2d(normal(*random), normal(*random));
  Eigen::Matrix2d deformed = Eigen::Rotation2Dd(0.004 * normal(*random)).toRotationMatrix();
  deformed.col(0) *= 1 + bench.prior.affinity * normal(*random);
  std::vector<interior::AssignmentMark> marks;
  for (const Vector2d& place : bench.places) {
    interior::AssignmentMark mark{place, {}, bench.window_mm * bench.window_mm};
    if (is_there(*random)) {
      const Vector2d noise =
          0.5 * bench.prior.point_mm * Vector2d(normal(*random), normal(*random));
      mark.candidates.push_back({deformed * place + shift + noise, 0});
    }
    for (int k = 0; k < bench.clutter; ++k)
      mark.candidates.push_back({place + Vector2d(uniform(*random), uniform(*random)), 0});
    std::shuffle(mark.candidates.begin(), mark.candidates.end(), *random);
    marks.push_back(std::move(mark));
  }
  return marks;
}

// Mean processor time of one affine fit to the marks of the scene.
double AffineMs(const Bench& bench) {
  std::vector<PointPair2d> pairs;
  for (const Vector2d& place : bench.places) pairs.push_back({place, place});
  constexpr int kFits = 2000;
  const double start = ProcessorMs();
  double sum = 0;
  for (int i = 0; i < kFits; ++i) {
    pairs[0].target.x() += 1e-6;
    const auto fit = FitAffine(pairs);
    if (fit) sum += fit->sigma0;
  }
  const double ms = (ProcessorMs() - start) / kFits;
  return sum >= 0 ? ms : 0;
}

bool SolveExactly(const std::vector<interior::AssignmentMark>& marks,
                  const interior::ConstellationPrior& prior) {
  return interior::AssignMarks(marks, prior).proven;
}

bool SolveBySoftassign(const std::vector<interior::AssignmentMark>& marks,
                       const interior::ConstellationPrior& prior) {
  std::vector<interior::SoftassignMark> soft;
  for (const interior::AssignmentMark& mark : marks) {
    soft.push_back({mark.place_mm, {}});
    for (const interior::AssignmentCandidate& c : mark.candidates)
      soft.back().candidates.push_back(c.position_mm);
  }
  interior::SoftassignOptions options;
  options.first_temperature = 2 * marks[0].window_mm2;
  options.last_temperature = 4 * prior.point_mm * prior.point_mm;
  return interior::SoftassignAsPublished(soft, options).solves > 0;
}

using Method = bool (*)(const std::vector<interior::AssignmentMark>&,
                        const interior::ConstellationPrior&);

void Run(const Bench& bench, int solves, Method method = &SolveExactly) {
  std::mt19937 random(20);
  std::vector<double> ms;
  int unproven = 0;
  for (int i = 0; i < solves; ++i) {
    const auto marks = MakeScene(bench, &random);
    const double start = ProcessorMs();
    unproven += !method(marks, bench.prior);
    ms.push_back(ProcessorMs() - start);
  }
  std::sort(ms.begin(), ms.end());
  const double median = ms[ms.size() / 2];
  std::printf("%-42s %9.3f %9.3f %9.3f %9.0f %9d\n", bench.name, median, ms[ms.size() * 99 / 100],
              ms.back(), median / AffineMs(bench), unproven);
}

void RunUnder(const interior::ConstellationPrior& prior, int solves) {
  Run({"8 marks, true ones and 19 clutter", CornersAndSides(), 30, 19, 1.0, prior}, solves);
  Run({"8 marks, 20 clutter, found 0.8", CornersAndSides(), 30, 20, 0.8, prior}, solves);
  Run({"8 marks, 20 clutter only", CornersAndSides(), 30, 20, 0.0, prior}, solves);
  const int few = std::max(1, solves / 20);
  Run({"reseau of 25, true ones and 19 clutter", Reseau(), 30, 19, 1.0, prior}, few);
  Run({"reseau of 25, 20 clutter, found 0.8", Reseau(), 30, 20, 0.8, prior}, few);
  Run({"reseau of 25, 20 clutter only", Reseau(), 30, 20, 0.0, prior}, few);
}

}  // namespace
}  // namespace orient

int main(int argc, char** argv) {
  using namespace orient;
  const int solves = argc > 1 ? std::max(1, std::atoi(argv[1])) : 200;
  interior::ConstellationPrior fine;
  fine.shift_mm = Eigen::Vector2d(2, 2);
  fine.turn_rad = 0.01;
  fine.scale = 0.001;
  fine.affinity = 1.5e-4;
  fine.point_mm = 0.0125;
  fine.found = 0.9;
  std::printf("%-42s %9s %9s %9s %9s %9s\n", "ms a solve", "median", "99 %", "most", "/ affine",
              "unproven");
  Run({"P31, 5 marks, 20 clutter", P31Marks(), 5, 20, 1.0, fine}, solves);
  Run({"P31, 5 marks, 20 clutter, found 0.8", P31Marks(), 5, 20, 0.8, fine}, solves);
  Run({"P31, 5 marks, 20 clutter only", P31Marks(), 5, 20, 0.0, fine}, solves);
  Run({"P31, 5 marks, 20 clutter: softassign", P31Marks(), 5, 20, 1.0, fine}, solves,
      &SolveBySoftassign);
  std::printf("photogrammetric scanner\n");
  fine.shift_mm = Eigen::Vector2d(5, 5);
  RunUnder(fine, solves);
  std::printf("desktop scanner\n");
  interior::ConstellationPrior desktop;
  desktop.shift_mm = Eigen::Vector2d(5, 5);
  desktop.affinity = 0.0125;
  RunUnder(desktop, solves);
}
