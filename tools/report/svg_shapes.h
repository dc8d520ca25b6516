// Many small shapes as the data of one SVG path: a block has thousands of patches, and an element
// for each would make the report large and slow.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace orient {

// In the SVG's units, y down.
class SvgPath {
 public:
  // A dot where the stroke has round ends.
  void AddDot(const Eigen::Vector2d& at);
  void AddCross(const Eigen::Vector2d& at, double radius);
  void AddLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to);
  void AddRing(const std::vector<Eigen::Vector2d>& corners);  // closed
  // A line with an open head; short arrows have small heads.
  void AddArrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to);

  bool Empty() const { return data_.empty(); }
  // <path class="..." d="..."/>, nothing where the path is empty.
  std::string Element(const std::string& css_class) const;

 private:
  std::string data_;
};

// <text class="..." x="..." y="...">text</text>; the text is escaped. `more`: further attributes.
std::string SvgText(const char* css_class, const Eigen::Vector2d& at, const std::string& text,
                    const std::string& more = "");
inline constexpr const char* kCentred = " text-anchor=\"middle\"";

// 1, 2 or 5 times a power of ten, not above `limit` (> 0).
double RoundNumberBelow(double limit);

}  // namespace orient
