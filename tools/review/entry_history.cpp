#include "tools/review/entry_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "block/inputs/digest.h"
#include "core/base/atomic_write.h"

namespace orient {
namespace {
using Json = nlohmann::json;
namespace fs = std::filesystem;
}  // namespace

std::string VersionOf(const FileTexts& files) {
  std::string all;
  for (const auto& [name, text] : files) all += fmt::format("{} {}\n", name, text.size()) + text;
  return block::Digest(all);
}

EntryHistory::EntryHistory(std::string path, const FileTexts& now) : path_(std::move(path)) {
  try {
    if (fs::exists(path_)) Read();
  } catch (const std::exception&) {  // the history is only an aid
    steps_.clear();
  }
  // A review may have been ended between the files and this history.
  while (!steps_.empty() && !LeadsTo(now)) steps_.pop_back();
}

void EntryHistory::Read() {
  const Json history = Json::parse(ReadFile(path_));
  for (const Json& entry : history.at("words")) {
    Step step{entry.at("about"), entry.at("version_after"), {}};
    for (const auto& [file, change] : entry.at("before").items()) {
      std::optional<Change>& before = step.changes[file];
      if (!change.is_null()) before = {change.at("begin"), change.at("end"), change.at("middle")};
    }
    steps_.push_back(std::move(step));
  }
}

void EntryHistory::Write() const {
  Json entries = Json::array();
  for (const Step& step : steps_) {
    Json before = Json::object();
    for (const auto& [file, change] : step.changes)
      before[file] = change ? Json{{"begin", change->same_at_begin},
                                   {"end", change->same_at_end},
                                   {"middle", change->middle}}
                            : Json();
    entries.push_back(
        {{"about", step.about}, {"version_after", step.version_after}, {"before", before}});
  }
  try {
    WriteFileAtomically(path_, Json{{"words", entries}}.dump());
  } catch (const std::exception&) {  // a full disk, or a file that is no UTF-8
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
}

namespace {

// Whether it is a continuation byte of a UTF-8 character.
bool Continues(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

}  // namespace

EntryHistory::Change EntryHistory::ChangeOf(const std::string& before, const std::string& after) {
  const std::size_t shorter = std::min(before.size(), after.size());
  const auto differs =
      std::mismatch(before.begin(), before.begin() + std::ptrdiff_t(shorter), after.begin());
  auto same = static_cast<std::size_t>(differs.first - before.begin());
  const auto in_character = [&](const std::string& text, std::size_t at) {
    return at < text.size() && Continues(text[at]);
  };
  // Characters are not split, so that what is kept is text again.
  while (same > 0 && (in_character(before, same) || in_character(after, same))) --same;
  const auto differs_at_end = std::mismatch(
      before.rbegin(), before.rbegin() + std::ptrdiff_t(shorter - same), after.rbegin());
  auto same_at_end = static_cast<std::size_t>(differs_at_end.first - before.rbegin());
  while (same_at_end > 0 && Continues(before[before.size() - same_at_end])) --same_at_end;
  return {same, same_at_end, before.substr(same, before.size() - same - same_at_end)};
}

bool EntryHistory::LeadsTo(const FileTexts& now) const {
  if (steps_.empty() || steps_.back().version_after != VersionOf(now)) return false;
  for (const auto& [file, change] : steps_.back().changes) {
    const auto found = now.find(file);
    if (found == now.end()) return false;
    const std::size_t size = found->second.size();
    if (change &&
        (change->same_at_begin > size || change->same_at_end > size - change->same_at_begin))
      return false;  // a history that is not ours
  }
  return true;
}

FileTexts EntryHistory::BeforeLatest(const FileTexts& now) const {
  FileTexts files = now;
  for (const auto& [file, change] : steps_.back().changes) {
    if (!change) {
      files.erase(file);
      continue;
    }
    const std::string& text = files[file];
    files[file] = text.substr(0, change->same_at_begin) + change->middle +
                  text.substr(text.size() - change->same_at_end);
  }
  return files;
}

void EntryHistory::Add(const std::string& about, const FileTexts& before, const FileTexts& after) {
  Step step{about, VersionOf(after), {}};
  for (const auto& [file, text] : after) {
    const auto found = before.find(file);
    if (found == before.end())
      step.changes[file] = std::nullopt;
    else if (found->second != text)
      step.changes[file] = ChangeOf(found->second, text);
  }
  steps_.push_back(std::move(step));
  Write();
}

void EntryHistory::ForgetLatest() {
  steps_.pop_back();
  Write();
}

}  // namespace orient
