// What the scanner's prior lets pass: constellations read as ReadFilm reads them, under both
// priors.
#include "interior/constellation/film_search.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <numbers>
#include <random>

#include "interior/constellation/rival_readings.h"
#include "interior/constellation/set_evidence.h"
#include "interior/judge.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

struct Spec {
  Scanner scanner = Scanner::kPhotogrammetric;
  int marks = 4;
  int clutter = 8;
  double found = 1.0;
  double displaced_mm = 0;  // of one mark
};

struct Scene {
  std::vector<AssignmentMark> marks;
  std::vector<int> truth;  // a displaced mark's candidate is not its truth
};

struct Outcome {
  FilmReading reading;
  std::vector<int> kept;
  Status status = Status::kFailed;
  bool RightSet(const Scene& scene) const {
    for (size_t i = 0; i < kept.size(); ++i)
      if (kept[i] >= 0 && kept[i] != scene.truth[i]) return false;
    return true;
  }
};

constexpr double kHalfWindow = 15;
constexpr double kPixel = 0.1;

class Films {
 public:
  explicit Films(unsigned seed) : random_(seed) {}

  Scene Make(const Spec& spec) {
    const double m = 106;
    const std::vector<Vector2d> places = {{-m, -m}, {m, m}, {-m, m}, {m, -m},
                                          {-m, 0},  {m, 0}, {0, m},  {0, -m}};
    const bool desktop = spec.scanner == Scanner::kDesktop;
    const Eigen::Matrix2d film = Film(desktop);
    const Vector2d shift(3 * Normal(), 3 * Normal());
    const int displaced = spec.displaced_mm > 0 ? static_cast<int>(Uniform(0, spec.marks)) : -1;
    Scene scene;
    for (int i = 0; i < spec.marks; ++i) {
      AssignmentMark mark{places[i], {}, 4 * kHalfWindow * kHalfWindow};
      for (int k = 0; k < spec.clutter; ++k)  // one in ten looks like a mark
        mark.candidates.push_back(
            {places[i] + kHalfWindow * Vector2d(Uniform(-1, 1), Uniform(-1, 1)),
             Uniform(0, 1) < 0.1 ? 1.0 : -1.5});
      int truth = -1;
      if (Uniform(0, 1) < spec.found) {
        const double angle = Uniform(0, 2 * std::numbers::pi);
        const double bend = desktop ? 0.08 : 0.01;
        Vector2d at = film * places[i] + shift + bend * Vector2d(Normal(), Normal());
        if (i == displaced) at += spec.displaced_mm * Vector2d(std::cos(angle), std::sin(angle));
        if (i != displaced) truth = spec.clutter;
        mark.candidates.push_back({at, 1.5});
      }
      scene.truth.push_back(truth);
      scene.marks.push_back(std::move(mark));
    }
    return scene;
  }

  double Uniform(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random_);
  }

 private:
  Eigen::Matrix2d Film(bool desktop) {
    const double d = (desktop ? 0.01 : 1.5e-4) * Normal();
    const double e = (desktop ? 0.003 : 1.5e-4) * Normal();
    Eigen::Matrix2d film = Eigen::Rotation2Dd(0.01 * Normal()).toRotationMatrix();
    film *= 1 + 0.003 * Normal();
    film *= (Eigen::Matrix2d() << 1 + d / 2, e / 2, e / 2, 1 - d / 2).finished();
    return film;
  }
  double Normal() { return std::normal_distribution<double>()(random_); }
  std::mt19937 random_;
};

FilmReading ReadWith(const Scene& scene, Scanner scanner) {
  FilmReading reading;
  reading.scanner = scanner;
  reading.pixel_size = {kPixel, 0.008};
  reading.orientations = {ScanOrientation::kR0};
  reading.prior = PriorOf(scanner, reading.pixel_size, {5, 5}, 0.06);
  reading.marks = scene.marks;
  for (const AssignmentMark& mark : scene.marks) {
    reading.candidates.emplace_back();
    for (const AssignmentCandidate& c : mark.candidates)
      reading.candidates.back().push_back({c.position_mm / kPixel, 0.8});
  }
  Assign(&reading);
  return reading;
}

