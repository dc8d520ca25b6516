// When two readings of one scan are rivals, and when they say the same.
#include "interior/constellation/rival_readings.h"

#include <gtest/gtest.h>

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr double kPixel_mm = 0.1, kHalf_mm = 50;

// Four marks in the corners of a square, each found where a film moved by `shift_mm` has it and
// `off_mm` farther on; one candidate a mark, those not `found` are clutter.
FilmReading Reading(double nats, const std::vector<bool>& found,
                    const std::vector<Vector2d>& off_mm = {4, Vector2d::Zero()},
                    const Vector2d& shift_mm = Vector2d::Zero()) {
  FilmReading reading;
  reading.pixel_size = {kPixel_mm, 0.008};
  reading.orientations = {ScanOrientation::kR0};
  reading.prior.shift_mm = Vector2d(200, 200);
  reading.margin = nats;
  for (size_t i = 0; i < found.size(); ++i) {
    const Vector2d place((i % 2 == 0 ? -1 : 1) * kHalf_mm, (i < 2 ? -1 : 1) * kHalf_mm);
    const Vector2d at = place + shift_mm + off_mm[i];
    reading.marks.push_back({place, {{at, 1.5}}, 900});
    reading.candidates.push_back({{at / kPixel_mm, 0.9}});
    reading.best.choice.push_back(found[i] ? 0 : -1);
  }
  reading.best.nats = nats;
  reading.second.choice.assign(found.size(), -1);
  return reading;
}

TEST(RivalReadings, OfOneFilmSayTheSameHoweverManyMarksTheyFound) {
  const FilmReading all = Reading(30, {true, true, true, true});
  EXPECT_TRUE(ReadingsAgree(all, Reading(10, {true, true, false, false})));
  EXPECT_TRUE(ReadingsAgree(all, Reading(20, {false, true, true, true})));
  EXPECT_TRUE(ReadingsAgree(Reading(10, {true, true, false, false}),
                            Reading(10, {false, false, true, true})));
}

TEST(RivalReadings, WithTwoMarksInCommonDifferWhereTheirOtherMarksMoveTheFilm) {
  const std::vector<Vector2d> moved = {{0, 0}, {0, 0}, {0, 4}, {0, 4}};
  const FilmReading right = Reading(25, {true, true, true, false});
  const FilmReading other = Reading(24, {true, true, false, true}, moved);
  EXPECT_FALSE(ReadingsAgree(right, other));
  EXPECT_NEAR(BestOf({right, other}).margin, 1, 1e-9);
}

TEST(RivalReadings, OfASecondFilmOnTheScanLeaveNoMargin) {
  const FilmReading one = Reading(40, {true, true, true, true});
  const FilmReading next =
      Reading(30, {true, true, true, true}, {4, Vector2d::Zero()}, Vector2d(120, 0));
  EXPECT_EQ(BestOf({one, next}).margin, 0);
  // As the second set of marks of one and the same reading.
  FilmReading both = one;
  for (size_t i = 0; i < both.marks.size(); ++i) {
    both.marks[i].candidates.push_back(next.marks[i].candidates[0]);
    both.candidates[i].push_back(next.candidates[i][0]);
  }
  both.second = {{1, 1, 1, 1}, 30};
  both.margin = 10;
  EXPECT_EQ(BestOf({both}).margin, 0);
}

TEST(RivalReadings, InThePolarityThatTheUserExcludedAreNoRivalsButTold) {
  const FilmReading clutter = Reading(12, {true, true, true, false});
  FilmReading film = Reading(40, {true, true, true, true});
  film.polarity = Polarity::kNegative;
  const FilmReading best = BestOf({clutter}, {film});
  EXPECT_EQ(best.polarity, Polarity::kPositive);
  EXPECT_EQ(best.margin, 12);
  EXPECT_EQ(best.polarity_margin, -28);
  FilmReading beside = Reading(40, {true, true, true, true}, {4, Vector2d::Zero()}, {120, 0});
  beside.polarity = Polarity::kNegative;
  EXPECT_GT(BestOf({Reading(30, {true, true, true, true})}, {beside}).polarity_margin, 1e9)
      << "another film on the scan";
  FilmReading chance = film;
  chance.best.nats = 8;  // no set of marks by itself
  EXPECT_GT(BestOf({Reading(2, {true, true, false, false})}, {chance}).polarity_margin, 1e9);
}

TEST(RivalReadings, OfTheSameMarksOrBesideThemOrOfMuchFewerNatsAreNoSecondFilm) {
  const FilmReading one = Reading(40, {true, true, true, true});
  const FilmReading a_mesh_on =
      Reading(30, {true, true, true, true}, {4, Vector2d::Zero()}, Vector2d(2 * kHalf_mm, 0));
  EXPECT_NEAR(BestOf({one, a_mesh_on}).margin, 10, 1e-9);
  const FilmReading clutter =
      Reading(12, {true, true, true, true}, {4, Vector2d::Zero()}, Vector2d(120, 0));
  EXPECT_NEAR(BestOf({one, clutter}).margin, 28, 1e-9);
  // The fields of a checkered mark are checkers of the other polarity beside its centre.
  FilmReading inverse =
      Reading(30, {true, true, true, true}, {4, Vector2d::Zero()}, Vector2d(2, 0));
  inverse.polarity = Polarity::kNegative;
  EXPECT_NEAR(BestOf({one, inverse}).margin, 10, 1e-9);
}

}  // namespace
}  // namespace orient::interior
