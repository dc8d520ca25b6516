#include "core/files/adjustment_result.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/example_adjustment.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

TEST(AdjustmentResult, ComesBackAsItWasWritten) {
  const TemporaryFolder folder;
  const AdjustmentResult written = ExampleAdjustment();
  WriteAdjustmentResult(folder.Path(), written);
  const AdjustmentResult read = ReadAdjustmentResult(AdjustmentResultPath(folder.Path()));
  EXPECT_TRUE(read.converged);
  EXPECT_EQ(read.sigma0, written.sigma0);
  ASSERT_EQ(read.components.size(), 2u);
  EXPECT_EQ(read.components[0].factor, 1.44);
  EXPECT_FALSE(read.parts[0].finding);
  EXPECT_EQ(read.parts[1].finding, written.parts[1].finding);
  EXPECT_EQ(read.calibration[0].sigma, 4e-9);
  EXPECT_EQ(read.findings, written.findings);
  ASSERT_EQ(read.ties.size(), 2u);
  EXPECT_FALSE(read.ties[0].control);
  EXPECT_EQ(read.ties[1].seen[1].state, "rejected");
  EXPECT_EQ(read.ties[1].seen[1].residual_px, Eigen::Vector2d(0, -0.4));
  EXPECT_EQ(read.ties[0].sigma_m, written.ties[0].sigma_m);
  ASSERT_TRUE(read.control[0].control);
  EXPECT_EQ(read.control[0].control->given_m, written.control[0].control->given_m);
  EXPECT_FALSE(read.control[0].ground_m);
  EXPECT_FALSE(read.control[0].seen[0].redundancy);
}

TEST(AdjustmentResult, KeepsWhatWasKnownOfPosesAndReadsFilesWithout) {
  const TemporaryFolder folder;
  AdjustmentResult written = ExampleAdjustment();
  written.approximations = {{"a", "used", std::nullopt, 1.5}};
  written.gnss = {{"a", "rejected", Eigen::Vector3d(1, 2, -3), 40}};
  written.gnss_strips = {
      {"05", Eigen::Vector3d(4, 5, 6), Eigen::Vector3d(0.1, 0.1, 0.2), std::nullopt, std::nullopt}};
  WriteAdjustmentResult(folder.Path(), written);
  const AdjustmentResult read = ReadAdjustmentResult(AdjustmentResultPath(folder.Path()));
  ASSERT_EQ(read.approximations.size(), 1u);
  EXPECT_EQ(read.approximations[0].w, 1.5);
  EXPECT_FALSE(read.approximations[0].residual_m);
  ASSERT_EQ(read.gnss.size(), 1u);
  EXPECT_EQ(read.gnss[0].state, "rejected");
  EXPECT_EQ(read.gnss[0].residual_m, Eigen::Vector3d(1, 2, -3));
  ASSERT_EQ(read.gnss_strips.size(), 1u);
  EXPECT_EQ(read.gnss_strips[0].shift_m, Eigen::Vector3d(4, 5, 6));
  EXPECT_FALSE(read.gnss_strips[0].drift_m);
  std::string text = ReadFile(folder / "block.json");
  text.replace(text.find("\"gnss\""), 6, "\"else\"");
  text.replace(text.find("\"approximations\""), 16, "\"something else\"");
  WriteFileAtomically(folder / "block.json", text);
  EXPECT_TRUE(ReadAdjustmentResult(folder / "block.json").gnss.empty());
}

TEST(AdjustmentResult, HasSentencesBesideItsCodes) {
  const TemporaryFolder folder;
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  const auto json = nlohmann::json::parse(ReadFile(folder / "block.json"));
  EXPECT_EQ(json["findings"], nlohmann::json::parse(R"([{"code": "gnss_rejected",
      "at_best": "ok", "value": 1.0, "where": "<4713>"}])"));
  EXPECT_EQ(json["messages"],
            nlohmann::json::parse(R"(["GNSS contradicts the block and is not used: <4713>."])"));
  EXPECT_EQ(json["parts"][0]["message"], "");
  EXPECT_EQ(json["parts"][1]["finding"]["code"], "part_without_control");
  EXPECT_EQ(json["parts"][1]["message"], Sentence(*ExampleAdjustment().parts[1].finding));
}

