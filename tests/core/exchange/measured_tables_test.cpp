#include "core/exchange/measured_tables.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.h"
#include "tests/core/exchange/texts.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

class MeasuredTables : public testing::Test {
 protected:
  void Read(const std::string& text, const MeasuredSigma& sigma = {}) {
    all_ = {};
    std::ofstream(folder_ / "table.csv") << text;
    AddMeasuredTable(folder_ / "table.csv", sigma, &all_);
  }
  void ExpectRefused(const std::string& text, std::initializer_list<std::string> parts) {
    ExpectError<InputError>([&] { Read(text); }, parts);
  }
  // Photo, point, place and sigma of the only image point.
  std::string OnlyImagePoint() const {
    if (all_.All().image_points.size() != 1) return "not one image point";
    const ImagePointMeasurement& seen = all_.All().image_points[0];
    const Eigen::Vector2d at = seen.pixel ? *seen.pixel : *seen.photo_mm;
    std::ostringstream text;
    text << seen.photo << " " << seen.point << " " << at.x() << " " << at.y()
         << (seen.pixel ? " px " : " mm ") << seen.sigma;
    return text.str();
  }
  std::string Notes() const { return NotesOf(all_); }

  TemporaryFolder folder_;
  GatheredMeasurements all_;
};

TEST_F(MeasuredTables, ImagePointsMayBeCalledAsOtherProgramsCallThem) {
  for (const char* header :
       {"photo,point,col,row,sigma", "Image,Marker,px,py,accuracy", "filename,gcp,u,v,sigma",
        "name,id,x,y,accuracy", "Image Name,Point ID,X [px],Y [px],Sigma [px]",
        "label,point,pixel x,pixel y,std", "#photo,point,col,row,sigma"}) {
    Read(std::string(header) + "\nscans/0182.v2.tif,p1,100.25,200.5,0.5\n");
    EXPECT_EQ(OnlyImagePoint(), "0182.v2 p1 100.25 200.5 px 0.5") << header;
    EXPECT_TRUE(all_.Notes().empty()) << header << Notes();
  }
}

TEST_F(MeasuredTables, MillimetresOfThePhotoSystemAreToldFromPixels) {
  Read("photo,point,x_mm,y_mm,sigma\n4711,p1,-10.5,20,0.005\n");
  EXPECT_EQ(OnlyImagePoint(), "4711 p1 -10.5 20 mm 0.005");
  Read("photo,point,x [mm],y [mm]\n4711,p1,-10.5,20\n");
  EXPECT_EQ(OnlyImagePoint(), "4711 p1 -10.5 20 mm 0.01");
}

TEST_F(MeasuredTables, WhatIsNoPixelOfAScanIsNotTakenForOne) {
  ExpectRefused("photo,point,x,y\n4711,p1,-50.1,20.3\n", {"line 2", "x_mm, y_mm"});
  ExpectRefused("id,name,x,y\n1,p1,500000,5000000\n", {"line 2", "add z"});
  ExpectRefused("id,name,easting,northing\n1,p1,500000,5000000\n", {"line 2", "add z"});
}

TEST_F(MeasuredTables, AnAccuracysUnitIsTheOneInItsName) {
  ExpectRefused("photo,point,col,row,sigma_mm\n4711,p1,10,20,0.01\n", {"are in mm"});
  ExpectRefused("point,x,y,z,accuracy_mm\np1,500000,5000000,100,5\n", {"are in mm"});
  Read("photo,point,x_mm,y_mm,sigma_mm\n4711,p1,-10.5,20,0.005\n");
  EXPECT_EQ(OnlyImagePoint(), "4711 p1 -10.5 20 mm 0.005");
  Read("photo,point,col,row,x,y,z,sigma_m\n4711,p1,10,20,500000,5000000,100,0.25\n");
  EXPECT_EQ(OnlyImagePoint(), "4711 p1 10 20 px 1");
  EXPECT_EQ(all_.All().points.at(0).sigma_m, Eigen::Vector3d(0.25, 0.25, 0.25));
}

