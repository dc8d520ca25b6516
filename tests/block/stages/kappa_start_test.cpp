#include "block/stages/kappa_start.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/geometry/collinearity.h"
#include "core/geometry/rotation.h"

namespace orient::block {
namespace {

// Tilt and relief are taken for errors.
constexpr double kWithin_rad = 0.15;

// Two strips, flown there and back with some tilt, over ground with relief.
class TwoStrips : public testing::Test {
 protected:
  TwoStrips() {
    camera_.principal_distance_mm = 150;
    camera_.frame_mm = {230, 230};
    for (int i = 0; i < 8; ++i) {
      const int along = i % 4, strip = i / 4;
      const double tilt = 0.02 * (i % 3 - 1);
      poses_.push_back({{500000.0 + 800 * along, 5600000.0 + 1600 * strip, 1800},
                        {tilt, -tilt, (i < 4 ? 0.1 : 0.1 + M_PI) + 0.03 * (i % 2)}});
    }
    for (int col = 0; col < 12; ++col)
      for (int row = 0; row < 12; ++row)
        ground_.emplace_back(499200 + 370.0 * col, 5599000 + 320.0 * row,
                             300 + 40 * ((3 * col + row) % 3));
    for (const Pose& pose : poses_) photos_.push_back(Seen(pose));
  }

  LevelPhoto Seen(const Pose& pose) const {
    LevelPhoto photo{pose.position_m.head<2>(), {}};
    for (std::size_t i = 0; i < ground_.size(); ++i)
      if (const auto mm = PhotoFromGround(camera_, pose, ground_[i]);
          mm && mm->cwiseAbs().maxCoeff() < 115)
        photo.seen_mm[std::to_string(i)] = *mm;
    return photo;
  }
  double Off(std::size_t photo, const std::vector<std::optional<double>>& kappas) const {
    return kappas[photo] ? NormalizeAngle(*kappas[photo] - poses_[photo].opk_rad[2]) : INFINITY;
  }

  Camera camera_;
  std::vector<Pose> poses_;
  std::vector<Eigen::Vector3d> ground_;
  std::vector<LevelPhoto> photos_;
};

TEST_F(TwoStrips, SharedPointsAndPlacesTellEachPhotosKappa) {
  const auto kappas = KappasByPlaces(photos_, {});
  for (std::size_t i = 0; i < photos_.size(); ++i) EXPECT_LT(std::abs(Off(i, kappas)), kWithin_rad);
}

TEST_F(TwoStrips, APhotoThatSharesOnePointIsLeftOpenAndTheOthersAreNot) {
  while (photos_[3].seen_mm.size() > 1) photos_[3].seen_mm.erase(photos_[3].seen_mm.begin());
  const auto kappas = KappasByPlaces(photos_, {});
  EXPECT_FALSE(kappas[3]);
  for (const std::size_t i : {0u, 1u, 2u, 4u, 7u}) EXPECT_LT(std::abs(Off(i, kappas)), kWithin_rad);
}

TEST_F(TwoStrips, APhotoAloneHasItsKappaFromKnownGround) {
  photos_.resize(1);
  EXPECT_FALSE(KappasByPlaces(photos_, {})[0]);
  std::map<std::string, Eigen::Vector2d> known;
  for (std::size_t i = 0; i < ground_.size(); ++i) known[std::to_string(i)] = ground_[i].head<2>();
  EXPECT_LT(std::abs(Off(0, KappasByPlaces(photos_, known))), kWithin_rad);
}

TEST(KappasByPlaces, OfNoPhotosThereAreNone) { EXPECT_TRUE(KappasByPlaces({}, {}).empty()); }

}  // namespace
}  // namespace orient::block
