#include "tools/review/server.h"

#include <fmt/format.h>
#include <httplib.h>

#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "tools/review/access.h"

namespace orient {
namespace {

// A browser opens connections that it does not use at once, and a client that sends a request byte
// by byte holds one for long: a waiting thread costs next to nothing.
constexpr int kThreads = 256;
constexpr int kWaiting = 512;  // connections that may wait for one

std::optional<std::string> HeaderOf(const httplib::Request& request, const char* name) {
  if (!request.has_header(name)) return std::nullopt;
  return request.get_header_value(name);
}

RequestHead HeadOf(const httplib::Request& request) {
  return {.method = request.method,
          .target = request.path,  // decoded
          .host = request.get_header_value("Host"),
          .origin = HeaderOf(request, "Origin"),
          .fetch_site = HeaderOf(request, "Sec-Fetch-Site"),
          .content_type = HeaderOf(request, "Content-Type"),
          .content_length = HeaderOf(request, "Content-Length"),
          .content_encoding = HeaderOf(request, "Content-Encoding"),
          .chunked = request.has_header("Transfer-Encoding")};
}

// The path below the token, whose length has been checked.
WebPath PathOf(const std::string& target) {
  WebPath path(1);
  for (std::size_t i = target.find('/', 1) + 1; i < target.size(); ++i)
    if (target[i] == '/')
      path.emplace_back();
    else
      path.back() += target[i];
  return path;
}

void Send(const Reply& reply, httplib::Response* response) {
  response->status = reply.status;
  response->set_content(*reply.body, reply.type);
  response->set_header("Cache-Control", reply.keep ? "private, max-age=3600" : "no-store");
}

void Refuse(const Refusal& refusal, httplib::Response* response) {
  response->status = refusal.status;
  response->set_content(refusal.reason + "\n", "text/plain; charset=utf-8");
}

// Nothing from elsewhere, no script in the page itself, in no other page's frame; the address with
// its token is not passed on.
httplib::Headers SafeHeaders() {
  return {{"Content-Security-Policy",
           "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
           "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
          {"X-Content-Type-Options", "nosniff"},
          {"Referrer-Policy", "no-referrer"},
          {"Cross-Origin-Resource-Policy", "same-origin"}};
}

std::map<std::string, std::string> QueryOf(const httplib::Request& request) {
  return {request.params.begin(), request.params.end()};
}

void SetUp(Review* review, const std::function<const Access&()>& access, httplib::Server* server) {
  using Handled = httplib::Server::HandlerResponse;
  server->set_default_headers(SafeHeaders());
  // Each connection serves one request: the rest of a refused body is not taken for the next one.
  server->set_keep_alive_max_count(1);
  server->set_keep_alive_timeout(1);
  server->set_read_timeout(5);
  server->set_write_timeout(5);
  server->set_payload_max_length(kLongestBody);
  server->new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  server->set_pre_routing_handler([access](const auto& request, auto& response) {
    const auto refusal = access().WhyRefused(HeadOf(request));
    if (refusal) Refuse(*refusal, &response);
    return refusal ? Handled::Handled : Handled::Unhandled;
  });
  server->Get(".*", [review](const auto& request, auto& response) {
    Send(review->Get(PathOf(request.path), QueryOf(request)), &response);
  });
  server->Post(".*", [review](const auto& request, auto& response) {
    Send(review->Post(PathOf(request.path), request.body), &response);
  });
}

}  // namespace

void ServeReview(Review* review, int port,
                 const std::function<void(const std::string& address)>& ready) {
  httplib::Server server;
  std::optional<Access> access;  // as soon as the port is known
  SetUp(
      review, [&access]() -> const Access& { return *access; }, &server);
  socket_t listening = INVALID_SOCKET;
  // A port that another program serves is not shared with it.
  server.set_socket_options([&](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    listening = socket;
  });
  if (port == 0)
    port = server.bind_to_any_port("127.0.0.1");
  else if (!server.bind_to_port("127.0.0.1", port))
    port = -1;
  if (port < 0) throw UsageError("the port is taken; name another one with --port, or none");
  access.emplace(RandomToken(), port);
  listen(listening, kWaiting);
  ready(access->Address());
  if (!server.listen_after_bind()) throw EnvironmentError("the server could not go on listening");
}

}  // namespace orient
