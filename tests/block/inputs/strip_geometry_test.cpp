#include "block/inputs/strip_geometry.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "core/base/error.h"
#include "core/geometry/rotation.h"
#include "tests/support/expect_error.h"

namespace orient::block {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kGround_m = 300, kHeight_m = 1500;

// 23 cm, 153 mm: a frame shows 2255 m, a base of 60 % is 902 m, strips are 1578 m apart.
Camera FilmCamera() {
  Camera camera;
  camera.principal_distance_mm = 153;
  camera.frame_mm = {230, 230};
  return camera;
}
constexpr double kFrame_m = 230.0 / 153 * kHeight_m;
constexpr double kBase_m = 0.4 * kFrame_m, kApart_m = 0.7 * kFrame_m;

std::string NameOf(int strip, int number) {
  return std::to_string(strip) + "_" + std::to_string(number);
}

FlightPlan Plan(const std::vector<int>& photos_of_strips) {
  FlightPlan plan;
  for (std::size_t s = 0; s < photos_of_strips.size(); ++s) {
    FlightStrip strip;
    strip.name = std::to_string(s + 1);
    for (int n = 1; n <= photos_of_strips[s]; ++n)
      strip.photos.push_back(NameOf(static_cast<int>(s) + 1, n));
    plan.strips.push_back(strip);
  }
  return plan;
}

OrientationRow Located(const std::string& photo, const Vector3d& place, double kappa_deg,
                       double sigma_m = 5) {
  OrientationRow row;
  row.photo = photo;
  row.pose.position_m = place;
  row.pose.opk_rad = {0, 0, RadFromDeg(kappa_deg)};
  row.sigma.emplace();
  *row.sigma << Vector3d::Constant(sigma_m), Vector3d::Constant(RadFromDeg(1));
  return row;
}

std::map<std::string, OrientationRow> Filled(const FlightPlan& plan,
                                             const std::vector<OrientationRow>& located) {
  std::map<std::string, OrientationRow> rows;
  for (OrientationRow& row : FillStrips(plan, located, FilmCamera(), kGround_m))
    rows[row.photo] = std::move(row);
  return rows;
}

const Vector3d kStart(500000, 5200000, kGround_m + kHeight_m);

TEST(StripGeometry, OnePhotoAndAnAzimuthLocateTheStrip) {
  FlightPlan plan = Plan({5});
  plan.azimuth_rad = RadFromDeg(90);
  const auto rows = Filled(plan, {Located("1_2", kStart, 0)});
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_LT((rows.at("1_1").pose.position_m - (kStart - Vector3d(kBase_m, 0, 0))).norm(), 1);
  EXPECT_LT((rows.at("1_5").pose.position_m - (kStart + Vector3d(3 * kBase_m, 0, 0))).norm(), 1);
  EXPECT_TRUE(rows.at("1_5").attitude_known);
  EXPECT_NEAR(rows.at("1_5").pose.opk_rad[2], 0, 1e-9);
}

TEST(StripGeometry, SigmasGrowWithTheDistanceFromWhatIsLocated) {
  FlightPlan plan = Plan({6});
  plan.azimuth_rad = RadFromDeg(45);
  const auto rows = Filled(plan, {Located("1_1", kStart, 45)});
  double before = 5;
  for (int n = 2; n <= 6; ++n) {
    const Vector6d& sigma = *rows.at(NameOf(1, n)).sigma;
    EXPECT_GT(sigma[0], before);
    before = sigma[0];
  }
  // A tenth of the way, somewhat more: overlaps are not what was planned.
  EXPECT_GT(before, 0.06 * 5 * kBase_m);
  EXPECT_LT(before, 0.2 * 5 * kBase_m);
}

TEST(StripGeometry, TwoLocatedPhotosTellDirectionAndBase) {
  const Vector2d step(700, 400);  // of an overlap that nobody stated
  const auto at = [&](int n) { return Vector3d(kStart + Vector3d(n * step.x(), n * step.y(), 0)); };
  const auto rows = Filled(Plan({6}), {Located("1_2", at(1), 10), Located("1_4", at(3), 10)});
  for (const int n : {1, 3, 5, 6}) {
    const OrientationRow& row = rows.at(NameOf(1, n));
    EXPECT_LT((row.pose.position_m - at(n - 1)).norm(), 12) << n;
    EXPECT_LT((*row.sigma)[0], (n == 6 ? 0.3 : 0.2) * kBase_m) << n;
  }
  EXPECT_LT((*rows.at("1_3").sigma)[0], (*rows.at("1_6").sigma)[0]);
}

TEST(StripGeometry, WithoutDirectionAPhotoMayLieAnywhereAroundTheLocatedOne) {
  const auto rows = Filled(Plan({3}), {Located("1_1", kStart, 77)});
  const OrientationRow& next = rows.at("1_2");
  EXPECT_LT((next.pose.position_m - kStart).head<2>().norm(), 1);
  EXPECT_NEAR((*next.sigma)[0], 0.75 * kBase_m, 0.1 * kBase_m);
  EXPECT_NEAR((*next.sigma)[1], (*next.sigma)[0], 1);
  // Kappa is known none the less: the camera does not turn within a strip.
  EXPECT_TRUE(next.attitude_known);
  EXPECT_NEAR(DegFromRad(next.pose.opk_rad[2]), 77, 1e-9);
}

TEST(StripGeometry, TheNextStripLiesBesideAndIsFlownBack) {
  FlightPlan plan = Plan({4, 4, 4});
  plan.azimuth_rad = RadFromDeg(90);
  plan.next_strip = Vector2d(0, -1);
  const auto rows = Filled(plan, {Located("1_1", kStart, 0)});
  ASSERT_EQ(rows.size(), 11u);
  const Vector3d south(0, -kApart_m, 0), east(kBase_m, 0, 0);
  EXPECT_LT((rows.at("2_4").pose.position_m - (kStart + south)).norm(), 2);
  EXPECT_LT((rows.at("2_1").pose.position_m - (kStart + south + 3 * east)).norm(), 2);
  EXPECT_LT((rows.at("3_1").pose.position_m - (kStart + 2 * south)).norm(), 2);
  EXPECT_NEAR(std::abs(DegFromRad(rows.at("2_1").pose.opk_rad[2])), 180, 1e-6);
  EXPECT_NEAR(DegFromRad(rows.at("3_1").pose.opk_rad[2]), 0, 1e-6);
  plan.back_and_forth = false;
  const auto same_way = Filled(plan, {Located("1_1", kStart, 0)});
  EXPECT_LT((same_way.at("2_1").pose.position_m - (kStart + south)).norm(), 2);
  EXPECT_NEAR(same_way.at("2_1").pose.opk_rad[2], 0, 1e-9);
}

TEST(StripGeometry, WithoutWordOnTheSideTheNextStripMayLieOnBoth) {
  FlightPlan plan = Plan({4, 4});
  plan.azimuth_rad = RadFromDeg(90);
  const auto rows = Filled(plan, {Located("1_1", kStart, 0)});
  EXPECT_NEAR(rows.at("2_4").pose.position_m.y(), kStart.y(), 1);
  EXPECT_NEAR((*rows.at("2_4").sigma)[1], kApart_m, 0.2 * kApart_m);
}

TEST(StripGeometry, AStripsOwnAzimuthCounts) {
  FlightPlan plan = Plan({3, 3});
  plan.strips[0].azimuth_rad = RadFromDeg(90);
  plan.strips[1].azimuth_rad = RadFromDeg(0);
  const auto rows = Filled(plan, {Located("1_2", kStart, 20), Located("2_1", kStart, 110)});
  // That the strips lie abreast has a say, too, a small one.
  EXPECT_LT((rows.at("2_3").pose.position_m - (kStart + Vector3d(0, 2 * kBase_m, 0))).norm(), 15);
}

TEST(StripGeometry, AStripsOwnAzimuthTurnsKappaAgainstTheFlights) {
  FlightPlan plan = Plan({2, 2});
  plan.azimuth_rad = RadFromDeg(78);
  plan.strips[1].azimuth_rad = RadFromDeg(78);
  const auto kappa = [&] {
    const OrientationRow row = Filled(plan, {Located("1_1", kStart, 12)}).at("2_1");
    EXPECT_TRUE(row.attitude_known);
    return std::abs(DegFromRad(row.pose.opk_rad[2] - RadFromDeg(12)));
  };
  EXPECT_NEAR(kappa(), 0, 1e-6);
  plan.strips[1].azimuth_rad.reset();
  EXPECT_NEAR(kappa(), 180, 1e-6);
  plan.azimuth_rad.reset();
  plan.strips[1].azimuth_rad = RadFromDeg(78);
  const auto rows = Filled(plan, {Located("1_1", kStart, 12)});
  EXPECT_FALSE(rows.at("2_1").attitude_known);
  EXPECT_TRUE(rows.at("1_2").attitude_known);
}

TEST(StripGeometry, ACrossStripsAzimuthIsNotTheFlights) {
  FlightPlan plan = Plan({3, 3, 3});
  plan.strips[2].azimuth_rad = RadFromDeg(90);
  const auto rows = Filled(plan, {Located("1_1", kStart, 0)});
  const Vector6d& sigma = *rows.at("1_3").sigma;
  EXPECT_NEAR(sigma[0], sigma[1], 0.05 * sigma[0]);
}

TEST(StripGeometry, ANextStripAlongTheFlightIsRefused) {
  FlightPlan plan = Plan({3, 3});
  plan.azimuth_rad = RadFromDeg(2);
  plan.next_strip = Vector2d(0, 1);
  ExpectError<InputError>([&] { Filled(plan, {Located("1_1", kStart, 0)}); },
                          {"[flight]", "next_strip", "azimuth_deg"});
  plan.azimuth_rad.reset();
  const Vector3d step(0.035 * kBase_m, kBase_m, 0);
  const auto rows = Filled(plan, {Located("1_1", kStart, 0), Located("1_3", kStart + 2 * step, 0)});
  EXPECT_GT((*rows.at("2_2").sigma)[0], 0.8 * kApart_m) << "it may lie on both sides";
}

// A frame wider than high may be mounted either way.
TEST(StripGeometry, KappaSaysWhichSideOfTheFrameLiesAlong) {
  Camera camera = FilmCamera();
  camera.frame_mm = {100, 50};
  FlightPlan plan = Plan({2});
  const double x_m = 0.4 * 100.0 / 153 * kHeight_m, y_m = x_m / 2;
  const auto base = [&](double azimuth_deg, bool kappa_known) {
    plan.azimuth_rad = RadFromDeg(azimuth_deg);
    OrientationRow located = Located("1_1", kStart, 10);
    located.attitude_known = kappa_known;
    const OrientationRow row = FillStrips(plan, {located}, camera, kGround_m).at(0);
    return std::pair((row.pose.position_m - kStart).norm(), row.sigma->head<2>().norm());
  };
  EXPECT_NEAR(base(80, true).first, x_m, 1);
  EXPECT_NEAR(base(260, true).first, x_m, 1);
  EXPECT_NEAR(base(170, true).first, y_m, 1);
  EXPECT_NEAR(base(170, false).first, std::sqrt(x_m * y_m), 1);
  EXPECT_GT(base(170, false).second, 0.3 * std::sqrt(x_m * y_m));
}

TEST(StripGeometry, AKappaThatNobodyKnowsStaysUnknown) {
  OrientationRow located = Located("1_1", kStart, 0);
  located.attitude_known = false;
  const auto rows = Filled(Plan({2}), {located});
  EXPECT_FALSE(rows.at("1_2").attitude_known);
  EXPECT_DOUBLE_EQ((*rows.at("1_2").sigma)[5], std::numbers::pi);
}

TEST(StripGeometry, StripsOfWhichNoPhotoIsLocatedAreNamed) {
  ExpectError<InputError>([&] { Filled(Plan({3}), {Located("4711", kStart, 0)}); },
                          {"strip 1", "1_1", "located"});
  ExpectError<InputError>(
      [&] {
        Filled(Plan({3}), {Located("1_2", {500000, 5200000, kGround_m - 5}, 0)});
      },
      {"1_2", "below the ground"});
}

// Flights as they happen: overlap of 0.55 to 0.67, crab, drift, strips that begin anywhere within a
// base. Errors fit the sigmas.
TEST(StripGeometry, SigmasAreHonest) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  double chi2 = 0;
  int count = 0;
  for (int flight = 0; flight < 200; ++flight) {
    FlightPlan plan = Plan({5, 6, 5});
    const double azimuth = RadFromDeg(360.0 * flight / 200);
    plan.azimuth_rad = azimuth;
    const Vector2d along(std::sin(azimuth), std::cos(azimuth)), right(along.y(), -along.x());
    plan.next_strip = right;
    std::map<std::string, Vector3d> truth;
    for (std::size_t s = 0; s < 3; ++s) {
      const double sense = s % 2 == 0 ? 1 : -1;
      const auto photos = static_cast<double>(plan.strips[s].photos.size());
      const double base = kBase_m * (1 + 0.08 * normal(random));
      const double turn = 0.05 * normal(random);
      const Vector2d start =
          static_cast<double>(s) * kApart_m * (1 + 0.1 * normal(random)) * right +
          0.3 * kBase_m * normal(random) * along - sense * 0.5 * (photos - 1) * base * along;
      for (std::size_t n = 0; n < plan.strips[s].photos.size(); ++n) {
        const double gone = sense * base * static_cast<double>(n);
        const Vector2d place = start + gone * along + gone * turn * right +
                               0.04 * kBase_m * normal(random) * along +
                               0.02 * kBase_m * normal(random) * right;
        truth[plan.strips[s].photos[n]] << place,
            kGround_m + kHeight_m * (1 + 0.01 * normal(random));
      }
    }
    const std::string known = NameOf(1 + flight % 3, 1 + flight % 5);
    for (const auto& [photo, row] : Filled(plan, {Located(known, truth.at(known), 0, 1)})) {
      const Vector3d off = row.pose.position_m - truth.at(photo);
      chi2 += off.cwiseQuotient(row.sigma->head<3>()).squaredNorm();
      count += 3;
    }
  }
  const double normalised = std::sqrt(chi2 / count);
  EXPECT_GT(normalised, 0.5);
  EXPECT_LT(normalised, 1.25);
}

TEST(StripGeometry, TurnsWithTheWorld) {
  EXPECT_TRUE(rc::check([] {
    const double turn = RadFromDeg(*rc::gen::inRange(0, 360));
    FlightPlan plan = Plan({4, 3});
    plan.azimuth_rad = 0.3;
    const auto rows = Filled(plan, {Located("1_2", kStart, 0)});
    plan.azimuth_rad = 0.3 - turn;
    const auto turned = Filled(plan, {Located("1_2", kStart, DegFromRad(turn))});
    const Eigen::Rotation2Dd rotation(turn);
    for (const auto& [photo, row] : rows) {
      const Vector2d there = (row.pose.position_m - kStart).head<2>();
      const Vector2d here = (turned.at(photo).pose.position_m - kStart).head<2>();
      RC_ASSERT((rotation * there - here).norm() < 1e-3);
    }
  }));
}

}  // namespace
}  // namespace orient::block
