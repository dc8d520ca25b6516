#include "tools/cluster/upload.h"

#include <cpl_vsi.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

#include "block/inputs/digest.h"
#include "core/base/environment_error.h"
#include "core/base/partial_files.h"
#include "core/base/quiet_gdal.h"
#include "core/base/remote_files.h"
#include "core/base/side_by_side.h"
#include "tools/cluster/uploaded_files.h"
#include "tools/report/html_text.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

struct CloseFile {
  void operator()(VSILFILE* file) const { VSIFCloseL(file); }
};

std::string TypedPlace(const std::string& object) { return WithoutSecrets(TypedName(object)); }

// Relative to the folder, in their order.
std::vector<std::string> FilesOf(const fs::path& folder) {
  std::vector<std::string> files;
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code broken_link;
    const std::string name = entry->path().filename().string();
    if (entry->is_regular_file(broken_link) && !IsPartialFile(name) && name != kUploadList)
      files.push_back(fs::relative(entry->path(), folder).string());
  }
  if (error) throw InputError(fmt::format("cannot read {}: {}", folder.string(), error.message()));
  for (const std::string& file : files)
    if (ValidText(file) != file)
      throw InputError((folder / file).string() +
                       " has a name that is not UTF-8, as an object's must be; rename it");
  if (files.empty())
    throw InputError(folder.string() + " holds no files; name the output folder of a run");
  std::sort(files.begin(), files.end());
  return files;
}

// Calls use(piece) for all of a local file; returns what the list says of it.
template <typename Use>
UploadedFile ReadInPieces(const fs::path& path, const Use& use) {
  std::ifstream file(path, std::ios::binary);
  std::string piece(std::size_t{1} << 20, '\0');
  block::DigestOfPieces digest;
  UploadedFile read;
  while (file.read(piece.data(), std::ssize(piece)) || file.gcount() > 0) {
    const std::string_view part(piece.data(), static_cast<std::size_t>(file.gcount()));
    digest.Add(part);
    read.bytes += part.size();
    if (!use(part)) break;
  }
  if (!file.is_open() || file.bad()) throw InputError("cannot read " + path.string());
  read.digest = digest.Digits();
  return read;
}

// The error of a store that does not take a file.
EnvironmentError Refused(const std::string& object, const QuietGdal& gdal) {
  return EnvironmentError(
      fmt::format("cannot write {}{}; what has arrived stays, and the same "
                  "command goes on. Where it never succeeds, check the name of "
                  "the bucket, the credentials and their right to write",
                  TypedPlace(object), WithoutSecrets(gdal.Message())));
}

// One attempt. Nothing is there before it is closed without an error.
template <typename Write>
bool Put(const std::string& object, const Write& write) {
  std::unique_ptr<VSILFILE, CloseFile> file(VSIFOpenL(object.c_str(), "wb"));
  if (!file) return false;
  const bool written = write(file.get());
  return VSIFCloseL(file.release()) == 0 && written;
}

void PutText(const std::string& object, const std::string& text) {
  const QuietGdal gdal;
  const bool done = Patiently([&] {
    return Put(object, [&](VSILFILE* file) {
      return VSIFWriteL(text.data(), 1, text.size(), file) == text.size();
    });
  });
  if (!done) throw Refused(object, gdal);
}

// Returns what was sent.
UploadedFile PutFile(const fs::path& path, const std::string& object) {
  const QuietGdal gdal;
  UploadedFile sent;
  const bool done = Patiently([&] {
    return Put(object, [&](VSILFILE* file) {
      bool written = true;
      sent = ReadInPieces(path, [&](std::string_view piece) {
        return written = VSIFWriteL(piece.data(), 1, piece.size(), file) == piece.size();
      });
      return written;
    });
  });
  if (!done) throw Refused(object, gdal);
  return sent;
}

// Of an object; empty where there is none.
std::optional<std::uint64_t> SizeOf(const std::string& object) {
  return Watched([&]() -> std::optional<std::uint64_t> {
    const QuietGdal quiet;
    VSIStatBufL status{};
    if (VSIStatL(object.c_str(), &status) != 0 || VSI_ISDIR(status.st_mode)) return std::nullopt;
    return static_cast<std::uint64_t>(status.st_size);
  });
}

std::optional<UploadedFiles> ReadListAt(const std::string& object) {
  if (!SizeOf(object)) return std::nullopt;
  const auto text = Watched([&]() -> std::optional<std::string> {
    const QuietGdal quiet;
    GByte* bytes = nullptr;
    vsi_l_offset size = 0;
    constexpr GIntBig kMost = 1 << 30;
    if (VSIIngestFile(nullptr, object.c_str(), &bytes, &size, kMost) == 0) return std::nullopt;
    const std::unique_ptr<GByte, decltype(&VSIFree)> owned(bytes, &VSIFree);
    return std::string(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(size));
  });
  if (!text) throw InputError("cannot read " + TypedPlace(object));
  return ReadUploadedFiles(*text, TypedPlace(object));
}

