#include "core/files/results.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr double kExact = 1e-12;  // arithmetic only: degrees to radians and back

InteriorResult ExampleInterior() {
  InteriorResult result;
  result.photo = "4711";
  result.status = Status::kOk;
  result.width = result.height = 9200;
  result.pixel_size_um = 25.0;
  result.polarity = Polarity::kPositive;
  result.orientation = ScanOrientation::kR90;
  result.possible_orientations = {ScanOrientation::kR90};
  result.photo_from_pixel =
      Affine2d{(Eigen::Matrix2d() << 0.025, 0.001, 0.002, -0.0251).finished(), {-115.0, 115.5}};
  result.sigma0_um = 4.1;
  result.margin = 9.3;
  result.marks.push_back({"1", MarkState::kUsed, Eigen::Vector2d(312.41, 288.07),
                          Eigen::Vector2d(0.02, 0.03), Eigen::Vector2d(1.1, -0.4), 0.93});
  result.marks.push_back({"2", MarkState::kMissing, {}, {}, {}, {}});
  result.findings = {{.reason = Reason::kStated, .where = "mark 2 lies outside the scan"}};
  return result;
}

ExteriorResult ExampleExterior() {
  ExteriorResult result;
  result.photo = "4711";
  result.status = Status::kWeak;
  result.pose =
      Pose{{500123.4, 5000321.0, 1823.9}, {RadFromDeg(0.12), RadFromDeg(-0.3), RadFromDeg(91.2)}};
  result.covariance = Matrix6d::Identity() * 0.25;
  (*result.covariance)(0, 5) = (*result.covariance)(5, 0) = 1e-7;
  result.approximation = StartingPose{*result.pose, Vector6d::Constant(0.5)};
  result.approximation->pose.position_m.x() -= 3;
  result.sigma0_px = 0.31;
  result.projection_sigma = ProjectionSigma{0.42, 0.21};
  result.orientation = ScanOrientation::kM180;
  result.width = 9200;
  result.height = 9100;
  result.footprint_m = {{0, 0, 5}, {1, 0, 5}, {1, 1, 6}, {0, 0, 5}};
  result.iterations = {{26, 9, 412.0, 1.9, 4}, {26, 21, 30.5, 0.4}};
  result.patches.push_back({17,
                            3,
                            PatchState::kMatched,
                            Eigen::Vector3d(500100.5, 5000300, 410),
                            Eigen::Vector2d(401, 512),
                            Eigen::Vector2d(398.21, 515.66),
                            Eigen::Vector2d(0.08, 0.07),
                            Eigen::Vector2d(0.11, -0.2),
                            0.87,
                            {}});
  result.patches.push_back(
      {18, {}, PatchState::kNotVisible, {}, {}, {}, {}, {}, {}, {{Reason::kPatchHidden}}});
  return result;
}

nlohmann::json Written(const InteriorResult& result) {
  const TemporaryFolder folder;
  WriteInteriorResult(folder.Path(), result);
  return nlohmann::json::parse(ReadFile(InteriorResultPath(folder.Path(), result.photo)));
}

nlohmann::json Written(const ExteriorResult& result) {
  const TemporaryFolder folder;
  WriteExteriorResult(folder.Path(), result);
  return nlohmann::json::parse(ReadFile(ExteriorResultPath(folder.Path(), result.photo)));
}

