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

// The plain name of a remote file: the address without its query string (after the ?) and with
// percent-encoding (%20 ...) decoded: ".../roll%207/1.tif?sig=a/b" gives ".../roll 7/1.tif".
std::string WithoutEscapes(const std::string& gdal_name);

// An address as it may be written down: without user, password and question (signatures).
std::string WithoutSecrets(const std::string& text);

// The files of a remote folder that match a shell's pattern in the last part of `pattern`, sorted.
// Throws InputError for a pattern in the folder's name, EnvironmentError where the folder cannot be
// listed: a web server may not let one.
std::vector<std::string> RemoteMatches(const std::string& pattern);

// Configures GDAL's requests: retry if a server is busy, time out if it does not answer, and fetch
// nothing twice (128 MB cache). Settings in the environment (GDAL_HTTP_..., CPL_VSIL_CURL_...) take
// precedence.
void ConfigureRemoteAccess();

void PauseBefore(int attempt);

// Calls `attempt` until it returns true, four times at most, with pauses that grow.
template <typename Attempt>
bool WithRetries(const Attempt& attempt) {
  constexpr int kAttempts = 4;
  for (int i = 0; i < kAttempts; ++i) {
    if (i > 0) PauseBefore(i);
    if (attempt()) return true;
  }
  return false;
}

}  // namespace orient
