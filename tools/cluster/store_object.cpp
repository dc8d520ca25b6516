#include "tools/cluster/store_object.h"

#include <cpl_conv.h>
#include <cpl_vsi.h>
#include <cpl_vsi_error.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <string_view>
#include <system_error>

#include "block/inputs/digest.h"
#include "core/base/atomic_write.h"
#include "core/base/environment_error.h"
#include "core/base/quiet_gdal.h"
#include "core/base/remote_files.h"

namespace orient {
namespace {

constexpr std::uint64_t kLeastPart = 5 << 20;  // of an object in several parts

struct CloseObject {
  void operator()(VSILFILE* file) const { VSIFCloseL(file); }
};
using Object = std::unique_ptr<VSILFILE, CloseObject>;

// Opens without listing the folder, a list that GDAL would copy at every later query.
Object OpenToRead(const std::string& object) {
  const CPLConfigOptionSetter no_listing("GDAL_DISABLE_READDIR_ON_OPEN", "TRUE", false);
  return Object(VSIFOpenL(object.c_str(), "rb"));
}

// Calls use(piece) for all of a local file, as long as it returns true.
template <typename Use>
UploadedFile ReadPieces(FilePieces* pieces, const Use& use) {
  block::DigestOfPieces digest;
  UploadedFile read;
  pieces->Rewind();
  for (auto piece = pieces->Next(); !piece.empty(); piece = pieces->Next()) {
    digest.Add(piece);
    read.bytes += piece.size();
    if (!use(piece)) break;
  }
  read.digest = digest.Digits();
  return read;
}

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
  const Object file = OpenToRead(object);
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

// Throws InputError if the server refuses to say what is there.
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
                    " is not in object storage; name a place such as s3://bucket/folder, "
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
    ForgetRemoteFile(object);
    return true;
  });
  const auto size = SizeOfObject(object);
  if (!size) return std::nullopt;
  constexpr std::uint64_t kMost = 256 << 20;
  auto text = Watched([&]() -> std::optional<std::string> {
    const QuietGdal quiet;
    const Object file = OpenToRead(object);
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
  const bool done = WithRetries([&] {
    return Put(object, [&](VSILFILE* file) {
      return VSIFWriteL(text.data(), 1, text.size(), file) == text.size();
    });
  });
  if (!done) throw Refused(object, gdal);
}

UploadedFile PutFile(const std::string& path, const std::string& object) {
  const QuietGdal gdal;
  FilePieces local(path);  // opened before the object: a missing file must not empty it
  std::error_code vanished;
  const std::uintmax_t bytes = std::filesystem::file_size(path, vanished);
  // An existing object must not be mistaken for the new one if that one's parts cannot be joined.
  if (!vanished && bytes > kLeastPart) RemoveObject(object);
  UploadedFile sent;
  const auto write = [&](VSILFILE* file) {
    bool written = true;
    sent = ReadPieces(&local, [&](std::string_view piece) {
      return written = VSIFWriteL(piece.data(), 1, piece.size(), file) == piece.size();
    });
    return written;
  };
  bool done = false;
  try {
    done = WithRetries([&] { return Put(object, write) && IsWhole(object, sent.bytes); });
  } catch (...) {  // the part read so far has become the object
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
  FilePieces pieces(path);
  return ReadPieces(&pieces, [](std::string_view) { return true; });
}

}  // namespace orient