TEST(InteriorResult, FieldsAreThoseOfTheConventions) {
  const nlohmann::json json = Written(ExampleInterior());
  EXPECT_EQ(json["photo"], "4711");
  EXPECT_EQ(json["status"], "ok");
  EXPECT_EQ(json["scan"], nlohmann::json::parse(R"({"width": 9200, "height": 9200,
      "pixel_size_um": 25.0, "polarity": "positive", "orientation": "r90",
      "possible_orientations": ["r90"]})"));
  EXPECT_EQ(json["photo_from_pixel"],
            nlohmann::json::parse("[[0.025, 0.001, -115.0], [0.002, -0.0251, 115.5]]"));
  EXPECT_EQ(json["sigma0_um"], 4.1);
  EXPECT_EQ(json["margin"], 9.3);
  EXPECT_EQ(json["marks"][0], nlohmann::json::parse(R"({"id": "1", "state": "used",
      "pixel": [312.41, 288.07], "sigma_px": [0.02, 0.03], "residual_um": [1.1, -0.4],
      "score": 0.93})"));
  EXPECT_EQ(json["marks"][1]["state"], "missing");
  EXPECT_TRUE(json["marks"][1]["pixel"].is_null());
  EXPECT_EQ(json["messages"], nlohmann::json::parse(R"(["mark 2 lies outside the scan"])"));
}

TEST(InteriorResult, WhatTheRollDecidedIsReadAsItWasWritten) {
  InteriorResult result = ExampleInterior();
  result.orientations_alone = {ScanOrientation::kM0, ScanOrientation::kR90};
  result.orientation_nats = {0, -1.5};
  const TemporaryFolder folder;
  WriteInteriorResult(folder.Path(), result);
  const InteriorResult read = ReadInteriorResult(InteriorResultPath(folder.Path(), result.photo));
  EXPECT_EQ(read.orientations_alone, result.orientations_alone);
  EXPECT_EQ(read.orientation_nats, result.orientation_nats);
}

TEST(InteriorResult, WhereAMarkWasLookedForIsReadAsItWasWritten) {
  InteriorResult result = ExampleInterior();
  result.marks[1].expected = Eigen::Vector2d(8800.5, -12.25);
  result.marks[1].window = SearchedWindow{8500, -300, 600, 610};
  const TemporaryFolder folder;
  WriteInteriorResult(folder.Path(), result);
  const InteriorResult read = ReadInteriorResult(InteriorResultPath(folder.Path(), result.photo));
  EXPECT_FALSE(read.marks[0].expected);
  EXPECT_FALSE(read.marks[0].window);
  EXPECT_EQ(read.marks[1].expected, result.marks[1].expected);
  ASSERT_TRUE(read.marks[1].window);
  EXPECT_EQ(read.marks[1].window->col, 8500);
  EXPECT_EQ(read.marks[1].window->row, -300);
  EXPECT_EQ(read.marks[1].window->width, 600);
  EXPECT_EQ(read.marks[1].window->height, 610);
}

TEST(InteriorResult, EvidenceOfTheOrientationIsReadAsItWasWritten) {
  InteriorResult result = ExampleInterior();
  result.orientation_evidence = {
      {"symbol of mark 3", {{ScanOrientation::kR0, 2.5}, {ScanOrientation::kM90, -7}}},
      {"data strip", {{ScanOrientation::kR0, 0}, {ScanOrientation::kM90, 0}}}};
  const TemporaryFolder folder;
  WriteInteriorResult(folder.Path(), result);
  const InteriorResult read = ReadInteriorResult(InteriorResultPath(folder.Path(), result.photo));
  ASSERT_EQ(read.orientation_evidence.size(), 2u);
  EXPECT_EQ(read.orientation_evidence[0].by, "symbol of mark 3");
  EXPECT_EQ(read.orientation_evidence[0].nats, result.orientation_evidence[0].nats);
  EXPECT_EQ(read.orientation_evidence[1].nats, result.orientation_evidence[1].nats);
}

TEST(InteriorResult, AnOpenOrientationIsNull) {
  InteriorResult result = ExampleInterior();
  result.orientation.reset();
  const nlohmann::json json = Written(result);
  ASSERT_TRUE(json["scan"].contains("orientation"));
  EXPECT_TRUE(json["scan"]["orientation"].is_null());
}

TEST(InteriorResult, WhatIsStillPossibleReadsBackInItsOrder) {
  const TemporaryFolder folder;
  InteriorResult result = ExampleInterior();
  result.orientation.reset();
  result.possible_orientations = {ScanOrientation::kR270, ScanOrientation::kM0};
  WriteInteriorResult(folder.Path(), result);
  EXPECT_EQ(ReadInteriorResult(folder / "4711.interior.json").possible_orientations,
            result.possible_orientations);
}

