#include "interior/constellation/assignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "interior/constellation/set_evidence.h"
#include "tests/interior/constellation/p31_scenes.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr double kWindowMm = 30;  // side of the searched square

struct Scene {
  std::vector<AssignmentMark> marks;
  std::vector<int> truth;  // -1 where the true place is not among the candidates
};

class Constellations {
 public:
  explicit Constellations(unsigned seed) : random_(seed) {}

  // Corners of +-106 mm (and mid-sides), the film shifted, turned and with two scales; `clutter`
  // more candidates a mark, the true one missing with probability 1 - found.
  Scene Make(int mark_count, int clutter, double found, double noise_mm,
             bool marks_are_there = true) {
    constexpr double m = 106;
    const std::vector<Vector2d> places = {{-m, -m}, {m, m}, {-m, m}, {m, -m},
                                          {-m, 0},  {m, 0}, {0, m},  {0, -m}};
    return Around({places.begin(), places.begin() + mark_count}, clutter,
                  marks_are_there ? found : 0, noise_mm);
  }

  Scene Reseau(int side, int clutter, double found, double noise_mm) {
    std::vector<Vector2d> places;
    for (int row = 0; row < side; ++row)
      for (int col = 0; col < side; ++col)
        places.emplace_back(50.0 * col - 25.0 * (side - 1), 50.0 * row - 25.0 * (side - 1));
    return Around(places, clutter, found, noise_mm);
  }

 private:
  Scene Around(const std::vector<Vector2d>& places, int clutter, double found, double noise_mm) {
    Eigen::Matrix2d deformed = Eigen::Rotation2Dd(0.01 * Normal()).toRotationMatrix();
    deformed *= 1 + 0.003 * Normal();
    deformed.col(0) *= 1 + 0.005 * Normal();
    const Vector2d shift(4 * Normal(), 4 * Normal());
    Scene scene;
    for (const Vector2d& place : places) {
      AssignmentMark mark;
      mark.place_mm = place;
      mark.window_mm2 = kWindowMm * kWindowMm;
      for (int k = 0; k < clutter; ++k)
        mark.candidates.push_back({place + Vector2d(Uniform(), Uniform()), -1.0});
      int truth = -1;
      if (std::uniform_real_distribution<double>(0, 1)(random_) < found) {
        truth = std::uniform_int_distribution<int>(0, clutter)(random_);
        const Vector2d at = deformed * place + shift + noise_mm * Vector2d(Normal(), Normal());
        mark.candidates.insert(mark.candidates.begin() + truth, {at, 0.5});
      }
      scene.truth.push_back(truth);
      scene.marks.push_back(std::move(mark));
    }
    return scene;
  }

  double Normal() { return normal_(random_); }
  double Uniform() {
    return std::uniform_real_distribution<double>(-0.5 * kWindowMm, 0.5 * kWindowMm)(random_);
  }
  std::mt19937 random_;
  std::normal_distribution<double> normal_{0.0, 1.0};
};

TEST(AssignMarks, FindsFourMarksAmongTwentyCandidatesEach) {
  Constellations make(TestSeed());
  int right = 0;
  constexpr int kTrials = 100;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Scene scene = make.Make(4, 19, 1.0, 0.05);
    const AssignmentAnswer answer = AssignMarks(scene.marks, {});
    right += answer.best.choice == scene.truth;
    if (answer.best.nats - answer.second.nats > 3) {
      EXPECT_EQ(answer.best.choice, scene.truth) << trial;
    }
  }
  EXPECT_GE(right, 95);
}

TEST(AssignMarks, LeavesOutWhatIsNotThere) {
  Constellations make(TestSeed());
  int right = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const Scene scene = make.Make(8, 5, 0.8, 0.05);
    right += AssignMarks(scene.marks, {}).best.choice == scene.truth;
  }
  EXPECT_GE(right, 90);
}

TEST(AssignMarks, ClutterAloneRarelyReachesAcceptance) {
  Constellations make(TestSeed());
  int accepted = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const Scene scene = make.Make(4, 20, 1.0, 0.05, false);
    const AssignmentAnswer answer = AssignMarks(scene.marks, {});
    accepted += answer.best.nats > 9 && answer.best.Matched() >= 4;
  }
  EXPECT_EQ(accepted, 0);
}

