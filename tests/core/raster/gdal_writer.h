// Makes small rasters of every kind for the tests, with GDAL itself.
#pragma once

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

namespace orient {

struct RasterRecipe {
  std::string driver = "GTiff";
  GDALDataType type = GDT_Float32;
  int width = 64, height = 48, bands = 1;
  std::vector<std::string> options;  // NAME=VALUE of the driver
  // Value at a pixel's centre (corner convention) in a band that counts from 1.
  std::function<double(int band, double x, double y)> value;
  std::function<void(GDALDataset*)> prepare;  // before the values
  std::vector<int> overviews;                 // factors
  std::string overview_method = "AVERAGE";
};

inline CPLStringList ToList(const std::vector<std::string>& options) {
  CPLStringList list;
  for (const std::string& option : options) list.AddString(option.c_str());
  return list;
}

inline void FillRaster(GDALDataset* dataset, const RasterRecipe& recipe) {
  std::vector<double> line(static_cast<size_t>(recipe.width));
  for (int b = 1; b <= recipe.bands; ++b) {
    for (int r = 0; r < recipe.height; ++r) {
      for (int c = 0; c < recipe.width; ++c)
        line[static_cast<size_t>(c)] = recipe.value(b, c + 0.5, r + 0.5);
      ASSERT_EQ(dataset->GetRasterBand(b)->RasterIO(GF_Write, 0, r, recipe.width, 1, line.data(),
                                                    recipe.width, 1, GDT_Float64, 0, 0, nullptr),
                CE_None);
    }
  }
}

// Drivers that cannot be written piece by piece are copied from memory.
inline void WriteRaster(const std::string& path, const RasterRecipe& recipe) {
  GDALAllRegister();
  const bool direct = recipe.driver == "GTiff";
  GDALDriver* driver =
      GetGDALDriverManager()->GetDriverByName(direct ? recipe.driver.c_str() : "MEM");
  CPLStringList options = direct ? ToList(recipe.options) : CPLStringList();
  GDALDatasetUniquePtr dataset(driver->Create(path.c_str(), recipe.width, recipe.height,
                                              recipe.bands, recipe.type, options.List()));
  ASSERT_NE(dataset, nullptr);
  if (recipe.prepare) recipe.prepare(dataset.get());
  FillRaster(dataset.get(), recipe);
  std::vector<int> factors = recipe.overviews;
  if (!factors.empty()) {
    const CPLErr made =
        dataset->BuildOverviews(recipe.overview_method.c_str(), static_cast<int>(factors.size()),
                                factors.data(), 0, nullptr, nullptr, nullptr);
    ASSERT_EQ(made, CE_None);
  }
  if (direct) return;
  GDALDriver* target = GetGDALDriverManager()->GetDriverByName(recipe.driver.c_str());
  ASSERT_NE(target, nullptr);
  options = ToList(recipe.options);
  const GDALDatasetUniquePtr copy(
      target->CreateCopy(path.c_str(), dataset.get(), 0, options.List(), nullptr, nullptr));
  ASSERT_NE(copy, nullptr);
}

}  // namespace orient
