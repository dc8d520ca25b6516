#include "tools/report/report_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/atomic_write.h"
#include "tests/support/shared_data.h"
#include "tests/tools/report/example_block.h"
#include "tests/tools/report/report_page.h"

namespace orient {
namespace {

TEST(ReportJson, TheSameFiguresForPrograms) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  const auto json = ReportJsonOf(folder.Path());
  EXPECT_EQ(json["ok"], 1);
  EXPECT_EQ(json["failed"], 1);
  EXPECT_NEAR(json["projection_sigma_median"]["px"].get<double>(), 0.42, 1e-12);
  EXPECT_TRUE(json["ground_ce90_m_median"].is_null()) << "no camera";
  EXPECT_TRUE(json["ties_le90_m_median"].is_null()) << "no block adjustment";
  EXPECT_TRUE(json["adjustment"].is_null());
  EXPECT_TRUE(json["orthophotos"].is_null());
  ASSERT_EQ(json["photos"].size(), 3u);
  EXPECT_EQ(json["photos"][0]["status"], "ok");
  EXPECT_EQ(json["photos"][0]["patches"]["matched"], 3);
  EXPECT_NEAR(json["photos"][0]["pose"]["sigma_x_m"].get<double>(), 0.4, 1e-12);
  EXPECT_TRUE(json["photos"][2]["pose"].is_null());
  EXPECT_EQ(json["moved_from_approximations"], nlohmann::json::parse(R"({"photos": 2,
      "mean_m": [12.5, -4.0, -1.0], "rms_about_mean_m": [0.0, 0.0, 1.0]})"));
  EXPECT_EQ(json["look_at_first"][0]["photo"], "4713");
}

TEST(ReportJson, SaysTheCe90OfEachPhotoAndOfTheBlock) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  WriteExampleCamera(folder.Path());
  const auto json = ReportJsonOf(folder.Path());
  const double median_m = json["photos"][0]["ground_ce90_m"];
  EXPECT_GT(json["photos"][0]["ground_ce90_m_at_worst"].get<double>(), median_m);
  EXPECT_EQ(json["ground_ce90_m_median"].get<double>(), median_m) << "both photos are alike";
  EXPECT_TRUE(json["photos"][2]["ground_ce90_m"].is_null()) << "it failed";
}

TEST(ReportJson, SaysWhatTheAdjustmentSays) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  const auto adjustment = ReportJsonOf(folder.Path())["adjustment"];
  EXPECT_EQ(adjustment["converged"], true);
  EXPECT_EQ(adjustment["degrees_of_freedom"], 41.0);
  EXPECT_NEAR(adjustment["groups"][0]["sigma_over_stated"].get<double>(), 1.2, 1e-12);
  EXPECT_TRUE(adjustment["groups"][1]["sigma_px"].is_null()) << "nothing measured in a photo";
  EXPECT_EQ(adjustment["photos"][1]["ties"], nlohmann::json::parse(R"({"used": 1, "all": 2})"));
  EXPECT_EQ(adjustment["photo_of_largest_w"], "4711");
  EXPECT_NEAR(adjustment["checks"]["rms_px"].get<double>(), 0.5, 1e-12);
  const auto checks = adjustment["checks"]["on_the_ground"];
  EXPECT_EQ(checks["points"], 1);
  EXPECT_NEAR(checks["ce90_m"].get<double>(), 2.146 * 0.35, 1e-9);
  EXPECT_NEAR(checks["le90_m"].get<double>(), 1.6449 * 0.8, 1e-9);
  EXPECT_NEAR(adjustment["control"]["on_the_ground"]["rmse_m"][2].get<double>(), 0.2, 1e-12);
  EXPECT_TRUE(adjustment["gnss"].is_null());
  EXPECT_EQ(adjustment["parts"].size(), 2u);
  EXPECT_EQ(adjustment["calibration"][0]["parameter"], "k1");
}

TEST(ReportJson, SaysHowTheFilmLiesAndHowPhotosOverlap) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  const auto json = ReportJsonOf(folder.Path());
  ASSERT_EQ(json["film"].size(), 1u);
  EXPECT_EQ(json["film"][0]["photos"], 3);
  EXPECT_EQ(json["film"][0]["marks"]["used"], 3);
  EXPECT_NEAR(json["film"][0]["pixel_along_columns_um"]["mean"].get<double>(), 25, 1e-9);
  EXPECT_EQ(json["overlap"]["seen_by"][1]["share_of_ground"], 1.0) << "two photos of one place";
}

}  // namespace
}  // namespace orient
