#include "patchdb/content_digest.h"

#include "patchdb/connection.h"

namespace orient {
namespace {

constexpr const char* kCount = "SELECT count(*) FROM patches";
constexpr const char* kNewest = "SELECT max(id) FROM patches";
// Retired by hand or by newer views, not by learning (learning.cpp words the reason).
constexpr const char* kRetired =
    "SELECT count(*) FROM patches WHERE state = 'retired' AND "
    "retired_reason NOT LIKE 'failed in % photos where its neighbours matched%'";
constexpr const char* kRetiredSum =
    "SELECT sum(id) FROM patches WHERE state = 'retired' AND "
    "retired_reason NOT LIKE 'failed in % photos where its neighbours matched%'";

}  // namespace

std::string ContentOf(const PatchDatabase& database) {
  return WithFile(database.Path(), "read", [&] {
    std::string text;
    for (const char* question : {kCount, kNewest, kRetired, kRetiredSum})
      text += std::to_string(database.Sql().Number(question)) + " ";
    return text;
  });
}

}  // namespace orient
