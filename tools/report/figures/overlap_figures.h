// How many photos show each place of the ground.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace orient {

// Cells on the ground (m, rows from the north), and how many outlines cover each one's middle.
class OverlapCounts {
 public:
  using Outline = std::vector<Eigen::Vector2d>;  // a polygon; closes itself
  static constexpr int kMostCounted = 6;         // so many, or more

  // At least one outline, with three corners or more each.
  explicit OverlapCounts(const std::vector<Outline>& outlines);

  int Width() const { return width_; }  // cells
  int Height() const { return height_; }
  double Cell_m() const { return cell_m_; }
  int At(int col, int row) const;  // at most kMostCounted
  // Of the cells that are covered at all those with this count (1 to kMostCounted), 0 to 1.
  double Share(int count) const;

 private:
  void AddRow(const Outline& outline, int row);

  double cell_m_ = 1;
  Eigen::Vector2d north_west_;
  int width_ = 0, height_ = 0;
  std::vector<int> counts_;
};

}  // namespace orient
