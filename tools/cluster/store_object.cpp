#include "tools/cluster/store_object.h"

#include <cpl_conv.h>
#include <cpl_vsi.h>
#include <cpl_vsi_error.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string_view>

#include "block/inputs/digest.h"
#include "core/base/environment_error.h"
#include "core/base/quiet_gdal.h"
#include "core/base/remote_files.h"

namespace orient {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;
constexpr std::uint64_t kLeastPart = 5 << 20;  // of an object in several parts

struct CloseObject {
  void operator()(VSILFILE* file) const { VSIFCloseL(file); }
};
using Object = std::unique_ptr<VSILFILE, CloseObject>;

struct CloseLocal {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

class LocalFile {
 public:
  explicit LocalFile(const std::string& path) : path_(path), file_(std::fopen(path.c_str(), "rb")) {
    if (!file_) Fail();
  }

  std::uint64_t Bytes() const {
    struct stat state {};
    return fstat(fileno(file_.get()), &state) == 0 ? static_cast<std::uint64_t>(state.st_size) : 0;
  }

  // Calls use(piece) for all of it, as long as it says true.
  template <typename Use>
  UploadedFile Read(const Use& use) {
    std::rewind(file_.get());
    std::string piece(kPiece, '\0');
    block::DigestOfPieces digest;
    UploadedFile read;
    for (bool go_on = true; go_on;) {
      errno = 0;
      const std::size_t count = std::fread(piece.data(), 1, kPiece, file_.get());
      if (std::ferror(file_.get()) != 0) Fail();
      const std::string_view part(piece.data(), count);
      digest.Add(part);
      read.bytes += count;
      go_on = count > 0 && use(part);
    }
    read.digest = digest.Digits();
    return read;
  }

 private:
  [[noreturn]] void Fail() const {
    const int error = errno;
    const std::string what = fmt::format("cannot read {}: {}", path_, std::strerror(error));
    if (IsOfEnvironment(error)) throw EnvironmentError(what);
    throw InputError(what);
  }

