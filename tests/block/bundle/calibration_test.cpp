// Self-calibration within the block adjustment.
#include <gtest/gtest.h>

#include <stdexcept>

#include "block/bundle/adjustment.h"
#include "tests/block/bundle/bundle_verdict.h"

namespace orient::block {
namespace {

Camera NominalCamera() {
  Camera camera;
  camera.kind = CameraKind::kFilm;
  camera.principal_distance_mm = 153;
  camera.frame_mm = {230, 230};
  return camera;
}

BundleSimulationOptions CalibrationBlock() {
  BundleSimulationOptions options;
  options.ties_per_photo = 60;
  options.control_seen_by_all = true;
  options.gnss_sigma_m = 0.05;  // without it principal distance and height are hardly two things
  return options;
}

BlockOptions SelfCalibration() {
  BlockOptions options;
  options.self_calibration = true;
  return options;
}

const CalibrationParameter& Find(const BlockResult& result, const std::string& name) {
  for (const CalibrationParameter& parameter : result.calibration)
    if (parameter.name == name) return parameter;
  throw std::logic_error("no parameter " + name);
}

double RadialUm(const LensDistortion& lens, double radius_mm) {
  return 1e3 * DistortionAt(lens, {radius_mm, 0}).x();
}

TEST(BlockCalibration, FindsLensAndPrincipalPoint) {
  Camera lens = NominalCamera();
  BrownDistortion brown;
  brown.k[0] = 2e-8;  // 20 um at 100 mm
  lens.lens = brown;
  lens.principal_point_mm = {0.08, -0.05};
  const BundleSimulation simulation = BundleSimulator(CalibrationBlock()).TrueCamera(lens).Make();
  const BlockResult result = AdjustBlock(simulation.block, SelfCalibration());
  const CalibrationParameter& x = Find(result, "principal_point_x_mm");
  const CalibrationParameter& y = Find(result, "principal_point_y_mm");
  EXPECT_EQ(x.state, CalibrationState::kEstimated);
  EXPECT_EQ(y.state, CalibrationState::kEstimated);
  EXPECT_LT(std::abs(x.value - 0.08), 4 * x.sigma);
  EXPECT_LT(std::abs(y.value + 0.05), 4 * y.sigma);
  EXPECT_LT(x.sigma, 0.01);
  // k2 and k3 may share what k1 does: the lens counts, not its coefficients.
  for (const double r : {30.0, 60.0, 90.0, 110.0})
    EXPECT_NEAR(RadialUm(result.cameras[0].lens, r), RadialUm(brown, r), 3);
  const BundleVerdict verdict = JudgeBundle(simulation, result);
  EXPECT_LT(verdict.height_gsd, 0.9);
  EXPECT_LT(verdict.PoseChi(), 1.4);
}

TEST(BlockCalibration, RefusesWhatIsNotSignificant) {
  const BundleSimulation simulation = SimulateBundle(CalibrationBlock());
  const BlockResult result = AdjustBlock(simulation.block, SelfCalibration());
  ASSERT_EQ(result.calibration.size(), 6u);
  for (const CalibrationParameter& parameter : result.calibration) {
    EXPECT_NE(parameter.state, CalibrationState::kEstimated) << parameter.name;
    EXPECT_EQ(parameter.value, 0) << parameter.name;
    EXPECT_GT(parameter.sigma, 0) << parameter.name;
  }
  EXPECT_EQ(result.cameras[0].principal_distance_mm, 153);
  EXPECT_TRUE(result.findings.empty()) << "heights are those of GNSS";
}

TEST(BlockCalibration, SaysWhatTheBlockDoesNotDetermine) {
  BundleSimulationOptions flat = CalibrationBlock();
  flat.gnss_sigma_m = 0;
  flat.prior = false;
  flat.relief_m = 0;  // on flat ground the flying height takes up the principal distance
  const BundleSimulation simulation = SimulateBundle(flat);
  const BlockResult result = AdjustBlock(simulation.block, SelfCalibration());
  EXPECT_NE(Find(result, "principal_distance_mm").state, CalibrationState::kEstimated);
  EXPECT_LT(JudgeBundle(simulation, result).horizontal_gsd, 0.6);
  ASSERT_EQ(result.findings.size(), 1u);
  EXPECT_EQ(result.findings[0].reason, Reason::kDistanceLeftOpen);
  EXPECT_EQ(result.findings[0].value, Find(result, "principal_distance_mm").sigma);
}

TEST(BlockCalibration, AddsToARadialTable) {
  Camera lens = NominalCamera();
  const RadialTable table{{0, 50, 100, 160}, {0, 4, -6, -10}};
  RadialTable truth;  // 40 um more at 100 mm, as r^3
  for (double r = 0; r <= 165; r += 1) {
    truth.radius_mm.push_back(r);
    truth.dr_um.push_back(RadialUm(table, r) + 40 * std::pow(r / 100, 3));
  }
  lens.lens = truth;
  BundleSimulation simulation = BundleSimulator(CalibrationBlock()).TrueCamera(lens).Make();
  simulation.block.cameras[0].lens = table;
  const BlockResult result = AdjustBlock(simulation.block, SelfCalibration());
  for (const double r : {30.0, 60.0, 90.0, 110.0})
    EXPECT_NEAR(RadialUm(result.cameras[0].lens, r), RadialUm(truth, r), 4);
}

}  // namespace
}  // namespace orient::block
