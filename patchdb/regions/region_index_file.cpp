#include "patchdb/regions/region_index_file.h"

#include <fmt/format.h>

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>

#include "core/base/error.h"

namespace orient::patchdb {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;

template <typename T>
Json OrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

std::optional<std::string> TextOf(const Json& field) {
  if (field.is_null()) return std::nullopt;
  return field.get<std::string>();
}

Json ToJson(const PatchSource& source) {
  return {{"id", source.id},       {"kind", Name(source.kind)},
          {"name", source.name},   {"date", OrNull(source.date)},
          {"gsd_m", source.gsd_m}, {"digest", OrNull(source.digest)}};
}

[[noreturn]] void FailAs(const Json& field, const std::string& what) {
  throw std::domain_error(field.dump() + " is no " + what);
}

std::int64_t IntegerFrom(const Json& field, std::int64_t least,
                         std::int64_t most = std::numeric_limits<std::int64_t>::max()) {
  const bool fits = field.is_number_integer() &&
                    !(field.is_number_unsigned() && field.get<std::uint64_t>() > INT64_MAX);
  if (!fits || field.get<std::int64_t>() < least || field.get<std::int64_t>() > most)
    FailAs(field, fmt::format("whole number from {} to {}", least, most));
  return field.get<std::int64_t>();
}

SourceKind KindFrom(const Json& field) {
  for (const SourceKind kind : {SourceKind::kPhoto, SourceKind::kOrthophoto, SourceKind::kGcp})
    if (field.get<std::string>() == Name(kind)) return kind;
  FailAs(field, "kind of source");
}

PatchSource SourceFrom(const Json& field) {
  PatchSource source;
  source.id = IntegerFrom(field.at("id"), 1);
  source.kind = KindFrom(field.at("kind"));
  source.name = field.at("name");
  source.date = TextOf(field.at("date"));
  source.gsd_m = field.at("gsd_m");
  source.digest = TextOf(field.at("digest"));
  return source;
}

Bounds ExtentFrom(const Json& field) {
  const Bounds extent{field.at(0), field.at(1), field.at(2), field.at(3)};
  if (field.size() != 4 || !(extent.min_x <= extent.max_x && extent.min_y <= extent.max_y))
    FailAs(field, "extent");
  return extent;
}

Json ToJson(const Region& region) {
  Json extent = nullptr;
  if (region.patches > 0)
    extent = {region.extent.min_x, region.extent.min_y, region.extent.max_x, region.extent.max_y};
  return {{"number", region.number},   {"file", region.file},   {"extent", extent},
          {"patches", region.patches}, {"bytes", region.bytes}, {"modified_ns", region.modified_ns},
          {"sources", region.sources}};
}

Region RegionFrom(const Json& field, const std::set<std::int64_t>& sources) {
  Region region;
  region.number = static_cast<int>(IntegerFrom(field.at("number"), 1, kMostRegions));
  region.file = field.at("file");
  // It is appended to the folder's path, and must not lead out of it.
  if (fs::path(region.file).filename() != region.file || region.file == "..")
    FailAs(field.at("file"), "file of the folder");
  region.patches = IntegerFrom(field.at("patches"), 0);
  if (region.patches > 0) region.extent = ExtentFrom(field.at("extent"));
  region.bytes = IntegerFrom(field.at("bytes"), 0);
  region.modified_ns =
      IntegerFrom(field.at("modified_ns"), std::numeric_limits<std::int64_t>::min());
  for (const Json& pair : field.at("sources")) {
    const std::int64_t of_index = IntegerFrom(pair.at(1), 1);
    if (!sources.contains(of_index)) FailAs(pair, "source of the index");
    region.sources[IntegerFrom(pair.at(0), 1)] = of_index;
  }
  return region;
}

RegionIndex IndexFrom(const Json& document, const std::string& path) {
  RegionIndex index{Crs::Parse(document.at("crs").get<std::string>(), path),
                    static_cast<int>(IntegerFrom(document.at("next_number"), 1, kMostRegions + 1)),
                    {},
                    {}};
  std::set<std::int64_t> sources;
  for (const Json& field : document.at("sources")) {
    index.sources.push_back(SourceFrom(field));
    if (!sources.insert(index.sources.back().id).second) FailAs(field, "source of its own number");
  }
  std::set<int> numbers;
  for (const Json& field : document.at("regions")) {
    index.regions.push_back(RegionFrom(field, sources));
    const int number = index.regions.back().number;
    if (!numbers.insert(number).second || number >= index.next_number)
      FailAs(field, "region of its own number");
  }
  return index;
}

}  // namespace

std::string TextOfRegionIndex(const RegionIndex& index) {
  Json document = {{"version", kVersion},
                   {"crs", index.crs.Wkt()},
                   {"next_number", index.next_number},
                   {"sources", Json::array()},
                   {"regions", Json::array()}};
  for (const PatchSource& source : index.sources) document["sources"].push_back(ToJson(source));
  for (const Region& region : index.regions) document["regions"].push_back(ToJson(region));
  return document.dump(1) + "\n";
}

RegionIndex RegionIndexFromText(const std::string& text, const std::string& path) {
  const auto damaged = [&](const std::exception& error) {
    return InputError(fmt::format(
        "{} is damaged ({}); delete it and make it again with 'orient patchdb index {}'", path,
        error.what(), fs::path(path).parent_path().string()));
  };
  try {
    const Json document = Json::parse(text);
    const std::int64_t version = IntegerFrom(document.at("version"), 1);
    if (version != kVersion)
      throw InputError(fmt::format("{} is of version {}, this program reads version {}", path,
                                   version, kVersion));
    return IndexFrom(document, path);
  } catch (const Json::exception& error) {
    throw damaged(error);
  } catch (const std::domain_error& error) {
    throw damaged(error);
  }
}

}  // namespace orient::patchdb
