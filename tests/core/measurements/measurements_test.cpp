#include "core/measurements/measurements.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

class MeasurementFiles : public testing::Test {
 protected:
  void Write(const std::string& file, const std::string& text) const {
    std::ofstream(folder_ / file) << text;
  }
  Measurements Read() const { return ReadMeasurements(folder_.Path()); }
  void ExpectRefused(const std::string& file, const std::string& text,
                     std::initializer_list<std::string> parts) const {
    Write(file, text);
    ExpectError<InputError>([&] { Read(); }, parts);
  }

  TemporaryFolder folder_;
};

TEST_F(MeasurementFiles, AreReadAsTheyWereWritten) {
  const std::vector<MarkMeasurement> marks = {
      {"a,1", "3", {12.25, 80.5}, 0.5, false, {"J. Smith", "2024-05-01"}},
      {"b", "=cmd", {1, 2}, 1, true, {}}};
  WriteMarks(folder_.Path(), marks);
  WriteImagePoints(folder_.Path(),
                   {{"b", "p1", Eigen::Vector2d(3, 4), std::nullopt, 0.25, {"J", ""}}});
  WritePoints(folder_.Path(),
              {{"p1", {500000, 5e6, 12.5}, {1, 1, 2}, PointRole::kCheck, {"K, L", "2024"}}});
  WriteDecisions(folder_.Path(), {{"b", DecisionKind::kOrientation, "r90", "see strip", {}}});
  const Measurements read = Read();
  ASSERT_EQ(read.marks.size(), 2u);
  EXPECT_EQ(read.marks[0].photo, "a,1");
  EXPECT_EQ(read.marks[0].pixel, marks[0].pixel);
  EXPECT_EQ(read.marks[0].attribution.by, "J. Smith");
  EXPECT_FALSE(read.marks[0].exact);
  EXPECT_EQ(read.marks[1].mark, "=cmd");
  EXPECT_TRUE(read.marks[1].exact);
  ASSERT_EQ(read.image_points.size(), 1u);
  EXPECT_EQ(*read.image_points[0].pixel, Eigen::Vector2d(3, 4));
  EXPECT_EQ(read.image_points[0].attribution.by, "J");
  ASSERT_NE(read.Point("p1"), nullptr);
  EXPECT_EQ(read.Point("p1")->role, PointRole::kCheck);
  EXPECT_EQ(read.Point("p1")->attribution.by, "K, L");
  EXPECT_EQ(read.Point("p2"), nullptr);
  EXPECT_EQ(read.OrientationOf("b"), ScanOrientation::kR90);
  EXPECT_FALSE(read.OrientationOf("a,1"));
}

TEST_F(MeasurementFiles, PointsOfThePhotoSystemAreToldFromPixels) {
  WriteImagePoints(folder_.Path(), {{"b", "p", std::nullopt, Eigen::Vector2d(-3, 4), 0.005}});
  const Measurements read = Read();
  EXPECT_FALSE(read.image_points[0].pixel);
  EXPECT_EQ(*read.image_points[0].photo_mm, Eigen::Vector2d(-3, 4));
  EXPECT_EQ(read.image_points[0].sigma, 0.005);
}

TEST_F(MeasurementFiles, AFolderWithoutAnyOfThemIsAnError) {
  ExpectError<InputError>([&] { Read(); }, {folder_.Path(), "marks.csv", "decisions.csv"});
}

