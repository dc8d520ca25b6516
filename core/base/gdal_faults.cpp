#include "core/base/gdal_faults.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <cpl_vsi_virtual.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string_view>

#include "core/base/environment_error.h"
#include "core/base/geopackage/sqlite_faults.h"
#include "core/base/remote_files.h"

namespace orient {
namespace {

// Like errno: the last fault of this thread, and the number of faults so far.
struct Faults {
  std::size_t files = 0, memory = 0;
  std::string what;
};

Faults& OfThisThread() {
  thread_local Faults faults;
  return faults;
}

void Note(const char* doing, const std::string& path, const char* why) {
  Faults& faults = OfThisThread();
  ++faults.files;
  faults.what = fmt::format("cannot {} {}: {}", doing, path, why);
}

void Note(const char* doing, const std::string& path, int error) {
  if (IsOfEnvironment(error)) Note(doing, path, std::strerror(error));
}

// GDAL caches the first part of an interrupted reply, and "no such file" after a refused request.
// What it has cached of a remote file is dropped when a handle opened as "not cached" is closed
// (VSICurlPartialClearCache() knows only GDAL's own handlers, not those that watch them).
void Forget(VSIFilesystemHandler* files, const char* path) {
  const CPLConfigOptionSetter not_cached(
      "CPL_VSIL_CURL_NON_CACHED", "/vsicurl/http:/vsicurl/https:/vsis3/:/vsigs/:/vsiaz/", false);
  delete files->Open(path, "rb", false, nullptr);
}

class WatchedFile final : public VSIVirtualHandle {
 public:
  // `files`: the handler that opened `file`; with it a remote file can be opened again.
  WatchedFile(VSIVirtualHandle* file, VSIFilesystemHandler* files, const char* path, bool writes,
              bool remote)
      : file_(file), files_(files), path_(path), writes_(writes), remote_(remote) {
    if (remote) remote_size_ = SizeOf(*file_);
  }

  size_t Read(void* bytes, size_t size, size_t count) override {
    if (broken_) return 0;
    const vsi_l_offset at = file_->Tell();
    size_t done = file_->Read(bytes, size, count);
    // libtiff crashes if it cannot read back what it has just written.
    if (done < count && writes_ && file_->Eof() == 0 && file_->Seek(at, SEEK_SET) == 0)
      done = file_->Read(bytes, size, count);
    if (done < count && remote_ && !IsAtEnd())
      WithRetries([&] {
        auto again = OpenAgain();
        if (again == nullptr || again->Seek(at, SEEK_SET) != 0) return false;
        file_ = std::move(again);
        done = file_->Read(bytes, size, count);
        return done == count || IsAtEnd();
      });
    if (done < count && (remote_ ? !IsAtEnd() : file_->Eof() == 0 && IsRegular()))
      Note("read", path_, EIO);
    return done;
  }
  int ReadMultiRange(int count, void** data, const vsi_l_offset* at, const size_t* sizes) override {
    // Ranges are read together only if that is faster (remote files); local ones go through Read.
    if (!remote_) return VSIVirtualHandle::ReadMultiRange(count, data, at, sizes);
    // GDAL does not retry ranges read together, and one of many is easily refused: then one by one.
    int result = file_->ReadMultiRange(count, data, at, sizes);
    if (result != 0) result = VSIVirtualHandle::ReadMultiRange(count, data, at, sizes);
    if (result != 0) Note("read", path_, EIO);
    return result;
  }
  size_t PRead(void* bytes, size_t size, vsi_l_offset at) const override {
    errno = 0;
    size_t done = file_->PRead(bytes, size, at);
    if (!remote_) {
      if (done != size) Note("read", path_, errno);
      return done;
    }
    const size_t there = at < remote_size_ ? std::min<vsi_l_offset>(size, remote_size_ - at) : 0;
    if (done < there)
      WithRetries([&] {
        const auto again = OpenAgain();
        if (again != nullptr) done = again->PRead(bytes, size, at);
        return done >= there;
      });
    if (done < there) Note("read", path_, EIO);
    return done;
  }
  size_t Write(const void* bytes, size_t size, size_t count) override {
    errno = 0;
    const size_t done = file_->Write(bytes, size, count);
    broken_ = broken_ || done < count;
    if (done < count) Note("write", path_, errno);
    return done;
  }
  int Flush() override {
    return Noted([&] { return file_->Flush(); });
  }
  int Close() override {
    return Noted([&] { return file_->Close(); });
  }
  int Truncate(vsi_l_offset size) override {
    return Noted([&] { return file_->Truncate(size); });
  }

