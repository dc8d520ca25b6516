#include "core/files/adjustment_result.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

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
AdjustmentResult WithManyPoints() {
  constexpr int kMany = 5000;  // more than is written, or read, at a time
  AdjustmentResult result = ExampleAdjustment();
  for (int i = 0; i < kMany; ++i) {
    result.ties.push_back(result.ties[0]);
    result.ties.back().id = 1000 + i;
  }
  return result;
}

TEST(AdjustmentResult, IsTheDocumentThatItWouldBeAsAWhole) {
  const TemporaryFolder folder;
  for (const AdjustmentResult& result :
       {ExampleAdjustment(), AdjustmentResult(), WithManyPoints()}) {
    WriteAdjustmentResult(folder.Path(), result);
    const std::string text = ReadFile(folder / "block.json");
    const auto json = nlohmann::ordered_json::parse(text);
    EXPECT_EQ(text, json.dump(1) + "\n");
    std::vector<std::string> members;
    for (const auto& [name, value] : json.items()) members.push_back(name);
    EXPECT_EQ(members,
              (std::vector<std::string>{"converged", "sigma0", "redundancy", "variance_components",
                                        "parts", "calibration", "checks", "findings", "messages",
                                        "approximations", "gnss", "ties", "control"}));
    EXPECT_EQ(json["ties"].size(), result.ties.size());
    EXPECT_EQ(json["control"].size(), result.control.size());
  }
}

TEST(AdjustmentResult, OfManyPointsNoneIsLostOrChanged) {
  const TemporaryFolder folder;
  const AdjustmentResult written = WithManyPoints();
  WriteAdjustmentResult(folder.Path(), written);
  const AdjustmentResult read = ReadAdjustmentResult(folder / "block.json");
  ASSERT_EQ(read.ties.size(), written.ties.size());
  for (std::size_t i = 0; i < read.ties.size(); ++i) {
    EXPECT_EQ(read.ties[i].id, written.ties[i].id);
    EXPECT_EQ(read.ties[i].ground_m, written.ties[i].ground_m);
    ASSERT_EQ(read.ties[i].seen.size(), written.ties[i].seen.size());
    EXPECT_EQ(read.ties[i].seen[0].pixel, written.ties[i].seen[0].pixel);
  }
  const std::string text = ReadFile(folder / "block.json");
  WriteFileAtomically(folder / "again.json", text.substr(0, text.size() / 2));
  ExpectError<InputError>([&] { ReadAdjustmentResult(folder / "again.json"); },
                          {"again.json", "not valid JSON"});
  WriteAdjustmentResult(folder.Path(), read);
  EXPECT_EQ(ReadFile(folder / "block.json"), text);
}

TEST(AdjustmentResult, PointsMayStandBeforeTheRest) {
  const TemporaryFolder folder;
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  const auto json = nlohmann::ordered_json::parse(ReadFile(folder / "block.json"));
  nlohmann::ordered_json turned;
  for (const char* first : {"control", "ties"}) turned[first] = json[first];
  for (const auto& [name, value] : json.items()) turned[name] = value;
  WriteFileAtomically(folder / "turned.json", turned.dump());
  WriteAdjustmentResult(folder.Path(), ReadAdjustmentResult(folder / "turned.json"));
  EXPECT_EQ(nlohmann::ordered_json::parse(ReadFile(folder / "block.json")), json);
}

TEST(AdjustmentResult, WhatIsNoListOfPointsIsNamed) {
  const TemporaryFolder folder;
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  const auto json = nlohmann::json::parse(ReadFile(folder / "block.json"));
  const auto expect = [&](const std::string& ties, const std::string& complaint) {
    auto other = json;
    other["ties"] = nlohmann::json::parse(ties);
    WriteFileAtomically(folder / "other.json", other.dump());
    ExpectError<InputError>([&] { ReadAdjustmentResult(folder / "other.json"); },
                            {"other.json", complaint});
  };
  expect("5", "field ties must be a list");
  expect("{}", "field ties must be a list");
  expect(R"({"a": 5})", "field ties must be a list");
  expect(R"({"a": {"id": 1}})", "field ties must be a list");
  expect("[1, 2]", "ties[0] must be an object");
  expect("[[]]", "ties[0] must be an object");
  expect(R"([{"id": 1, "rays": 0, "seen": []}, {"id": 2}])", "ties[1] lacks");
  auto without = json;
  without.erase("control");
  WriteFileAtomically(folder / "other.json", without.dump());
  ExpectError<InputError>([&] { ReadAdjustmentResult(folder / "other.json"); },
                          {"other.json", "lacks \"control\""});
  std::string twice = json.dump();
  twice.insert(1, R"("ties": [],)");
  WriteFileAtomically(folder / "other.json", twice);
  ExpectError<InputError>([&] { ReadAdjustmentResult(folder / "other.json"); },
                          {"other.json", "\"ties\" occurs twice"});
}

// A parser that looked through a list after each of its objects would take minutes.
TEST(AdjustmentResult, LongListsThatNobodyAsksForAreReadInPassing) {
  const TemporaryFolder folder;
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  auto json = nlohmann::json::parse(ReadFile(folder / "block.json"));
  json["other"] = std::vector<nlohmann::json>(1'000'000, nlohmann::json::object());
  WriteFileAtomically(folder / "other.json", json.dump());
  EXPECT_EQ(ReadAdjustmentResult(folder / "other.json").ties.size(), 2u);
}

TEST(AdjustmentResult, ANameThatIsNoTextLeavesTheFileThatWasThere) {
  const TemporaryFolder folder;
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  const std::string before = ReadFile(folder / "block.json");
  AdjustmentResult result = ExampleAdjustment();
  result.ties[0].seen[0].photo = "\xff";
  EXPECT_ANY_THROW(WriteAdjustmentResult(folder.Path(), result));
  EXPECT_EQ(ReadFile(folder / "block.json"), before);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.Path()), {}), 1);
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
