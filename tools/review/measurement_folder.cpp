#include "tools/review/measurement_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/output_directory.h"
#include "core/base/trimmed.h"
#include "core/geometry/sigma.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr std::array kFiles = {kMarksFile, kImagePointsFile, kPointsFile, kDecisionsFile};
constexpr const char* kHistoryFile = ".orient-review.undo.json";
constexpr std::size_t kLongestName = 200, kLongestReason = 2000;

std::string Made(const std::string& folder) {
  MakeOutputDirectory(folder);
  return folder;
}

void RequireText(const std::string& what, const std::string& text, std::size_t longest) {
  if (text.size() > longest)
    throw InputError(fmt::format("{} has more than {} characters; shorten it", what, longest));
  if (Trimmed(text) != text)
    throw InputError(fmt::format("{} \"{}\" has blanks around it; leave them out", what, text));
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; };
  if (std::any_of(text.begin(), text.end(), is_control))
    throw InputError(what + " has line breaks or control characters in it; leave them out");
}

void RequireName(const std::string& what, const std::string& name) {
  if (name.empty()) throw InputError(what + " has no name; give it one");
  RequireText("the name of " + what, name, kLongestName);
}

void RequireNumber(const std::string& what, double number) {
  if (!std::isfinite(number) || std::abs(number) > 1e9)
    throw InputError(fmt::format("{} is {}; it must be a number below 1e9", what, number));
}

void RequireSigma(double sigma) {
  if (const std::string problem = SigmaProblem(sigma); !problem.empty())
    throw InputError(fmt::format("sigma is {}; {}", sigma, problem));
}

void RequireAttribution(const Attribution& attribution) {
  RequireText("the name of who says it", attribution.by, kLongestName);
  RequireText("the date", attribution.when, kLongestName);
}

// Throws InputError if the files could not be read again with this statement in them.
void RequireRight(const Entry& entry) {
  for (const MarkMeasurement& mark : entry.marks) {
    RequireName("the photo", mark.photo);
    RequireName("the mark", mark.mark);
    for (const double number : mark.pixel) RequireNumber("the mark's pixel", number);
    RequireSigma(mark.sigma_px);
    RequireAttribution(mark.attribution);
  }
  for (const ImagePointMeasurement& seen : entry.image_points) {
    RequireName("the photo", seen.photo);
    RequireName("the point", seen.point);
    for (const double number : seen.pixel.value()) RequireNumber("the point's pixel", number);
    RequireSigma(seen.sigma);
    RequireAttribution(seen.attribution);
  }
  for (const GroundPoint& point : entry.points) {
    RequireName("the point", point.name);
    for (const double number : point.ground_m) RequireNumber("the point's coordinate", number);
    for (const double sigma : point.sigma_m) RequireSigma(sigma);
    RequireAttribution(point.attribution);
  }
  for (const Decision& decision : entry.decisions) {
    RequireName("the photo", decision.photo);
    RequireText("the value", decision.value, kLongestName);
    RequireText("the reason", decision.reason, kLongestReason);
    RequireAttribution(decision.attribution);
    if (const std::string why = DecisionProblem(decision.kind, decision.value); !why.empty())
      throw InputError(
          fmt::format("the value \"{}\" of {} {}", decision.value, Name(decision.kind), why));
  }
}

bool IsVerdict(DecisionKind kind) {
  return kind == DecisionKind::kAccept || kind == DecisionKind::kReject;
}

void Decide(const Entry& entry, std::vector<Decision>* all) {
  for (const auto& [photo, kind] : entry.no_decisions)
    std::erase_if(*all, [&, p = photo, k = kind](const Decision& one) {
      return one.photo == p && one.kind == k;
    });
  for (const Decision& decision : entry.decisions) {
    std::erase_if(*all, [&](const Decision& one) {
      return one.photo == decision.photo &&
             (one.kind == decision.kind || (IsVerdict(one.kind) && IsVerdict(decision.kind)));
    });
    all->push_back(decision);
  }
}

// `key`: photo and name of a measurement.
template <typename Measured, typename Key>
void Measure(const std::vector<Measured>& measured,
             const std::vector<std::pair<std::string, std::string>>& not_any_more, const Key& key,
             std::vector<Measured>* all) {
  for (const auto& gone : not_any_more)
    std::erase_if(*all, [&](const Measured& one) { return key(one) == gone; });
  for (const Measured& one : measured) {
    std::erase_if(*all, [&](const Measured& other) { return key(other) == key(one); });
    all->push_back(one);
  }
}

