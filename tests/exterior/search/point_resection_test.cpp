#include "exterior/search/point_resection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <random>
#include <stdexcept>

#include "core/geometry/collinearity.h"
#include "core/geometry/rotation.h"
#include "exterior/search/point_checks.h"
#include "exterior/steps/resect.h"

namespace orient::exterior {
namespace {

constexpr double kPixel_mm = 0.025;
constexpr double kClick_px = 1;

Camera FilmCamera() {
  Camera camera;
  camera.principal_distance_mm = 153.0;
  camera.frame_mm = {230, 230};
  return camera;
}

FilmPosition Scan() {
  FilmPosition position;
  position.photo_from_pixel = {kPixel_mm * PhotoFromPixelAxes(ScanOrientation::kR0), {-115, 115}};
  return position;
}

Pose Truth() { return {{612345.6, 5123456.7, 1843.2}, {0.021, -0.034, 2.2}}; }

// Clicks with the stated errors on points spread over the frame, with 100 m of relief.
std::vector<MeasuredPoint> Clicks(int count, unsigned seed, double apart_mm = 50,
                                  double sigma_px = kClick_px, double sigma_m = 0.2) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-105, 105), height(100, 200);
  std::normal_distribution<double> noise(0, sigma_px), ground_noise(0, sigma_m);
  const Camera camera = FilmCamera();
  const PhotoView view{camera, Scan().photo_from_pixel, Truth()};
  std::vector<MeasuredPoint> clicks;
  while (std::ssize(clicks) < count) {
    const Eigen::Vector2d at(place(random), place(random));
    const bool close = std::any_of(clicks.begin(), clicks.end(), [&](const MeasuredPoint& other) {
      return (view.PhotoFromPixel(other.pixel) - at).norm() < apart_mm;
    });
    if (close) continue;
    const Ray ray = GroundRayFromPhoto(camera, Truth(), at).value();
    MeasuredPoint click;
    click.name = "p" + std::to_string(clicks.size() + 1);
    click.ground_m =
        ray.origin_m + ray.direction * (height(random) - ray.origin_m.z()) / ray.direction.z();
    click.pixel =
        *view.PixelFromGround(click.ground_m) + Eigen::Vector2d(noise(random), noise(random));
    click.ground_m +=
        Eigen::Vector3d(ground_noise(random), ground_noise(random), ground_noise(random));
    click.sigma_m = Eigen::Vector3d::Constant(sigma_m);
    click.sigma_px = sigma_px;
    clicks.push_back(click);
  }
  return clicks;
}

PosePrior Approximation() {
  PosePrior prior{Truth(), Matrix6d::Identity()};
  prior.pose.position_m += Eigen::Vector3d(8, -6, 4);
  prior.covariance.diagonal() << 100, 100, 100, 3e-3, 3e-3, 3e-3;
  return prior;
}

PointResection Resected(const std::vector<MeasuredPoint>& clicks,
                        const std::optional<PosePrior>& prior = std::nullopt) {
  return ResectByPoints(FilmCamera(), {Scan()}, prior, clicks);
}

double SigmasOff(const PointPose& found) {
  Vector6d error = found.pose.AsVector() - Truth().AsVector();
  for (int i = 3; i < 6; ++i) error[i] = NormalizeAngle(error[i]);
  return std::sqrt(error.dot(found.covariance.inverse() * error));
}

// Of six degrees of freedom, once in 10^6.
constexpr double kMostSigmas = 6.2;

TEST(ResectByPoints, FourClicksGiveAPoseAsPreciseAsItSays) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const PointResection answer = Resected(Clicks(4, seed));
    ASSERT_TRUE(answer.found) << seed;
    EXPECT_EQ(answer.found->Used(), 4);
    EXPECT_LT(SigmasOff(*answer.found), kMostSigmas) << seed;
  }
}

TEST(ResectByPoints, ThreeClicksNeedAnApproximation) {
  const auto clicks = Clicks(3, 5);
  const PointResection without = Resected(clicks);
  EXPECT_FALSE(without.found);
  EXPECT_EQ(without.findings.front().reason, Reason::kTooFewPoints);
  const PointResection with = Resected(clicks, Approximation());
  ASSERT_TRUE(with.found);
  EXPECT_LT(SigmasOff(*with.found), kMostSigmas);
}

TEST(ResectByPoints, AWrongApproximationDoesNotMoveFourClicks) {
  PosePrior wrong = Approximation();
  wrong.pose.position_m += Eigen::Vector3d(5000, 0, 0);
  const PointResection answer = Resected(Clicks(4, 7), wrong);
  ASSERT_TRUE(answer.found);
  EXPECT_LT(SigmasOff(*answer.found), kMostSigmas);
}

