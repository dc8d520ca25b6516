#include "core/files/mark_painting.h"

#include <gtest/gtest.h>

#include <cmath>

namespace orient {
namespace {

using Eigen::Vector2d;

TEST(Paint, CoversWhatSignedDistanceSaysIsInside) {
  const std::vector<MarkElement> elements = {
      CrossElement{3.0, 0.2, 0.5, 0.3, {0.1, -0.2}, -0.5},
      DotElement{0.7, {-0.4, 0.3}},
      CircleElement{1.6, 0.3, {0.2, 0.2}},
      LineElement{{-1, -0.5}, {0.8, 0.9}, 0.4},
      WedgeElement{1.2, 1.5, 0.7, {0.3, 0}},
      CheckerElement{1.8, 0.4, {0.1, 0.1}},
      PolygonElement{{{-1, -1}, {1, -1}, {1, 0}, {0, 0}, {0, 1}, {-1, 1}}}};
  std::vector<Vector2d> points;
  for (double x = -2; x < 2; x += 0.0631)
    for (double y = -2; y < 2; y += 0.0571) points.emplace_back(x, y);
  for (const MarkElement& element : elements) {
    std::vector<float> values(points.size(), 2.0f);
    Paint(element, points, &values);
    const auto painted = static_cast<float>(BrightnessOf(element));
    for (size_t i = 0; i < points.size(); ++i) {
      const double distance = SignedDistance(element, points[i]);
      if (std::abs(distance) < 1e-9) continue;
      ASSERT_EQ(values[i], distance < 0 ? painted : 2.0f)
          << element.index() << ": " << points[i].transpose();
    }
  }
}

}  // namespace
}  // namespace orient
