// Files in object storage and on web servers: their names, and what is to be expected of a network.
#pragma once

#include <string>
#include <vector>

namespace orient {

// "s3://bucket/scan.tif" as GDAL calls it, "/vsis3/bucket/scan.tif"; likewise gs://, az://, http://
// and https://. Other names are returned as they are.
std::string GdalName(const std::string& name);

// The other way round, for messages.
std::string TypedName(const std::string& gdal_name);

// By its name: one that GDAL reads by itself (/vsi...), in the network or not; one in the network.
bool IsVirtual(const std::string& gdal_name);
bool IsRemote(const std::string& gdal_name);

// What the name of a remote file is apart from the address: without the question behind a ?, with
// the characters that %20 and the like stand for. "roll 7/1.tif" of ".../roll%207/1.tif?sig=a/b".
std::string WithoutEscapes(const std::string& gdal_name);

// An address as it may be written down: without user, password and question (signatures).
std::string WithoutSecrets(const std::string& text);

// The files of a remote folder that match a shell's pattern in the last part of `pattern`, sorted.
// Throws InputError for a pattern in the folder's name, EnvironmentError where the folder cannot be
// listed: a web server may not let one.
std::vector<std::string> RemoteMatches(const std::string& pattern);

// How GDAL asks: again where a server is busy, not for ever where it says nothing, and nothing
// twice (128 MB are kept). What the environment says (GDAL_HTTP_..., CPL_VSIL_CURL_...) comes
// first.
void AskPatiently();

void PauseBefore(int attempt);

// Calls `attempt` until it returns true, four times at most, with pauses that grow.
template <typename Attempt>
bool Patiently(const Attempt& attempt) {
  constexpr int kAttempts = 4;
  for (int i = 0; i < kAttempts; ++i) {
    if (i > 0) PauseBefore(i);
    if (attempt()) return true;
  }
  return false;
}

}  // namespace orient