  std::string path_;
  std::unique_ptr<std::FILE, CloseLocal> file_;
};

EnvironmentError Refused(const std::string& object, const QuietGdal& gdal) {
  return EnvironmentError(
      fmt::format("cannot write {}{}; what has arrived stays, and the same "
                  "command goes on. Where it never succeeds, check the name of "
                  "the bucket, the credentials and their right to write",
                  TypedObject(object), WithoutSecrets(gdal.Message())));
}

// Whether the last byte can be read back. A store may say that it has an object of several parts
// and, in the same answer, that it could not put them together.
bool IsWhole(const std::string& object, std::uint64_t bytes) {
  if (bytes <= kLeastPart) return true;
  const CPLConfigOptionSetter no_listing("GDAL_DISABLE_READDIR_ON_OPEN", "TRUE", false);
  const Object file(VSIFOpenL(object.c_str(), "rb"));
  char last = 0;
  return file && VSIFSeekL(file.get(), 0, SEEK_END) == 0 && VSIFTellL(file.get()) == bytes &&
         VSIFSeekL(file.get(), bytes - 1, SEEK_SET) == 0 && VSIFReadL(&last, 1, 1, file.get()) == 1;
}

// One attempt. The object is not there before it is closed without an error.
template <typename Write>
bool Put(const std::string& object, const Write& write) {
  Object file(VSIFOpenL(object.c_str(), "wb"));
  if (!file) return false;
  const bool written = write(file.get());
  return VSIFCloseL(file.release()) == 0 && written;
}

// Another program may have written it since GDAL has asked. Objects that are opened "not cached"
// are forgotten when they are closed.
void Forget(const std::string& object) {
  const CPLConfigOptionSetter not_cached("CPL_VSIL_CURL_NON_CACHED", "/vsis3/:/vsigs/:/vsiaz/",
                                         false);
  const Object file(VSIFOpenL(object.c_str(), "rb"));
}

// That the server refuses to say what is there.
void ThrowIfForbidden(const std::string& object) {
  if (LastRemoteAnswer() == RemoteAnswer::kForbidden)
    throw InputError(fmt::format(
        "{} cannot be read ({}); check the credentials, and their right to read and list",
        TypedObject(object), VSIGetLastErrorMsg()));
}

}  // namespace

bool IsStore(const std::string& gdal_name) {
  constexpr std::array<std::string_view, 3> kStores = {"/vsis3/", "/vsigs/", "/vsiaz/"};
  const auto store = std::find_if(kStores.begin(), kStores.end(),
                                  [&](std::string_view one) { return gdal_name.starts_with(one); });
  if (store == kStores.end() || gdal_name.find('?') != std::string::npos) return false;
  std::string_view rest = std::string_view(gdal_name).substr(store->size());
  if (rest.ends_with('/')) rest.remove_suffix(1);
  while (true) {
    const std::string_view part = rest.substr(0, rest.find('/'));
    if (part.empty() || part == "." || part == "..") return false;
    if (part.size() == rest.size()) return true;
    rest.remove_prefix(part.size() + 1);
  }
}

UsageError NoStore(const std::string& place) {
  return UsageError(WithoutSecrets(place) +
                    " is no object storage; name a place such as s3://bucket/folder, "
                    "gs://bucket/folder or az://container/folder");
}

std::string TypedObject(const std::string& object) { return WithoutSecrets(TypedName(object)); }

std::optional<std::uint64_t> SizeOfObject(const std::string& object) {
  return Watched([&]() -> std::optional<std::uint64_t> {
    const QuietGdal quiet;
    VSIStatBufL status{};
    VSIErrorReset();
    if (VSIStatL(object.c_str(), &status) != 0) {
      ThrowIfForbidden(object);
      return std::nullopt;
    }
    if (VSI_ISDIR(status.st_mode)) return std::nullopt;
    return static_cast<std::uint64_t>(status.st_size);
  });
}

std::optional<std::string> ReadObject(const std::string& object) {
  Watched([&] {
    const QuietGdal quiet;
    Forget(object);
    return true;
  });
  const auto size = SizeOfObject(object);
  if (!size) return std::nullopt;
  constexpr std::uint64_t kMost = 256 << 20;
  auto text = Watched([&]() -> std::optional<std::string> {
    const QuietGdal quiet;
    const CPLConfigOptionSetter no_listing("GDAL_DISABLE_READDIR_ON_OPEN", "TRUE", false);
    const Object file(VSIFOpenL(object.c_str(), "rb"));
    std::string read(std::min(*size, kMost), '\0');
    if (!file || VSIFReadL(read.data(), 1, read.size(), file.get()) != read.size())
      return std::nullopt;
    return read;
  });
  if (!text) throw InputError("cannot read " + TypedObject(object));
  return text;
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

UploadedFile PutFile(const std::string& path, const std::string& object) {
  const QuietGdal gdal;
  LocalFile local(path);  // before the object: one that is not there must not empty it
  // One that is there must not be taken for what could not be put together.
  if (local.Bytes() > kLeastPart) RemoveObject(object);
  UploadedFile sent;
  const auto write = [&](VSILFILE* file) {
    bool written = true;
    sent = local.Read([&](std::string_view piece) {
      return written = VSIFWriteL(piece.data(), 1, piece.size(), file) == piece.size();
    });
    return written;
  };
  bool done = false;
  try {
    done = Patiently([&] { return Put(object, write) && IsWhole(object, sent.bytes); });
  } catch (...) {  // the half that was read has become the object
    RemoveObject(object);
    throw;
  }
  if (!done) throw Refused(object, gdal);
  return sent;
}

void RemoveObject(const std::string& object) {
  const QuietGdal quiet;
  VSIUnlink(object.c_str());
}

UploadedFile ReadLocal(const std::string& path) {
  return LocalFile(path).Read([](std::string_view) { return true; });
}

}  // namespace orient