// As the pipeline does, with the candidates for measured marks.
Outcome Orient(const Scene& scene) {
  Outcome outcome;
  outcome.reading =
      BestOf({ReadWith(scene, Scanner::kPhotogrammetric), ReadWith(scene, Scanner::kDesktop)});
  const FilmReading& reading = outcome.reading;
  outcome.kept = WithoutContradicted(reading.marks, reading.prior, reading.best.choice);
  FilmMarks marks(scene.marks.size());
  std::vector<MeasuredMark> measured;
  for (size_t i = 0; i < marks.size(); ++i) {
    if (outcome.kept[i] < 0) continue;
    marks[i].state = MarkState::kUsed;
    const Vector2d& place = scene.marks[i].place_mm;
    measured.push_back({reading.candidates[i][outcome.kept[i]].pixel, {place.x(), -place.y()}});
  }
  outcome.status = StatusOf(Judge(reading, marks, FitFilm(measured, false), {}));
  return outcome;
}

// Shares of all scenes.
struct Tally {
  double ok = 0, false_ok = 0;  // false: a clutter candidate or the displaced one is in
  double weak = 0, false_weak = 0;
  double desktop = 0;
};

Tally Count(const Spec& spec, int trials, unsigned seed) {
  Films films(seed);
  Tally tally;
  const double one = 1.0 / trials;
  for (int i = 0; i < trials; ++i) {
    const Scene scene = films.Make(spec);
    const Outcome outcome = Orient(scene);
    const bool right = outcome.RightSet(scene);
    if (outcome.status == Status::kOk) (right ? tally.ok : tally.false_ok) += one;
    if (outcome.status == Status::kWeak) (right ? tally.weak : tally.false_weak) += one;
    tally.desktop += outcome.reading.scanner == Scanner::kDesktop ? one : 0;
  }
  std::printf(
      "%d marks, %s, clutter %d, found %.2f, one displaced by %.2f mm: ok %.3f, false %.4f; "
      "weak %.3f, false %.4f; read as desktop %.3f\n",
      spec.marks, spec.scanner == Scanner::kDesktop ? "desktop" : "photogrammetric", spec.clutter,
      spec.found, spec.displaced_mm, tally.ok, tally.false_ok, tally.weak, tally.false_weak,
      tally.desktop);
  return tally;
}

void ExpectTheScannerIsToldByTheMarks(int trials) {
  const Tally fine = Count({}, trials, TestSeed());
  EXPECT_GE(fine.ok, 0.99);
  EXPECT_LE(fine.desktop, 0.01);
  const Tally bent = Count({.scanner = Scanner::kDesktop}, trials, TestSeed());
  EXPECT_GE(bent.ok, 0.93);
  EXPECT_GE(bent.desktop, 0.93);
}

void ExpectClutterIsNeverOk(int trials) {
  for (const int marks : {4, 8})
    for (const int clutter : {8, 20}) {
      const Tally tally =
          Count({.marks = marks, .clutter = clutter, .found = 0}, trials, TestSeed());
      EXPECT_LE(tally.false_ok, 0.002);
      EXPECT_LE(tally.false_weak, 0.005);
    }
}

void ExpectAMisplacedMarkIsNotAccepted(int trials) {
  for (const double displaced_mm : {0.3, 0.4, 0.5, 0.7, 1.0, 2.0, 5.0}) {
    EXPECT_LE(Count({.displaced_mm = displaced_mm}, trials, TestSeed()).false_ok, 0.02);
    const Tally eight = Count({.marks = 8, .displaced_mm = displaced_mm}, trials, TestSeed());
    EXPECT_LE(eight.false_ok, 0.005);
    EXPECT_GE(eight.ok, 0.95);
  }
}