TEST(InteriorResult, Roundtrip) {
  const TemporaryFolder folder;
  const InteriorResult result = ExampleInterior();
  WriteInteriorResult(folder.Path(), result);
  const InteriorResult read = ReadInteriorResult(folder / "4711.interior.json");
  EXPECT_EQ(read.photo, result.photo);
  EXPECT_EQ(read.status, result.status);
  EXPECT_EQ(read.width, result.width);
  EXPECT_EQ(read.pixel_size_um, result.pixel_size_um);
  EXPECT_EQ(read.polarity, result.polarity);
  EXPECT_EQ(read.orientation, result.orientation);
  EXPECT_EQ(read.photo_from_pixel->A, result.photo_from_pixel->A);
  EXPECT_EQ(read.photo_from_pixel->t, result.photo_from_pixel->t);
  EXPECT_EQ(read.sigma0_um, result.sigma0_um);
  EXPECT_EQ(read.margin, result.margin);
  ASSERT_EQ(read.marks.size(), 2u);
  EXPECT_EQ(read.marks[0].pixel, result.marks[0].pixel);
  EXPECT_EQ(read.marks[0].residual_um, result.marks[0].residual_um);
  EXPECT_EQ(read.marks[1].state, MarkState::kMissing);
  EXPECT_FALSE(read.marks[1].pixel);
  EXPECT_EQ(read.findings, result.findings);
}

TEST(InteriorResult, AReseauReadsBackToAHundredthOfAMicrometre) {
  InteriorResult result = ExampleInterior();
  FilmCorrection grid;
  grid.origin_px = {100.5, 200};
  grid.step_px = {300, 250.25};
  grid.columns = 3;
  grid.rows = 2;
  for (int i = 0; i < 6; ++i) grid.correction_mm.emplace_back(0.001 * i, -0.0123456);
  result.reseau = ReseauResult{grid, 23, 2.5, 3.5};
  TemporaryFolder folder;
  WriteInteriorResult(folder.Path(), result);
  const std::string path = InteriorResultPath(folder.Path(), result.photo);
  const auto reseau = ReadInteriorResult(path).reseau;
  ASSERT_TRUE(reseau);
  EXPECT_EQ(reseau->crosses, 23);
  EXPECT_NEAR(reseau->noise_um, 2.5, kExact);
  EXPECT_NEAR(reseau->left_out_rms_um, 3.5, kExact);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(150, 220), Eigen::Vector2d(690, 444)})
    EXPECT_LT((reseau->correction.At(pixel) - grid.At(pixel)).norm(), 1e-5) << "mm";

  std::string text = ReadFile(path);
  text.replace(text.find("\"columns\": 3"), 12, "\"columns\": 4");
  WriteFileAtomically(path, text);
  EXPECT_THROW(ReadInteriorResult(path), InputError) << "six values are not four columns";
}

TEST(InteriorResult, AFailedPhotoHasNullsAndReadsBackEmpty) {
  const TemporaryFolder folder;
  InteriorResult result;
  result.photo = "4712";
  WriteInteriorResult(folder.Path(), result);
  const InteriorResult read = ReadInteriorResult(folder / "4712.interior.json");
  EXPECT_EQ(read.status, Status::kFailed);
  EXPECT_FALSE(read.photo_from_pixel || read.polarity || read.orientation || read.margin);
  EXPECT_TRUE(read.marks.empty());
}

TEST(InteriorResult, ATransformWithoutAnInverseIsNotRead) {
  const TemporaryFolder folder;
  InteriorResult result = ExampleInterior();
  for (const double factor : {0.0, 1e200}) {
    result.photo_from_pixel->A.setConstant(factor);
    WriteInteriorResult(folder.Path(), result);
    ExpectError<InputError>([&] { ReadInteriorResult(folder / "4711.interior.json"); },
                            {"4711.interior.json", "photo_from_pixel"});
  }
}

