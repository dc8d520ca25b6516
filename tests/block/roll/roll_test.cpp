#include "block/roll/roll.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "interior/orientation/film_transform.h"

namespace orient::block {
namespace {

using Eigen::Vector2d;

// A roll of simulated photos: eight marks measured with 2 um of noise on film whose shrinkage
// varies from frame to frame, through one scanner.
struct RollSpec {
  int photos = 30;
  double scanner_difference = 0;  // of the two scales
  double film_shrinkage = 1e-4;   // one sigma, both axes and shear, frame to frame
  double noise_um = 2;
  std::vector<Vector2d> camera_error_um;  // of the marks' calibrated positions
  unsigned seed = 1;
};

const std::vector<Vector2d> kPlaces = {{-106, -106}, {106, 106}, {-106, 106}, {106, -106},
                                       {-110, 0},    {110, 0},   {0, 110},    {0, -110}};

InteriorResult Photo(const RollSpec& spec, int index, const Eigen::Matrix2d& extra,
                     double extra_noise_um, std::mt19937* random) {
  std::normal_distribution<double> normal;
  const auto draw = [&] { return spec.film_shrinkage * normal(*random); };
  Eigen::Matrix2d film;
  film << 1 + draw() + spec.scanner_difference, draw(), 0, 1 + draw();
  film = extra * film;
  InteriorResult result;
  result.photo = std::to_string(1000 + index);
  result.status = Status::kOk;
  std::vector<interior::MeasuredMark> marks;
  for (size_t i = 0; i < kPlaces.size(); ++i) {
    const double noise = 1e-3 * std::hypot(spec.noise_um, extra_noise_um);
    const Vector2d seen = film * kPlaces[i] + noise * Vector2d(normal(*random), normal(*random));
    Vector2d calibrated = kPlaces[i];
    if (i < spec.camera_error_um.size()) calibrated += 1e-3 * spec.camera_error_um[i];
    marks.push_back({Vector2d(4600 + seen.x() / 0.025, 4600 - seen.y() / 0.025), calibrated});
  }
  const auto fit = interior::FitFilm(marks, false);
  result.photo_from_pixel = fit->photo_from_pixel;
  result.sigma0_um = fit->sigma0_um;
  for (size_t i = 0; i < marks.size(); ++i) {
    MarkResult mark;
    mark.id = std::to_string(i + 1);
    mark.state = MarkState::kUsed;
    mark.pixel = marks[i].pixel;
    mark.residual_um = fit->residual_um[i];
    result.marks.push_back(mark);
  }
  return result;
}

std::vector<InteriorResult> Roll(const RollSpec& spec) {
  std::mt19937 random(spec.seed);
  std::vector<InteriorResult> results;
  for (int i = 0; i < spec.photos; ++i)
    results.push_back(Photo(spec, i, Eigen::Matrix2d::Identity(), 0, &random));
  return results;
}

int CountWeak(const std::vector<InteriorResult>& results) {
  return static_cast<int>(std::count_if(results.begin(), results.end(),
                                        [](const auto& r) { return r.status == Status::kWeak; }));
}

std::vector<InteriorResult> Compared(std::vector<InteriorResult> results) {
  CompareWithRoll(StatisticsOfRoll(results), &results);
  return results;
}

TEST(Roll, RollsThatDifferByChanceOnlyAreLeftAloneInMoreThan99Percent) {
  int rolls = 0, alarmed = 0;
  for (const int photos : {8, 12, 20, 60})
    for (unsigned seed = 1; seed <= 150; ++seed) {
      RollSpec spec;
      spec.photos = photos;
      spec.seed = seed;
      // So much that the absolute limits do not help: only the sigmas decide.
      spec.film_shrinkage = 2e-3;
      spec.noise_um = 60;
      ++rolls;
      alarmed += CountWeak(Compared(Roll(spec))) > 0 ? 1 : 0;
    }
  EXPECT_LE(alarmed, 0.01 * rolls) << alarmed << " of " << rolls;
}

TEST(Roll, AFrameOfAnotherScaleShearOrFitIsWeakAndSaysWhy) {
  struct Case {
    Eigen::Matrix2d film;
    double noise_um;
    const char* word;
  };
  Eigen::Matrix2d larger = 1.002 * Eigen::Matrix2d::Identity();
  Eigen::Matrix2d sheared = Eigen::Matrix2d::Identity();
  sheared(0, 1) = 0.002;
  Eigen::Matrix2d stretched = Eigen::Matrix2d::Identity();
  stretched(1, 1) = 1.002;
  for (const Case& c : {Case{larger, 0, "pixel size along"}, Case{sheared, 0, "sheared"},
                        Case{stretched, 0, "scales of its two axes"},
                        Case{Eigen::Matrix2d::Identity(), 40, "sigma0"}}) {
    RollSpec spec;
    std::vector<InteriorResult> results = Roll(spec);
    std::mt19937 random(99);
    results[7] = Photo(spec, 7, c.film, c.noise_um, &random);
    results = Compared(results);
    EXPECT_EQ(CountWeak(results), 1) << c.word;
    EXPECT_EQ(results[7].status, Status::kWeak) << c.word;
    EXPECT_EQ(results[7].status_alone, Status::kOk);
    bool said = false;
    for (const std::string& m : Sentences(results[7].findings))
      said = said || m.find(c.word) != std::string::npos;
    EXPECT_TRUE(said) << c.word;
  }
}

TEST(Roll, ADepartureTooSmallToMatterIsNoReason) {
  RollSpec spec;
  spec.film_shrinkage = 1e-6;  // so uniform that a tenth of a micrometre has many sigmas
  spec.noise_um = 0.1;
  std::vector<InteriorResult> results = Roll(spec);
  std::mt19937 random(99);
  results[3] = Photo(spec, 3, 1.0001 * Eigen::Matrix2d::Identity(), 1, &random);
  EXPECT_EQ(CountWeak(Compared(results)), 0);
}

TEST(Roll, SevenPhotosAreTooFew) {
  RollSpec spec;
  spec.photos = 7;
  EXPECT_FALSE(StatisticsOfRoll(Roll(spec)));
  spec.photos = 8;
  EXPECT_TRUE(StatisticsOfRoll(Roll(spec)));
}

TEST(Roll, FailedPhotosAndThoseWithThreeMarksDoNotCount) {
  RollSpec spec;
  spec.photos = 9;
  std::vector<InteriorResult> results = Roll(spec);
  results[0].status = Status::kFailed;
  for (size_t i = 0; i < 5; ++i) results[1].marks[i].state = MarkState::kMissing;
  EXPECT_FALSE(StatisticsOfRoll(results));
}

TEST(Roll, ComparingAgainTakesBackWhatNoLongerHolds) {
  RollSpec spec;
  std::vector<InteriorResult> results = Roll(spec);
  std::mt19937 random(99);
  const InteriorResult good = results[7];
  results[7] = Photo(spec, 7, 1.01 * Eigen::Matrix2d::Identity(), 0, &random);
  results = Compared(results);
  const Findings said = results[7].findings;
  ASSERT_FALSE(said.empty());
  EXPECT_TRUE(CompareWithRoll(StatisticsOfRoll(results), &results).empty()) << "nothing new";
  EXPECT_EQ(results[7].findings, said) << "nothing is said twice";
  EXPECT_EQ(CompareWithRoll(std::nullopt, &results), std::vector<size_t>{7});
  EXPECT_EQ(results[7].status, Status::kOk);
  EXPECT_TRUE(results[7].findings.empty());
}

TEST(Roll, APhotoThatIsWeakByItselfStaysSo) {
  RollSpec spec;
  std::vector<InteriorResult> results = Roll(spec);
  std::mt19937 random(99);
  results[7] = Photo(spec, 7, 1.01 * Eigen::Matrix2d::Identity(), 0, &random);
  results[7].status = Status::kWeak;
  results = Compared(results);
  EXPECT_FALSE(results[7].status_alone);
  CompareWithRoll(std::nullopt, &results);
  EXPECT_EQ(results[7].status, Status::kWeak);
}

TEST(Roll, TheScannersKindIsSeen) {
  RollSpec spec;
  EXPECT_TRUE(StatisticsOfRoll(Roll(spec))->photogrammetric);
  spec.scanner_difference = 0.004;
  const auto desktop = StatisticsOfRoll(Roll(spec));
  EXPECT_FALSE(desktop->photogrammetric);
  EXPECT_NEAR(std::abs(desktop->scale_difference.median), 0.004, 2e-4);
}

TEST(Roll, AWrongPositionInTheCameraFileIsSeen) {
  RollSpec spec;
  spec.camera_error_um = {{0, 0}, {0, 0}, {12, -8}};
  const auto roll = StatisticsOfRoll(Roll(spec));
  ASSERT_TRUE(roll);
  size_t worst = 0;
  for (size_t i = 0; i < roll->marks.size(); ++i)
    if (roll->marks[i].mean_um.norm() > roll->marks[worst].mean_um.norm()) worst = i;
  EXPECT_EQ(worst, 2U);
  EXPECT_TRUE(roll->marks[2].systematic);
  EXPECT_GT(roll->marks[2].mean_um.x(), 4) << "the calibrated position is too far right";
  EXPECT_LT(roll->marks[2].mean_um.y(), -2);
}

TEST(Roll, MarksWithoutErrorLookSystematicInFewerThanOneRollOf200) {
  int systematic = 0;
  for (unsigned seed = 1; seed <= 400; ++seed) {
    RollSpec spec;
    spec.photos = 12;
    spec.noise_um = 20;
    spec.seed = seed;
    const auto roll = StatisticsOfRoll(Roll(spec));
    ASSERT_TRUE(roll);
    for (const RollMark& mark : roll->marks) systematic += mark.systematic;
  }
  EXPECT_LE(systematic, 2);
}

}  // namespace
}  // namespace orient::block
