#include "tools/review/access.h"

#include <gtest/gtest.h>

#include <functional>

namespace orient {
namespace {

const Access kAccess("secret", 4000);

RequestHead GoodGet() {
  RequestHead head;
  head.method = "GET";
  head.target = "/secret/api/list";
  head.host = "127.0.0.1:4000";
  return head;
}

RequestHead GoodPost() {
  RequestHead head = GoodGet();
  head.method = "POST";
  head.origin = "http://127.0.0.1:4000";
  head.fetch_site = "same-origin";
  head.content_type = "application/json";
  head.content_length = "300";
  return head;
}

// The status of the refusal, 0 where it is let in.
int StatusOf(RequestHead head, const std::function<void(RequestHead*)>& change) {
  change(&head);
  const auto refusal = kAccess.WhyRefused(head);
  if (!refusal) return 0;
  EXPECT_FALSE(refusal->reason.empty());
  return refusal->status;
}

TEST(Access, LetsThePageIn) {
  EXPECT_EQ(StatusOf(GoodGet(), [](auto*) {}), 0);
  EXPECT_EQ(StatusOf(GoodPost(), [](auto*) {}), 0);
  EXPECT_EQ(StatusOf(GoodGet(), [](auto* h) { h->fetch_site = "none"; }), 0) << "typed by a person";
  EXPECT_EQ(kAccess.Address(), "http://127.0.0.1:4000/secret/");
}

TEST(Access, RefusesOtherHostsAndPages) {
  EXPECT_EQ(StatusOf(GoodGet(), [](auto* h) { h->host = "evil.example:4000"; }), 421);
  EXPECT_EQ(StatusOf(GoodGet(), [](auto* h) { h->host = "127.0.0.1:4001"; }), 421);
  EXPECT_EQ(StatusOf(GoodGet(), [](auto* h) { h->host = ""; }), 421);
  EXPECT_EQ(StatusOf(GoodPost(), [](auto* h) { h->origin = "https://evil.example"; }), 403);
  EXPECT_EQ(StatusOf(GoodPost(), [](auto* h) { h->origin = "null"; }), 403);
  EXPECT_EQ(StatusOf(GoodPost(), [](auto* h) { h->origin = "http://127.0.0.1:4001"; }), 403);
  EXPECT_EQ(StatusOf(GoodGet(), [](auto* h) { h->fetch_site = "cross-site"; }), 403);
  EXPECT_EQ(StatusOf(GoodGet(), [](auto* h) { h->fetch_site = "same-site"; }), 403);
}

TEST(Access, RefusesWrongTokensAndPathsThatClimb) {
  for (const char* target : {"/", "", "/secre/x", "/secret", "/Secret/", "/secret2/", "/xsecret/"})
    EXPECT_EQ(StatusOf(GoodGet(), [&](auto* h) { h->target = target; }), 403) << target;
  EXPECT_EQ(StatusOf(GoodGet(), [](auto* h) { h->target = "/secret/../etc/passwd"; }), 400);
  EXPECT_EQ(StatusOf(GoodGet(), [](auto* h) { h->target = "/secret/tile/.."; }), 400);
  EXPECT_EQ(StatusOf(GoodGet(), [](auto* h) { h->target = "/secret/api/photo/a..b"; }), 0)
      << "a photo may be called so";
}

TEST(Access, RefusesOtherMethodsAndBodies) {
  for (const char* method : {"PUT", "DELETE", "OPTIONS", "HEAD", "PATCH"})
    EXPECT_EQ(StatusOf(GoodGet(), [&](auto* h) { h->method = method; }), 405) << method;
  EXPECT_EQ(StatusOf(GoodPost(), [](auto* h) { h->content_length = "100000000"; }), 413);
  EXPECT_EQ(StatusOf(GoodPost(), [](auto* h) { h->content_length = "65537"; }), 413);
  EXPECT_EQ(StatusOf(GoodPost(), [](auto* h) { h->content_length = "65536"; }), 0);
  EXPECT_EQ(StatusOf(GoodPost(), [](auto* h) { h->content_length = "-1"; }), 400);
  EXPECT_EQ(StatusOf(GoodPost(), [](auto* h) { h->content_length = "12 "; }), 400);
  EXPECT_EQ(StatusOf(GoodPost(), [](auto* h) { h->chunked = true; }), 411);
  EXPECT_EQ(StatusOf(GoodPost(), [](auto* h) { h->content_encoding = "gzip"; }), 415);
  EXPECT_EQ(StatusOf(GoodPost(), [](auto* h) { h->content_type = "text/plain"; }), 415);
  EXPECT_EQ(StatusOf(GoodPost(), [](auto* h) { h->content_type.reset(); }), 415);
  EXPECT_EQ(StatusOf(GoodGet(), [](auto* h) { h->content_length = "5"; }), 400);
}

TEST(Access, TokensAreLongAndNotTheSame) {
  const std::string token = RandomToken();
  EXPECT_EQ(token.size(), 32u);
  EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_NE(token, RandomToken());
}

}  // namespace
}  // namespace orient
