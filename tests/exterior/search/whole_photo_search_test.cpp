#include "exterior/search/whole_photo_search.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "core/geometry/collinearity.h"
#include "core/geometry/rotation.h"
#include "tests/exterior/digital_view.h"

namespace orient::exterior {
namespace {

constexpr double kLimit = -6;

// Ways whose tries give what the test says, and what was tried.
class WaysOfTest {
 public:
  // log10 of the false alarms that each way's first try gives; nothing: no pose.
  explicit WaysOfTest(const std::vector<std::optional<double>>& first) {
    ways.count = first.size();
    ways.followed = 2;
    ways.max_log10_false_alarms = kLimit;
    ways.look = [](std::size_t way) { return Look{static_cast<long>(way), 0, 0, 0}; };
    ways.first = [this, first](std::size_t way) {
      tried.push_back(way);
      return first[way] ? std::optional(TrackOf(*first[way])) : std::nullopt;
    };
    ways.again = [this](std::size_t way, const PoseTrack& track) {
      followed.push_back(way);
      from.push_back(track.log10_false_alarms);
      const std::size_t round = rounds[way]++;
      return round < again[way].size() && again[way][round]
                 ? std::optional(TrackOf(*again[way][round]))
                 : std::nullopt;
    };
  }

  std::optional<double> Try() {
    ways.budget = &budget;
    const auto track = TryWays(ways);
    return track ? std::optional(track->log10_false_alarms) : std::nullopt;
  }

  WaysToTry ways;
  SearchBudget budget{1};
  std::map<std::size_t, std::vector<std::optional<double>>> again;  // by way, of its rounds
  std::vector<std::size_t> tried, followed;
  std::vector<double> from;  // what each try again started with

