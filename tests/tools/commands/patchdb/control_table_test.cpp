#include "tools/commands/patchdb/control_table.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr const char* kHeader = "point,x,y,z,sigma_x,sigma_y,sigma_z,photo,col,row\n";

std::vector<ControlTablePoint> Read(const TemporaryFolder& folder, const std::string& rows) {
  std::ofstream(folder / "gcp.csv") << kHeader << rows;
  return ReadControlTable(folder / "gcp.csv");
}

TEST(ControlTable, RowsOfOnePointAreItsMeasurements) {
  const TemporaryFolder folder;
  const auto points = Read(folder,
                           "# surveyed 1998\n"
                           "A,500000.5,5000000,310.2,0.02,0.02,0.04,4711,100.5,200\n"
                           "B,500100,5000000,300,0.02,0.02,0.04,4711,300,200\n"
                           "A,500000.5,5000000,310.2,0.02,0.02,0.04,4712,20,30\r\n");
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].measured.size(), 2u);
  EXPECT_EQ(points[0].measured[1].photo, "4712");
  EXPECT_EQ(points[0].measured[0].pixel.x(), 100.5);
  EXPECT_EQ(points[1].point.ground_m.x(), 500100);
}

TEST(ControlTable, MistakesNameFileAndLine) {
  const TemporaryFolder folder;
  for (const char* rows : {"A,1,2,3,0.1,0.1,0.1,p,5\n", "A,1,2,x,0.1,0.1,0.1,p,5,6\n",
                           "A,1,2,3,0,0.1,0.1,p,5,6\n", "A,1,2,3,0.1,0.1,99999,p,5,6\n",
                           "A,1,2,nan,0.1,0.1,0.1,p,5,6\n", ",1,2,3,0.1,0.1,0.1,p,5,6\n"}) {
    try {
      Read(folder, rows);
      FAIL() << rows;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("gcp.csv, line 2"), std::string::npos)
          << error.what();
    }
  }
  EXPECT_THROW(Read(folder,
                    "A,1,2,3,0.1,0.1,0.1,p,5,6\n"
                    "A,1,2,4,0.1,0.1,0.1,q,5,6\n"),
               InputError);
  EXPECT_THROW(Read(folder,
                    "A,1,2,3,0.1,0.1,0.1,p,5,6\n"
                    "A,1,2,3,0.1,0.1,0.1,p,7,6\n"),
               InputError);
}

}  // namespace
}  // namespace orient
