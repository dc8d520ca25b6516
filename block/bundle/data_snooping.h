// Which observations count: the states of all observations, what makes them change, and the test
// for gross errors. Private to block.
#pragma once

#include <vector>

#include "block/bundle/equations.h"
#include "block/bundle/normal_equations.h"

namespace orient::block {

// How many observations were taken out or put back.
struct BlockChanges {
  int poses = 0;   // GNSS positions and priors
  int points = 0;  // image points, and the ground of control
  int All() const { return poses + points; }
};

class BlockJudgement {
 public:
  explicit BlockJudgement(BlockSystem* system);

  const std::vector<ObservationState>& states() const { return states_; }
  const std::vector<bool>& takes_part() const { return takes_part_; }
  const std::vector<bool>& control_rejected() const { return control_rejected_; }

  // A photo that cannot be determined: nothing of it counts any more.
  void Dismiss(std::size_t photo);
  // A point that its rays do not fix.
  void GiveUp(std::size_t point);
  // Ties with one ray left, and those whose rays meet under next to no angle, as seen from the
  // present poses; those that come to count again are put back. True where anything changed.
  bool Screen();

  // Takes out what the test calls gross errors, in each neighbourhood the largest first, and puts
  // back what only looked like one. The limits are multiplied by `caution`.
  BlockChanges Apply(const BlockTests& tests, double caution);

 private:
  struct Suspect;
  double Score(const RowTest& test) const;
  std::vector<Suspect> FindSuspects(const BlockTests& tests, double caution) const;
  int Reject(const BlockTests& tests, double caution);
  void RejectAt(const Suspect& suspect, const BlockTests& tests);
  int PutBack(const BlockTests& tests);
  int PutBackDissolved();
  int RejectPoses(const BlockTests& tests, double caution);
  int RejectUntested();
  int PutBackPoses(const BlockTests& tests);
  bool RaysAgree(std::size_t point, const std::vector<std::size_t>& rows);
  bool ScreenPoint(std::size_t point);
  double LargestAngle(const std::vector<std::size_t>& rows) const;

  BlockSystem* system_;
  std::vector<ObservationState> states_;
  std::vector<bool> takes_part_;        // of each photo
  std::vector<bool> given_up_;          // of each point
  std::vector<bool> control_rejected_;  // of each point
  std::vector<bool> put_back_;          // of each observation: once only
  std::vector<bool> control_put_back_;
  std::vector<bool> pose_put_back_;    // of each row
  std::array<double, 7> limits_ = {};  // by degrees of freedom
};

}  // namespace orient::block
