// The result of an adjusted block of three photos, for tests of what is derived from it.
#pragma once

#include "core/files/adjustment_result.h"

namespace orient {

// Two ties of the photos 4711 and 4712, one control patch and one check patch.
inline AdjustmentResult ExampleAdjustment() {
  AdjustmentResult result;
  result.converged = true;
  result.sigma0 = 0.93;
  result.redundancy = 41;
  result.components = {{"tie image", 1.44, 30, 0.24, true}, {"control ground", 1.0, 3, 0.0, false}};
  result.parts = {
      {{"4711", "4712"}, 1, true, {}},
      {{"4713"}, 0, false, Finding{Reason::kPartWithoutControl, Status::kOk, 1, {}, "4713"}}};
  result.calibration = {{"k1", 1.5e-8, 4e-9, 3.75, "estimated"}};
  result.checks = {{16, 2, Eigen::Vector3d(0.3, -0.4, 0.8), {{0.3, 0.4}, {-0.3, 0.4}}}};
  result.findings = {{.reason = Reason::kGnssRejected, .value = 1, .where = "<4713>"}};
  for (const std::int64_t id : {1, 2}) {
    PointResult tie;
    tie.id = id;
    tie.ground_m = Eigen::Vector3d(500000.0 + 10.0 * static_cast<double>(id), 5000010, 400);
    tie.sigma_m = Eigen::Vector3d(0.05, 0.06, 0.11);
    tie.rays = 2;
    tie.seen = {
        {"4711", {1020, 980}, "used", Eigen::Vector2d(0.2, 0.0), 0.7, 0.8},
        {"4712", {1000, 960}, id == 1 ? "used" : "rejected", Eigen::Vector2d(0.0, -0.4), 1.1, 0.6}};
    result.ties.push_back(tie);
  }
  PointResult patch;
  patch.id = 11;
  patch.control = ControlResult{"used", Eigen::Vector3d(499600, 5000350, 400),
                                Eigen::Vector3d(0.1, 0.0, -0.2), 0.4};
  patch.rays = 1;
  patch.seen = {{"4711", {200, 300}, "used", Eigen::Vector2d(0.5, 0.0), 1.9, std::nullopt}};
  result.control = {patch};
  return result;
}

}  // namespace orient
