#include "core/base/geopackage/self_description.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogrsf_frmts.h>

#include "core/base/atomic_write.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

class SelfDescriptionTest : public testing::Test {
 protected:
  SelfDescriptionTest() {
    GDALAllRegister();
    file_.reset(GetGDALDriverManager()->GetDriverByName("GPKG")->Create(
        (folder_ / "some.gpkg").c_str(), 0, 0, 0, GDT_Unknown, nullptr));
    file_->CreateLayer("places", nullptr, wkbPoint, nullptr);
  }
  void Execute(const std::vector<std::string>& statements) {
    for (const std::string& statement : statements) {
      CPLErrorReset();
      file_->ReleaseResultSet(file_->ExecuteSQL(statement.c_str(), nullptr, nullptr));
      EXPECT_STREQ(CPLGetLastErrorMsg(), "") << statement;
    }
  }
  void Reopen() {
    file_.reset();
    file_.reset(
        GDALDataset::Open((folder_ / "some.gpkg").c_str(), GDAL_OF_VECTOR | GDAL_OF_UPDATE));
    ASSERT_TRUE(file_);
  }
  TemporaryFolder folder_;
  GDALDatasetUniquePtr file_;
};

TEST_F(SelfDescriptionTest, MetadataAreReadByGdal) {
  const std::string text = "{\"path\": \"a 'b' <c> & ü\"}\x01";
  Execute(StatementsOfMetadata({{"orient_block", text}, {"second", "2"}}));
  Reopen();
  EXPECT_STREQ(file_->GetMetadataItem("orient_block"), "{\"path\": \"a 'b' <c> & ü\"} ");
  EXPECT_STREQ(file_->GetMetadataItem("second"), "2");
}

TEST_F(SelfDescriptionTest, TheSameItemsAreThereOnce) {
  for (int i = 0; i < 2; ++i) Execute(StatementsOfMetadata({{"a", "1"}}));
  OGRLayer* rows =
      file_->ExecuteSQL("SELECT count(*) FROM gpkg_metadata_reference", nullptr, nullptr);
  const OGRFeatureUniquePtr count(rows->GetNextFeature());
  EXPECT_EQ(count->GetFieldAsInteger(0), 1);
  file_->ReleaseResultSet(rows);
}

TEST_F(SelfDescriptionTest, WithoutItemsThereIsNothingToDo) {
  EXPECT_TRUE(StatementsOfMetadata({}).empty());
}

TEST_F(SelfDescriptionTest, AStyleOfSomebodyElseStays) {
  Execute(StatementsOfStyles({{"places", "<qgis a='1'/>", "first"}}));
  Execute(StatementsOfStyles({{"places", "<qgis/>", "second"}, {"ways", "<qgis/>", ""}}));
  Reopen();
  OGRLayer* styles = file_->GetLayerByName("layer_styles");
  ASSERT_NE(styles, nullptr);
  EXPECT_EQ(styles->GetFeatureCount(), 2);
  styles->SetAttributeFilter("f_table_name = 'places'");
  const OGRFeatureUniquePtr style(styles->GetNextFeature());
  EXPECT_STREQ(style->GetFieldAsString("styleQML"), "<qgis a='1'/>");
}

}  // namespace
}  // namespace orient
