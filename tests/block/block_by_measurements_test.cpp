#include "block/block_by_measurements.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/files/adjustment_result.h"
#include "core/geometry/collinearity.h"
#include "core/geometry/rotation.h"
#include "tests/support/expect_error.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

constexpr double kPixel_mm = 0.01, kSeen_px = 0.3, kSurveyed_m = 0.03;
// What poses are good to: several sigmas of the worst one.
constexpr double kWithGnss_m = 0.6, kByControl_m = 3;

// Two strips of a digital camera, flown there and back: many ties, four surveyed points at the
// corners, none of the photos sees more than two of them.
class TwoStripsMeasured : public testing::Test {
 protected:
  TwoStripsMeasured() {
    camera_.camera.kind = CameraKind::kDigital;
    camera_.camera.principal_distance_mm = 70;
    camera_.camera.frame_mm = {60, 60};
    camera_.camera.image_px = {6000, 6000};
    for (int i = 0; i < 8; ++i) {
      const int strip = i / 4;
      const double tilt = 0.02 * (i % 3 - 1);
      truth_["p" + std::to_string(i)] = {
          {500000.0 + 450 * (i % 4), 5600000.0 + 800 * strip, 1700.0 + 4 * (i % 3)},
          {tilt, -tilt, (i < 4 ? 0 : M_PI) + 0.02 * (i % 2)}};
    }
    for (int col = 0; col < 12; ++col)
      for (int row = 0; row < 12; ++row)
        See("t" + std::to_string(12 * col + row),
            {499500 + 210.0 * col, 5599500 + 160.0 * row, 300.0 + 15 * ((3 * col + row) % 4)});
    for (const auto& [name, x, y] :
         {std::tuple("sw", 499600, 5599600), std::tuple("se", 501750, 5599600),
          std::tuple("nw", 499600, 5601200), std::tuple("ne", 501750, 5601200)}) {
      const Eigen::Vector3d ground(x, y, 310);
      See(name, ground);
      measured_.points.push_back(
          {name, ground, Eigen::Vector3d::Constant(kSurveyed_m), PointRole::kControl});
    }
    Locate({3, -4, 5}, true);
  }

  void See(const std::string& point, const Eigen::Vector3d& ground) {
    for (const auto& [photo, pose] : truth_) {
      const auto mm = PhotoFromGround(camera_.camera, pose, ground);
      if (!mm || mm->cwiseAbs().maxCoeff() > 29) continue;
      const Eigen::Vector2d pixel(3000 + mm->x() / kPixel_mm + kSeen_px * normal_(random_),
                                  3000 - mm->y() / kPixel_mm + kSeen_px * normal_(random_));
      measured_.image_points.push_back({photo, point, pixel, std::nullopt, kSeen_px, {}});
    }
  }
  // Approximations that are so far off, all alike.
  void Locate(const Eigen::Vector3d& off_m, bool kappa) {
    approximations_.clear();
    for (const auto& [photo, pose] : truth_) {
      OrientationRow row;
      row.photo = photo;
      row.pose.position_m = pose.position_m + off_m;
      if (kappa) row.pose.opk_rad[2] = pose.opk_rad[2];
      row.attitude_known = kappa;
      approximations_.push_back(row);
    }
  }
  void ObserveGnss(GnssModel model, double sigma_m, const Eigen::Vector3d& shift_m) {
    known_.model = model;
    for (const auto& [photo, pose] : truth_) {
      const Eigen::Vector3d error(normal_(random_), normal_(random_), normal_(random_));
      known_.gnss[photo] = {pose.position_m + shift_m + sigma_m * error,
                            sigma_m * sigma_m * Eigen::Matrix3d::Identity(), 0};
      known_.strip[photo] = photo < "p4" ? "south" : "north";
    }
  }
  JudgedBlock Oriented() const {
    return OrientByMeasurements({camera_, measured_, approximations_, known_});
  }
  static double WorstSigma_m(const JudgedBlock& block) {
    double worst = 0;
    for (const ExteriorResult& result : block.results)
      worst = std::max(worst, result.pose ? std::sqrt((*result.covariance)(2, 2)) : INFINITY);
    return worst;
  }
  double WorstOff_m(const JudgedBlock& block) const {
    double worst = 0;
    for (const ExteriorResult& result : block.results)
      worst = std::max(
          worst, result.pose ? (result.pose->position_m - truth_.at(result.photo).position_m).norm()
                             : INFINITY);
    return worst;
  }

  CameraFile camera_;
  Measurements measured_;
  std::vector<OrientationRow> approximations_;
  PoseObservations known_;
  std::map<std::string, Pose> truth_;
  std::mt19937 random_{7};
  std::normal_distribution<double> normal_;
};

