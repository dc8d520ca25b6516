// What reading and writing results share. Private to core/files.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "core/files/json_fields.h"
#include "core/files/results.h"

namespace orient {

template <typename Enum, size_t n>
Enum FromName(const JsonField& field, const std::array<Enum, n>& values) {
  const std::string text = field.AsString();
  std::string known;
  for (const Enum value : values) {
    if (Name(value) == text) return value;
    known += (known.empty() ? "" : ", ") + std::string(Name(value));
  }
  field.Fail("is \"" + text + "\"; it must be one of " + known);
}

// Name of the photo that the result at `path` belongs to. It becomes a file name, so a name that
// leads into another folder is refused; so is the result of another photo: a folder's results are
// found by their files' names, which end with `suffix`.
inline std::string ReadPhotoName(const JsonField& root, const std::string& path,
                                 const std::string& suffix) {
  const JsonField field = root.At("photo");
  const std::string name = field.AsString();
  if (name.empty() || name.find_first_of(std::string_view("/\0", 2)) != std::string::npos)
    field.Fail("is \"" + name + "\"; it must be a photo's name, without a folder");
  const std::string file = std::filesystem::path(path).filename().string();
  if (file.ends_with(suffix) && file != name + suffix)
    field.Fail("is \"" + name + "\": the result belongs to another photo than its file's name " +
               "says; do not rename result files");
  return name;
}

inline constexpr std::array kStatuses = {Status::kOk, Status::kWeak, Status::kFailed};

// A result with a NaN in a place that must hold a number is a programming error upstream: it would
// be read back as something else.
inline void RequireFinite(bool finite, const std::string& photo, const std::string& field) {
  if (!finite) throw std::invalid_argument("result of " + photo + ": " + field + " is not finite");
}

template <typename Enum>
Json NameOrNull(const std::optional<Enum>& value) {
  return value ? Json(Name(*value)) : Json(nullptr);
}

Json FindingJson(const Finding& finding);
Reason ReadReason(const JsonField& code);
Finding ReadFinding(const JsonField& field);
// As another program, or an earlier version, states it.
inline Finding Stated(std::string message) {
  return {.reason = Reason::kStated, .where = std::move(message)};
}
// "findings" and, for people, "messages".
void WriteFindings(const Findings& findings, Json* json);
// Of a result that has no findings (another program's) the messages, as stated.
Findings ReadFindings(const JsonField& root);

inline std::string TextOf(const Json& json) { return json.dump(2) + "\n"; }

}  // namespace orient
