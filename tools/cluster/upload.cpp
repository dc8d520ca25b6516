#include "tools/cluster/upload.h"

#include <cpl_conv.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <optional>
#include <random>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "core/base/partial_files.h"
#include "core/base/quiet_gdal.h"
#include "core/base/side_by_side.h"
#include "tools/cluster/job_scripts.h"
#include "tools/cluster/store_object.h"
#include "tools/cluster/uploaded_files.h"
#include "tools/report/html_text.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr const char* kChanges = "; upload when nothing writes into the folder any more";

// Whether a file is one of the results; `name`: in the folder.
bool IsUploaded(const fs::path& name) {
  const std::string file = name.filename().string();
  return name != kUploadList && !file.starts_with(".orient-") && !IsPartialFile(file);
}

// Throws InputError for what an upload would have to leave out.
void RefuseUnlessFile(const fs::directory_entry& entry, const fs::path& name) {
  const std::string path = entry.path().string();
  std::error_code error;
  if (entry.status(error).type() == fs::file_type::directory)
    throw InputError(path + " is a link to a folder, which is not followed; replace it by a copy");
  if (entry.status(error).type() != fs::file_type::regular)
    throw InputError(fmt::format("{} cannot be uploaded: {}", path,
                                 error ? error.message() : "it is not a file, or a link to none"));
  if (access(path.c_str(), R_OK) != 0)
    throw InputError(fmt::format("cannot read {}: {}", path, std::strerror(errno)));
  if (ValidText(name.string()) != name.string())
    throw InputError(path +
                     " cannot be an object's name: it is not UTF-8, or has control "
                     "characters; rename it");
}

// Paths in the folder, in their order.
std::vector<std::string> FilesOf(const fs::path& folder) {
  std::vector<std::string> files;
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    const fs::path name = entry->path().lexically_relative(folder);
    if (name == kJobsFolder) {  // its logs go on while this one is a job
      entry.disable_recursion_pending();
      continue;
    }
    if (IsBeingWritten(entry->path().string()))
      throw InputError(entry->path().string() + " is being written" + kChanges +
                       ", or remove it where a program on another machine has left it");
    if (!IsUploaded(name) || entry->symlink_status().type() == fs::file_type::directory) continue;
    RefuseUnlessFile(*entry, name);
    files.push_back(name.generic_string());
  }
  if (error) throw InputError(fmt::format("cannot read {}: {}", folder.string(), error.message()));
  if (files.empty())
    throw InputError(folder.string() + " holds no results; name the output folder of a run");
  std::sort(files.begin(), files.end());
  return files;
}

// With these settings, GDAL would not see our objects and would take all of them for absent.
void RefuseBlindGdal() {
  for (const char* setting : {"CPL_VSIL_CURL_ALLOWED_EXTENSIONS", "CPL_VSIL_CURL_ALLOWED_FILENAME"})
    if (CPLGetConfigOption(setting, nullptr) != nullptr)
      throw UsageError(fmt::format("{} is set, which hides objects; unset it", setting));
}

// Not on TBB's threads, of which there are as many as cores: these wait for the network.
template <typename Work>
void OnThreadsOfTheirOwn(std::size_t count, int threads, const Work& work) {
  FirstFailure failure;
  std::atomic<std::size_t> next = 0;
  {
    std::vector<std::jthread> workers;
    for (int k = 0; k < threads; ++k)
      workers.emplace_back([&] {
        for (std::size_t i = next++; i < count && !failure.IsBefore(i); i = next++) try {
            work(i);
          } catch (...) {
            failure.Keep(i);
          }
      });
  }
  failure.Rethrow();
}

std::string NewId() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}", random(), random());
}

// A local file and what is to become of it.
struct Planned {
  std::string name;
  UploadedFile contents = {};  // the digest only if the store has the same file
  fs::file_time_type changed = {};
  bool in_the_way =
      false;  // an object exists that neither this nor an interrupted upload has planned

  bool IsThere() const { return !contents.digest.empty(); }
};

class UploadRun {
 public:
  UploadRun(const fs::path& folder, const std::string& place, const UploadOptions& options,
            ProgressListener* progress)
      : folder_(folder), place_(place), options_(options), progress_(progress) {
    for (std::string& name : FilesOf(folder)) files_.emplace_back().name = std::move(name);
  }

  UploadSummary Run() {
    const auto before = ReadList();
    Compare(before.value_or(UploadedFiles{}));
    UploadSummary summary;
    for (const Planned& file : files_) ++(file.IsThere() ? summary.kept : summary.sent);
    if (summary.sent == 0 && before && before->complete && before->files == list_.files)
      return summary;
    if (ReadList() != before) ThrowAnother();
    PutList();
    SendAll(&summary);
    RefuseChanges();
    list_.complete = true;
    WriteList();
    return summary;
  }

 private:
  std::string Object(const std::string& name) const { return place_ + "/" + name; }
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  std::optional<UploadedFiles> ReadList() const {
    const std::string object = Object(kUploadList);
    const auto text = ReadObject(object);
    if (!text) return std::nullopt;
    return ReadUploadedFiles(*text, TypedObject(object));
  }

