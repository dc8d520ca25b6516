// How a block was flown, as its block file says: strips, their order, overlaps and directions.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace orient {

struct FlightStrip {
  std::string name;                   // for messages
  std::vector<std::string> photos;    // names in the order of exposure
  std::optional<double> azimuth_rad;  // flight direction, clockwise from grid north
};

struct FlightPlan {
  std::vector<FlightStrip> strips;  // as they lie side by side
  double overlap = 0.6;             // forward overlap, as a fraction
  double side_lap = 0.3;            // sidelap, as a fraction
  std::optional<double> azimuth_rad;
  std::optional<Eigen::Vector2d> next_strip;  // unit vector (east, north) towards the next strip
  bool back_and_forth = true;                 // every other strip flown the other way
  // One of them at most:
  std::optional<double> flying_height_m;  // above the ground
  std::optional<double> scale;            // number of the photo scale, 15000 for 1:15000

  bool Empty() const { return strips.empty(); }
  std::optional<double> FlyingHeight(double principal_distance_mm) const {
    if (scale) return *scale * principal_distance_mm / 1000;
    return flying_height_m;
  }
};

// "new_2" before "new_10": runs of digits count as numbers.
bool NaturallyLess(const std::string& a, const std::string& b);

}  // namespace orient
