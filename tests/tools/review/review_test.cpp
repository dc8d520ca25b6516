#include "tools/review/review.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/base/error.h"
#include "core/files/results.h"
#include "core/raster/raster.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

InteriorResult Interior(const std::string& photo, Status status) {
  InteriorResult result;
  result.photo = photo;
  result.status = status;
  result.width = 300;
  result.height = 200;
  result.made_from = {{"camera", "c"}, {"scan", "s"}};
  if (status == Status::kFailed) {
    result.findings = {{.reason = Reason::kMarksNotFound, .at_best = Status::kFailed, .value = 0}};
    return result;
  }
  result.photo_from_pixel = Affine2d{Eigen::Vector2d(0.1, -0.1).asDiagonal(), {-15, 10}};
  result.marks = {{"1", MarkState::kUsed, Eigen::Vector2d(12, 20), std::nullopt,
                   Eigen::Vector2d(50, 100), 0.9}};
  if (status == Status::kWeak)
    result.findings = {{.reason = Reason::kStated, .at_best = Status::kWeak, .where = "<i>x</i>"}};
  return result;
}

class ReviewTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directory(Out());
    WriteInteriorResult(Out(), Interior("a", Status::kOk));
    WriteInteriorResult(Out(), Interior("b<b>", Status::kWeak));
    WriteInteriorResult(Out(), Interior("c", Status::kFailed));
    WritePng(folder_ / "a.png", 300, 200, 1, std::vector<unsigned char>(60000, 77));
  }
  std::string Out() const { return folder_ / "out"; }
  ReviewOptions Options() const {
    return {Out(), {folder_ / "a.png"}, folder_ / "said", "J", "", "", "", {}, {}};
  }
  // With one of three marks, "1" to "3".
  ReviewOptions OptionsWithCamera() const {
    CameraFile camera;
    camera.camera.name = "small";
    camera.camera.principal_distance_mm = 20;
    camera.camera.frame_mm = {20, 10};
    camera.fiducials = {
        {"1", {-10, 5}, "dot", {}}, {"2", {10, 5}, "dot", {}}, {"3", {10, -5}, "dot", {}}};
    camera.marks["dot"].elements = {DotElement{.diameter_mm = 0.5}};
    WriteCameraFile(folder_ / "camera.toml", camera);
    ReviewOptions options = Options();
    options.camera = folder_ / "camera.toml";
    return options;
  }
  static Json Read(const Reply& reply) { return Json::parse(*reply.body); }
  static Json List(Review* review) { return Read(review->Get({"api", "list"}, {})); }
  static Reply Say(Review* review, Json entry) {
    entry["version"] = List(review).at("version");
    return review->Post({"api", "say"}, entry.dump());
  }
  static Json Decision(const char* photo, const char* decision) {
    return {{"about", decision},
            {"decisions",
             {{{"photo", photo}, {"decision", decision}, {"value", ""}, {"reason", "seen"}}}}};
  }

  TemporaryFolder folder_;
};

TEST_F(ReviewTest, ListsThePhotosToLookAtFirst) {
  Review review(Options());
  const Json list = List(&review);
  ASSERT_EQ(list.at("photos").size(), 3u);
  EXPECT_EQ(list.at("photos")[0].at("name"), "c");
  EXPECT_EQ(list.at("photos")[0].at("codes"), Json({"marks_not_found"}));
  EXPECT_EQ(list.at("photos")[1].at("name"), "b<b>");
  EXPECT_EQ(list.at("photos")[2].at("name"), "a");
  EXPECT_EQ(list.at("photos")[2].at("scan"), true);
  EXPECT_EQ(list.at("photos")[0].at("scan"), false);
}

TEST_F(ReviewTest, ShowsAPhotoWithItsMarks) {
  Review review(Options());
  const Json photo = Read(review.Get({"api", "photo", "a"}, {}));
  EXPECT_EQ(photo.at("scan").at("width"), 300);
  const Json& mark = photo.at("interior").at("marks").at(0);
  EXPECT_EQ(mark.at("pixel"), Json({12.0, 20.0}));
  EXPECT_NEAR(mark.at("residual_px").at(0).get<double>(), 0.5, 1e-9);
  EXPECT_NEAR(mark.at("residual_px").at(1).get<double>(), -1.0, 1e-9);
  const Json other = Read(review.Get({"api", "photo", "c"}, {}));
  EXPECT_TRUE(other.at("scan").is_null());
  EXPECT_NE(other.at("why_no_scan"), "");
  EXPECT_EQ(review.Get({"api", "photo", "d"}, {}).status, 404);
}

TEST_F(ReviewTest, TellsWhereMarksAndFrameAreExpected) {
  Review review(OptionsWithCamera());
  const Json interior = Read(review.Get({"api", "photo", "a"}, {})).at("interior");
  EXPECT_EQ(interior.at("expected").at(1).at("id"), "2");
  EXPECT_NEAR(interior.at("expected").at(1).at("pixel").at(0).get<double>(), 250, 1e-9);
  EXPECT_NEAR(interior.at("expected").at(1).at("pixel").at(1).get<double>(), 50, 1e-9);
  EXPECT_NEAR(interior.at("frame").at(0).at(0).get<double>(), 50, 1e-9);
  EXPECT_NEAR(interior.at("frame").at(0).at(1).get<double>(), 150, 1e-9);
  EXPECT_TRUE(Read(review.Get({"api", "photo", "c"}, {})).at("interior").at("frame").empty())
      << "it has no transform";
}

