// Ground control points with their image measurements, as a table people write.
#pragma once

#include <string>
#include <vector>

#include "patchdb/harvest/control_points.h"

namespace orient {

// One measurement of the table: the photo's name without folder and extension, and its pixel.
struct MeasuredPoint {
  std::string photo;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

struct ControlTablePoint {
  patchdb::ControlPoint point;
  std::vector<MeasuredPoint> measured;
};

// CSV with the header point,x,y,z,sigma_x,sigma_y,sigma_z,photo,col,row; a row a measurement, a
// point's rows repeat its coordinates. Throws InputError naming file and line: not a number, a
// sigma that is not positive, a point whose rows differ, measured twice in one photo.
std::vector<ControlTablePoint> ReadControlTable(const std::string& path);

}  // namespace orient