TEST(InteriorResult, ATransformThatIsNotFiniteIsNeverWritten) {
  const TemporaryFolder folder;
  InteriorResult result = ExampleInterior();
  result.photo_from_pixel->t.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(WriteInteriorResult(folder.Path(), result), std::invalid_argument);
  EXPECT_FALSE(std::filesystem::exists(folder / "4711.interior.json"));
}

TEST(ExteriorResult, FieldsAreThoseOfTheConventions) {
  const nlohmann::json json = Written(ExampleExterior());
  EXPECT_EQ(json["status"], "weak");
  EXPECT_EQ(json["pose"]["x"], 500123.4);
  EXPECT_EQ(json["pose"]["z"], 1823.9);
  EXPECT_NEAR(json["pose"]["omega"].get<double>(), 0.12, kExact);
  EXPECT_NEAR(json["pose"]["phi"].get<double>(), -0.3, kExact);
  EXPECT_NEAR(json["pose"]["kappa"].get<double>(), 91.2, kExact * 100);
  ASSERT_EQ(json["covariance"].size(), 6u);
  EXPECT_EQ(json["covariance"][0][5], 1e-7);
  EXPECT_EQ(json["approximation"]["x"], 500120.4);
  EXPECT_EQ(json["approximation"]["sigma"][1], 0.5);
  EXPECT_NEAR(json["approximation"]["sigma"][5].get<double>(), DegFromRad(0.5), kExact * 100);
  EXPECT_EQ(json["sigma0_px"], 0.31);
  EXPECT_EQ(json["projection_sigma"], nlohmann::json::parse(R"({"px": 0.42, "m": 0.21})"));
  EXPECT_EQ(json["iterations"][0], nlohmann::json::parse(R"({"searched": 26, "matched": 9,
      "window_px": 412.0, "rms_px": 1.9, "reduction": 4})"));
  EXPECT_EQ(json["patches"][0], nlohmann::json::parse(R"({"id": 17, "source": 3, "state": "matched",
      "ground": [500100.5, 5000300.0, 410.0], "predicted": [401.0, 512.0], "pixel": [398.21, 515.66], "sigma_px": [0.08, 0.07],
      "residual_px": [0.11, -0.2], "ncc": 0.87, "reason": "", "reason_codes": []})"));
  EXPECT_EQ(json["patches"][1]["state"], "not_visible");
  EXPECT_EQ(json["patches"][1]["reason"], "hidden by terrain");
  EXPECT_EQ(json["patches"][1]["reason_codes"], nlohmann::json::parse(R"(["patch_hidden"])"));
  EXPECT_EQ(json["not_visible"], nlohmann::json::parse(R"({"hidden by terrain": 1})"));
  EXPECT_TRUE(json["messages"].empty());
}

TEST(ExteriorResult, AnglesAreWrittenInTheHalfOpenCircle) {
  ExteriorResult result = ExampleExterior();
  result.pose->opk_rad.z() = RadFromDeg(268.8);
  EXPECT_NEAR(Written(result)["pose"]["kappa"].get<double>(), -91.2, kExact * 100);
}

