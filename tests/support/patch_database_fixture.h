// A patch database in its own temporary folder, with patches at random positions.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "core/base/error.h"
#include "patchdb/store/patch_database.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {

inline Crs Utm() { return Crs::Parse("EPSG:32635", "test"); }

inline Patch SomePatch(double x, double y, int grey = 7) {
  Patch patch;
  patch.ground_m = {x, y, 123.5};
  patch.covariance_m2 << 1, 0.25, 0.125, 0.25, 2, 0.5, 0.125, 0.5, 3;
  patch.gsd_m = 0.5;
  patch.chip = Image(21, 21, static_cast<float>(grey));
  for (int i = 0; i < 21; ++i) patch.chip.At(i, 20 - i) = 200;
  patch.heights = {3, 6, {1, 2, 3, 4, 5, 6, 7, 8, 9}};
  return patch;
}

inline PatchSource Photo(const std::string& name) {
  return {0, SourceKind::kPhoto, name, std::nullopt, 0.5, {}, {}, {}};
}

inline std::string WhatIsWrong(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

class PatchDatabaseTest : public testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string path_ = folder_ / "patches.gpkg";

  PatchDatabase Filled(int count) {
    PatchDatabase database = PatchDatabase::Create(path_, Utm());
    PatchSource source = Photo("4711.tif");
    std::mt19937 random(TestSeed());
    std::uniform_real_distribution<double> at(0, 10000);
    std::vector<Patch> patches;
    for (int i = 0; i < count; ++i)
      patches.push_back(SomePatch(500000 + at(random), 5000000 + at(random), i % 200));
    database.AddSource(source, patches);
    return database;
  }

  void Execute(const std::string& sql) {
    SQLite::Database raw(path_, SQLite::OPEN_READWRITE);
    raw.exec(sql);
  }
};

}  // namespace orient::patchdb
