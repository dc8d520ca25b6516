// Where a block keeps what each photo's jobs gave, so that an interrupted run goes on.
#pragma once

#include <string>

namespace orient {

// One stage's results, a file a photo, each with a note of what it was made from. A result without
// its note, or whose note says something else, is no result: the job is done again.
class StageFolder {
 public:
  static constexpr const char* kNoteSuffix = ".made_from";

  // `suffix`: ".exterior.json", ".ties.json". Nothing is made yet.
  StageFolder(std::string directory, std::string suffix)
      : directory_(std::move(directory)), suffix_(std::move(suffix)) {}

  const std::string& Directory() const { return directory_; }
  std::string ResultPath(const std::string& photo) const;
  // Which of the "name=value" parts of `digest` is not as in the note of the result that is there,
  // "scan, patches"; empty where there is no note, or all are.
  std::string WhatChanged(const std::string& photo, const std::string& digest) const;
  // Whether the result is there and was made from what `digest` stands for.
  bool IsCurrent(const std::string& photo, const std::string& digest) const;
  // Before a job: what is there is not of now.
  void Drop(const std::string& photo) const;
  // After a job, when its result is on disk.
  void Note(const std::string& photo, const std::string& digest) const;

 private:
  std::string NotePath(const std::string& photo) const;

  std::string directory_, suffix_;
};

}  // namespace orient