TEST_F(TwoStripsMeasured, GnssIsObservedAndMakesPosesMorePrecise) {
  const double alone_m = WorstSigma_m(Oriented());
  ObserveGnss(GnssModel::kPlain, 0.05, {0, 0, 0});
  const JudgedBlock block = Oriented();
  EXPECT_LT(WorstSigma_m(block), alone_m / 2);
  EXPECT_LT(WorstOff_m(block), kWithGnss_m);
  for (const AdjustedPhoto& photo : block.adjusted.result.photos) {
    EXPECT_TRUE(photo.gnss_residual_m);
    EXPECT_FALSE(photo.gnss_rejected);
  }
}

TEST_F(TwoStripsMeasured, AShiftIsEstimatedForEachStrip) {
  ObserveGnss(GnssModel::kShift, 0.05, {0.5, -0.4, 46});
  const JudgedBlock block = Oriented();
  ASSERT_EQ(block.adjusted.result.strips.size(), 2u);
  for (const StripGnss& strip : block.adjusted.result.strips)
    EXPECT_NEAR(strip.shift_m.z(), 46, 4 * strip.shift_sigma_m.z());
  EXPECT_LT(WorstOff_m(block), kByControl_m);
}

TEST_F(TwoStripsMeasured, AGrossErrorOfAPositionIsFoundAndNamed) {
  ObserveGnss(GnssModel::kPlain, 0.05, {0, 0, 0});
  known_.gnss["p2"].position_m.x() += 60;
  const JudgedBlock block = Oriented();
  EXPECT_TRUE(Has(block.findings, Reason::kGnssRejected));
  EXPECT_LT(WorstOff_m(block), kWithGnss_m);
}

TEST_F(TwoStripsMeasured, ApproximationsAreObservedWhereThatIsAsked) {
  const double alone_m = WorstSigma_m(Oriented());
  for (const auto& [photo, pose] : truth_) {
    Vector6d sigma;
    sigma << 0.05, 0.05, 0.05, 0.001, 0.001, 0.001;
    known_.approximations[photo] = {pose, sigma.cwiseAbs2().asDiagonal()};
  }
  EXPECT_LT(WorstSigma_m(Oriented()), alone_m / 2);
}

TEST_F(TwoStripsMeasured, PositionsMakeNoPhotoBetterThanItIsWithoutThem) {
  measured_.points.clear();
  ObserveGnss(GnssModel::kPlain, 0.05, {0, 0, 0});
  const JudgedBlock block = Oriented();
  ASSERT_EQ(block.results.size(), truth_.size());
  EXPECT_LT(WorstOff_m(block), kWithGnss_m) << "without any control";
  for (const ExteriorResult& result : block.results) {
    EXPECT_EQ(result.status, Status::kWeak);
    EXPECT_TRUE(Has(result.findings, Reason::kNotConnected));
  }
}

TEST_F(TwoStripsMeasured, PositionsAloneStartTheAdjustmentWhicheverWayAPhotoLies) {
  Locate({0.1, 0.1, 0.1}, false);
  const JudgedBlock block = Oriented();
  EXPECT_TRUE(block.adjusted.result.converged);
  EXPECT_LT(WorstOff_m(block), kByControl_m);
}

TEST_F(TwoStripsMeasured, TheProgramObservesWhatTheBlockFileSaysAndNamesWhatIsNotThere) {
  const TemporaryFolder folder;
  camera_.camera.name = "made up";
  WriteCameraFile(folder / "camera.toml", camera_);
  WriteImagePoints(folder.Path(), measured_.image_points);
  WritePoints(folder.Path(), measured_.points);
  std::string gnss = "filename,x,y,z\n";
  for (const auto& [photo, pose] : truth_)
    gnss += fmt::format("{}{},{:.3f},{:.3f},{:.3f}\n", photo == "p7" ? "IMG_" : "", photo,
                        pose.position_m.x(), pose.position_m.y(), pose.position_m.z());
  WriteFileAtomically(folder / "gnss.csv", gnss);
  WriteFileAtomically(folder / "approx.csv",
                      fmt::format("filename,x,y,z,kappa\np7,{:.3f},{:.3f},{:.3f},180\n",
                                  truth_["p7"].position_m.x(), truth_["p7"].position_m.y(),
                                  truth_["p7"].position_m.z()));
  WriteFileAtomically(folder / "block.toml",
                      "crs = \"EPSG:32635\"\ncamera = \"camera.toml\"\nmeasurements = \".\"\n"
                      "approximations = \"approx.csv\"\nearth = \"flat\"\n"
                      "[approximate_accuracy]\nposition_m = 0.5\nobserve = true\n"
                      "[gnss]\npositions = \"gnss.csv\"\nsigma_m = 0.05\nmodel = \"plain\"\n");
  const ProgramRun run = RunOrient({"block", folder / "block.toml"});
  EXPECT_EQ(run.exit_code, 3) << run.out << run.err;
  EXPECT_NE(run.out.find("gnss.csv lists 1 photo that is not in the block: IMG_p7"),
            std::string::npos)
      << run.out;
  const AdjustmentResult adjusted = ReadAdjustmentResult(AdjustmentResultPath(folder / "out"));
  EXPECT_EQ(adjusted.gnss.size(), 7u);
  EXPECT_EQ(adjusted.approximations.size(), 1u);
  EXPECT_TRUE(Has(adjusted.findings, Reason::kApproximationsOfOtherPhotos));
}

