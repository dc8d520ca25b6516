// What an upload (upload.h) puts into a store: a list that lies there with the objects.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace orient {

// The list's own name beside the objects.
inline constexpr const char* kUploadList = "orient-upload.json";

struct UploadedFile {
  std::uint64_t bytes = 0;
  std::string digest;  // block::Digest() of the contents; empty until the object is there

  bool operator==(const UploadedFile&) const = default;
};

struct UploadedFiles {
  std::string id;                             // of the upload that wrote it
  bool complete = false;                      // every object is there
  std::map<std::string, UploadedFile> files;  // by their paths in the folder

  bool operator==(const UploadedFiles&) const = default;
};

std::string TextOf(const UploadedFiles& list);

// Throws InputError for a text that is no such list; `name` is how the message calls it.
UploadedFiles ReadUploadedFiles(const std::string& text, const std::string& name);

}  // namespace orient