TEST_F(MeasuredTables, AMarkerThatIsNotEnabledIsACheckPointAndAVoidIsNoHeight) {
  Read("point,x,y,z,enabled\np1,500000,5000000,100,0\np2,500000,5000000,100,1\n");
  ASSERT_EQ(all_.All().points.size(), 2u);
  EXPECT_EQ(all_.All().points[0].role, PointRole::kCheck);
  EXPECT_EQ(all_.All().points[1].role, PointRole::kControl);
  for (const char* no : {"no", "No", "FALSE"}) {
    Read(std::string("point,x,y,z,enabled\np1,500000,5000000,100,") + no + "\n");
    EXPECT_EQ(all_.All().points.at(0).role, PointRole::kCheck) << no;
  }
  Read("point,x,y,z,enabled\np1,500000,5000000,100,yes\np2,500000,5000000,100,\n");
  EXPECT_EQ(all_.All().points.at(0).role, PointRole::kControl);
  EXPECT_EQ(all_.All().points.at(1).role, PointRole::kControl);
  ExpectRefused("point,x,y,z,enabled\np1,500000,5000000,100,off\n",
                {"line 2", "\"off\"", "yes or no"});
  ExpectRefused("point,x,y,z\np1,500000,5000000,-32767\n", {"line 2", "no ground"});
}

TEST_F(MeasuredTables, SemicolonsAndTabsAllowDecimalCommas) {
  Read("photo;point;col;row;sigma\n4711;p1;100,25;200,5;0,5\n");
  EXPECT_EQ(OnlyImagePoint(), "4711 p1 100.25 200.5 px 0.5");
  Read("photo\tpoint\tcol\trow\tsigma\n4711\tp1\t100,25\t200\t0,5\n");
  EXPECT_EQ(OnlyImagePoint(), "4711 p1 100.25 200 px 0.5");
  Read("photo;point;col;row;sigma\n4711;p1;100.25;200.5;0.5\n");
  EXPECT_EQ(OnlyImagePoint(), "4711 p1 100.25 200.5 px 0.5");
}

TEST_F(MeasuredTables, MixedDecimalMarksAndThousandsAreRefused) {
  const std::string header = "photo;point;col;row;sigma\n";
  ExpectRefused(header + "4711;p1;100,25;200.5;0.5\n", {"line 2, column 16", "200.5", "comma"});
  ExpectRefused(header + "4711;p1;1.100,25;200;1\n", {"line 2", "1.100,25", "thousands"});
  ExpectRefused("photo,point,col,row\n4711,p1,100,25,200\n", {"line 2", "5 cells", "header 4"});
}

TEST_F(MeasuredTables, AMissingAccuracyIsTakenAsSaidAndNoted) {
  Read("photo,point,col,row\na,p,1,2\n");
  EXPECT_EQ(OnlyImagePoint(), "a p 1 2 px 1");
  EXPECT_NE(Notes().find("one sigma of 1 px (--sigma): 1"), std::string::npos) << Notes();
  Read("photo,point,col,row,sigma\na,p,1,2,\n", {.image = 0.3});
  EXPECT_EQ(OnlyImagePoint(), "a p 1 2 px 0.3");
  for (const std::string sigma : {"0", "1e300", "1e-300"})
    ExpectRefused("photo,point,col,row,sigma\na,p,1,2," + sigma + "\n",
                  {"line 2, column 9", sigma, "must lie between 1e-09 and 1000000"});
  Read("point,x,y,z\np,500000,5000000,3\n", {.ground_m = 0.2});
  EXPECT_EQ(all_.All().points[0].sigma_m, Eigen::Vector3d(0.2, 0.2, 0.2));
  EXPECT_NE(Notes().find("one sigma of 0.2 m (--ground-sigma-m): 1"), std::string::npos) << Notes();
}