  // Finds what is there, plans what is to come, and refuses to replace what else is in the way.
  void Compare(const UploadedFiles& listed) {
    ProgressTask task(progress_, "comparing with the store", static_cast<int>(files_.size()));
    OnThreadsOfTheirOwn(files_.size(), options_.jobs, [&](std::size_t i) {
      Compare(listed, &files_[i]);
      task.Advance();
    });
    for (const Planned& file : files_) list_.files[file.name] = file.contents;
    std::vector<std::string> in_the_way;
    for (const Planned& file : files_)
      if (file.in_the_way) in_the_way.push_back(file.name);
    const auto unknown = [&](const auto& file) { return !list_.files.contains(file.first); };
    if (std::any_of(listed.files.begin(), listed.files.end(), unknown))
      in_the_way.emplace_back(kUploadList);  // the new list would no longer name them
    if (!in_the_way.empty() && !options_.overwrite) RefuseToReplace(in_the_way);
  }

  void Compare(const UploadedFiles& listed, Planned* file) const {
    file->contents.bytes = StateOf(file->name, &file->changed);
    const auto size = SizeOfObject(Object(file->name));
    const auto known = listed.files.find(file->name);
    const bool is_listed = known != listed.files.end();
    const bool as_listed = is_listed && size == known->second.bytes;
    if (as_listed && file->contents.bytes == known->second.bytes && !known->second.digest.empty() &&
        ReadLocal(Path(file->name)) == known->second)
      file->contents = known->second;
    const bool planned =
        is_listed && !listed.complete && (as_listed || known->second.digest.empty());
    file->in_the_way = size && !file->IsThere() && !planned;
  }

  [[noreturn]] void RefuseToReplace(const std::vector<std::string>& names) const {
    throw UsageError(
        fmt::format("{}{} would be replaced; use --overwrite, or name another place",
                    TypedObject(Object(names.front())),
                    names.size() > 1 ? fmt::format(" and {} more", names.size() - 1) : ""));
  }

  void SendAll(UploadSummary* summary) {
    ProgressTask task(progress_, "upload", static_cast<int>(summary->sent));
    try {
      OnThreadsOfTheirOwn(files_.size(), options_.jobs, [&](std::size_t i) {
        if (files_[i].IsThere()) return;
        Note(files_[i].name, Send(files_[i]), summary);
        task.Advance();
      });
    } catch (...) {
      NoteWhatArrived();
      throw;
    }
  }

  UploadedFile Send(const Planned& file) const {
    UploadedFile sent = PutFile(Path(file.name), Object(file.name));
    if (sent.bytes == file.contents.bytes && !HasChanged(file)) return sent;
    RemoveObject(Object(file.name));
    ThrowChanged(file.name);
  }

  // Bytes, and when they were last changed.
  std::uint64_t StateOf(const std::string& name, fs::file_time_type* changed) const {
    std::error_code error;
    *changed = fs::last_write_time(folder_ / name, error);
    const std::uintmax_t bytes = error ? 0 : fs::file_size(folder_ / name, error);
    if (error) throw InputError(fmt::format("cannot read {}: {}", Path(name), error.message()));
    return bytes;
  }

  bool HasChanged(const Planned& file) const {
    fs::file_time_type changed;
    return StateOf(file.name, &changed) != file.contents.bytes || changed != file.changed;
  }

  [[noreturn]] void ThrowChanged(const std::string& name) const {
    throw InputError(Path(name) + " has changed during the upload" + kChanges);
  }

  // Checked after everything was sent: the files sent first may have changed by now.
  void RefuseChanges() {
    const std::vector<std::string> now = FilesOf(folder_);
    const bool same =
        std::equal(now.begin(), now.end(), files_.begin(), files_.end(),
                   [](const std::string& name, const Planned& file) { return name == file.name; });
    if (!same)
      throw InputError(folder_.string() + " has gained or lost files during the upload" + kChanges);
    for (const Planned& file : files_) {
      if (!HasChanged(file)) continue;
      list_.files[file.name].digest.clear();
      NoteWhatArrived();
      ThrowChanged(file.name);
    }
  }

  // Now and then the list in the store is brought up to date.
  void Note(const std::string& name, const UploadedFile& sent, UploadSummary* summary) {
    constexpr std::chrono::seconds kSeldom(30);
    const std::lock_guard lock(mutex_);
    list_.files[name] = sent;
    summary->bytes_sent += sent.bytes;
    if (std::chrono::steady_clock::now() - written_ > kSeldom) WriteList();
  }

  void NoteWhatArrived() {
    try {
      WriteList();
    } catch (const std::exception&) {  // the failure that led here is the one to report
    }
  }

  void PutList() {
    PutText(Object(kUploadList), TextOf(list_));
    written_ = std::chrono::steady_clock::now();
  }

  // If another upload has put its list there meanwhile, neither is complete.
  void WriteList() {
    const auto now = ReadList();
    if (now && now->id == list_.id) return PutList();
    list_.complete = false;
    for (auto& [name, file] : list_.files) file.digest.clear();
    PutList();
    ThrowAnother();
  }

  [[noreturn]] void ThrowAnother() const {
    throw InputError(
        fmt::format("another upload writes to {}; wait until it has ended, and upload "
                    "again",
                    TypedObject(place_)));
  }

  fs::path folder_;
  std::string place_;
  UploadOptions options_;
  ProgressListener* progress_;
  std::vector<Planned> files_;
  std::mutex mutex_;                        // guards what follows, while files are sent
  UploadedFiles list_{NewId(), false, {}};  // files sent so far
  std::chrono::steady_clock::time_point written_;
};

}  // namespace

UploadSummary Upload(const std::string& folder, const std::string& place,
                     const UploadOptions& options, ProgressListener* progress) {
  RegisterGdalDrivers();
  RefuseBlindGdal();
  std::string bare = place;
  if (bare.ends_with('/')) bare.pop_back();
  return UploadRun(folder, bare, options, progress).Run();
}

}  // namespace orient