TEST(ResectByPoints, OfFourContradictoryClicksNoneIsBelieved) {
  auto clicks = Clicks(4, 3);
  clicks[1].pixel.x() += 3 / kPixel_mm;
  const PointResection answer = Resected(clicks);
  EXPECT_FALSE(answer.found);
  EXPECT_EQ(StatusOf(answer.findings), Status::kFailed);
}

TEST(ResectByPoints, PointsOnOneLineHaveNoPose) {
  auto clicks = Clicks(4, 3);
  const PhotoView view{FilmCamera(), Scan().photo_from_pixel, Truth()};
  for (int i = 0; i < 4; ++i) {
    clicks[i].ground_m = Truth().position_m + Eigen::Vector3d(300.0 * i - 450, 0, -1700);
    clicks[i].pixel = *view.PixelFromGround(clicks[i].ground_m);
  }
  EXPECT_FALSE(Resected(clicks).found);
}

TEST(ResectByPoints, CheckPointsAreNoPartOfThePose) {
  auto clicks = Clicks(6, 9);
  clicks[5].control = false;
  clicks[5].pixel.x() += 500;
  const PointResection answer = Resected(clicks);
  ASSERT_TRUE(answer.found);
  EXPECT_EQ(answer.found->Used(), 5);
  EXPECT_TRUE(answer.findings.empty());
  EXPECT_NEAR(answer.found->residuals_px[5].x(), 500, 20);
}

// Of so many trials with wrong clicks all name exactly these; at most one in a hundred names them
// among others, without a pose. None is accepted.
void ExpectNamed(
    int trials, int count,
    const std::function<std::string(std::vector<MeasuredPoint>*, std::mt19937*)>& spoil) {
  int doubtful = 0;
  for (int trial = 0; trial < trials; ++trial) {
    auto clicks = Clicks(count, 100 + static_cast<unsigned>(trial));
    std::mt19937 random(static_cast<unsigned>(trial));
    const std::string wrong = spoil(&clicks, &random);
    const PointResection answer = Resected(clicks);
    ASSERT_EQ(answer.findings.size(), 1u) << trial;
    const Finding& finding = answer.findings[0];
    if (!answer.found) {
      ++doubtful;
      EXPECT_EQ(finding.reason, Reason::kPointsContradictOneAnother) << trial;
      EXPECT_NE(finding.where.find(wrong.substr(0, 2)), std::string::npos) << trial;
      EXPECT_NE(finding.where.find(wrong.substr(wrong.size() - 2)), std::string::npos) << trial;
      continue;
    }
    EXPECT_EQ(finding.reason, Reason::kPointsWrong);
    EXPECT_EQ(finding.where, wrong) << trial;
    EXPECT_LT(SigmasOff(*answer.found), kMostSigmas) << trial;
  }
  EXPECT_LE(100 * doubtful, trials);
}

std::string MoveOne(std::vector<MeasuredPoint>* clicks, std::mt19937* random) {
  const std::size_t i = (*random)() % clicks->size();
  const double angle = 0.001 * static_cast<double>((*random)() % 6283);
  (*clicks)[i].pixel += 3 / kPixel_mm * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  return (*clicks)[i].name;
}

std::string ConfuseTwo(std::vector<MeasuredPoint>* clicks, std::mt19937* random) {
  const std::size_t i = (*random)() % clicks->size();
  const std::size_t j = (i + 1 + (*random)() % (clicks->size() - 1)) % clicks->size();
  std::swap((*clicks)[i].pixel, (*clicks)[j].pixel);
  return (*clicks)[std::min(i, j)].name + ", " + (*clicks)[std::max(i, j)].name;
}

TEST(ResectByPoints, AClickThreeMillimetresOffIsNamed) { ExpectNamed(20, 6, MoveOne); }

TEST(ResectByPoints, TwoConfusedPointsAreNamed) { ExpectNamed(20, 7, ConfuseTwo); }

