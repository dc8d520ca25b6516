#include "tools/report/svg_shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tools/report/html_text.h"

namespace orient {
namespace {

std::string Pair(const Eigen::Vector2d& v) {
  const std::string y = SvgNumber(v.y());
  return SvgNumber(v.x()) + (y.starts_with('-') ? "" : " ") + y;
}

}  // namespace

void SvgPath::AddDot(const Eigen::Vector2d& at) { data_ += "M" + Pair(at) + "h0"; }

void SvgPath::AddCross(const Eigen::Vector2d& at, double radius) {
  const Eigen::Vector2d down(radius, radius), up(radius, -radius);
  AddLine(at - down, at + down);
  AddLine(at - up, at + up);
}

void SvgPath::AddLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  data_ += "M" + Pair(from) + "L" + Pair(to);
}

void SvgPath::AddRing(const std::vector<Eigen::Vector2d>& corners) {
  for (std::size_t i = 0; i < corners.size(); ++i) data_ += (i == 0 ? "M" : "L") + Pair(corners[i]);
  if (!corners.empty()) data_ += "z";
}

void SvgPath::AddArrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  constexpr double kLongestHead = 5.0;
  constexpr double kHeadPart = 0.35;
  const Eigen::Vector2d shaft = to - from;
  const double length = shaft.norm();
  AddLine(from, to);
  if (length < 2.0) return;  // a head would hide it
  const Eigen::Vector2d back = -shaft / length * std::min(kLongestHead, kHeadPart * length);
  const Eigen::Vector2d side(-0.5 * back.y(), 0.5 * back.x());
  data_ += "M" + Pair(to + back + side) + "L" + Pair(to) + "L" + Pair(to + back - side);
}

std::string SvgPath::Element(const std::string& css_class) const {
  if (data_.empty()) return "";
  return fmt::format("<path class=\"{}\" d=\"{}\"/>\n", css_class, data_);
}

std::string SvgText(const char* css_class, const Eigen::Vector2d& at, const std::string& text,
                    const std::string& more) {
  return fmt::format("<text class=\"{}\" x=\"{}\" y=\"{}\"{}>{}</text>\n", css_class,
                     SvgNumber(at.x()), SvgNumber(at.y()), more, Escape(text));
}

double RoundNumberBelow(double limit) {
  if (!(limit > 0) || !std::isfinite(limit))
    throw std::invalid_argument("RoundNumberBelow: not a positive number");
  const double power = std::pow(10.0, std::floor(std::log10(limit)));
  for (const double digit : {5.0, 2.0})
    if (digit * power <= limit) return digit * power;
  return power;
}

}  // namespace orient