// What its block file says of such a block.
class KnownOfMeasured : public testing::Test {
 protected:
  KnownOfMeasured() {
    block_.approximations = folder_ / "approx.csv";
    block_.gnss.positions = folder_ / "gnss.csv";
    block_.gnss.sigma_m = 0.1;
    for (const char* photo : {"a", "b"})
      measured_.image_points.push_back({photo, "p", Eigen::Vector2d(1, 2), std::nullopt, 1, {}});
    WriteFileAtomically(block_.approximations, "filename,x,y,z\na,400000,6000000,1500\n");
    WriteFileAtomically(block_.gnss.positions,
                        "filename,x,y,z\na,400001,6000001,1501\nb,400500,6000000,1500\n");
  }

  const TemporaryFolder folder_;
  BlockFile block_{.crs = Crs::Parse("EPSG:32635", "test")};
  Measurements measured_;
};

TEST_F(KnownOfMeasured, GnssLocatesPhotosThatTheTableLacks) {
  const PosesKnown known = ReadPosesKnown(block_, measured_);
  ASSERT_EQ(known.approximations.size(), 2u);
  EXPECT_EQ(known.approximations[0].pose.position_m.x(), 400000);
  EXPECT_EQ(known.approximations[1].photo, "b");
  EXPECT_EQ(known.observed.gnss.size(), 2u);
  EXPECT_TRUE(known.observed.approximations.empty());
  EXPECT_TRUE(known.remarks.empty());
  EXPECT_TRUE(known.not_there.empty());
}

TEST_F(KnownOfMeasured, RowsOfPhotosThatAreNotMeasuredAreNamed) {
  WriteFileAtomically(block_.gnss.positions, "filename,x,y,z\nIMG_a,400001,6000001,1501\n");
  const PosesKnown known = ReadPosesKnown(block_, measured_);
  EXPECT_EQ(known.not_there, std::vector<std::string>{"IMG_a"});
  ASSERT_EQ(known.remarks.size(), 1u);
  EXPECT_EQ(known.remarks[0].where, block_.gnss.positions + ": IMG_a");
}

TEST_F(KnownOfMeasured, GnssHasTheStripsOfTheBlockFileAndPhotosOnlyInThemAreNamed) {
  block_.flight.strips = {{"05", {"a", "b", "ghost"}, std::nullopt}};
  const PosesKnown known = ReadPosesKnown(block_, measured_);
  EXPECT_EQ(known.observed.strip.at("b"), "05");
  ASSERT_TRUE(Has(known.remarks, Reason::kStripPhotosAbsent));
  EXPECT_EQ(known.remarks[0].where, "ghost");
}

TEST_F(KnownOfMeasured, ApproximationsToObserveNeedAnAccuracyAndATable) {
  block_.observe_approximations = true;
  ExpectError<InputError>([&] { ReadPosesKnown(block_, measured_); },
                          {"observe = true", "position_m"});
  block_.position_sigma_m = 5;
  EXPECT_EQ(ReadPosesKnown(block_, measured_).observed.approximations.size(), 1u);
  block_.approximations.clear();
  ExpectError<InputError>([&] { ReadPosesKnown(block_, measured_); },
                          {"observe = true", "no table of approximations"});
}

TEST_F(KnownOfMeasured, ExchangedAxesAreRefused) {
  WriteFileAtomically(block_.gnss.positions, "filename,x,y,z\na,6000001,400001,1501\n");
  ExpectError<InputError>([&] { ReadPosesKnown(block_, measured_); }, {"gnss.csv", "exchanged"});
}

}  // namespace
}  // namespace orient::block
