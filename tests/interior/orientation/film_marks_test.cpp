// Which measured marks are wrong, and what is left of them.
#include "interior/orientation/film_marks.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "interior/orientation/reseau.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr double kPixel_mm = 0.02;

struct Cross {
  Vector2d off_mm = Vector2d::Zero();
  double correlation = 0.9;
  bool clear = true;
};

// Crosses in rows of five, 10 mm apart; the assignment has chosen all of them.
std::pair<FilmReading, FilmMarks> Reseau(const std::vector<Cross>& crosses) {
  FilmReading reading;
  reading.pixel_size = {kPixel_mm, 0.004};
  reading.prior = {{10, 10}, 0.03, 0.004, 1.5e-4, 0.03, 0.85};
  FilmMarks marks;
  for (size_t i = 0; i < crosses.size(); ++i) {
    const size_t row = i / 5, col = i % 5;
    const Vector2d place(10.0 * static_cast<double>(col), 10.0 * static_cast<double>(row));
    const Vector2d at = place + crosses[i].off_mm;
    reading.marks.push_back({place, {{at, 1.5}}, 9});
    reading.candidates.push_back({{at / kPixel_mm, 0.9}});
    reading.best.choice.push_back(0);
    MarkPosition position;
    position.pixel = at / kPixel_mm;
    position.correlation = crosses[i].correlation;
    marks.push_back({MarkState::kUsed, position, crosses[i].clear});
  }
  return {reading, marks};
}

int Used(const FilmMarks& marks) {
  return static_cast<int>(std::count_if(marks.begin(), marks.end(),
                                        [](const auto& m) { return m.state == MarkState::kUsed; }));
}

TEST(WrongMarks, AReseausClearStrokesOutweighALowCorrelation) {
  const auto [reading, marks] = Reseau(std::vector<Cross>(20, {Vector2d::Zero(), 0.2, true}));
  EXPECT_EQ(Used(WithoutWrongMarks(reading, marks)), 20);
}

TEST(WrongMarks, ACrossThatTheOthersContradictIsRejected) {
  std::vector<Cross> crosses(20);
  crosses[7].off_mm = {0.5, 0};
  const auto [reading, marks] = Reseau(crosses);
  const FilmMarks left = WithoutWrongMarks(reading, marks);
  EXPECT_EQ(left[7].state, MarkState::kRejected);
  EXPECT_EQ(Used(left), 19);
}

// Twelve crossings of the picture's lines, whose strokes are clear as well, contradict the eight
// marks among them. Too few for a reseau, they are rejected by their correlation, and the marks
// that they contradicted are not.
TEST(WrongMarks, WhatClearStrokesContradictedIsJudgedAnewWhereTheyMakeNoReseau) {
  std::vector<Cross> crosses(20, {{1, 0.5}, 0.2, true});
  for (size_t i = 0; i < crosses.size(); ++i)
    if (i % 5 == 0 || i % 5 == 3) crosses[i] = {};
  const auto [reading, marks] = Reseau(crosses);
  const FilmMarks left = WithoutWrongMarks(reading, marks);
  EXPECT_EQ(Used(left), 8);
  EXPECT_EQ(left[0].state, MarkState::kUsed);
}

// In the picture's texture or at a stroke of a pixel a mark correlates little; its place tells.
TEST(WrongMarks, AMarkThatLooksUnlikeIsTakenBackWhereTheOthersPutIt) {
  std::vector<Cross> crosses(10);
  crosses[7] = {{0.02, -0.01}, 0.35, false};
  const auto [reading, marks] = Reseau(crosses);
  EXPECT_EQ(Used(WithoutWrongMarks(reading, marks)), 10);
}

TEST(WrongMarks, AMarkThatLooksUnlikeStaysRejectedUnlessTheOthersConfirmIt) {
  const auto state = [](const Cross& cross, double sigma_px) {
    std::vector<Cross> crosses(10);
    crosses[7] = cross;
    auto [reading, marks] = Reseau(crosses);
    marks[7].position->covariance = sigma_px * sigma_px * Eigen::Matrix2d::Identity();
    return WithoutWrongMarks(reading, marks)[7].state;
  };
  EXPECT_EQ(state({{0.02, 0}, 0.35, false}, 0.1), MarkState::kUsed);
  EXPECT_EQ(state({{0.08, 0}, 0.35, false}, 0.1), MarkState::kRejected);  // 2.7 sigma off
  EXPECT_EQ(state({{0.02, 0}, 0.20, false}, 0.1), MarkState::kRejected);  // resembles nothing
  EXPECT_EQ(state({{0.02, 0}, 0.35, false}, 2.0), MarkState::kRejected);  // may be anywhere there
}

// Marks of which only grain hides most.
struct Faint {
  double without_grain = 0.9, gain_over_sigma = 12, nats = 20, margin = 10, sigma_px = 0.15;
  double scanner_margin = 10;
  int marks = 4, found = 4;
  bool one_unlike = false;
  std::vector<Cross> crosses = {};  // the first of them, in place of faint ones
};

