#include "tools/block/stage_folder.h"

#include <filesystem>
#include <set>
#include <sstream>

#include "core/error.h"
#include "core/files/atomic_write.h"

namespace orient {
namespace fs = std::filesystem;

std::string StageFolder::ResultPath(const std::string& photo) const {
  return (fs::path(directory_) / (photo + suffix_)).string();
}

std::string StageFolder::NotePath(const std::string& photo) const {
  return (fs::path(directory_) / (photo + kNoteSuffix)).string();
}

bool StageFolder::IsCurrent(const std::string& photo, const std::string& digest) const {
  std::error_code ignored;
  if (!fs::exists(ResultPath(photo), ignored) || !fs::exists(NotePath(photo), ignored))
    return false;
  try {
    return ReadFile(NotePath(photo)) == digest + "\n";
  } catch (const InputError&) {
    return false;
  }
}

std::string StageFolder::WhatChanged(const std::string& photo, const std::string& digest) const {
  std::error_code ignored;
  if (!fs::exists(NotePath(photo), ignored)) return "";
  std::istringstream before(ReadFile(NotePath(photo))), now(digest);
  std::set<std::string> parts;
  for (std::string part; before >> part;) parts.insert(part);
  std::string changed;
  for (std::string part; now >> part;)
    if (!parts.contains(part))
      changed += (changed.empty() ? "" : ", ") + part.substr(0, part.find('='));
  return changed;
}

void StageFolder::Drop(const std::string& photo) const {
  std::error_code ignored;  // what cannot be removed cannot be replaced either: told then
  fs::remove(NotePath(photo), ignored);
  fs::remove(ResultPath(photo), ignored);
}

void StageFolder::Note(const std::string& photo, const std::string& digest) const {
  WriteFileAtomically(NotePath(photo), digest + "\n");
}

}  // namespace orient
