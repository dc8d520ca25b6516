// What was said in reviews of a folder of measurements, so that it can be taken back, also by a
// review that begins after the one that wrote it has ended.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace orient {

// Contents of a folder's files by their names; those that are absent are missing.
using FileTexts = std::map<std::string, std::string>;

// A text that changes when any of the files does.
std::string VersionOf(const FileTexts& files);

class EntryHistory {
 public:
  // Reads what earlier reviews have kept at `path`, as far as it leads to the files of now: of what
  // others have changed since, nothing is taken back. What cannot be read is forgotten.
  EntryHistory(std::string path, const FileTexts& now);

  bool IsEmpty() const { return steps_.empty(); }
  // What the latest word was about; empty where there is none.
  std::string LatestAbout() const { return steps_.empty() ? std::string() : steps_.back().about; }
  // Whether the files are as the latest word left them.
  bool LeadsTo(const FileTexts& now) const;
  // The files before the latest word; those that it did not change are as in `now`.
  FileTexts BeforeLatest(const FileTexts& now) const;

  // Keeps a word that changed the files from `before` to `after`; on disk when this returns. A
  // history that cannot be written does not lose the entry: it then lives as long as this object.
  void Add(const std::string& about, const FileTexts& before, const FileTexts& after);
  void ForgetLatest();

 private:
  // One file's text before a word: that of after it, its middle replaced. Absent: no such file.
  struct Change {
    std::size_t same_at_begin = 0, same_at_end = 0;
    std::string middle;
  };
  struct Step {
    std::string about, version_after;
    std::map<std::string, std::optional<Change>> changes;
  };

  static Change ChangeOf(const std::string& before, const std::string& after);
  void Read();
  void Write() const;

  std::string path_;
  std::vector<Step> steps_;
};

}  // namespace orient