 private:
  static PoseTrack TrackOf(double log10_false_alarms) {
    PoseTrack track;
    track.log10_false_alarms = log10_false_alarms;
    return track;
  }
  std::map<std::size_t, std::size_t> rounds;
};

using Tried = std::vector<std::size_t>;

TEST(TryWays, TheFirstThatConvincesEndsTheSearch) {
  WaysOfTest test({-1, std::nullopt, -7, -9});
  EXPECT_EQ(test.Try(), -7);
  EXPECT_EQ(test.tried, (Tried{0, 1, 2}));
  EXPECT_TRUE(test.followed.empty());
}

TEST(TryWays, WhatIsNoBetterThanTheLimitDoesNotConvince) {
  WaysOfTest test({kLimit, -6.001});
  EXPECT_EQ(test.Try(), -6.001);
  EXPECT_EQ(test.tried, (Tried{0, 1}));
}

TEST(TryWays, OfNoWayThatGivesAPoseIsNone) {
  WaysOfTest test({std::nullopt, std::nullopt});
  EXPECT_EQ(test.Try(), std::nullopt);
  EXPECT_EQ(test.tried, (Tried{0, 1}));
  EXPECT_TRUE(test.followed.empty());
}

TEST(TryWays, OnceTheBudgetIsSpentNoFurtherWayIsTried) {
  WaysOfTest ways({-1, -2, -9});
  ways.budget = SearchBudget(150);
  const auto first = ways.ways.first;
  ways.ways.first = [&](std::size_t way) {
    ways.budget.Spend({{.ground_m = Eigen::Vector3d::Zero(), .candidates = {}, .window_px2 = 400}},
                      2);
    return first(way);
  };
  ways.Try();
  EXPECT_EQ(ways.tried, (std::vector<std::size_t>{0, 1}));
  EXPECT_TRUE(ways.budget.Spent());
}

TEST(TryWays, OfNoWaysIsNone) { EXPECT_EQ(WaysOfTest({}).Try(), std::nullopt); }

TEST(TryWays, TheBestAreFollowedTwiceEachTheBestFirst) {
  WaysOfTest test({-1, -4, std::nullopt, -2, -3});
  EXPECT_EQ(test.Try(), -4);
  EXPECT_EQ(test.followed, (Tried{1, 1, 4, 4}));
}

TEST(TryWays, OfEquallyGoodWaysTheEarlierIsFollowedFirst) {
  WaysOfTest test({-2, -2, -2});
  EXPECT_EQ(test.Try(), -2);
  EXPECT_EQ(test.followed, (Tried{0, 0, 1, 1}));
}

TEST(TryWays, NoMoreAreFollowedThanMayBe) {
  WaysOfTest test({-1, -2, -3});
  test.ways.followed = 1;
  EXPECT_EQ(test.Try(), -3);
  EXPECT_EQ(test.followed, (Tried{2, 2}));
}

// Film turned by a quarter and kappa turned back: the same try.
TEST(TryWays, WhatLooksTheSameIsFollowedOnce) {
  WaysOfTest test({-4, -3, -2, -1});
  test.ways.look = [](std::size_t way) { return Look{static_cast<long>(way / 2), 0, 0, 0}; };
  EXPECT_EQ(test.Try(), -4);
  EXPECT_EQ(test.followed, (Tried{0, 0, 2, 2}));
}

TEST(TryWays, ATryAgainStartsFromTheBestSoFar) {
  WaysOfTest test({-1});
  test.again[0] = {-3, -5};
  EXPECT_EQ(test.Try(), -5);
  EXPECT_EQ(test.from, (std::vector<double>{-1, -3}));
}

TEST(TryWays, ATryAgainThatIsWorseOrGivesNothingIsNotTaken) {
  WaysOfTest test({-3, -2});
  test.again[0] = {-1, std::nullopt};
  test.again[1] = {std::nullopt, -2.5};
  EXPECT_EQ(test.Try(), -3);
  EXPECT_EQ(test.from, (std::vector<double>{-3, -3, -2, -2}));
}

TEST(TryWays, AWorseFirstTryMayEndAsTheBest) {
  WaysOfTest test({-3, -2});
  test.again[1] = {-5};
  EXPECT_EQ(test.Try(), -5);
}

TEST(TryWays, ATryAgainThatConvincesEndsTheSearch) {
  WaysOfTest test({-3, -2});
  test.again[0] = {-8};
  EXPECT_EQ(test.Try(), -8);
  EXPECT_EQ(test.followed, (Tried{0}));
}

TEST(KeepBetter, OfEqualPosesKeepsTheEarlierAndOfNoneWhatWasThere) {
  const auto track = [](double log10_false_alarms, int reduction) {
    PoseTrack made;
    made.log10_false_alarms = log10_false_alarms;
    made.reduction = reduction;
    return made;
  };
  std::optional<PoseTrack> best;
  KeepBetter(std::nullopt, &best);
  EXPECT_FALSE(best);
  KeepBetter(track(-3, 1), &best);
  KeepBetter(track(-3, 2), &best);
  KeepBetter(track(-2, 3), &best);
  KeepBetter(std::nullopt, &best);
  ASSERT_TRUE(best);
  EXPECT_EQ(best->reduction, 1);
  KeepBetter(track(-4, 4), &best);
  EXPECT_EQ(best->reduction, 4);
}

TEST(Outwards, CountsEveryKappaOnceFromTheMiddle) {
  std::vector<int> first;
  for (int i = 0; i < 5; ++i) first.push_back(Outwards(i));
  EXPECT_EQ(first, (std::vector<int>{0, 1, -1, 2, -2}));
  std::set<int> turns;
  for (int i = 0; i < kKappas; ++i) turns.insert((Outwards(i) + kKappas) % kKappas);
  EXPECT_EQ(turns.size(), static_cast<std::size_t>(kKappas));
}

TEST(MedianGroundHeight, IsThatOfMostPatches) {
  std::vector<patchdb::Patch> patches(5);
  const std::vector<double> heights = {300, 100, 9000, 200, -500};
  for (std::size_t i = 0; i < patches.size(); ++i) patches[i].ground_m = {1, 2, heights[i]};
  EXPECT_EQ(MedianGroundHeight(patches), 200);
}

// Twelve patches of which each has its true place in the photo and another one.
class ClusterOfVotes : public testing::Test {
 protected:
  ClusterOfVotes() {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> col(50, 590), row(50, 1100);
    for (int i = 0; i < 12; ++i) {
      VotingPatch patch;
      const int row_of_four = i / 4;
      const double x = 1000 + 400.0 * (i % 4 - 1.5), y = 2000 + 500.0 * (row_of_four - 1);
      patch.ground_m = {x, y, 400.0 + 40 * (i % 3)};
      patch.window_px2 = 640 * 1152;
      patch.candidates = {{*view_.PixelFromGround(patch.ground_m), 0.8},
                          {{col(random), row(random)}, 0.9}};
      voting_.push_back(patch);
    }
    Vector6d sigma;
    sigma << 50, 50, 50, 0.02, 0.02, 0.02;
    prior_ = {view_.pose, sigma.cwiseAbs2().asDiagonal()};
    options_.samples = 200;
  }
  std::vector<PlaneVote> ClusterOf(std::size_t voters, std::size_t candidate) const {
    std::vector<PlaneVote> cluster;
    for (std::size_t i = 0; i < voters; ++i) cluster.push_back({i, candidate, {0, 0}});
    return cluster;
  }

