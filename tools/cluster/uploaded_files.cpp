#include "tools/cluster/uploaded_files.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace orient {
namespace {
using Json = nlohmann::json;

constexpr const char* kKind = "orient upload";

bool Holds(const Json& object, const char* key, bool (Json::*is)() const noexcept) {
  const auto member = object.find(key);
  return member != object.end() && ((*member).*is)();
}

bool IsList(const Json& json) {
  return json.is_object() && json.value("kind", Json()) == kKind &&
         Holds(json, "id", &Json::is_string) && Holds(json, "complete", &Json::is_boolean) &&
         Holds(json, "files", &Json::is_object);
}

bool IsFile(const Json& json) {
  return json.is_object() && Holds(json, "bytes", &Json::is_number_unsigned) &&
         (!json.contains("digest") || Holds(json, "digest", &Json::is_string));
}

}  // namespace

std::string TextOf(const UploadedFiles& list) {
  Json files = Json::object();
  for (const auto& [name, file] : list.files) {
    Json& entry = files[name] = {{"bytes", file.bytes}};
    if (!file.digest.empty()) entry["digest"] = file.digest;
  }
  const Json json = {
      {"kind", kKind}, {"id", list.id}, {"complete", list.complete}, {"files", files}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

UploadedFiles ReadUploadedFiles(const std::string& text, const std::string& name) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  const bool is_list = IsList(json);
  if (!is_list || !std::all_of(json["files"].begin(), json["files"].end(), IsFile))
    throw InputError(name + " is not a list of an upload; name another place, or remove it");
  UploadedFiles list{json["id"], json["complete"], {}};
  for (const auto& [file, entry] : json["files"].items())
    list.files[file] = {entry["bytes"], entry.value("digest", "")};
  return list;
}

}  // namespace orient
