#include "tools/cluster/upload.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
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
  return *name.begin() != "slurm" && name != kUploadList && !file.starts_with(".orient-") &&
         !IsPartialFile(file);
}

// Throws InputError for what an upload would have to leave out.
void RefuseUnlessFile(const fs::directory_entry& entry, const fs::path& name) {
  const std::string path = entry.path().string();
  std::error_code error;
  if (entry.status(error).type() == fs::file_type::directory)
    throw InputError(path + " is a link to a folder, which is not followed; replace it by a copy");
  if (entry.status(error).type() != fs::file_type::regular)
    throw InputError(fmt::format("{} cannot be uploaded: {}", path,
                                 error ? error.message() : "it is no file, or leads to none"));
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
    if (IsBeingWritten(name.filename().string()))
      throw InputError(entry->path().string() + " is being written" + kChanges);
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

// GDAL would see no other objects, and take all of ours for absent.
void RefuseBlindGdal() {
  for (const char* setting : {"CPL_VSIL_CURL_ALLOWED_EXTENSIONS", "CPL_VSIL_CURL_ALLOWED_FILENAME"})
    if (std::getenv(setting) != nullptr)
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

class UploadRun {
 public:
  UploadRun(const fs::path& folder, const std::string& place, const UploadOptions& options,
            ProgressListener* progress)
      : folder_(folder),
        place_(place),
        options_(options),
        progress_(progress),
        names_(FilesOf(folder)),
        there_(names_.size()),
        changed_(names_.size()) {}

  UploadSummary Run() {
    const auto before = ReadList();
    Compare(before);
    UploadSummary summary;
    summary.kept = static_cast<std::size_t>(std::count(there_.begin(), there_.end(), true));
    summary.sent = names_.size() - summary.kept;
    if (summary.sent == 0 && before->complete && before->files == list_.files) return summary;
    WriteList();
    SendAll(&summary);
    if (FilesOf(folder_) != names_)
      throw InputError(folder_.string() + " has got, or lost, files meanwhile" + kChanges);
    const auto now = ReadList();
    if (!now || now->id != list_.id)
      throw InputError(
          fmt::format("another upload writes to {}; wait until it has ended, and "
                      "upload again with --overwrite",
                      TypedObject(place_)));
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

  // Tells what is there, plans what is to come, and refuses to replace what else lies in the way.
  void Compare(const std::optional<UploadedFiles>& before) {
    const UploadedFiles listed = before.value_or(UploadedFiles{});
    std::vector<UploadedFile> planned(names_.size());
    std::vector<char> replaces(names_.size()), there(names_.size());
    ProgressTask task(progress_, "comparing with the store", static_cast<int>(names_.size()));
    OnThreadsOfTheirOwn(names_.size(), options_.jobs, [&](std::size_t i) {
      const auto known = listed.files.find(names_[i]);
      const bool is_listed = known != listed.files.end();
      const auto size = SizeOfObject(Object(names_[i]));
      planned[i].bytes = StateOf(names_[i], &changed_[i]);
      if (is_listed && size == known->second.bytes && size == planned[i].bytes &&
          ReadLocal(Path(names_[i])) == known->second) {
        planned[i] = known->second;
        there[i] = 1;
      }
      replaces[i] = there[i] == 0 && size && (!is_listed || listed.complete);
      task.Advance();
    });
    std::vector<std::string> in_the_way;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      there_[i] = there[i] != 0;
      list_.files[names_[i]] = planned[i];
      if (replaces[i] != 0) in_the_way.push_back(names_[i]);
    }
    const auto unknown = [&](const auto& file) { return !list_.files.contains(file.first); };
    if (std::any_of(listed.files.begin(), listed.files.end(), unknown))
      in_the_way.emplace_back(kUploadList);  // would name them no more
    if (!in_the_way.empty() && !options_.overwrite) RefuseToReplace(in_the_way);
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
      OnThreadsOfTheirOwn(names_.size(), options_.jobs, [&](std::size_t i) {
        if (there_[i]) return;
        const UploadedFile sent = Send(i);
        Note(names_[i], sent, summary);
        task.Advance();
      });
    } catch (...) {
      NoteWhatArrived();
      throw;
    }
  }

  // The file as it was when the run began, or an error.
  UploadedFile Send(std::size_t i) const {
    const std::string &name = names_[i], path = Path(name);
    UploadedFile sent = PutFile(path, Object(name));
    fs::file_time_type changed;
    if (StateOf(name, &changed) == sent.bytes && changed == changed_[i] &&
        sent.bytes == list_.files.at(name).bytes)
      return sent;
    RemoveObject(Object(name));
    throw InputError(path + " has changed while it was sent" + kChanges);
  }

  // Bytes, and when they were last changed.
  std::uint64_t StateOf(const std::string& name, fs::file_time_type* changed) const {
    std::error_code error;
    *changed = fs::last_write_time(folder_ / name, error);
    const std::uintmax_t bytes = error ? 0 : fs::file_size(folder_ / name, error);
    if (error) throw InputError(fmt::format("cannot read {}: {}", Path(name), error.message()));
    return bytes;
  }

  // Now and then the list in the store is brought up to date.
  void Note(const std::string& name, const UploadedFile& sent, UploadSummary* summary) {
    constexpr std::chrono::seconds kSeldom(30);
    const std::lock_guard lock(mutex_);
    arrived_.emplace_back(name, sent);
    summary->bytes_sent += sent.bytes;
    if (std::chrono::steady_clock::now() - written_ > kSeldom) WriteList();
  }

  void NoteWhatArrived() {
    try {
      WriteList();
    } catch (const std::exception&) {  // the failure that led here is the one to be told
    }
  }

  void WriteList() {
    UploadedFiles now = list_;
    for (const auto& [name, sent] : arrived_) now.files[name] = sent;
    PutText(Object(kUploadList), TextOf(now));
    written_ = std::chrono::steady_clock::now();
  }

  fs::path folder_;
  std::string place_;
  UploadOptions options_;
  ProgressListener* progress_;
  std::vector<std::string> names_;
  std::vector<bool> there_;  // whether the store has the same
  std::vector<fs::file_time_type> changed_;
  UploadedFiles list_{NewId(), false, {}};  // as planned
  std::mutex mutex_;
  std::vector<std::pair<std::string, UploadedFile>> arrived_;
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
