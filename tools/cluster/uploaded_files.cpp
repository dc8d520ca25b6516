#include "tools/cluster/uploaded_files.h"

#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace orient {
namespace {
using Json = nlohmann::ordered_json;

constexpr const char* kKind = "orient upload";

// Null where the member is absent.
const Json* Find(const Json& object, const char* key) {
  const auto member = object.find(key);
  return member != object.end() ? &*member : nullptr;
}

bool IsList(const Json& json) {
  if (!json.is_object()) return false;
  const Json *kind = Find(json, "kind"), *files = Find(json, "files");
  const Json* complete = Find(json, "complete");
  return kind && *kind == kKind && complete && complete->is_boolean() && files &&
         files->is_object();
}

bool IsFile(const Json& json) {
  if (!json.is_object()) return false;
  const Json *bytes = Find(json, "bytes"), *digest = Find(json, "digest");
  return bytes && bytes->is_number_unsigned() && digest && digest->is_string();
}

}  // namespace

std::string TextOf(const UploadedFiles& list) {
  Json files = Json::object();
  for (const auto& [name, file] : list.files)
    files[name] = {{"bytes", file.bytes}, {"digest", file.digest}};
  const Json json = {{"kind", kKind}, {"complete", list.complete}, {"files", files}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

UploadedFiles ReadUploadedFiles(const std::string& text, const std::string& name) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!IsList(json))
    throw InputError(name + " is no list of an upload; name another place, or remove it");
  UploadedFiles list;
  list.complete = json["complete"];
  for (const auto& [file, entry] : json["files"].items()) {
    if (!IsFile(entry))
      throw InputError(name + ": " + file +
                       " has no size or no digest; remove the list, and upload "
                       "with --overwrite");
    list.files[file] = {entry["bytes"], entry["digest"]};
  }
  return list;
}

}  // namespace orient