// A local file and what is to become of it.
struct File {
  std::string name;
  UploadedFile contents;
  bool there = false;     // the same lies in the store
  bool replaces = false;  // something else does, which no interrupted upload has left
};

class UploadRun {
 public:
  UploadRun(const std::string& folder, const std::string& place, ProgressListener* progress)
      : folder_(folder), place_(place), progress_(progress) {
    for (std::string& name : FilesOf(folder_)) files_.emplace_back().name = std::move(name);
  }

  UploadSummary Run(bool overwrite) {
    const auto before = ReadListAt(Object(kUploadList));
    Compare(before);
    if (!overwrite) RefuseToReplace();
    UploadSummary summary;
    for (const File& file : files_) {
      ++(file.there ? summary.kept : summary.sent);
      summary.bytes_sent += file.there ? 0 : file.contents.bytes;
      if (file.there) list_.files[file.name] = file.contents;
    }
    const bool same = before && before->complete && before->files == list_.files;
    if (summary.sent == 0 && same) return summary;
    WriteList();
    SendAll(summary.sent);
    list_.complete = true;
    WriteList();
    return summary;
  }

 private:
  std::string Object(const std::string& name) const { return place_ + "/" + name; }

  // Tells what is there, and what is in the way.
  void Compare(const std::optional<UploadedFiles>& before) {
    const UploadedFiles listed = before.value_or(UploadedFiles{});
    const bool left_by_us = before && !before->complete;  // by an upload that was interrupted
    ProgressTask task(progress_, "compared with the store", static_cast<int>(files_.size()));
    SideBySide(files_.size(), [&](std::size_t i) {
      File& file = files_[i];
      file.contents = ReadInPieces(folder_ / file.name, [](std::string_view) { return true; });
      const auto size = SizeOf(Object(file.name));
      const auto known = listed.files.find(file.name);
      file.there = known != listed.files.end() && known->second == file.contents &&
                   size == file.contents.bytes;
      file.replaces = !file.there && size && !left_by_us;
      task.Advance();
    });
  }

  void RefuseToReplace() const {
    const auto replaces = [](const File& file) { return file.replaces; };
    const auto first = std::find_if(files_.begin(), files_.end(), replaces);
    if (first == files_.end()) return;
    const auto more = std::count_if(std::next(first), files_.end(), replaces);
    throw UsageError(fmt::format("{}{} would be replaced; use --overwrite, or name another place",
                                 TypedPlace(Object(first->name)),
                                 more > 0 ? fmt::format(" and {} more", more) : ""));
  }

  void SendAll(std::size_t count) {
    ProgressTask task(progress_, "upload", static_cast<int>(count));
    const auto send = [&](const File& file) {
      if (PutFile(folder_ / file.name, Object(file.name)) != file.contents)
        throw InputError(
            fmt::format("{} has changed while it was sent; upload when nothing writes "
                        "into the folder any more",
                        (folder_ / file.name).string()));
      Note(file);
      task.Advance();
    };
    try {
      SideBySide(files_.size(), [&](std::size_t i) {
        if (!files_[i].there) send(files_[i]);
      });
    } catch (...) {
      NoteWhatArrived();
      throw;
    }
  }

  // Now and then the list in the store is brought up to date.
  void Note(const File& file) {
    constexpr std::chrono::seconds kSeldom(30);
    const std::lock_guard lock(mutex_);
    list_.files[file.name] = file.contents;
    if (std::chrono::steady_clock::now() - written_ > kSeldom) WriteList();
  }

  void NoteWhatArrived() {
    try {
      WriteList();
    } catch (const std::exception&) {  // the failure that led here is the one to be told
    }
  }

  void WriteList() {
    PutText(Object(kUploadList), TextOf(list_));
    written_ = std::chrono::steady_clock::now();
  }

  fs::path folder_;
  std::string place_;
  ProgressListener* progress_;
  std::vector<File> files_;
  std::mutex mutex_;
  UploadedFiles list_;  // as far as it has come
  std::chrono::steady_clock::time_point written_;
};

}  // namespace

bool IsStore(const std::string& gdal_name) {
  constexpr std::array<std::string_view, 3> kStores = {"/vsis3/", "/vsigs/", "/vsiaz/"};
  return std::any_of(kStores.begin(), kStores.end(), [&](std::string_view store) {
    return gdal_name.starts_with(store) && gdal_name.size() > store.size();
  });
}

UsageError NoStore(const std::string& place) {
  return UsageError(WithoutSecrets(place) +
                    " is no object storage; name a place such as s3://bucket/folder, "
                    "gs://bucket/folder or az://container/folder");
}

UploadSummary Upload(const std::string& folder, const std::string& place,
                     const UploadOptions& options, ProgressListener* progress) {
  RegisterGdalDrivers();
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored))
    throw InputError(folder + " is no folder; name the output folder of a run");
  std::string bare = place;
  while (bare.ends_with('/')) bare.pop_back();
  UploadSummary summary;
  OnThreads(options.jobs,
            [&] { summary = UploadRun(folder, bare, progress).Run(options.overwrite); });
  return summary;
}

}  // namespace orient