  int Seek(vsi_l_offset at, int from) override { return file_->Seek(at, from); }
  vsi_l_offset Tell() override { return file_->Tell(); }
  int Eof() override { return file_->Eof(); }
  bool HasPRead() const override { return file_->HasPRead(); }
  void* GetNativeFileDescriptor() override { return file_->GetNativeFileDescriptor(); }
  VSIRangeStatus GetRangeStatus(vsi_l_offset at, vsi_l_offset size) override {
    return file_->GetRangeStatus(at, size);
  }

 private:
  // Null if the server does not answer, or its file now has another size.
  std::unique_ptr<VSIVirtualHandle> OpenAgain() const {
    Forget(files_, path_.c_str());
    std::unique_ptr<VSIVirtualHandle> again(files_->Open(path_.c_str(), "rb", true, nullptr));
    if (again != nullptr && SizeOf(*again) != remote_size_) again.reset();
    return again;
  }

  static vsi_l_offset SizeOf(VSIVirtualHandle& file) {
    file.Seek(0, SEEK_END);
    const vsi_l_offset size = file.Tell();
    file.Seek(0, SEEK_SET);
    return size;
  }

  template <class Work>
  int Noted(const Work& work) {
    errno = 0;
    const int result = work();
    if (result != 0) Note("write", path_, errno);
    return result;
  }

  // Excludes folders, which cannot be read either.
  bool IsRegular() {
    struct stat info {};
    const auto descriptor = reinterpret_cast<std::intptr_t>(file_->GetNativeFileDescriptor());
    return fstat(static_cast<int>(descriptor), &info) == 0 && S_ISREG(info.st_mode);
  }

  // By the size, as GDAL reports the end of the file also if the server does not answer.
  bool IsAtEnd() { return file_->Tell() >= remote_size_; }

  std::unique_ptr<VSIVirtualHandle> file_;
  VSIFilesystemHandler* files_;
  std::string path_;
  bool writes_, remote_;
  vsi_l_offset remote_size_ = 0;  // as it was when the file was opened
  // A write has failed: libtiff would search for ever for what it believes it has written.
  bool broken_ = false;
};

// Wraps one of GDAL's file handlers: forwards all calls, and watches the files that it opens.
class WatchedFiles final : public VSIFilesystemHandler {
 public:
  WatchedFiles(VSIFilesystemHandler* files, bool remote) : files_(files), remote_(remote) {}

  VSIVirtualHandle* Open(const char* path, const char* access, bool tell,
                         CSLConstList options) override {
    VSIVirtualHandle* file = nullptr;
    int error = 0;
    const auto open = [&] {
      errno = 0;
      VSIErrorReset();
      file = files_->Open(path, access, tell || remote_, options);
      error = errno;
      return file != nullptr || !remote_ || !Unanswered();
    };
    if (!open()) WithRetries([&] { return Forget(files_.get(), path), open(); });
    const bool writes = std::strpbrk(access, "wa+") != nullptr;
    if (file != nullptr) return new WatchedFile(file, files_.get(), path, writes, remote_);
    if (!remote_) {
      Note("open", path, error);
    } else if (Unanswered()) {
      Note("open", path, VSIGetLastErrorMsg());
      Forget(files_.get(), path);
    }
    errno = error;
    return nullptr;
  }
  int Stat(const char* path, VSIStatBufL* status, int flags) override {
    if (!remote_) return files_->Stat(path, status, flags);
    int result = -1;
    const auto ask = [&] {
      VSIErrorReset();
      // If asked for the size at once, GDAL reports a request without an answer as a missing file.
      result = files_->Stat(path, status, (flags & ~VSI_STAT_SIZE_FLAG) | VSI_STAT_SET_ERROR_FLAG);
      if (result == 0 && (flags & VSI_STAT_SIZE_FLAG) != 0)
        result = files_->Stat(path, status, flags | VSI_STAT_SET_ERROR_FLAG);
      return result == 0 || !Unanswered();
    };
    if (!ask() && !WithRetries([&] { return Forget(files_.get(), path), ask(); })) {
      Note("ask for", path, VSIGetLastErrorMsg());
      Forget(files_.get(), path);
    }
    return result;
  }
  int Unlink(const char* path) override { return files_->Unlink(path); }
  int Rename(const char* from, const char* to) override { return files_->Rename(from, to); }
  int Mkdir(const char* path, long mode) override { return files_->Mkdir(path, mode); }
  int Rmdir(const char* path) override { return files_->Rmdir(path); }
  char** ReadDirEx(const char* path, int most) override { return files_->ReadDirEx(path, most); }
  VSIDIR* OpenDir(const char* path, int depth, const char* const* options) override {
    return files_->OpenDir(path, depth, options);
  }
  int IsCaseSensitive(const char* path) override { return files_->IsCaseSensitive(path); }
  GIntBig GetDiskFreeSpace(const char* path) override { return files_->GetDiskFreeSpace(path); }
  int SupportsSparseFiles(const char* path) override { return files_->SupportsSparseFiles(path); }
  int HasOptimizedReadMultiRange(const char* path) override {
    return files_->HasOptimizedReadMultiRange(path);
  }
  bool IsLocal(const char* path) override { return files_->IsLocal(path); }
  const char* GetActualURL(const char* path) override { return files_->GetActualURL(path); }
  const char* GetOptions() override { return files_->GetOptions(); }