TEST(AssignMarks, WithoutCandidatesAssignsNothing) {
  std::vector<AssignmentMark> marks(4);
  const AssignmentAnswer answer = AssignMarks(marks, {});
  EXPECT_EQ(answer.best.Matched(), 0);
  EXPECT_EQ(answer.best.nats, 0.0);
}

TEST(AssignMarks, ATwinConstellationIsAmbiguous) {
  // Every mark twice, the second set shifted as a whole: nothing tells the sets apart.
  std::vector<AssignmentMark> marks;
  for (const Vector2d& place : {Vector2d(-106, -106), {106, 106}, {-106, 106}, {106, -106}})
    marks.push_back({place, {{place + Vector2d(3, 0), 1}, {place - Vector2d(3, 0), 1}}, 900});
  const AssignmentAnswer answer = AssignMarks(marks, {});
  EXPECT_EQ(answer.best.Matched(), 4);
  EXPECT_NEAR(answer.best.nats, answer.second.nats, 1e-9);
}

TEST(LeaveOneOut, SeesTheMarkThatTheOthersContradict) {
  Constellations make(TestSeed());
  Scene scene = make.Make(8, 0, 1.0, 0.02);
  for (int i = 0; i < 8; ++i)
    EXPECT_LT(LeaveOneOutChiSquare(scene.marks, {}, scene.truth, i), 11.8) << i;
  scene.marks[5].candidates[0].position_mm += Vector2d(1.0, 0.5);
  EXPECT_GT(LeaveOneOutChiSquare(scene.marks, {}, scene.truth, 5), 11.8);
  EXPECT_GT(GainOfMark(scene.marks, {}, scene.truth, 0), 0.0);
}

TEST(LeaveOneOut, OfAMarkWithoutCandidateIsABrokenPromise) {
  std::vector<AssignmentMark> marks(4);
  EXPECT_THROW(GainOfMark(marks, {}, {-1, -1, -1, -1}, 0), std::invalid_argument);
  EXPECT_THROW(LeaveOneOutChiSquare(marks, {}, {-1, -1, -1, -1}, 0), std::invalid_argument);
}

// Log density of all chosen candidates together: one Gaussian, no chain of innovations.
double JointNats(const std::vector<AssignmentMark>& marks, const ConstellationPrior& prior,
                 const std::vector<int>& choice) {
  std::vector<size_t> chosen;
  for (size_t i = 0; i < marks.size(); ++i)
    if (choice[i] >= 0) chosen.push_back(i);
  const auto n = static_cast<Eigen::Index>(chosen.size());
  Eigen::MatrixXd design(2 * n, 6);
  Eigen::VectorXd difference(2 * n);
  double nats = 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const AssignmentMark& mark = marks[chosen[k]];
    const AssignmentCandidate& c = mark.candidates[choice[chosen[k]]];
    const double x = mark.place_mm.x(), y = mark.place_mm.y();
    design.row(2 * k) << 1, 0, -y, x, x / 2, y / 2;
    design.row(2 * k + 1) << 0, 1, x, y, -y / 2, x / 2;
    difference.segment<2>(2 * k) = c.position_mm - mark.place_mm;
    nats += std::log(prior.found / (1 - prior.found)) + std::clamp(c.score_nats, -1.5, 1.5) +
            std::log(mark.window_mm2 / static_cast<double>(mark.candidates.size()));
  }
  Eigen::VectorXd sigma(6);
  sigma << prior.shift_mm, prior.turn_rad, prior.scale, prior.affinity, prior.affinity;
  Eigen::MatrixXd covariance =
      design * sigma.cwiseAbs2().asDiagonal() * design.transpose() +
      prior.point_mm * prior.point_mm * Eigen::MatrixXd::Identity(2 * n, 2 * n);
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  for (Eigen::Index k = 0; k < 2 * n; ++k) nats -= std::log(llt.matrixL()(k, k));
  return nats - 0.5 * difference.dot(llt.solve(difference)) -
         static_cast<double>(n) * std::log(2 * std::numbers::pi);
}

