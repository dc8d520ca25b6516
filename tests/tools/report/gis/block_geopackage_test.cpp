#include "tools/report/gis/block_geopackage.h"

#include <cpl_error.h>
#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogrsf_frmts.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/geometry/rotation.h"
#include "tests/support/shared_data.h"
#include "tests/tools/report/example_block.h"
#include "tools/report/run_record.h"
#include "tools/report/template.h"

namespace orient {
namespace {

constexpr double kExact = 1e-9;

std::vector<ExteriorResult> ExampleResults() {
  return {ExampleExterior("4711", Status::kOk), ExampleExterior("4712", Status::kWeak),
          ExampleExterior("4713", Status::kFailed)};
}

// The written file, opened so that any complaint of GDAL fails the test.
GDALDatasetUniquePtr Open(const std::string& path) {
  CPLErrorReset();
  GDALDatasetUniquePtr dataset(GDALDataset::Open(path.c_str(), GDAL_OF_VECTOR));
  EXPECT_STREQ(CPLGetLastErrorMsg(), "");
  return dataset;
}

GDALDatasetUniquePtr WriteAndOpen(const TemporaryFolder& folder,
                                  const std::vector<ExteriorResult>& results,
                                  const std::string& crs = "EPSG:32635") {
  return Open(WriteBlockGeopackage(folder.Path(), Crs::Parse(crs, "test"), results));
}

TEST(BlockGeopackage, PhotosHoldPoseSigmasAndCounts) {
  const TemporaryFolder folder;
  const auto dataset = WriteAndOpen(folder, ExampleResults());
  ASSERT_TRUE(dataset);
  OGRLayer* layer = dataset->GetLayerByName("photos");
  ASSERT_NE(layer, nullptr);
  EXPECT_EQ(layer->GetFeatureCount(), 3);
  const OGRFeatureUniquePtr photo(layer->GetNextFeature());
  EXPECT_STREQ(photo->GetFieldAsString("name"), "4711");
  EXPECT_STREQ(photo->GetFieldAsString("status"), "ok");
  EXPECT_NEAR(photo->GetFieldAsDouble("kappa"), DegFromRad(1.5), kExact);
  EXPECT_NEAR(photo->GetFieldAsDouble("sigma_z"), 0.4, kExact);
  EXPECT_NEAR(photo->GetFieldAsDouble("sigma_kappa"), DegFromRad(1e-4), kExact);
  EXPECT_EQ(photo->GetFieldAsInteger("matched"), 3);
  EXPECT_EQ(photo->GetFieldAsInteger("searched"), 5);
  const OGRPoint* centre = photo->GetGeometryRef()->toPoint();
  EXPECT_EQ(centre->getX(), 500000.25);
  EXPECT_EQ(centre->getY(), 5000000.5);
  EXPECT_EQ(centre->getZ(), 1823.75);
}

TEST(BlockGeopackage, FailedPhotoHasNoPlaceButItsReason) {
  const TemporaryFolder folder;
  const auto dataset = WriteAndOpen(folder, ExampleResults());
  OGRLayer* layer = dataset->GetLayerByName("photos");
  layer->SetAttributeFilter("name = '4713'");
  const OGRFeatureUniquePtr photo(layer->GetNextFeature());
  EXPECT_EQ(photo->GetGeometryRef(), nullptr);
  EXPECT_STREQ(photo->GetFieldAsString("message"), "only 3 patches agree on a pose");
  EXPECT_FALSE(photo->IsFieldSetAndNotNull(photo->GetFieldIndex("sigma0_px")));
}

TEST(BlockGeopackage, FootprintsAreClosedPolygons) {
  const TemporaryFolder folder;
  const auto dataset = WriteAndOpen(folder, ExampleResults());
  OGRLayer* layer = dataset->GetLayerByName("footprints");
  EXPECT_EQ(layer->GetFeatureCount(), 2);
  const OGRFeatureUniquePtr footprint(layer->GetNextFeature());
  EXPECT_NEAR(footprint->GetGeometryRef()->toPolygon()->get_Area(), 1e6, 1e-3);
  EXPECT_TRUE(footprint->GetGeometryRef()->toPolygon()->getExteriorRing()->get_IsClosed());
}

TEST(BlockGeopackage, PatchesKeepStateResidualAndReason) {
  const TemporaryFolder folder;
  const auto dataset = WriteAndOpen(folder, ExampleResults());
  OGRLayer* layer = dataset->GetLayerByName("patches");
  // Of six in each of two photos those that the photo could see.
  EXPECT_EQ(layer->GetFeatureCount(), 10);
  layer->SetAttributeFilter("photo = '4711' AND patch = 14");
  const OGRFeatureUniquePtr patch(layer->GetNextFeature());
  EXPECT_STREQ(patch->GetFieldAsString("state"), "rejected");
  EXPECT_STREQ(patch->GetFieldAsString("reason"), "does not agree with the other patches");
  EXPECT_EQ(patch->GetFieldAsDouble("residual_col_px"), 9.0);
  EXPECT_EQ(patch->GetFieldAsDouble("residual_row_px"), 4.0);
}

// Columns to the east and rows to the south with 0.5 m pixels: a sign or an axis that is swapped
// points the vectors elsewhere.
TEST(BlockGeopackage, ResidualsPointTheirWayOnTheGround) {
  constexpr double kFitted = 1e-6;  // through an affine fit at coordinates of millions of metres
  const TemporaryFolder folder;
  const auto dataset = WriteAndOpen(folder, ExampleResults());
  OGRLayer* layer = dataset->GetLayerByName("residuals");
  layer->SetAttributeFilter("photo = '4711' AND patch = 12");
  const OGRFeatureUniquePtr residual(layer->GetNextFeature());
  const OGRLineString* line = residual->GetGeometryRef()->toLineString();
  const double exaggeration = residual->GetFieldAsDouble("exaggeration");
  EXPECT_NEAR(line->getX(1) - line->getX(0), 0, kFitted);
  EXPECT_NEAR(line->getY(1) - line->getY(0), 0.25 * 0.5 * exaggeration, kFitted);  // row up: north
}

TEST(BlockGeopackage, TiesHaveTheirPlacePrecisionAndResiduals) {
  const TemporaryFolder folder;
  const AdjustmentResult adjusted = ExampleAdjustment();
  const auto dataset = Open(WriteBlockGeopackage(folder.Path(), Crs::Parse("EPSG:32635", "test"),
                                                 ExampleResults(), &adjusted));
  OGRLayer* layer = dataset->GetLayerByName("ties");
  ASSERT_NE(layer, nullptr);
  EXPECT_EQ(layer->GetFeatureCount(), 2);
  layer->SetAttributeFilter("tie = 2");
  const OGRFeatureUniquePtr tie(layer->GetNextFeature());
  EXPECT_STREQ(tie->GetFieldAsString("photos"), "4711 4712");
  EXPECT_EQ(tie->GetFieldAsInteger("rejected"), 1);
  EXPECT_NEAR(tie->GetFieldAsDouble("rms_px"), 0.2, kExact);  // the rejected one does not count
  EXPECT_NEAR(tie->GetFieldAsDouble("sigma_z"), 0.11, kExact);
  OGRLayer* residuals = dataset->GetLayerByName("residuals");
  residuals->SetAttributeFilter("kind = 'tie'");
  EXPECT_EQ(residuals->GetFeatureCount(), 4);
}

// QGIS reads styles by these columns and takes none where one is absent.
TEST(BlockGeopackage, NamesProgramAndInputsAndNoTimes) {
  const TemporaryFolder folder;
  RunRecord record{
      "orient 1.2", "orient block", "2024-05-06T07:08:09Z", 3, {{"DEM", "dem ü.tif", "abc"}}};
  WriteRunRecord(folder.Path(), "block", record);
  const auto dataset = WriteAndOpen(folder, ExampleResults());
  const char* run = dataset->GetMetadataItem("orient_block");
  ASSERT_NE(run, nullptr);
  const auto json = nlohmann::json::parse(run);
  EXPECT_EQ(json.at("program"), "orient 1.2");
  EXPECT_EQ(json.at("inputs").at(0).at("path"), "dem ü.tif");
  EXPECT_EQ(json.size(), 2U) << "no times: the same block has the same tables";
}

TEST(BlockGeopackage, EveryLayerHasItsStyle) {
  const TemporaryFolder folder;
  const AdjustmentResult adjusted = ExampleAdjustment();
  const auto dataset = Open(WriteBlockGeopackage(folder.Path(), Crs::Parse("EPSG:32635", "test"),
                                                 ExampleResults(), &adjusted));
  OGRLayer* styles = dataset->GetLayerByName("layer_styles");
  ASSERT_NE(styles, nullptr);
  for (const char* column :
       {"f_table_catalog", "f_table_schema", "f_table_name", "f_geometry_column", "styleName",
        "styleQML", "styleSLD", "useAsDefault", "description", "owner", "update_time"})
    EXPECT_GE(styles->GetLayerDefn()->GetFieldIndex(column), 0) << column;
  for (const char* name : {"photos", "footprints", "patches", "residuals", "ties"}) {
    styles->SetAttributeFilter(("f_table_name = '" + std::string(name) + "'").c_str());
    const OGRFeatureUniquePtr style(styles->GetNextFeature());
    ASSERT_TRUE(style) << name;
    EXPECT_STREQ(style->GetFieldAsString("f_geometry_column"),
                 dataset->GetLayerByName(name)->GetGeometryColumn());
    EXPECT_EQ(style->GetFieldAsInteger("useAsDefault"), 1);
    EXPECT_EQ(style->GetFieldAsString("styleQML"), ReportFile(std::string(name) + ".qml"));
  }
}

TEST(BlockGeopackage, EveryLayerHasCrsAndSpatialIndex) {
  const TemporaryFolder folder;
  const auto dataset = WriteAndOpen(folder, ExampleResults());
  ASSERT_EQ(dataset->GetLayerCount(), 5);
  for (OGRLayer* layer : dataset->GetLayers()) {
    if (std::string(layer->GetName()) == "layer_styles") continue;  // has no places
    EXPECT_STREQ(layer->GetSpatialRef()->GetAuthorityCode(nullptr), "32635") << layer->GetName();
    EXPECT_TRUE(layer->TestCapability(OLCFastSpatialFilter)) << layer->GetName();
  }
}

TEST(BlockGeopackage, CrsWithoutACodeIsKept) {
  const TemporaryFolder folder;
  const std::string crs = "+proj=tmerc +lat_0=0 +lon_0=25 +k=1 +x_0=0 +y_0=0 +ellps=WGS84 +units=m";
  const auto dataset = WriteAndOpen(folder, ExampleResults(), crs);
  const OGRSpatialReference* written = dataset->GetLayer(0)->GetSpatialRef();
  ASSERT_NE(written, nullptr);
  EXPECT_EQ(written->GetProjParm(SRS_PP_CENTRAL_MERIDIAN), 25);
}

TEST(BlockGeopackage, SecondRunReplacesTheFirst) {
  const TemporaryFolder folder;
  WriteAndOpen(folder, ExampleResults());
  const auto dataset = WriteAndOpen(folder, {ExampleExterior("4711", Status::kOk)});
  EXPECT_EQ(dataset->GetLayerByName("photos")->GetFeatureCount(), 1);
  size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.Path()))
    ++files;
  EXPECT_EQ(files, 1u) << "something was left beside block.gpkg";
}

TEST(BlockGeopackage, BlockWithoutResultsIsValid) {
  const TemporaryFolder folder;
  EXPECT_TRUE(WriteAndOpen(folder, {}));
}

TEST(BlockGeopackage, TextThatIsNotUtf8IsRepaired) {
  const TemporaryFolder folder;
  ExteriorResult result = ExampleExterior("4711", Status::kOk);
  result.photo = "M\xFCnchen";
  const auto dataset = WriteAndOpen(folder, {result});
  const OGRFeatureUniquePtr photo(dataset->GetLayerByName("photos")->GetNextFeature());
  EXPECT_STREQ(photo->GetFieldAsString("name"), "M\xEF\xBF\xBDnchen");
}

TEST(BlockGeopackage, FolderThatIsNotThereIsAnInputError) {
  const TemporaryFolder folder;
  EXPECT_THROW(WriteBlockGeopackage(folder / "absent", Crs::Parse("EPSG:32635", "test"), {}),
               InputError);
}

}  // namespace
}  // namespace orient