 private:
  static bool Unanswered() { return LastRemoteAnswer() == RemoteAnswer::kUnanswered; }

  std::unique_ptr<VSIFilesystemHandler> files_;
  bool remote_;
};

}  // namespace

RemoteAnswer LastRemoteAnswer() {
  switch (VSIGetLastErrorNo()) {  // set by object stores that give a reason
    case VSIE_AWSObjectNotFound:
    case VSIE_AWSBucketNotFound:
      return RemoteAnswer::kNotThere;
    case VSIE_AWSAccessDenied:
    case VSIE_AWSInvalidCredentials:
    case VSIE_AWSSignatureDoesNotMatch:
      return RemoteAnswer::kForbidden;
    default:
      break;
  }
  const std::string_view said = VSIGetLastErrorMsg();
  if (said.empty()) return RemoteAnswer::kNothingSaid;
  constexpr std::string_view kCode = "response code: ";
  const std::size_t at = said.find(kCode);
  const std::string_view code =
      at == std::string_view::npos ? std::string_view() : said.substr(at + kCode.size(), 3);
  if (code == "404" || code == "410") return RemoteAnswer::kNotThere;
  return code == "401" || code == "403" ? RemoteAnswer::kForbidden : RemoteAnswer::kUnanswered;
}

void ForgetRemoteFile(const std::string& path) {
  Forget(VSIFileManager::GetHandler(path.c_str()), path.c_str());
}

void WatchGdalFiles() {
  ConfigureRemoteAccess();
  WatchSqliteFiles(
      [](const char* doing, const char* path, int error) { Note(doing, path, error); });
  // NOLINTNEXTLINE(clang-analyzer-cplusplus.NewDeleteLeaks): handlers are GDAL's once installed
  for (const char* place : {"", "/vsicurl/", "/vsis3/", "/vsigs/", "/vsiaz/"}) {
    VSIFilesystemHandler* files = VSIFileManager::GetHandler(place);
    const bool remote = *place != '\0';
    // GDAL built without network support returns the local handler, which is watched already.
    if (remote && files == VSIFileManager::GetHandler("")) continue;
    auto owned = std::make_unique<WatchedFiles>(files, remote);
    WatchedFiles* watched = owned.release();  // GDAL's, as `files` was
    VSIFileManager::InstallHandler(place, watched);
    if (VSIFileManager::GetHandler("/vsicurl?") == files)  // the same one by another name
      VSIFileManager::InstallHandler("/vsicurl?", watched);
  }
}

void NoteGdalError(int number, const char* text) {
  const std::string_view said = text;
  for (const char* memory : {"memory", "No space for", "annot allocate"})
    if (number == CPLE_OutOfMemory || said.find(memory) != std::string_view::npos) {
      ++OfThisThread().memory;
      return;
    }
}

GdalFaults::GdalFaults()
    : files_before_(OfThisThread().files), memory_before_(OfThisThread().memory) {}

void GdalFaults::ThrowIfAny() const {
  if (OfThisThread().files > files_before_) throw EnvironmentError(OfThisThread().what);
  if (OutOfMemory()) ThrowIfOutOfResources();
}

bool GdalFaults::OutOfMemory() const { return OfThisThread().memory > memory_before_; }

}  // namespace orient
