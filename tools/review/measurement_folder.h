// A folder of measurements (docs/measurements.md) while a person adds to it: every entry is on disk
// before it is confirmed, no other person's entry is overwritten unseen, and each can be undone.
#pragma once

#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/base/folder_lock.h"
#include "core/measurements/measurements.h"
#include "tools/review/entry_history.h"

namespace orient {

// What a person enters in one action. It replaces what was entered before for the same thing.
struct Entry {
  std::vector<MarkMeasurement> marks;
  std::vector<ImagePointMeasurement> image_points;
  std::vector<GroundPoint> points;
  std::vector<Decision> decisions;  // accept and reject replace one another
  // What is withdrawn: photo and mark, photo and point, point, photo and kind.
  std::vector<std::pair<std::string, std::string>> no_marks, no_image_points;
  std::vector<std::string> no_points;
  std::vector<std::pair<std::string, DecisionKind>> no_decisions;

  std::string about;  // for messages: "mark 3 of photo 4711"
};

enum class EntryOutcome {
  kRecorded,
  kOtherVersion,  // the files changed after the version was read; nothing was written
  kNothing        // there is nothing to take back
};

// Safe from several threads. As long as it lives, no other program's MeasurementFolder has the
// folder; files that are edited by hand meanwhile are another version.
class MeasurementFolder {
 public:
  // Makes the folder where it is not there. Throws InputError where it cannot, where another review
  // is open on it, or where a file in it is wrong.
  explicit MeasurementFolder(const std::string& folder);

  const std::string& Folder() const { return folder_; }

  // The current contents, and their version: a text that changes when any of the files does.
  // Throws InputError where a file is wrong.
  std::pair<Measurements, std::string> Read() const;

  // Adds to what `version` says. Throws InputError for names and numbers that the files cannot
  // hold, or points in pixels beside points in the photo system; nothing is written then. Before a
  // file is changed that was there when the review began, it is copied to <file>.before_review,
  // unless that is there: comments in it are not kept.
  EntryOutcome Record(const std::string& version, const Entry& entry);

  // Takes the latest word back that was said in a review of this folder, this one or an earlier
  // one, and was not taken back yet: as long as nobody else has changed the files since.
  EntryOutcome Undo(const std::string& version);
  // What Undo would take back; empty where there is nothing.
  std::string LatestAbout() const;

 private:
  FileTexts ReadFiles() const;
  Measurements Parsed(const FileTexts& files) const;
  void CopyBeforeReview(const std::string& file, const FileTexts& now) const;
  void Write(const std::string& file, const Measurements& all) const;

  std::string folder_;
  FolderLock lock_;
  FileTexts at_start_;
  mutable std::mutex mutex_;
  EntryHistory history_;
};

}  // namespace orient