TEST_F(MeasuredTables, GroundPointsMayBeCalledAsOtherProgramsCallThem) {
  for (const char* header : {"point,x,y,z,sigma", "name,east,north,height,accuracy",
                             "Label,X/Easting,Y/Northing,Z/Altitude,Accuracy_m",
                             "gcp,Easting [m],Northing [m],Elevation (m),sigma_m"}) {
    Read(std::string(header) + "\np1,500000.5,5000000,123,0.02\n");
    ASSERT_EQ(all_.All().points.size(), 1u) << header;
    EXPECT_EQ(all_.All().points[0].name, "p1");
    EXPECT_EQ(all_.All().points[0].ground_m, Eigen::Vector3d(500000.5, 5000000, 123));
    EXPECT_EQ(all_.All().points[0].sigma_m, Eigen::Vector3d::Constant(0.02));
    EXPECT_EQ(all_.All().points[0].role, PointRole::kControl);
  }
}

TEST_F(MeasuredTables, GroundPointsHaveAccuraciesPerAxisAndRoles) {
  Read(
      "point,x,y,z,sigma_xy,sigma_z,type\np,500000,5000000,3,0.02,0.05,Check point\n"
      "q,500000,5000000,3,0.02,0.05,GCP\n");
  EXPECT_EQ(all_.All().points[0].sigma_m, Eigen::Vector3d(0.02, 0.02, 0.05));
  EXPECT_EQ(all_.All().points[0].role, PointRole::kCheck);
  EXPECT_EQ(all_.All().points[1].role, PointRole::kControl);
  ExpectRefused("point,x,y,z,role\np,500000,5000000,3,cp\n", {"line 2, column 20", "\"cp\""});
}

TEST_F(MeasuredTables, OneTableMayHoldGroundAndImagePoints) {
  Read(
      "x,y,z,px,py,image,gcp\n500000,5000000,3,10,20,a.jpg,p\n"
      "500000,5000000,3,30,40,b.jpg,p\n");
  EXPECT_EQ(all_.All().points.size(), 1u);
  ASSERT_EQ(all_.All().image_points.size(), 2u);
  EXPECT_EQ(all_.All().image_points[1].photo, "b");
  EXPECT_EQ(*all_.All().image_points[1].pixel, Eigen::Vector2d(30, 40));
}

TEST_F(MeasuredTables, GeographicCoordinatesAreRefused) {
  ExpectRefused("name,lat,lon,height\np,47.1,15.4,400\n", {"line 1", "geographic", "CRS"});
  ExpectRefused("name,x,y,z\np,15.4,47.1,400\n", {"degrees", "CRS"});
}

TEST_F(MeasuredTables, OtherTablesAreRefusedByTheirHeader) {
  ExpectRefused("label,x,y,z,omega,phi,kappa\na,1,2,3,0,0,0\n", {"line 1", "orientations"});
  ExpectRefused("photo,point,col\na,p,1\n", {"line 1", "col", "none of row"});
  ExpectRefused("photo,point,col,px,row\na,p,1,1,2\n", {"two columns mean col", "\"px\""});
  ExpectRefused("4711,p1,100,200\n", {"line 1", "photo, point, col, row"});
  ExpectRefused("", {"table.csv", "empty"});
}

TEST_F(MeasuredTables, ColumnsThatAreNotReadAreNamed) {
  Read("photo,point,col,row,sigma,Description\na,p,1,2,1,kerb\n");
  EXPECT_NE(Notes().find("not read: Description"), std::string::npos) << Notes();
}

TEST_F(MeasuredTables, APointSaidTwiceIsNamedWithBothLines) {
  ExpectRefused("photo,point,col,row,sigma\na,p,1,2,1\na.tif,p,1,3,1\n",
                {"line 3", "point p of photo a", "line 2"});
}

}  // namespace
}  // namespace orient