void Add(const Entry& entry, Measurements* all) {
  const auto mark = [](const MarkMeasurement& m) { return std::pair(m.photo, m.mark); };
  const auto seen = [](const ImagePointMeasurement& m) { return std::pair(m.photo, m.point); };
  const auto point = [](const GroundPoint& p) { return std::pair(std::string(), p.name); };
  Measure(entry.marks, entry.no_marks, mark, &all->marks);
  Measure(entry.image_points, entry.no_image_points, seen, &all->image_points);
  std::vector<std::pair<std::string, std::string>> no_points;
  for (const std::string& name : entry.no_points) no_points.emplace_back("", name);
  Measure(entry.points, no_points, point, &all->points);
  Decide(entry, &all->decisions);
  if (!entry.image_points.empty() && all->image_points.front().photo_mm)
    throw InputError(fmt::format(
        "{} in {} is measured in the photo system (x_mm, y_mm), and a click is in pixels; put the "
        "clicks into a folder of their own with --measurements",
        kImagePointsFile, all->folder));
}

// Ground before image points: a point that is not measured in a photo yet does no harm.
std::vector<std::string> FilesOf(const Entry& entry) {
  std::vector<std::string> files;
  if (!entry.points.empty() || !entry.no_points.empty()) files.emplace_back(kPointsFile);
  if (!entry.image_points.empty() || !entry.no_image_points.empty())
    files.emplace_back(kImagePointsFile);
  if (!entry.marks.empty() || !entry.no_marks.empty()) files.emplace_back(kMarksFile);
  if (!entry.decisions.empty() || !entry.no_decisions.empty()) files.emplace_back(kDecisionsFile);
  return files;
}

}  // namespace

MeasurementFolder::MeasurementFolder(const std::string& folder)
    : folder_(Made(folder)),
      lock_(folder_, ".orient-review.lock"),
      at_start_(ReadFiles()),
      history_((fs::path(folder_) / kHistoryFile).string(), at_start_) {
  Parsed(at_start_);
}

FileTexts MeasurementFolder::ReadFiles() const {
  FileTexts files;
  for (const char* file : kFiles) {
    const fs::path path = fs::path(folder_) / file;
    if (fs::exists(path)) files[file] = ReadFile(path.string());
  }
  return files;
}

Measurements MeasurementFolder::Parsed(const FileTexts& files) const {
  if (!files.empty()) return ReadMeasurements(folder_);
  Measurements nothing;
  nothing.folder = folder_;
  return nothing;
}

std::pair<Measurements, std::string> MeasurementFolder::Read() const {
  const std::lock_guard lock(mutex_);
  const FileTexts files = ReadFiles();
  return {Parsed(files), VersionOf(files)};
}

void MeasurementFolder::CopyBeforeReview(const std::string& file, const FileTexts& now) const {
  const std::string copy = (fs::path(folder_) / (file + ".before_review")).string();
  if (at_start_.contains(file) && now.contains(file) && !fs::exists(copy))
    WriteFileAtomically(copy, now.at(file));
}

void MeasurementFolder::Write(const std::string& file, const Measurements& all) const {
  if (file == kMarksFile) WriteMarks(folder_, all.marks);
  if (file == kImagePointsFile) WriteImagePoints(folder_, all.image_points);
  if (file == kPointsFile) WritePoints(folder_, all.points);
  if (file == kDecisionsFile) WriteDecisions(folder_, all.decisions);
}

EntryOutcome MeasurementFolder::Record(const std::string& version, const Entry& entry) {
  RequireRight(entry);
  const std::lock_guard lock(mutex_);
  const FileTexts now = ReadFiles();
  if (VersionOf(now) != version) return EntryOutcome::kOtherVersion;
  Measurements all = Parsed(now);
  Add(entry, &all);
  for (const std::string& file : FilesOf(entry)) {
    CopyBeforeReview(file, now);
    Write(file, all);
  }
  history_.Add(entry.about, now, ReadFiles());
  return EntryOutcome::kRecorded;
}

EntryOutcome MeasurementFolder::Undo(const std::string& version) {
  const std::lock_guard lock(mutex_);
  if (history_.IsEmpty()) return EntryOutcome::kNothing;
  const FileTexts now = ReadFiles();
  if (VersionOf(now) != version || !history_.LeadsTo(now)) return EntryOutcome::kOtherVersion;
  const FileTexts before = history_.BeforeLatest(now);
  for (const auto& [file, text] : now) {
    const std::string path = (fs::path(folder_) / file).string();
    const auto kept = before.find(file);
    if (kept == before.end())
      fs::remove(path);
    else if (kept->second != text)
      WriteFileAtomically(path, kept->second);
  }
  history_.ForgetLatest();
  return EntryOutcome::kRecorded;
}

std::string MeasurementFolder::LatestAbout() const {
  const std::lock_guard lock(mutex_);
  return history_.LatestAbout();
}

}  // namespace orient