TEST(ScannerPrior, IsToldByTheMarks) { ExpectTheScannerIsToldByTheMarks(150); }
TEST(SlowScannerPrior, IsToldByTheMarks) { ExpectTheScannerIsToldByTheMarks(2000); }
TEST(ScannerPrior, ClutterAloneIsNeverOk) { ExpectClutterIsNeverOk(20); }
TEST(SlowScannerPrior, ClutterAloneIsNeverOk) { ExpectClutterIsNeverOk(1000); }
TEST(ScannerPrior, AMisplacedMarkOfAFineScanIsNotTakenForADesktopScan) {
  ExpectAMisplacedMarkIsNotAccepted(40);
}
TEST(SlowScannerPrior, AMisplacedMarkOfAFineScanIsNotTakenForADesktopScan) {
  ExpectAMisplacedMarkIsNotAccepted(1000);
}

TEST(ScannerPrior, WhoNamesADesktopScannerGetsAllFourMarks) {
  Films films(TestSeed());
  int ok = 0;
  for (int i = 0; i < 50; ++i) {
    const FilmReading reading =
        BestOf({ReadWith(films.Make({.displaced_mm = 0.3}), Scanner::kDesktop)});
    EXPECT_EQ(reading.scanner_margin, std::numeric_limits<double>::infinity());
    ok += reading.best.Matched() == 4;
  }
  EXPECT_GE(ok, 45);
}

TEST(Judge, ThreeOfFourMarksAreWeakHoweverLargeTheMargin) {
  EXPECT_EQ(JudgeSet(4, 3, 1e3, 1e3), Status::kWeak);
  EXPECT_EQ(JudgeSet(4, 4, 1e3, 1e3), Status::kOk);
  EXPECT_EQ(JudgeSet(8, 4, 1e3, 1e3), Status::kWeak);  // 60 % are five
  EXPECT_EQ(JudgeSet(8, 5, 1e3, 1e3), Status::kOk);
  EXPECT_EQ(JudgeSet(8, 8, 15, 1e3), Status::kFailed);  // more marks, more chances
  EXPECT_EQ(JudgeSet(3, 3, 1e3, 1e3), Status::kWeak);
  EXPECT_EQ(JudgeSet(4, 2, 1e3, 1e3), Status::kFailed);
  EXPECT_EQ(JudgeSet(4, 4, 1e3, 3.0), Status::kFailed);
  EXPECT_EQ(JudgeSet(4, 4, 8.9, 1e3), Status::kFailed);
}

// Eight marks found, of which the measuring keeps five: what these earn alone decides.
TEST(Judge, RejectedMarksBearNoWitness) {
  Films films(TestSeed());
  const Scene scene = films.Make({.marks = 8, .clutter = 8});
  FilmReading reading = ReadWith(scene, Scanner::kPhotogrammetric);
  ASSERT_EQ(reading.best.choice, scene.truth);
  // Clutter so dense that a mark earns little.
  for (AssignmentMark& mark : reading.marks) mark.window_mm2 = 1.0;
  const auto verdict = [&](int used) {
    FilmMarks marks(reading.marks.size());
    std::vector<MeasuredMark> measured;
    std::vector<int> kept(marks.size(), -1);
    for (int i = 0; i < used; ++i) {
      marks[i].state = MarkState::kUsed;
      kept[i] = reading.best.choice[i];
      const Vector2d& place = reading.marks[i].place_mm;
      measured.push_back({reading.candidates[i][kept[i]].pixel, {place.x(), -place.y()}});
    }
    reading.margin = 30;
    reading.best.nats = NatsOfSet(reading.marks, reading.prior, reading.best.choice);
    std::printf("%d used: %.1f nats of %.1f, %.1f needed\n", used,
                NatsOfSet(reading.marks, reading.prior, kept), reading.best.nats, MinSetNats(8));
    return StatusOf(Judge(reading, marks, FitFilm(measured, false), {}));
  };
  EXPECT_EQ(verdict(8), Status::kOk);
  EXPECT_EQ(verdict(5), Status::kFailed);
}

FilmReading ReadingOf(const Scene& scene, std::vector<int> choice) {
  FilmReading reading = ReadWith(scene, Scanner::kPhotogrammetric);
  reading.best.choice = std::move(choice);
  reading.best.nats = NatsOfSet(reading.marks, reading.prior, reading.best.choice);
  reading.margin = 30;
  return reading;
}