TEST_F(ReviewTest, AMarkThatTheCameraDoesNotHaveIsRefused) {
  Review review(OptionsWithCamera());
  const auto say = [&](const char* mark) {
    return Say(&review, {{"about", "a mark"},
                         {"marks",
                          {{{"photo", "a"},
                            {"mark", mark},
                            {"pixel", {12, 20}},
                            {"sigma", 1},
                            {"exact", false}}}}});
  };
  const Reply refused = say("9");
  EXPECT_EQ(refused.status, 422);
  EXPECT_NE(refused.body->find("its marks are 1, 2, 3"), std::string::npos) << *refused.body;
  EXPECT_EQ(say("2").status, 200);
}

TEST_F(ReviewTest, TwoReviewsOfOneFolderAreRefusedWhereverTheyWrite) {
  const Review one(Options());
  ReviewOptions other = Options();
  other.measurements = folder_ / "said elsewhere";
  ExpectError<InputError>([&] { const Review two(other); }, {Out(), "another orient"});
}

TEST_F(ReviewTest, ServesThePageAndNothingElse) {
  Review review(Options());
  for (const char* file : {"", "review.js", "leaflet.js", "leaflet.css"})
    EXPECT_EQ(review.Get({file}, {}).status, 200) << file;
  EXPECT_EQ(review.Get({"images", "layers.png"}, {}).status, 200);
  for (const WebPath& path : {WebPath{"passwd"},
                              {"..", "passwd"},
                              {"images", "..", "leaflet.js"},
                              {"api"},
                              {"api", "x"},
                              {"tile", "a", "0", "0"},
                              {"ground", "ortho", "0", "0", "0"}})
    EXPECT_EQ(review.Get(path, {}).status, 404);
  EXPECT_EQ(review.Get({"tile", "a", "0", "0", "0"}, {}).status, 200);
  EXPECT_EQ(review.Get({"tile", "a", "0", "0", "x"}, {}).status, 400);
  EXPECT_EQ(review.Get({"tile", "a", "0", "9", "9"}, {}).status, 404);
  EXPECT_EQ(review.Post({"api", "list"}, "{}").status, 404);
}

TEST_F(ReviewTest, WritesWhatIsSaidWithNameAndDate) {
  Review review(Options());
  ASSERT_EQ(Say(&review, Decision("b<b>", "accept")).status, 200);
  const Measurements measurements = ReadMeasurements(folder_ / "said");
  ASSERT_EQ(measurements.decisions.size(), 1u);
  EXPECT_EQ(measurements.decisions[0].photo, "b<b>");
  EXPECT_EQ(measurements.decisions[0].attribution.by, "J");
  EXPECT_EQ(measurements.decisions[0].attribution.when.size(),
            std::string("2024-05-01T10:00:00Z").size());
  EXPECT_EQ(List(&review).at("photos")[1].at("decisions")[0].at("decision"), "accept");
  EXPECT_EQ(List(&review).at("undo"), "accept");
  const Json undo = {{"version", List(&review).at("version")}};
  ASSERT_EQ(review.Post({"api", "undo"}, undo.dump()).status, 200);
  EXPECT_TRUE(List(&review).at("photos")[1].at("decisions").empty());
  EXPECT_EQ(
      review.Post({"api", "undo"}, Json({{"version", List(&review).at("version")}}).dump()).status,
      409);
}

TEST_F(ReviewTest, APhotoIsPendingUntilItsResultWasMadeFromTheWord) {
  Review review(Options());
  EXPECT_EQ(List(&review).at("photos")[1].at("pending"), false);
  Say(&review, Decision("b<b>", "accept"));
  EXPECT_EQ(List(&review).at("photos")[1].at("pending"), true);
  EXPECT_EQ(List(&review).at("photos")[2].at("pending"), false);
}

TEST_F(ReviewTest, RefusesWhatCannotBe) {
  Review review(Options());
  const Reply failed = Say(&review, Decision("c", "accept"));
  EXPECT_EQ(failed.status, 422);
  EXPECT_NE(Read(failed).at("error").get<std::string>().find("nothing to accept"),
            std::string::npos);
  EXPECT_EQ(Say(&review, Decision("nobody", "reject")).status, 422);
  EXPECT_EQ(review.Post({"api", "say"}, "no JSON").status, 422);
  Json stale = Decision("c", "reject");
  stale["version"] = "0";
  EXPECT_EQ(review.Post({"api", "say"}, stale.dump()).status, 409);
  EXPECT_FALSE(fs::exists(folder_ / "said/decisions.csv"));
}

TEST_F(ReviewTest, OrientsAgainWhereThatIsOffered) {
  EXPECT_EQ(Review(Options()).Post({"api", "again"}, "{}").status, 422);
  ReviewOptions options = Options();
  options.run_again = [&](ProgressListener*) {
    WriteInteriorResult(Out(), Interior("c", Status::kOk));
  };
  Review review(options);
  EXPECT_EQ(List(&review).at("photos")[0].at("status"), "failed");
  ASSERT_EQ(review.Post({"api", "again"}, "{}").status, 200);
  for (int i = 0; Read(review.Get({"api", "progress"}, {})).at("running") == true && i < 5000; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(Read(review.Get({"api", "progress"}, {})).at("error"), "");
  for (const Json& photo : List(&review).at("photos")) EXPECT_NE(photo.at("status"), "failed");
}

TEST_F(ReviewTest, BeginsOnlyWithResultsAndScansOfDifferentNames) {
  ReviewOptions options = Options();
  options.scans = {folder_ / "a.png", folder_ / "x/a.tif"};
  ExpectError<UsageError>([&] { Review review(options); }, {"a.png", "a.tif"});
  options = Options();
  options.directory = folder_ / "nothing";
  ExpectError<InputError>([&] { Review review(options); }, {"nothing"});
  options = Options();
  options.ortho = folder_ / "a.png";
  ExpectError<InputError>([&] { Review review(options); }, {"a.png", "north up"});
}

}  // namespace
}  // namespace orient