  const PhotoView view_ = DigitalView();
  PosePrior prior_;
  std::vector<VotingPatch> voting_;
  ConsensusOptions options_;
};

TEST_F(ClusterOfVotes, OnlyItsCandidatesSupportThePose) {
  const auto cluster = ClusterOf(8, 0);
  const auto consensus = FindConsensus(view_, prior_, {voting_, cluster, options_});
  ASSERT_TRUE(consensus);
  EXPECT_EQ(consensus->supporters.size(), 8u) << "all twelve would";
  for (const Supporter& supporter : consensus->supporters) EXPECT_LT(supporter.patch, 8u);
}

TEST_F(ClusterOfVotes, ChanceIsAskedAboutAllThatMightHaveAgreed) {
  const auto cluster = ClusterOf(8, 0);
  const auto consensus = FindConsensus(view_, prior_, {voting_, cluster, options_});
  ASSERT_TRUE(consensus);
  EXPECT_DOUBLE_EQ(consensus->log10_false_alarms,
                   Log10FalseAlarms(voting_, consensus->supporters, options_));
  std::vector<VotingPatch> of_cluster(voting_.begin(), voting_.begin() + 8);
  for (VotingPatch& patch : of_cluster) patch.candidates.resize(1);
  EXPECT_GT(consensus->log10_false_alarms,
            Log10FalseAlarms(of_cluster, consensus->supporters, options_) + 1)
      << "eight of twelve with two places each are more by chance than eight of eight with one";
}

TEST_F(ClusterOfVotes, OfTwoPatchesOrNoneGivesNoPose) {
  for (const std::size_t voters : {0, 2}) {
    const auto cluster = ClusterOf(voters, 0);
    EXPECT_FALSE(FindConsensus(view_, prior_, {voting_, cluster, options_}));
  }
}

// A film whose marks do not tell how it lies: r0, turned by a quarter, by a half, and mirrored.
class FilmOfEqualMarks : public testing::Test {
 protected:
  FilmOfEqualMarks() {
    for (const std::array<double, 4>& a :
         {std::array<double, 4>{1, 0, 0, 1}, {0, -1, 1, 0}, {-1, 0, 0, -1}, {-1, 0, 0, 1}}) {
      Affine2d turned;
      turned.A << a[0], a[1], a[2], a[3];
      photo_.positions.push_back({turned * view_.photo_from_pixel, std::nullopt});
    }
    photo_.prior = {view_.pose, Vector6d::Constant(0.01).asDiagonal()};
    track_.position = photo_.positions.front();
    track_.pose = view_.pose;
  }

  // Found as `first`, with kappa's approximation `off_rad` from what was found.
  void Decide(double off_rad, double sigma_rad) {
    photo_.prior.pose.opk_rad.z() = view_.pose.opk_rad.z() + off_rad;
    photo_.prior.covariance(5, 5) = sigma_rad * sigma_rad;
    LetPriorDecidePosition(photo_.positions, photo_.prior, &track_.position, &track_.pose);
  }
  Eigen::Vector2d Seen(const Eigen::Vector3d& ground_m) const {
    PhotoView view = view_;
    view.photo_from_pixel = track_.position.photo_from_pixel;
    view.pose = track_.pose;
    return *view.PixelFromGround(ground_m);
  }

  const PhotoView view_ = DigitalView();
  PhotoToOrient photo_;
  PoseTrack track_;
};

TEST_F(FilmOfEqualMarks, LiesAsTheApproximatedKappaSays) {
  const Ray ray = *GroundRayFromPhoto(view_.camera, view_.pose, {20, -10});
  const Eigen::Vector3d ground_m = ray.origin_m + 5000 * ray.direction;
  const Eigen::Vector2d seen = Seen(ground_m);
  for (const double quarters : {-1, 2, 0}) {
    track_.position = photo_.positions.front();
    track_.pose = view_.pose;
    Decide(RadFromDeg(90 * quarters + 4), 0.05);
    EXPECT_LT(std::abs(NormalizeAngle(track_.pose.opk_rad.z() - photo_.prior.pose.opk_rad.z())),
              RadFromDeg(5))
        << quarters;
    EXPECT_LT((Seen(ground_m) - seen).norm(), 1e-6) << "the same photograph, " << quarters;
  }
}

TEST_F(FilmOfEqualMarks, LiesAsItWasFoundWhereKappaIsNotKnown) {
  Decide(RadFromDeg(175), std::numbers::pi);
  EXPECT_EQ(track_.pose.AsVector(), view_.pose.AsVector());
  EXPECT_EQ(track_.position.photo_from_pixel.A, photo_.positions.front().photo_from_pixel.A);
}

TEST_F(FilmOfEqualMarks, IsNotMirroredForKappasSake) {
  photo_.positions.erase(photo_.positions.begin() + 1, photo_.positions.begin() + 3);
  Decide(RadFromDeg(180), 0.05);
  EXPECT_EQ(track_.pose.AsVector(), view_.pose.AsVector());
  EXPECT_GT(
      (track_.position.photo_from_pixel.A * photo_.positions.front().photo_from_pixel.A.inverse())
          .determinant(),
      0);
}

TEST_F(FilmOfEqualMarks, IsSaidToBeOpenWhereNothingDecides) {
  Decide(0, std::numbers::pi);
  EXPECT_EQ(EquallyLikelyPositions(photo_, track_.position, track_.pose.opk_rad.z()), 3);
  Decide(0, 0.05);
  EXPECT_EQ(EquallyLikelyPositions(photo_, track_.position, track_.pose.opk_rad.z()), 1);
}

}  // namespace
}  // namespace orient::exterior
