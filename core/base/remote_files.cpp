#include "core/base/remote_files.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <regex>
#include <thread>
#include <utility>

#include "core/base/environment_error.h"
#include "core/base/error.h"

namespace orient {
namespace {

using Names = std::pair<const char*, const char*>;

constexpr std::array<Names, 5> kPlaces = {Names{"s3://", "/vsis3/"},
                                          {"gs://", "/vsigs/"},
                                          {"az://", "/vsiaz/"},
                                          {"http://", "/vsicurl/http://"},
                                          {"https://", "/vsicurl/https://"}};

constexpr std::array<const char*, 5> kRemote = {"/vsicurl/", "/vsicurl?", "/vsis3/", "/vsigs/",
                                                "/vsiaz/"};

}  // namespace

std::string GdalName(const std::string& name) {
  for (const auto& [scheme, place] : kPlaces)
    if (name.starts_with(scheme)) return place + name.substr(std::string(scheme).size());
  return name;
}

std::string TypedName(const std::string& gdal_name) {
  for (const auto& [scheme, place] : kPlaces)
    if (gdal_name.starts_with(place)) return scheme + gdal_name.substr(std::string(place).size());
  return gdal_name;
}

bool IsVirtual(const std::string& gdal_name) { return gdal_name.starts_with("/vsi"); }

bool IsRemote(const std::string& gdal_name) {
  return std::any_of(kRemote.begin(), kRemote.end(),
                     [&](const char* place) { return gdal_name.starts_with(place); });
}

std::string WithoutEscapes(const std::string& gdal_name) {
  const std::size_t folder = gdal_name.find("://");
  std::string name;
  const std::string path =
      folder == std::string::npos ? gdal_name : gdal_name.substr(0, gdal_name.find('?', folder));
  for (std::size_t i = 0; i < path.size(); ++i) {
    int code = 0;
    const char* end = path.data() + std::min(i + 3, path.size());
    const bool escape = path[i] == '%' && i + 2 < path.size() &&
                        std::from_chars(path.data() + i + 1, end, code, 16).ptr == end && code > 0;
    name += escape ? static_cast<char>(code) : path[i];
    if (escape) i += 2;
  }
  return name;
}

std::string WithoutSecrets(const std::string& text) {
  static const std::regex user("(https?://)[^/@\\s]*@"), question("(https?://[^?\\s]*)\\?[^\\s']*");
  return std::regex_replace(std::regex_replace(text, user, "$1"), question, "$1");
}

std::vector<std::string> RemoteMatches(const std::string& pattern) {
  const std::size_t slash = pattern.rfind('/');
  const std::string folder = pattern.substr(0, slash), name = pattern.substr(slash + 1);
  if (folder.find('*') != std::string::npos)  // [ is allowed: it occurs in addresses, [::1]
    throw InputError(fmt::format("{}: only the last part of an address may hold a pattern",
                                 WithoutSecrets(TypedName(pattern))));
  ConfigureRemoteAccess();
  const CPLErrorHandlerPusher quiet(CPLQuietErrorHandler);
  const CPLStringList listed(VSIReadDir(folder.c_str()));
  if (listed.Count() == 0)
    throw EnvironmentError(
        fmt::format("{} cannot be listed, or holds nothing; name the photos one by one, or in a "
                    "file (@FILE)",
                    WithoutSecrets(TypedName(folder))));
  std::vector<std::string> found;
  for (int i = 0; i < listed.Count(); ++i)
    if (fnmatch(name.c_str(), listed[i], FNM_PERIOD) == 0)
      found.push_back(folder + "/" + listed[i]);
  std::sort(found.begin(), found.end());
  return found;
}

void ConfigureRemoteAccess() {
  constexpr std::array<Names, 6> kSettings = {Names{"GDAL_HTTP_MAX_RETRY", "3"},
                                              {"GDAL_HTTP_RETRY_DELAY", "0.5"},
                                              {"GDAL_HTTP_CONNECTTIMEOUT", "20"},
                                              // Less than a kilobyte a second for half a minute.
                                              {"GDAL_HTTP_LOW_SPEED_LIMIT", "1000"},
                                              {"GDAL_HTTP_LOW_SPEED_TIME", "30"},
                                              // What was received is not requested again, not even
                                              // by another thread: a scan's windows overlap.
                                              {"CPL_VSIL_CURL_CACHE_SIZE", "134217728"}};
  for (const auto& [key, value] : kSettings)
    if (CPLGetConfigOption(key, nullptr) == nullptr) CPLSetConfigOption(key, value);
}

void PauseBefore(int attempt) {
  std::this_thread::sleep_for(std::chrono::milliseconds(100 << attempt));
}

}  // namespace orient