// Every set there is, best first.
std::vector<Assignment> AllSets(const Scene& scene) {
  std::vector<Assignment> sets = {{std::vector<int>(scene.marks.size(), -1), 0}};
  for (size_t i = 0; i < scene.marks.size(); ++i) {
    const size_t before = sets.size();
    for (size_t k = 0; k < before; ++k)
      for (size_t j = 0; j < scene.marks[i].candidates.size(); ++j) {
        sets.push_back(sets[k]);
        sets.back().choice[i] = static_cast<int>(j);
      }
  }
  for (Assignment& set : sets) set.nats = JointNats(scene.marks, {}, set.choice);
  std::sort(sets.begin(), sets.end(),
            [](const Assignment& a, const Assignment& b) { return a.nats > b.nats; });
  return sets;
}

TEST(AssignMarks, EqualsTheBestAndTheSecondOfAllSets) {
  Constellations make(TestSeed());
  for (int trial = 0; trial < 40; ++trial) {
    const Scene scene = make.Make(4, 4, 0.7, 0.05, trial % 3 > 0);
    const std::vector<Assignment> sets = AllSets(scene);
    const AssignmentAnswer answer = AssignMarks(scene.marks, {});
    ASSERT_TRUE(answer.proven);
    EXPECT_EQ(answer.best.choice, sets.front().choice) << trial;
    EXPECT_NEAR(answer.best.nats, sets.front().nats, 1e-8) << trial;
    EXPECT_NEAR(NatsOfSet(scene.marks, {}, sets[7].choice), sets[7].nats, 1e-8) << trial;
    const auto conflicts = [&](const Assignment& set) {
      for (size_t i = 0; i < set.choice.size(); ++i)
        if (set.choice[i] >= 0 && sets.front().choice[i] >= 0 &&
            set.choice[i] != sets.front().choice[i])
          return true;
      return false;
    };
    const auto second = std::find_if(sets.begin(), sets.end(), conflicts);
    if (second == sets.end() || second->nats < answer.best.nats - 30) continue;
    EXPECT_NEAR(answer.second.nats, second->nats, 1e-8) << trial;
  }
}

TEST(AssignMarks, AReseauAmongClutterIsFoundAndProven) {
  Constellations make(TestSeed());
  for (int trial = 0; trial < 3; ++trial) {
    const Scene scene = make.Reseau(5, 10, 0.9, 0.05);
    const AssignmentAnswer answer = AssignMarks(scene.marks, {});
    EXPECT_TRUE(answer.proven);
    EXPECT_GT(answer.best.nats, 60);
    int wrong = 0;
    for (size_t i = 0; i < scene.truth.size(); ++i)
      wrong += answer.best.choice[i] != scene.truth[i];
    EXPECT_LE(wrong, 1);
  }
}

TEST(AssignMarks, SaysWhereItGaveUpProving) {
  Constellations make(TestSeed());
  const Scene scene = make.Reseau(5, 20, 0.0, 0.05);  // clutter only: no bound helps
  EXPECT_FALSE(AssignMarks(scene.marks, {}).proven);
}

TEST(TransformOf, FollowsTheChosenCandidates) {
  Constellations make(TestSeed());
  const Scene scene = make.Make(8, 2, 1.0, 1e-6);
  ConstellationPrior exact;
  exact.point_mm = 1e-6;
  const Affine2d transform = TransformOf(scene.marks, exact, scene.truth);
  for (size_t i = 0; i < 8; ++i) {
    const Vector2d& seen = scene.marks[i].candidates[scene.truth[i]].position_mm;
    EXPECT_LT((transform * scene.marks[i].place_mm - seen).norm(), 1e-5);
  }
}

// What became of many scenes of five P31 marks; shares of all scenes.
struct Tally {
  double right = 0;         // the assignment is (see P31Scene)
  double accepted = 0;      // ends ok
  double false_accept = 0;  // ends ok, the most probable transform is wrong by more than 2 px
};