TEST(AdjustmentResult, OfAnEarlierVersionTheMessagesStand) {
  const TemporaryFolder folder;
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  auto json = nlohmann::json::parse(ReadFile(folder / "block.json"));
  json.erase("findings");
  for (auto& part : json["parts"]) part.erase("finding");
  WriteFileAtomically(folder / "block.json", json.dump());
  const AdjustmentResult read = ReadAdjustmentResult(folder / "block.json");
  ASSERT_EQ(read.findings.size(), 1u);
  EXPECT_EQ(read.findings[0].reason, Reason::kStated);
  EXPECT_EQ(Sentences(read.findings), Sentences(ExampleAdjustment().findings));
  EXPECT_FALSE(read.parts[0].finding);
  EXPECT_EQ(Sentence(read.parts[1].finding.value()), json["parts"][1]["message"]);
}

TEST(AdjustmentResult, ChecksHaveTheRmsOfTheirVectors) {
  EXPECT_NEAR(ExampleAdjustment().CheckRmsPx().value(), 0.5, 1e-12);
  EXPECT_FALSE(AdjustmentResult().CheckRmsPx());
}

TEST(AdjustmentResult, WhatIsNoNumberIsNull) {
  const TemporaryFolder folder;
  AdjustmentResult result;
  result.sigma0 = std::numeric_limits<double>::quiet_NaN();
  WriteAdjustmentResult(folder.Path(), result);
  EXPECT_FALSE(ReadAdjustmentResult(AdjustmentResultPath(folder.Path())).sigma0);
}

// Points are written one by one, and read so.
TEST(AdjustmentResult, IsTheDocumentThatItWouldBeAsAWhole) {
  const TemporaryFolder folder;
  for (const AdjustmentResult& result : {ExampleAdjustment(), AdjustmentResult()}) {
    WriteAdjustmentResult(folder.Path(), result);
    const std::string text = ReadFile(folder / "block.json");
    EXPECT_EQ(text, nlohmann::ordered_json::parse(text).dump(1) + "\n");
    EXPECT_EQ(ReadAdjustmentResult(folder / "block.json").ties.size(), result.ties.size());
  }
}

TEST(AdjustmentResult, WhatIsNoListOfPointsIsNamed) {
  const TemporaryFolder folder;
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  const auto expect = [&](const nlohmann::json& ties, const std::string& complaint) {
    auto json = nlohmann::json::parse(ReadFile(folder / "block.json"));
    json["ties"] = ties;
    WriteFileAtomically(folder / "other.json", json.dump());
    ExpectError<InputError>([&] { ReadAdjustmentResult(folder / "other.json"); },
                            {"other.json", "ties", complaint});
  };
  expect(5, "must be a list");
  expect(nlohmann::json::object(), "must be a list");
  expect({1, 2}, "ties[0] must be an object");
  expect(nlohmann::json::array({nlohmann::json::array()}), "ties[0] must be an object");
  auto json = nlohmann::json::parse(ReadFile(folder / "block.json"));
  json.erase("control");
  WriteFileAtomically(folder / "other.json", json.dump());
  ExpectError<InputError>([&] { ReadAdjustmentResult(folder / "other.json"); },
                          {"other.json", "lacks \"control\""});
}

TEST(AdjustmentResult, AFieldOfTheWrongTypeIsNamed) {
  const TemporaryFolder folder;
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  std::string text = ReadFile(folder / "block.json");
  text.replace(text.rfind("\"rays\": "), 9, "\"rays\": []");
  WriteFileAtomically(folder / "block.json", text);
  ExpectError<InputError>([&] { ReadAdjustmentResult(folder / "block.json"); },
                          {"block.json", "control[0].rays"});
}

}  // namespace
}  // namespace orient
