#include "block/stages/result_store.h"

#include <algorithm>
#include <filesystem>

namespace orient::block {
namespace fs = std::filesystem;

std::string ResultStore::PathOf(const std::string& job) const {
  return (fs::path(folder_) / (job + suffix_)).string();
}

std::vector<std::string> ResultStore::Jobs() const {
  std::vector<std::string> jobs;
  std::error_code error;
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string file = entry->path().filename().string();
    if (file.ends_with(suffix_)) jobs.push_back(file.substr(0, file.size() - suffix_.size()));
  }
  std::sort(jobs.begin(), jobs.end());
  return jobs;
}

std::optional<Inputs> ResultStore::MadeFrom(const std::string& job) const {
  return ReadMadeFrom(PathOf(job));
}

KnownResult ResultStore::Check(const std::string& job, const Inputs& now) const {
  std::error_code ignored;
  if (!fs::exists(PathOf(job), ignored)) return {ResultState::kAbsent, {}};
  const auto then = MadeFrom(job);
  if (!then) return {ResultState::kUnreadable, {}};
  if (then->empty()) return {ResultState::kUnstated, {}};
  std::vector<std::string> changed = WhatChanged(*then, now);
  if (changed.empty()) return {ResultState::kCurrent, {}};
  return {ResultState::kChanged, std::move(changed)};
}

void ResultStore::Drop(const std::string& job) const {
  std::error_code ignored;
  fs::remove(PathOf(job), ignored);
}

}  // namespace orient::block