// Of a height known to 50 m it says nothing along one direction, and as much as ever across.
TEST(ResectByPoints, AWrongPointOfPoorHeightIsNamedAndNoRightOnes) {
  const PhotoView view{FilmCamera(), Scan().photo_from_pixel, Truth()};
  std::vector<MeasuredPoint> clicks;
  MeasuredPoint lone;
  for (const MeasuredPoint& click : Clicks(120, 5, 8, 0.2, 0.02)) {
    const Eigen::Vector2d at_mm = view.PhotoFromPixel(click.pixel);
    if (at_mm.x() < 20) clicks.push_back(click);
    if (at_mm.x() > 80 && std::abs(at_mm.y()) < 40) lone = click;
  }
  ASSERT_GE(clicks.size(), 40u);
  lone.sigma_m.z() = 50;
  lone.pixel.y() += 6;  // the scan's axes are the photo's: across the height's displacement
  lone.pixel.x() += 2;
  clicks.push_back(lone);
  const PointResection answer = Resected(clicks);
  ASSERT_TRUE(answer.found);
  EXPECT_EQ(answer.found->Used(), static_cast<int>(clicks.size()) - 1);
  EXPECT_FALSE(answer.found->used.back());
}

// Heights with a digit too many: no pose shows these points at all.
TEST(ResectByPoints, PointsAboveTheCameraAreNamedWithoutTryingAllSets) {
  auto clicks = Clicks(40, 3, 12);
  std::string wrong;
  for (std::size_t i = 2; i < clicks.size(); i += 7) {
    clicks[i].ground_m.z() += 10000;
    wrong += (wrong.empty() ? "" : ", ") + clicks[i].name;
  }
  const PointResection answer = Resected(clicks);
  ASSERT_TRUE(answer.found);
  ASSERT_EQ(answer.findings.size(), 1u);
  EXPECT_EQ(answer.findings[0].where, wrong);
}

// Not every set of sixty points can be tried.
TEST(ResectByPoints, SixOfSixtyPointsAreNamed) {
  auto clicks = Clicks(60, 11, 10);
  std::string wrong;
  for (std::size_t i = 3; i < clicks.size(); i += 10) {
    const double angle = static_cast<double>(i);
    clicks[i].pixel += 1.5 / kPixel_mm * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    wrong += (wrong.empty() ? "" : ", ") + clicks[i].name;
  }
  const PointResection answer = Resected(clicks);
  ASSERT_TRUE(answer.found);
  ASSERT_EQ(answer.findings.size(), 1u);
  EXPECT_EQ(answer.findings[0].where, wrong);
  EXPECT_LT(SigmasOff(*answer.found), kMostSigmas);
}

// As a block has them in which another program's ties are measured points.
TEST(ResectByPoints, ThousandsOfPointsNeedLittleMemory) {
  const std::vector<MeasuredPoint> clicks = Clicks(4000, 3, 0);  // 10^10 triples
  const auto answer = ResectByPoints(FilmCamera(), {Scan()}, std::nullopt, clicks);
  ASSERT_TRUE(answer.found);
  EXPECT_LT((answer.found->pose.position_m - Truth().position_m).norm(), 0.5);
}

// Many in one strip of the frame and two beside it, of which one is sixteen sigma wrong: in the sum
// over all, that is next to nothing.
TEST(ResectByPoints, AWrongPointDoesNotHideAmongMany) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    std::vector<MeasuredPoint> clicks, right;
    const PhotoView view{FilmCamera(), Scan().photo_from_pixel, Truth()};
    for (const MeasuredPoint& click : Clicks(60, seed, 12)) {
      const double x_mm = view.PhotoFromPixel(click.pixel).x();
      if (x_mm < -50) clicks.push_back(click);
      if (x_mm > 70) right.push_back(click);
    }
    ASSERT_GE(right.size(), 2u);
    right[0].pixel += 16 * kClick_px * Eigen::Vector2d(std::cos(seed), std::sin(seed));
    clicks.push_back(right[0]);
    clicks.push_back(right[1]);
    const PointResection answer = Resected(clicks);
    EXPECT_FALSE(answer.found && answer.found->used[clicks.size() - 2]) << seed;
  }
}

// None of them is far off by itself; together they are: the stated accuracy is not theirs.
TEST(ResectByPoints, ManyPointsWorseThanStatedGiveNoPose) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    constexpr double kWorse = 1.6;
    std::vector<MeasuredPoint> clicks = Clicks(40, seed, 15, kWorse * kClick_px, kWorse * 0.2);
    for (MeasuredPoint& click : clicks) {
      click.sigma_px = kClick_px;
      click.sigma_m /= kWorse;
    }
    const PointResection answer = Resected(clicks);
    EXPECT_FALSE(answer.found) << seed;
    EXPECT_EQ(StatusOf(answer.findings), Status::kFailed) << seed;
  }
}

TEST(SlowResectByPoints, WrongClicksAreNamedInTwoHundredOfTwoHundred) {
  ExpectNamed(200, 6, MoveOne);
  ExpectNamed(200, 7, ConfuseTwo);
}

