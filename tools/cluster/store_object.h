// Single objects of a store, by their GDAL names ("/vsis3/bucket/folder/file").
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/base/error.h"
#include "tools/cluster/uploaded_files.h"

namespace orient {

// Whether objects can be put under this name: a bucket of S3, Google or Azure, folders without
// empty names, "." and "..", and no question mark.
bool IsStore(const std::string& gdal_name);
// The error for a place that is not an object store.
UsageError NoStore(const std::string& place);

// For messages: "s3://bucket/folder/file".
std::string TypedObject(const std::string& object);

// Size in bytes; empty if there is no such object. Throws InputError if the store forbids reading,
// EnvironmentError where it does not answer.
std::optional<std::uint64_t> SizeOfObject(const std::string& object);

// Its whole text; empty where there is none. Throws as SizeOfObject.
std::optional<std::string> ReadObject(const std::string& object);

// The object is there as a whole when it returns. Throws EnvironmentError where the store does not
// take it.
void PutText(const std::string& object, const std::string& text);

// The same of a local file; returns what was read of it and sent. Where it cannot be read to its
// end (InputError, EnvironmentError) no half of it stays.
UploadedFile PutFile(const std::string& path, const std::string& object);

// Failure to remove it is not reported.
void RemoveObject(const std::string& object);

// Bytes and digest of a local file. Throws InputError, EnvironmentError.
UploadedFile ReadLocal(const std::string& path);

}  // namespace orient
