#include "tools/review/access.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <array>

#include "core/base/environment_error.h"
#include "core/base/number_text.h"

namespace orient {
namespace {

std::optional<Refusal> WhyNoBody(const RequestHead& head) {
  if (head.chunked) return Refusal{411, "state the body's length"};
  if (head.content_encoding) return Refusal{415, "send the body as it is, not packed"};
  std::size_t length = 0;
  if (head.content_length) {
    const auto stated = NumberIn<std::size_t>(*head.content_length);
    if (!stated) return Refusal{400, "Content-Length is not a number"};
    length = *stated;
  }
  if (length > kLongestBody)
    return Refusal{413, fmt::format("the body has more than {} bytes", kLongestBody)};
  if (head.method == "GET")
    return length == 0 ? std::nullopt : std::optional(Refusal{400, "a GET has no body"});
  // Forms of other pages cannot send this without a preflight request.
  if (!head.content_type || !head.content_type->starts_with("application/json"))
    return Refusal{415, "send application/json"};
  return std::nullopt;
}

bool ClimbsUp(const std::string& path) {
  return (path + "/").find("/../") != std::string::npos || path.find('\0') != std::string::npos;
}

}  // namespace

std::optional<Refusal> Access::WhyRefused(const RequestHead& head) const {
  const std::string here = fmt::format("127.0.0.1:{}", port_);
  if (head.host != here) return Refusal{421, "this server answers as " + here + " only"};
  if (head.origin && *head.origin != "http://" + here)
    return Refusal{403, "the request comes from another page"};
  if (head.fetch_site && *head.fetch_site != "same-origin" && *head.fetch_site != "none")
    return Refusal{403, "the request comes from another page"};
  if (head.method != "GET" && head.method != "POST") return Refusal{405, "only GET and POST"};
  if (!HasToken(head.target))
    return Refusal{403, "wrong token; open the address that orient review printed"};
  if (ClimbsUp(head.target)) return Refusal{400, "no such path"};
  return WhyNoBody(head);
}

bool Access::HasToken(const std::string& target) const {
  const std::string start = "/" + token_ + "/";
  if (target.size() < start.size()) return false;
  unsigned different = 0;  // all of it is compared, so that timing reveals nothing
  for (std::size_t i = 0; i < start.size(); ++i)
    different |= static_cast<unsigned char>(start[i] ^ target[i]);
  return different == 0;
}

std::string Access::Address() const {
  return fmt::format("http://127.0.0.1:{}/{}/", port_, token_);
}

std::string RandomToken() {
  std::array<unsigned char, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw EnvironmentError("the system has no random numbers for the address of the review");
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

}  // namespace orient
