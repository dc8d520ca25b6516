// Whether a database is whole, and mending what is not.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "patchdb/store/patch_database.h"

namespace orient::patchdb {

struct CheckFinding {
  std::string what;        // "attempts that name a patch that is not there"
  std::int64_t count = 0;  // how many
  std::string repair;      // what --repair does about it; empty: nothing can be done
};

struct CheckOptions {
  bool chips = true;    // decode every patch; otherwise only tables, indexes and references
  bool repair = false;  // the database must be open for writing
};

// Everything found wrong; with `repair`, what was wrong before. All repairs are one transaction: no
// row of patches is ever deleted; what cannot be decoded is retired. `progress` hears of (patches
// read, patches in all). Throws InputError where the file cannot even be read.
std::vector<CheckFinding> CheckDatabase(
    PatchDatabase& database, const CheckOptions& options,
    const std::function<void(std::int64_t, std::int64_t)>& progress = {});

}  // namespace orient::patchdb
