#include "interior/assignment.h"

#include <random>

#include "tests/support/shared_data.h"

namespace orient {
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
    Eigen::Matrix2d deformed = Eigen::Rotation2Dd(0.01 * Normal()).toRotationMatrix();
    deformed *= 1 + 0.003 * Normal();
    deformed.col(0) *= 1 + 0.005 * Normal();
    const Vector2d shift(4 * Normal(), 4 * Normal());
    Scene scene;
    for (int i = 0; i < mark_count; ++i) {
      const double m = 106;
      const std::vector<Vector2d> places = {{-m, -m}, {m, m}, {-m, m}, {m, -m},
                                            {-m, 0},  {m, 0}, {0, m},  {0, -m}};
      AssignmentMark mark;
      mark.place_mm = places[i];
      mark.window_mm2 = kWindowMm * kWindowMm;
      for (int k = 0; k < clutter; ++k)
        mark.candidates.push_back({places[i] + Vector2d(Uniform(), Uniform()), -1.0});
      int truth = -1;
      if (marks_are_there && std::uniform_real_distribution<double>(0, 1)(random_) < found) {
        truth = std::uniform_int_distribution<int>(0, clutter)(random_);
        const Vector2d at = deformed * places[i] + shift + noise_mm * Vector2d(Normal(), Normal());
        mark.candidates.insert(mark.candidates.begin() + truth, {at, 0.5});
      }
      scene.truth.push_back(truth);
      scene.marks.push_back(std::move(mark));
    }
    return scene;
  }

 private:
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

}  // namespace
}  // namespace orient
