// GDAL's own judgement of a GeoPackage.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace orient::patchdb {

// Skips the test where the validator is not installed. Its output goes to a file beside `path`.
inline void ExpectValidGeoPackage(const std::string& path) {
  const std::string validator =
      "/usr/lib/python3/dist-packages/osgeo_utils/samples/validate_gpkg.py";
  if (!std::filesystem::exists(validator) || !std::filesystem::exists("/usr/bin/python3"))
    GTEST_SKIP() << "GDAL's validate_gpkg.py is absent (Debian's python3-gdal)";
  const std::string log = path + ".log";
  std::string command = "/usr/bin/python3 " + validator;
  command += " --extra --warning-as-error " + path + " > " + log + " 2>&1";
  const int status = std::system(command.c_str());
  std::ifstream file(log);
  EXPECT_EQ(status, 0) << std::string((std::istreambuf_iterator<char>(file)), {});
}

}  // namespace orient::patchdb