int UsedOf(const Faint& faint) {
  const auto count = static_cast<size_t>(faint.marks);
  std::vector<Cross> crosses(count, {Vector2d::Zero(), 0.35, false});
  std::copy(faint.crosses.begin(), faint.crosses.end(), crosses.begin());
  auto [reading, marks] = Reseau(crosses);
  reading.best.nats = faint.nats;
  reading.margin = faint.margin;
  reading.scanner_margin = faint.scanner_margin;
  for (size_t i = 0; i < count; ++i) {
    marks[i].position->correlation_without_grain = faint.without_grain;
    marks[i].position->gain_over_sigma = faint.gain_over_sigma;
    marks[i].position->covariance = faint.sigma_px * faint.sigma_px * Eigen::Matrix2d::Identity();
    if (static_cast<int>(i) < faint.found) continue;
    marks[i] = {};
    reading.best.choice[i] = -1;
  }
  if (faint.one_unlike) marks[2].position->correlation_without_grain = 0.6;
  return Used(WithoutWrongMarks(reading, marks));
}

TEST(WrongMarks, FaintMarksAreUsedWhereOnlyGrainKeepsThemFromCorrelating) {
  EXPECT_EQ(UsedOf({}), 4);
  EXPECT_EQ(UsedOf({.without_grain = 0.6}), 0);
  EXPECT_EQ(UsedOf({.gain_over_sigma = 5}), 0);
  EXPECT_EQ(UsedOf({.sigma_px = 0.5}), 0);
}

TEST(WrongMarks, FaintMarksAreUsedWhereAllOfTheCamerasMarksAre) {
  EXPECT_EQ(UsedOf({.nats = 10, .margin = 4, .scanner_margin = 4}), 4);
  EXPECT_EQ(UsedOf({.margin = 4, .marks = 3, .found = 3}), 0);
  const Cross clearer{Vector2d::Zero(), 0.5, false}, contradicted{{0.5, 0}, 0.35, false};
  EXPECT_EQ(UsedOf({.margin = 4, .crosses = {clearer, clearer}}), 4);
  EXPECT_EQ(UsedOf({.margin = 4, .marks = 5, .found = 5, .crosses = {contradicted}}), 0);
}

TEST(WrongMarks, OneUnlikeMarkAmongFaintOnesLeavesADoubt) {
  EXPECT_EQ(UsedOf({.margin = 4, .scanner_margin = 4}), 4);
  EXPECT_EQ(UsedOf({.margin = 4, .scanner_margin = 4, .one_unlike = true}), 0);
}

TEST(WrongMarks, FaintMarksWithoutTheOthersAreUsedOnlyInAReadingBeyondDoubt) {
  EXPECT_EQ(UsedOf({.marks = 5}), 4);
  EXPECT_EQ(UsedOf({.nats = 10, .marks = 5}), 0);
  EXPECT_EQ(UsedOf({.margin = 4, .marks = 5}), 0);
  EXPECT_EQ(UsedOf({.scanner_margin = 4, .marks = 5}), 0);
}

// Clear marks are the measure of a faint one: it may be a wrong place in clutter.
TEST(WrongMarks, AFaintMarkAmongClearOnesIsRejectedUnlessTheyConfirmIt) {
  auto [reading, marks] = Reseau(std::vector<Cross>(4));
  reading.best.nats = 20;
  reading.margin = 10;
  marks[3].position->correlation = 0.24;
  marks[3].position->correlation_without_grain = 0.9;
  marks[3].position->gain_over_sigma = 12;
  EXPECT_EQ(WithoutWrongMarks(reading, marks)[3].state, MarkState::kRejected);
}

TEST(WrongMarks, TwoMarksConfirmNoThird) {
  std::vector<Cross> crosses(3);
  crosses[1] = {Vector2d::Zero(), 0.35, false};
  const auto [reading, marks] = Reseau(crosses);
  EXPECT_EQ(Used(WithoutWrongMarks(reading, marks)), 2);
}

TEST(PositionByLines, HoldsWhatMatchingContradictsForUnsureWhateverItsCorrelation) {
  MarkPosition matched;
  matched.pixel = {100, 100};
  matched.covariance = 4e-4 * Eigen::Matrix2d::Identity();
  MeasuredCross crossing;
  crossing.pixel = {100.8, 100};
  crossing.covariance = 4e-4 * Eigen::Matrix2d::Identity();
  for (const double correlation : {0.2, 0.9}) {
    matched.correlation = correlation;
    const MarkPosition position = PositionByLines(matched, crossing);
    EXPECT_EQ(position.pixel, crossing.pixel);
    EXPECT_EQ(position.correlation, correlation);
    EXPECT_NEAR(std::sqrt(position.covariance(0, 0)), 0.8, 0.001);
    EXPECT_NEAR(std::sqrt(position.covariance(1, 1)), 0.02, 1e-6);
  }
  crossing.pixel = {100.05, 100};
  EXPECT_NEAR(std::sqrt(PositionByLines(matched, crossing).covariance(0, 0)), 0.02, 1e-6);
}

}  // namespace
}  // namespace orient::interior