TEST(ExteriorResult, Roundtrip) {
  const TemporaryFolder folder;
  const ExteriorResult result = ExampleExterior();
  WriteExteriorResult(folder.Path(), result);
  const ExteriorResult read = ReadExteriorResult(folder / "4711.exterior.json");
  EXPECT_EQ(read.status, Status::kWeak);
  EXPECT_EQ(read.orientation, ScanOrientation::kM180);
  EXPECT_EQ(read.pose->position_m, result.pose->position_m);
  EXPECT_LT((read.pose->opk_rad - result.pose->opk_rad).norm(), kExact);
  ASSERT_TRUE(read.approximation);
  EXPECT_EQ(read.approximation->pose.position_m.x(), 500120.4);
  EXPECT_LT((read.approximation->sigma - result.approximation->sigma).norm(), kExact);
  EXPECT_EQ(*read.covariance, *result.covariance);
  EXPECT_EQ(read.projection_sigma->px, 0.42);
  EXPECT_EQ(read.projection_sigma->m, 0.21);
  EXPECT_EQ(read.height, 9100);
  EXPECT_EQ(read.footprint_m, result.footprint_m);
  ASSERT_EQ(read.iterations.size(), 2u);
  EXPECT_EQ(read.iterations[1].window_px, 30.5);
  EXPECT_EQ(read.iterations[0].reduction, 4);
  EXPECT_EQ(read.iterations[1].reduction, 1);
  ASSERT_EQ(read.patches.size(), 2u);
  EXPECT_EQ(read.patches[0].id, 17);
  EXPECT_EQ(read.patches[0].source, 3);
  EXPECT_FALSE(read.patches[1].source);
  EXPECT_EQ(read.patches[0].ground_m, result.patches[0].ground_m);
  EXPECT_FALSE(read.patches[1].ground_m);
  EXPECT_EQ(read.patches[0].sigma_px, result.patches[0].sigma_px);
  EXPECT_TRUE(read.patches[0].findings.empty());
  EXPECT_EQ(read.patches[1].findings, result.patches[1].findings);
  EXPECT_FALSE(read.patches[1].ncc);
}

TEST(ExteriorResult, APatchKeepsAllItsReasonsOrWhatAnotherMakerStates) {
  const TemporaryFolder folder;
  ExteriorResult result = ExampleExterior();
  result.patches[0].findings = {{Reason::kLowCorrelation}, {Reason::kGradientsAmbiguous}};
  result.patches[1].findings = {{.reason = Reason::kStated, .where = "outside the frame"}};
  EXPECT_EQ(Written(result)["patches"][0]["reason"],
            "best correlation below the threshold; "
            "ambiguous: the gradients of a second place fit as well");
  WriteExteriorResult(folder.Path(), result);
  const ExteriorResult read = ReadExteriorResult(folder / "4711.exterior.json");
  EXPECT_EQ(read.patches[0].findings, result.patches[0].findings);
  EXPECT_EQ(read.patches[1].findings, result.patches[1].findings);
}

TEST(ExteriorResult, AnEstimatedPrincipalDistanceReadsBack) {
  const TemporaryFolder folder;
  ExteriorResult result = ExampleExterior();
  EXPECT_FALSE(Written(result).contains("principal_distance_mm"));
  result.principal_distance = EstimatedPrincipalDistance{152.31, 0.02, 152.0, 0.5};
  WriteExteriorResult(folder.Path(), result);
  const auto read = ReadExteriorResult(folder / "4711.exterior.json").principal_distance;
  ASSERT_TRUE(read);
  EXPECT_EQ(read->value_mm, 152.31);
  EXPECT_EQ(read->sigma_mm, 0.02);
  EXPECT_EQ(read->prior_mm, 152.0);
  EXPECT_EQ(read->prior_sigma_mm, 0.5);
}

TEST(ExteriorResult, ReductionsOfOlderResultsAreOneAndOthersAtLeastOne) {
  const TemporaryFolder folder;
  const std::string path = folder / "4711.exterior.json";
  WriteExteriorResult(folder.Path(), ExampleExterior());
  nlohmann::json json = nlohmann::json::parse(ReadFile(path));
  json["iterations"][0].erase("reduction");
  WriteFileAtomically(path, json.dump());
  EXPECT_EQ(ReadExteriorResult(path).iterations[0].reduction, 1);
  json["iterations"][0]["reduction"] = 0;
  WriteFileAtomically(path, json.dump());
  ExpectError<InputError>([&] { ReadExteriorResult(path); }, {"reduction must be at least 1"});
}

TEST(ExteriorResult, ARoundWithoutMatchesHasNoRms) {
  const TemporaryFolder folder;
  ExteriorResult result = ExampleExterior();
  result.iterations = {{26, 0, 412.0, std::numeric_limits<double>::quiet_NaN()}};
  WriteExteriorResult(folder.Path(), result);
  EXPECT_TRUE(std::isnan(ReadExteriorResult(folder / "4711.exterior.json").iterations[0].rms_px));
}