TEST_F(MeasurementFiles, WrongTablesAreRefusedWithFileAndLine) {
  ExpectRefused("marks.csv", "photo,mark,col,row\n", {"marks.csv, line 1", "\"sigma\""});
  ExpectRefused("marks.csv", "photo,mark,col,row,sigma,colour\n", {"\"colour\"", "by,when"});
  ExpectRefused("marks.csv", "photo,mark,col,row,sigma\na,1,2,x,1\n",
                {"line 2, column 7", "row is \"x\""});
  for (const std::string sigma : {"0", "1e300", "1e-300"})
    ExpectRefused("marks.csv", "photo,mark,col,row,sigma\na,1,2,3," + sigma + "\n",
                  {"marks.csv, line 2", sigma, "must lie between 1e-09 and 1000000"});
  ExpectRefused("marks.csv", "photo,mark,col,row,sigma\n,1,2,3,1\n", {"photo has no name"});
  ExpectRefused("marks.csv", "photo,mark,col,row,sigma\na,1,2,3,1\na,1,2,4,1\n",
                {"line 3", "mark 1 of photo a is measured a second time"});
  ExpectRefused("marks.csv", "photo,mark,col,row,sigma,exact\na,1,2,3,1,maybe\n",
                {"exact is \"maybe\""});
  ExpectRefused("marks.csv", "photo,mark,col,row,sigma\na,1,2,3\n", {"4 cells", "header 5"});
}

TEST_F(MeasurementFiles, ImagePointsAreEitherInPixelsOrInMillimetres) {
  ExpectRefused("image_points.csv", "photo,point,sigma\n", {"line 1", "col,row", "x_mm,y_mm"});
  ExpectRefused("image_points.csv", "photo,point,col,row,x_mm,y_mm,sigma\n", {"col,row"});
  ExpectRefused("image_points.csv", "photo,point,col,y_mm,sigma\n", {"col,row"});
}

TEST_F(MeasurementFiles, WrongDecisionsAreRefused) {
  const std::string header = "photo,decision,value,reason\n";
  ExpectRefused("decisions.csv", header + "a,like,,\n", {"\"like\"", "accept, reject"});
  ExpectRefused("decisions.csv", header + "a,orientation,r45,\n", {"\"r45\"", "m270"});
  ExpectRefused("decisions.csv", header + "a,polarity,dark,\n", {"positive or negative"});
  ExpectRefused("decisions.csv", header + "a,pixel_size,0.5,\n", {"between 1 and 1000"});
  ExpectRefused("decisions.csv", header + "a,accept,yes,\n", {"leave it empty"});
  ExpectRefused("decisions.csv", header + "a,accept,,\na,reject,,\n", {"line 3", "second time"});
  ExpectRefused("points.csv", "point,x,y,z,sigma_x,sigma_y,sigma_z,role\np,1,2,3,1,1,1,tie\n",
                {"role is \"tie\""});
}

TEST_F(MeasurementFiles, TextsChangeWithWhatIsSaidAndNotWithWhoSaysIt) {
  Measurements measurements;
  measurements.marks = {{"a", "1", {1, 2}, 1, false, {"x", "y"}}};
  const std::string text = TextOfMarks(measurements, "a");
  EXPECT_FALSE(text.empty());
  EXPECT_TRUE(TextOfMarks(measurements, "b").empty());
  measurements.marks[0].attribution = {"z", ""};
  EXPECT_EQ(TextOfMarks(measurements, "a"), text);
  measurements.marks[0].pixel.x() += 1;
  EXPECT_NE(TextOfMarks(measurements, "a"), text);
  measurements.marks[0].pixel.x() = 23456.71;
  const std::string far = TextOfMarks(measurements, "a");
  measurements.marks[0].pixel.x() += 0.01;
  EXPECT_NE(TextOfMarks(measurements, "a"), far) << "a hundredth of a pixel, far from the corner";
  measurements.image_points = {{"a", "p", Eigen::Vector2d(1, 1), std::nullopt, 1}};
  EXPECT_TRUE(TextOfPoints(measurements, "a").empty()) << "a tie does not start a photo";
  measurements.points = {{"p", {1, 2, 3}, {1, 1, 1}, PointRole::kControl}};
  const std::string points = TextOfPoints(measurements, "a");
  measurements.points[0].ground_m.z() += 1;
  EXPECT_NE(TextOfPoints(measurements, "a"), points);
}

}  // namespace
}  // namespace orient