TEST(JudgePointsAlone, IsOkOnlyWithEnoughPointsThatCheckOneAnother) {
  EXPECT_EQ(JudgePointsAlone(6, 2, 0.8, 4.9, 1).at_best, Status::kOk);
  EXPECT_EQ(JudgePointsAlone(6, 2, 1.2, 4.9, 1).at_best, Status::kWeak);
  EXPECT_EQ(JudgePointsAlone(5, 1, 0.8, 4.9, 1).at_best, Status::kWeak);
  EXPECT_EQ(JudgePointsAlone(8, 3, 0.8, 4.9, 1).at_best, Status::kWeak) << "too many are wrong";
  const Finding unchecked = JudgePointsAlone(6, 2, 0.8, 5.1, 1);
  EXPECT_EQ(unchecked.at_best, Status::kWeak);
  EXPECT_EQ(unchecked.where,
            "one sigma up to 0.8 px in the frame, 1.0 px are wanted; one wrong point may displace "
            "it by 5.1 px before it shows (5.0 px are allowed)");
}

double Hidden(const std::vector<MeasuredPoint>& clicks) {
  const PointResection answer = Resected(clicks);
  if (!answer.found) throw std::runtime_error("no pose");
  const PhotoView view{FilmCamera(), Scan().photo_from_pixel, answer.found->pose};
  return HiddenDisplacement(*answer.found, view, 150);
}

// All of them twice as precise: half of it. Of few, one checks another less.
TEST(HiddenDisplacement, GrowsWithTheSigmasAndWithFewerPoints) {
  std::vector<MeasuredPoint> clicks = Clicks(40, 3, 20);
  const double of_many = Hidden(clicks);
  for (MeasuredPoint& click : clicks) {
    click.sigma_px *= 2;
    click.sigma_m *= 2;
  }
  EXPECT_NEAR(Hidden(clicks), 2 * of_many, 0.01 * of_many);
  const double of_few = Hidden(Clicks(8, 3));
  EXPECT_GT(of_few, 2 * of_many);
  std::cout << "one wrong of 40: " << of_many << " px, of 8: " << of_few << " px\n";
}

// However precise it is said to be: the more, the less do others check it.
TEST(HiddenDisplacement, IsNotMadeSmallerByASmallSigmaOfTheOnlyPointOfItsSide) {
  const PhotoView view{FilmCamera(), Scan().photo_from_pixel, Truth()};
  std::vector<MeasuredPoint> clicks;
  MeasuredPoint lone;
  for (const MeasuredPoint& click : Clicks(60, 5, 12, 0.4, 0.001)) {
    const double x_mm = view.PhotoFromPixel(click.pixel).x();
    if (x_mm < -50) clicks.push_back(click);
    if (x_mm > 80) lone = click;
  }
  lone.pixel = *view.PixelFromGround(lone.ground_m);
  const auto with = [&](double sigma_px) {
    auto all = clicks;
    lone.sigma_px = sigma_px;
    lone.sigma_m.setConstant(sigma_px * 0.001);
    all.push_back(lone);
    return Hidden(all);
  };
  const double usual = with(0.4);
  for (const double sigma_px : {0.05, 0.01, 0.001}) EXPECT_GT(with(sigma_px), usual) << sigma_px;
}

// What an error of a point that just does not show moves the pose by is no more than is said.
TEST(HiddenDisplacement, IsTheMostThatAnErrorThatDoesNotShowMovesThePose) {
  const std::vector<MeasuredPoint> clicks = Clicks(12, 5, 30);
  const PointResection without = Resected(clicks);
  ASSERT_TRUE(without.found);
  const PhotoView view{FilmCamera(), Scan().photo_from_pixel, without.found->pose};
  const double said_px = HiddenDisplacement(*without.found, view, 150);
  double worst_px = 0;
  for (std::size_t i = 0; i < clicks.size(); ++i)
    for (int direction = 0; direction < 4; ++direction)
      for (double error_px = 3; error_px < 30; error_px += 1) {
        auto wrong = clicks;
        const double angle = 0.25 * 3.14159265 * direction;
        wrong[i].pixel += error_px * Eigen::Vector2d(std::cos(angle), std::sin(angle));
        const PointResection answer = Resected(wrong);
        if (!answer.found || !answer.findings.empty()) break;
        const Vector6d by = PoseDifference(answer.found->pose, without.found->pose);
        worst_px = std::max(worst_px, WorstProjectionSigma(view, by * by.transpose(), 150));
      }
  EXPECT_LT(worst_px, said_px);
  EXPECT_GT(worst_px, 0.4 * said_px);
  std::cout << "moved by up to " << worst_px << " px, said " << said_px << " px\n";
}