Tally MonteCarlo(const P31Spec& spec, int trials, unsigned seed) {
  P31Scenes scenes(seed);
  const ConstellationPrior prior = P31Prior();
  int right = 0, same = 0, accepted = 0, wrong = 0;
  for (int i = 0; i < trials; ++i) {
    const P31Scene scene = scenes.Make(spec);
    const AssignmentAnswer answer = AssignMarks(scene.marks, prior);
    right += scene.IsRight(answer.best.choice);
    same += answer.best.choice == scene.truth;
    const auto kept = WithoutContradicted(scene.marks, prior, answer.best.choice);
    const auto used = std::count_if(kept.begin(), kept.end(), [](int c) { return c >= 0; });
    const double margin = answer.best.nats - std::max(answer.second.nats, 0.0);
    if (JudgeSet(5, static_cast<int>(used), answer.best.nats, margin) != Status::kOk) continue;
    ++accepted;
    wrong += scene.ErrorOf(TransformOf(scene.marks, prior, kept)) > 2;
  }
  std::printf(
      "clutter %2d, found %.1f: right %.4f (the very candidates %.4f), accepted %.4f, "
      "of all wrong by more than 2 px and accepted %.4f\n",
      spec.clutter, spec.found, 1.0 * right / trials, 1.0 * same / trials, 1.0 * accepted / trials,
      1.0 * wrong / trials);
  return {1.0 * right / trials, 1.0 * accepted / trials, 1.0 * wrong / trials};
}

TEST(P31MonteCarlo, AllMarksAmongClutterAreFound) {
  const Tally tally = MonteCarlo({20, 1.0}, 300, TestSeed());
  EXPECT_GE(tally.right, 0.99);
  EXPECT_LE(tally.false_accept, 0.01);
}

TEST(P31MonteCarlo, MissingMarksAreLeftOut) {
  const Tally tally = MonteCarlo({10, 0.8}, 300, TestSeed());
  EXPECT_GE(tally.right, 0.88);
  EXPECT_GE(tally.accepted, 0.6);
  EXPECT_LE(tally.false_accept, 0.015);
}

struct P31Case {
  P31Spec spec;
  double right;
};
class SlowP31MonteCarlo : public testing::TestWithParam<P31Case> {};

TEST_P(SlowP31MonteCarlo, IsRightAndHardlyEverWronglyAccepted) {
  const Tally tally = MonteCarlo(GetParam().spec, 2000, TestSeed());
  EXPECT_GE(tally.right, GetParam().right);
  EXPECT_LE(tally.false_accept, 0.005);
}
INSTANTIATE_TEST_SUITE_P(Issue, SlowP31MonteCarlo,
                         testing::Values(P31Case{{2, 1.0}, 0.997}, P31Case{{6, 1.0}, 0.997},
                                         P31Case{{10, 1.0}, 0.997}, P31Case{{20, 1.0}, 0.997},
                                         P31Case{{6, 0.9}, 0.98}, P31Case{{10, 0.8}, 0.88},
                                         P31Case{{20, 0.8}, 0.79}));

// Far outside the trusted marks a mark's wrong candidate has the better score, and is chosen before
// the two marks beside it are known. It then tells three quarters of where it is to be.
TEST(ChooseAround, AMarkIsNotJudgedByItsOwnCandidate) {
  ConstellationPrior prior;
  prior.point_mm = 0.05;
  prior.affinity = 0.0125;
  std::vector<AssignmentMark> marks;
  for (const Vector2d& place :
       {Vector2d(-10, -10), Vector2d(10, -10), Vector2d(-10, 10), Vector2d(10, 10),
        Vector2d(100, 100), Vector2d(100, 0), Vector2d(0, 100)})
    marks.push_back({place, {{place, 1.5}}, 9});
  marks[4].candidates = {{Vector2d(100, 100), -1.5}, {Vector2d(100.3, 100), 1.5}};
  const std::vector<int> choice = ChooseAround(marks, prior, {0, 0, 0, 0, -1, -1, -1});
  EXPECT_EQ(choice, (std::vector<int>(7, 0)));
}

}  // namespace
}  // namespace orient::interior
