#include "exterior/steps/evidence.h"

#include <gtest/gtest.h>

#include "core/base/binomial.h"
#include "tests/support/textured_photo.h"

namespace orient::exterior {
namespace {

// Matched under the true pose, in windows of 20 pixels.
class RoundOfTexture : public testing::Test {
 protected:
  PreciseRound Match(const std::vector<patchdb::Patch>& patches) {
    photo_.prior.pose = world_.View().pose;
    Vector6d sigma;
    sigma << 1, 1, 1, 0.001, 0.001, 0.001;
    photo_.prior.covariance = sigma.cwiseAbs2().asDiagonal();
    const PhotoTask task{photo_, world_.File(), patches, options_};
    PreciseRound round = MatchAll(task, world_.View(), photo_.prior.covariance, 20, 1);
    decoys_ = MatchDecoys(task, round);
    return round;
  }
  static int Found(const PreciseRound& round) {
    int found = 0;
    for (const PreciseMatch& match : round.matches) found += match.found ? 1 : 0;
    return found;
  }

  const TexturedPhoto world_{400, HillsAt, false};
  PhotoToOrient photo_ = world_.ToOrient();
  OrientPhotoOptions options_;
  DecoyMatches decoys_;
};

TEST_F(RoundOfTexture, FindsWhatIsThereAndHardlyADecoy) {
  const PreciseRound round = Match(world_.Patches(world_.Ground(), 3, 90));
  const int sought = static_cast<int>(round.predictions.size());
  ASSERT_GT(sought, 30);
  EXPECT_GT(Found(round), 0.9 * sought);
  EXPECT_GT(decoys_.sought, 0.5 * sought);
  EXPECT_LT(decoys_.found, 0.2 * decoys_.sought);
}

// The patches are then decoys themselves.
TEST_F(RoundOfTexture, FindsPatchesOfAnotherPlaceAsSeldomAsDecoys) {
  const PreciseRound round = Match(world_.Patches(Texture(6, 6), 3, 90));
  EXPECT_LT(Found(round), 0.2 * static_cast<double>(round.predictions.size()));
  EXPECT_LE(static_cast<double>(Found(round)) / static_cast<double>(round.predictions.size()),
            UpperBoundOfRate(decoys_.found, decoys_.sought, 0.001));
}

}  // namespace
}  // namespace orient::exterior