struct Damage {
  std::string json_pointer;
  nlohmann::json value;
  std::string named;
};

class DamagedResult : public testing::TestWithParam<Damage> {};

TEST_P(DamagedResult, IsRefusedNamingFileAndField) {
  const TemporaryFolder folder;
  nlohmann::json json = Written(ExampleInterior());
  json[nlohmann::json::json_pointer(GetParam().json_pointer)] = GetParam().value;
  const std::string path = folder / "4711.interior.json";
  WriteFileAtomically(path, json.dump());
  ExpectError<InputError>([&] { ReadInteriorResult(path); }, {path, GetParam().named});
}

INSTANTIATE_TEST_SUITE_P(
    InteriorResult, DamagedResult,
    testing::Values(Damage{"/status", "fine", "status is \"fine\""},
                    Damage{"/scan/width", 9200.5, "scan.width"},
                    Damage{"/scan/width", 18446744073709551615u, "scan.width is out of range"},
                    Damage{"/scan/orientation", "r45", "scan.orientation"},
                    Damage{"/photo_from_pixel", {{1, 2, 3}}, "2 x 3"},
                    Damage{"/photo_from_pixel/1/2", "x", "photo_from_pixel[1][2]"},
                    Damage{"/photo_from_pixel", {{1, 2, 3}, {2, 4, 6}}, "singular"},
                    Damage{"/photo", "../4711", "photo is \"../4711\""},
                    Damage{"/photo", "", "photo"},
                    Damage{"/marks/0/pixel", {1, 2, 3}, "marks[0].pixel"},
                    Damage{"/marks", 7, "marks"},
                    Damage{"/findings/0/code", "fine", "findings[0].code is \"fine\""}));

TEST(InteriorResult, AListNestedAMillionDeepIsNoText) {
  constexpr std::size_t kDepth = 1000000;
  const TemporaryFolder folder;
  const std::string path = folder / "4711.interior.json";
  WriteFileAtomically(path,
                      "{\"photo\": " + std::string(kDepth, '[') + std::string(kDepth, ']') + "}");
  ExpectError<InputError>([&] { ReadInteriorResult(path); }, {path, "photo", "a list"});
}

TEST(InteriorResult, AKeyThatOccursTwiceIsRefused) {
  const TemporaryFolder folder;
  const std::string path = folder / "4711.interior.json";
  WriteFileAtomically(path, R"({"photo": "4711", "status": "ok", "photo": "4712"})");
  ExpectError<InputError>([&] { ReadInteriorResult(path); }, {path, "\"photo\" occurs twice"});
  WriteFileAtomically(path, R"({"photo": "4711", "scan": {"width": 1, "width": 2}})");
  ExpectError<InputError>([&] { ReadInteriorResult(path); }, {path, "\"width\" occurs twice"});
}

TEST(InteriorResult, OfAnotherPhotoThanItsFileSaysIsRefused) {
  const TemporaryFolder folder;
  const std::string path = folder / "4712.interior.json";
  WriteFileAtomically(path, R"({"photo": "4711", "status": "ok"})");
  ExpectError<InputError>([&] { ReadInteriorResult(path); },
                          {path, "4711", "do not rename result files"});
}

TEST(InteriorResult, MissingFieldsAndBrokenJsonAreNamed) {
  const TemporaryFolder folder;
  const std::string path = folder / "4711.interior.json";
  WriteFileAtomically(path, R"({"photo": "4711"})");
  ExpectError<InputError>([&] { ReadInteriorResult(path); }, {path, "status"});
  WriteFileAtomically(path, "{\"photo\": \"47");
  ExpectError<InputError>([&] { ReadInteriorResult(path); }, {path, "line 1"});
  WriteFileAtomically(path, "[1, 2]");
  ExpectError<InputError>([&] { ReadExteriorResult(path); }, {path, "must be an object"});
}

}  // namespace
}  // namespace orient