// Two films in one scan: the marks 0 to 3 say one thing, 4 to 7 another, 5 mm off.
// Four marks with one clutter candidate beside each.
FilmReading SquareRead(AssignmentMethod method, double clutter_mm) {
  FilmReading reading;
  reading.assignment = method;
  reading.pixel_size = {kPixel, 0.008};
  reading.orientations = {ScanOrientation::kR0};
  reading.prior = PriorOf(Scanner::kDesktop, reading.pixel_size, {5, 5}, 0.06);
  for (const Vector2d& place :
       {Vector2d(-106, -106), Vector2d(106, -106), Vector2d(106, 106), Vector2d(-106, 106)}) {
    AssignmentMark mark;
    mark.place_mm = place;
    mark.window_mm2 = 900;
    const Vector2d seen = place + Vector2d(1.5, -0.5);
    mark.candidates = {{seen + clutter_mm * Vector2d(place.y(), 106).normalized(), 0}, {seen, 1}};
    reading.marks.push_back(mark);
  }
  Assign(&reading);
  return reading;
}

TEST(AssignBySoftassign, FindsTheMarksThatTheExactSearchFinds) {
  const FilmReading soft = SquareRead(AssignmentMethod::kSoftassign, 4);
  const FilmReading exact = SquareRead(AssignmentMethod::kExact, 4);
  EXPECT_EQ(soft.best.choice, std::vector<int>({1, 1, 1, 1}));
  EXPECT_EQ(soft.best.choice, exact.best.choice);
  EXPECT_EQ(soft.margin, exact.margin);
}

TEST(BestOf, ReadingsWithoutCommonMarksAreRivalsWhereTheirTransformsDiffer) {
  Films films(TestSeed());
  const Scene scene = films.Make({.marks = 8, .clutter = 0});
  Scene moved = scene;
  for (AssignmentMark& mark : moved.marks) mark.candidates[0].position_mm += Vector2d(5, 0);
  const FilmReading first = ReadingOf(scene, {0, 0, 0, 0, -1, -1, -1, -1});
  const FilmReading same = ReadingOf(scene, {-1, -1, -1, -1, 0, 0, 0, 0});
  const FilmReading other = ReadingOf(moved, {-1, -1, -1, -1, 0, 0, 0, 0});
  const FilmReading nothing = ReadingOf(scene, std::vector<int>(8, -1));
  EXPECT_DOUBLE_EQ(BestOf({first, same}).margin, 30);
  EXPECT_DOUBLE_EQ(BestOf({first, nothing}).margin, 30);
  EXPECT_NEAR(BestOf({first, other}).margin, std::abs(first.best.nats - other.best.nats), 1e-9);
}

// Why: of such sets a good share is false, whatever their margin.
void ExpectThreeOfFourAreNeverOk(int trials) {
  int all_weak = 0;
  for (const Scanner scanner : {Scanner::kPhotogrammetric, Scanner::kDesktop}) {
    Films films(TestSeed());
    int weak = 0, wrong = 0;
    for (int i = 0; i < trials; ++i) {
      const Scene scene = films.Make({.scanner = scanner, .clutter = 20, .found = 0.6});
      const Outcome outcome = Orient(scene);
      const auto used =
          std::count_if(outcome.kept.begin(), outcome.kept.end(), [](int c) { return c >= 0; });
      if (used != 3) continue;
      EXPECT_NE(outcome.status, Status::kOk);
      weak += outcome.status == Status::kWeak;
      wrong += outcome.status == Status::kWeak && !outcome.RightSet(scene);
    }
    std::printf("three of four: %d weak of %d, %.3f of them false\n", weak, trials,
                1.0 * wrong / std::max(weak, 1));
    all_weak += weak;
  }
  EXPECT_GT(all_weak, 0);
}
TEST(Judge, ThreeOfFourMarksAreNeverOk) { ExpectThreeOfFourAreNeverOk(60); }
TEST(SlowJudge, ThreeOfFourMarksAreNeverOk) { ExpectThreeOfFourAreNeverOk(2000); }

}  // namespace
}  // namespace orient::interior
