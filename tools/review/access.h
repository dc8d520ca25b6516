// Which requests the review's server accepts: those of the page that it served itself, no others.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace orient {

// What a request says of itself, as the browser or program that sent it wrote it.
struct RequestHead {
  std::string method, target;               // "GET", "/<token>/api/list", decoded
  std::string host;                         // of the header
  std::optional<std::string> origin;        // browsers send it with every POST
  std::optional<std::string> fetch_site;    // Sec-Fetch-Site
  std::optional<std::string> content_type;  // of the body
  std::optional<std::string> content_length, content_encoding;
  bool chunked = false;  // a body of a length that it does not state
};

// Why and with which HTTP status a request is refused.
struct Refusal {
  int status = 0;
  std::string reason;
};

class Access {
 public:
  Access(std::string token, int port) : token_(std::move(token)), port_(port) {}

  // Looks at the head alone, before any of the body is read: Host (a foreign name that leads here),
  // Origin and Sec-Fetch-Site (another page), the token, `..` in the path, methods other than GET
  // and POST, and bodies that are too large, of no stated length, or not JSON. Empty: accepted.
  std::optional<Refusal> WhyRefused(const RequestHead& head) const;

  // "http://127.0.0.1:PORT/TOKEN/".
  std::string Address() const;

 private:
  bool HasToken(const std::string& target) const;

  std::string token_;
  int port_;
};

// The longest body: a person's entry has some hundred bytes.
inline constexpr std::size_t kLongestBody = 64 * 1024;

// 32 hexadecimal digits of the system's random numbers. Throws EnvironmentError where it has none.
std::string RandomToken();

}  // namespace orient