struct Accepted {
  int ok = 0;
  double worst_px = 0;  // of those, in the frame's worst corner
};

// Points all over the frame, or in a strip of it but for the first two.
std::vector<MeasuredPoint> ClicksToTry(int count, unsigned seed, double sigma_px, bool strip) {
  if (!strip) return Clicks(count, seed, 15, sigma_px, 0.02);
  std::vector<MeasuredPoint> clicks, in_strip;
  const PhotoView view{FilmCamera(), Scan().photo_from_pixel, Truth()};
  for (const MeasuredPoint& click : Clicks(100, seed, 8, sigma_px, 0.02)) {
    const double x_mm = view.PhotoFromPixel(click.pixel).x();
    if (x_mm < -40 && std::ssize(in_strip) < count - 2) in_strip.push_back(click);
    if (x_mm > 70 && clicks.size() < 2) clicks.push_back(click);
  }
  clicks.insert(clicks.end(), in_strip.begin(), in_strip.end());
  return clicks;
}

// Photos by so many points alone; with `wrong`, one of them is 4 to 16 sigma off.
Accepted AcceptedByPointsAlone(int points, double sigma_px, bool wrong, bool strip = false) {
  constexpr int kTrials = 50;
  Accepted accepted;
  std::mt19937 random(static_cast<unsigned>(points));
  std::uniform_real_distribution<double> sigmas(4, 16), angles(0, 6.283);
  for (unsigned trial = 1; trial <= kTrials; ++trial) {
    auto clicks = ClicksToTry(points, 1000 + trial, sigma_px, strip);
    const double angle = angles(random), off_px = sigmas(random) * sigma_px;
    if (wrong) clicks[0].pixel += off_px * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const PointResection answer = Resected(clicks);
    if (!answer.found) continue;
    PhotoView view{FilmCamera(), Scan().photo_from_pixel, answer.found->pose};
    const double worst_px = WorstProjectionSigma(view, answer.found->covariance, 150);
    const double hidden_px = HiddenDisplacement(*answer.found, view, 150);
    const Finding judged = JudgePointsAlone(answer.found->Used(), points - answer.found->Used(),
                                            worst_px, hidden_px, 1);
    if (judged.at_best != Status::kOk) continue;
    ++accepted.ok;
    const Vector6d by = PoseDifference(answer.found->pose, Truth());
    const double error_px = WorstProjectionSigma(view, by * by.transpose(), 150);
    accepted.worst_px = std::max(accepted.worst_px, error_px);
  }
  std::cout << points << " points" << (strip ? " in a strip" : "") << " of " << sigma_px << " px"
            << (wrong ? ", one wrong" : "") << ": " << 100 * accepted.ok / kTrials
            << " % ok, wrong by up to " << accepted.worst_px << " px\n";
  return accepted;
}

TEST(SlowPointsAlone, InAStripAreOkWhereAWrongOneBesideItShows) {
  for (const double sigma_px : {0.2, 0.3, 0.4})
    for (const int points : {14, 20, 30}) {
      EXPECT_LT(AcceptedByPointsAlone(points, sigma_px, false, true).worst_px, 4);
      EXPECT_LT(AcceptedByPointsAlone(points, sigma_px, true, true).worst_px, 5);
    }
}

// What it costs that a wrong point must show, and what it prevents.
TEST(SlowPointsAlone, AreOkWhereAWrongOneShows) {
  for (const double sigma_px : {0.3, 0.5, 1.0})
    for (const int points : {6, 8, 10, 15, 20, 30, 40}) {
      const Accepted right = AcceptedByPointsAlone(points, sigma_px, false);
      EXPECT_LT(right.worst_px, 4) << "four sigma";
      if (points >= 20 && sigma_px < 0.4) {
        EXPECT_GE(right.ok, 48);
      }
      EXPECT_LT(AcceptedByPointsAlone(points, sigma_px, true).worst_px, 5);
    }
}

TEST(JudgePointsUnder, NamesThoseThatLieElsewhere) {
  auto clicks = Clicks(6, 11);
  clicks[2].pixel.x() += 40;
  const PhotoView view{FilmCamera(), Scan().photo_from_pixel, Truth()};
  const auto finding = JudgePointsUnder(view, Matrix6d::Identity() * 1e-10, clicks);
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->value, 1);
  EXPECT_EQ(finding->where.substr(0, 3), "p3 ");
  EXPECT_EQ(finding->at_best, Status::kOk);
}

}  // namespace
}  // namespace orient::exterior
